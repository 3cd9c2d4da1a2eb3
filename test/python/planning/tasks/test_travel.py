"""Travel distances of robots to goals, the robots themselves taken away, and where an idle one may wait."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import pytest

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind, Robot
from yarm.planning.tasks.travel import Travel

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def travel(robots: Sequence[Robot], occupied: np.ndarray = OPEN, **params: object) -> Travel:
    return Travel(request(SPEC, occupied, robots), PlannerParams(**params))  # type: ignore[arg-type]


def target(column: tuple, **more: object) -> Goal:
    return Goal(f"t{column}", GoalKind.TARGET, column, **more)  # type: ignore[arg-type]


def test_the_distance_is_the_way_around_and_other_robots_do_not_count() -> None:
    robots = [robot("a", (2, 2), block(1, 1)), robot("b", (8, 2), block(2, 2))]
    assert travel(robots).distance("a", target((12, 2))) == (10.0, "")
    length, reason = travel(robots, walls(SPEC, [(5, 7, 0, 20)])).distance("a", target((12, 2)))
    assert reason == "" and 36.0 < length < 60.0


def test_turning_costs_what_the_parameters_say() -> None:
    """With the tip at the left edge the arm must point there: half a turn from where it points."""
    for deg_per_cell in (10.0, 30.0):
        length, _ = travel([robot("a", (15, 12), arm(5))], turn_deg_per_cell=deg_per_cell).distance(
            "a", target((1, 12))
        )
        straight = 14.0
        assert straight + 90.0 / deg_per_cell <= length <= straight + 2.0 + 180.0 / deg_per_cell


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (target((26, 12)), "has no way to"),
        (target((18, 12)), "cannot stand with its end effector"),
        (target((30, 12)), "outside the 30 x 24 columns"),
    ],
)
def test_what_cannot_be_reached_is_infinitely_far_with_the_reason(goal: Goal, words: str) -> None:
    length, reason = travel([robot("a", (2, 2), block(1, 1))], walls(SPEC, [(17, 20, 0, 24)])).distance("a", goal)
    assert length == math.inf and words in reason


def test_a_robot_that_cannot_be_planned_for_reaches_nothing() -> None:
    lost = robot("a", (40, 2), block(1, 1))
    length, reason = travel([lost, robot("b", (2, 2), block(1, 1))]).distance("a", target((5, 5)))
    assert length == math.inf and "outside the grid" in reason


def test_two_goals_are_compatible_when_both_robots_fit() -> None:
    measured = travel([robot("a", (2, 2), block(2, 2)), robot("b", (2, 20), block(2, 2))], turns_deg=(0.0,))
    assert measured.compatible("a", target((10, 10)), "b", target((10, 13)))
    assert not measured.compatible("a", target((10, 10)), "b", target((10, 12)))


def test_only_headings_that_can_be_come_to_count_for_compatibility() -> None:
    """Arms that may not turn both lie along x; with quarter turns one points from above, the other from below."""
    robots = [robot("a", (10, 6), arm(5)), robot("b", (10, 18), arm(5))]
    side_by_side = (target((15, 11)), target((15, 13)))
    assert not travel(robots, turns_deg=(0.0,)).compatible("a", side_by_side[0], "b", side_by_side[1])
    assert travel(robots).compatible("a", side_by_side[0], "b", side_by_side[1])


def test_the_place_outside_is_the_nearest_that_leaves_the_columns_and_is_in_nobodys_way() -> None:
    columns = np.zeros(SPEC.shape[:2], dtype=bool)
    columns[10:20, 8:16] = True
    robots = [robot("a", (18, 11), block(2, 2)), robot("b", (22, 4), block(2, 2))]
    measured = travel(robots)
    assert measured.stands_in("a", columns) and not measured.stands_in("b", columns)
    place = measured.place_outside("a", columns, [], [])
    assert place is not None and place[0] == (20, 11) and place[1] == 2.0
    held = measured.place_outside("a", columns, [("b", target((21, 12)))], [])
    assert held is not None and max(abs(held[0][0] - 21), abs(held[0][1] - 12)) > 2
    waiting = measured.place_outside("a", columns, [], [target((21, 12), robot="b")])
    assert waiting is not None and waiting[0] == held[0]


def test_there_may_be_no_place_outside() -> None:
    everything = np.ones(SPEC.shape[:2], dtype=bool)
    assert travel([robot("a", (18, 11), block(2, 2))]).place_outside("a", everything, [], []) is None
