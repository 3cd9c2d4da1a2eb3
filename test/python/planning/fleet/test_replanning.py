"""The remembered plan is carried on from where the robots are, or not at all."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Sequence, Tuple

import pytest

from python.planning.fleet_samples import blocks, fleet_of, goals
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.fleet.replanning import Memory, pose_of, waypoint
from yarm.planning.model.types import Waypoint

NAMES = ("r0", "r1")
GOALS = goals((26, 12), (14, 20))
MOVES = [
    Move(0, (2, 12, 0), (10, 12, 0)),
    Move(1, (14, 2, 0), (14, 20, 0)),
    Move(0, (10, 12, 0), (26, 12, 0)),
]


def at(*columns: Tuple[int, int], yaw_deg: float = 0.0) -> Fleet:
    robots = [replace(one, yaw_rad=math.radians(yaw_deg)) for one in blocks(*columns)]
    return fleet_of(robots, GOALS)


def remembered(names: Sequence[str] = NAMES) -> Memory:
    memory = Memory()
    memory.keep(at((2, 12), (14, 2)), names, MOVES)
    return memory


def test_before_anybody_has_moved_the_plan_is_the_same() -> None:
    assert remembered().recall(at((2, 12), (14, 2)), NAMES) == MOVES


def test_moves_that_are_made_are_left_out() -> None:
    assert remembered().recall(at((10, 12), (14, 2)), NAMES) == [MOVES[1], MOVES[2]]
    assert remembered().recall(at((10, 12), (14, 20)), NAMES) == [MOVES[2]]


def test_moves_made_between_two_plans_are_left_out_too() -> None:
    assert remembered().recall(at((26, 12), (14, 2)), NAMES) == [MOVES[1]]


def test_a_robot_that_is_to_come_back_to_where_it_stands_still_makes_both_moves() -> None:
    memory = Memory()
    there_and_back = [Move(0, (2, 12, 0), (10, 12, 0)), Move(0, (10, 12, 0), (2, 12, 0))]
    memory.keep(at((2, 12), (14, 2)), NAMES, there_and_back)
    assert memory.recall(at((2, 12), (14, 2)), NAMES) == there_and_back


def test_a_robot_that_stopped_short_makes_its_first_move_from_there() -> None:
    recalled = remembered().recall(at((6, 13), (14, 2)), NAMES)
    assert recalled is not None and recalled[0] == Move(0, (6, 13, 0), (10, 12, 0)) and recalled[1:] == MOVES[1:]


def test_the_order_of_the_robots_may_change() -> None:
    swapped = fleet_of(list(reversed(blocks((2, 12), (14, 2)))), list(reversed(GOALS)))
    recalled = remembered().recall(swapped, ("r1", "r0"))
    assert recalled is not None and [move.robot for move in recalled] == [1, 0, 1]


def test_a_robot_that_is_gone_ends_the_plan() -> None:
    assert remembered().recall(at((2, 12)), ("r0",)) is None


@pytest.mark.parametrize(("yaw_deg", "kept"), [(2.0, True), (3.0, False)])
def test_a_heading_imprecisely_reached_is_the_same_and_another_ends_the_plan(yaw_deg: float, kept: bool) -> None:
    """At 3 deg none of the headings of the plan (0, 90, ...) is left among those quarter turns lead to."""
    assert (remembered().recall(at((2, 12), (14, 2), yaw_deg=yaw_deg), NAMES) is not None) is kept


def test_poses_and_waypoints_are_the_same_thing() -> None:
    space = at((2, 12), (14, 2)).spaces[0]
    for h, yaw in enumerate(space.headings):
        assert waypoint((5, 6, h), space) == Waypoint((5, 6), yaw)
        assert pose_of(Waypoint((5, 6), yaw + 2 * math.pi), space) == (5, 6, h)
    assert pose_of(Waypoint((5, 6), math.radians(45.0)), space) is None
