"""The line a second that a person sees of an exploration."""

from __future__ import annotations

import math

from yarm.msg import ExplorerStatus

from yarm.ros.exploration.progress import REASON_SHOWN, progress_line, status_line

STATUS = ExplorerStatus(state="exploring", behaviour="drive", elapsed=12.34, left=887.66)


def test_it_says_share_time_left_behaviour_and_bumps():
    assert progress_line(STATUS, 2.5, 0.876, 1) == (
        "  12.3 s | x2.50 |  87.6 % mapped |   888 s left | exploring: drive | bumps: 1"
    )


def test_before_the_first_map_there_is_no_share():
    assert "|     - % mapped |" in progress_line(STATUS, 1.0, math.nan, 0)


def test_a_reason_is_told_and_a_long_one_only_begun():
    held = ExplorerStatus(state="exploring", behaviour="hold", reason="scan: it has no beams")
    assert progress_line(held, 1.0, 0.5, 0).endswith("| bumps: 0 | scan: it has no beams")
    left = "; ".join(f"({i}.00, 0.50): 2 cells, fewer than a view must show" for i in range(20))
    told = progress_line(ExplorerStatus(state="done", behaviour="stand", reason=left), 1.0, 0.5, 0).split(
        "bumps: 0 | "
    )[1]
    assert told.startswith("(0.00, 0.50): 2 cells") and told.endswith(" ...") and len(told) <= REASON_SHOWN


def test_without_a_judge_it_says_what_is_known():
    known = ExplorerStatus(state="exploring", behaviour="turn", elapsed=7.0, left=893.0, known_m2=12.34, bumps=2)
    assert status_line(known) == "   7.0 s |  12.3 m2 known |   893 s left | exploring: turn | bumps: 2"
