"""What records come to: each measure from a record made for it."""

from __future__ import annotations

import math

import pytest

from python.experiments.explore_samples import ROOM, path_row, perfect_map, record_of
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.measures import Obstacles, measure, times_to
from yarm.experiments.explore.record import CoverageRow, TouchRow

JUDGE = Judge(ROOM)
GOOD = perfect_map(JUDGE)


def touch(t_s: float, block: str, speed: float = 0.05) -> TouchRow:
    return TouchRow(t_s, block, block.startswith("low"), 0.0, 0.0, 0.0, speed)


def test_times_are_the_first_to_reach_a_share() -> None:
    rows = [CoverageRow(float(t), 1.0, share) for t, share in enumerate((0.1, 0.91, 0.89, 0.95, 0.97))]
    assert times_to(rows) == (1.0, 3.0, math.inf) and times_to([]) == (math.inf,) * 3


def test_a_good_run_breaks_no_rule() -> None:
    path = tuple(path_row(0.1 * i, -1.0 + 0.02 * i, 0.2) for i in range(11))
    found = measure(record_of(GOOD, path=path, end_s=1.0, done=True, first_seen={"low_1": 3.0}), JUDGE)
    assert found.share == 1.0 and found.broken_rules == () and not found.early
    assert found.distance_m == pytest.approx(0.2) and found.turning_rad == 0.0
    assert found.tall == Obstacles(1, 1, 1) and found.low == Obstacles(1, 1, 1)
    assert found.bumps == 0 and found.fastest_bump == 0.0 and found.wall_fitted.mean_m < 0.03


def test_speeds_are_judged_by_what_is_ahead() -> None:
    def run(x: float, speed: float, yaw: float = 0.0) -> float:
        step = 0.1 * speed * math.cos(yaw)
        path = tuple(path_row(0.1 * i, x + step * i, speed, yaw=yaw) for i in range(4))
        return measure(record_of(GOOD, path=path), JUDGE).too_fast_near_s

    assert run(-1.0, 0.3) == 0.0, "2 m of room"
    assert run(1.6, 0.3) == pytest.approx(0.3), "the east wall is 0.4 m away"
    assert run(1.6, 0.15) == 0.0 and run(1.6, 0.3, math.pi) == 0.0, "slow, and driving away"
    fast = tuple(path_row(0.1 * i, -1.0, 0.4) for i in range(3))
    assert measure(record_of(GOOD, path=fast), JUDGE).too_fast_s == pytest.approx(0.2)


def test_touches_are_counted_by_what_was_touched() -> None:
    rows = (touch(1.0, "low_1"), touch(2.0, "low_1", 0.2), touch(3.0, "wall"))
    found = measure(record_of(GOOD, touches=rows, first_seen={"low_1": 1.5, "block_1": 0.5}), JUDGE)
    assert (found.bumps, found.bumped_again, found.fastest_bump) == (3, 1, 0.2)
    assert found.low == Obstacles(1, 1, 0), "in the map only after the first touch"
    assert any("bump at 0.20" in rule for rule in found.broken_rules)


def test_moving_after_the_end_is_seen() -> None:
    path = (path_row(899.9, 0.0, 0.2), path_row(900.0, 0.0, 0.2), path_row(900.1, 0.0, 0.01))
    assert not measure(record_of(GOOD, path=path), JUDGE).standing
    assert measure(record_of(GOOD, path=path[:2]), JUDGE).standing


def test_ending_early_with_something_left_is_said() -> None:
    assert measure(record_of(None, done=True, end_s=10.0), JUDGE).early
    nothing = measure(record_of(None), JUDGE)
    assert nothing.share == 0.0 and math.isnan(nothing.wall.mean_m) and nothing.tall.detected == 0
