"""What becomes of a goal: done, failed with a reason, lost by a server started again; a server that is gone."""

from __future__ import annotations

import pytest

from yarm.inspection.goal_watch import RESULT_DELAY_S, SILENT_S, SUCCEEDED, GoalWatch
from yarm.inspection.model import Outcome


def watched() -> GoalWatch:
    watch = GoalWatch()
    watch.sent("a", 10.0)
    watch.heard_status({"a"}, 10.1)
    return watch


def test_a_result_counts_a_little_later_and_then_for_good() -> None:
    watch = watched()
    assert watch.outcome(11.0) == (Outcome.BUSY, "")
    watch.heard_result("a", SUCCEEDED, "", 12.0)
    assert watch.outcome(12.0 + RESULT_DELAY_S - 0.1) == (Outcome.BUSY, "")
    assert watch.outcome(12.0 + RESULT_DELAY_S) == (Outcome.DONE, "")
    assert watch.outcome(99.0) == (Outcome.DONE, "")


@pytest.mark.parametrize(
    ("status", "words"), [(4, "given up: no way"), (5, "refused: no way"), (7, "status 7: no way")]
)
def test_a_failure_says_how_it_ended_and_why(status: int, words: str) -> None:
    watch = watched()
    watch.heard_result("a", status, "no way", 12.0)
    outcome, reason = watch.outcome(13.0)
    assert outcome == Outcome.FAILED and words in reason


def test_results_of_other_goals_are_nobodys() -> None:
    watch = watched()
    watch.heard_result("b", SUCCEEDED, "", 11.0)
    assert watch.outcome(12.0)[0] == Outcome.BUSY
    watch.heard_result("a", SUCCEEDED, "", 12.0)
    watch.sent("c", 13.0)
    assert watch.outcome(14.0)[0] == Outcome.BUSY


def test_a_server_started_again_does_not_know_the_goal() -> None:
    watch = watched()
    for i in range(1, 70):
        watch.heard_status(set(), 10.1 + 0.1 * i)
    outcome, reason = watch.outcome(17.0)
    assert outcome == Outcome.FAILED and "has not known the goal for 6.9 s" in reason


def test_a_silent_server_is_gone_but_its_goal_has_not_failed() -> None:
    watch = GoalWatch()
    assert watch.gone(1.0) == "nothing heard of it yet"
    watch.sent("a", 10.0)
    watch.heard_status({"a"}, 10.1)
    assert watch.gone(10.1 + SILENT_S) == ""
    assert watch.gone(20.1) == "silent for 10.0 s"
    assert watch.outcome(20.1)[0] == Outcome.BUSY
