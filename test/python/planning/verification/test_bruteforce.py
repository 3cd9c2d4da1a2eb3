"""The brute force oracle finds what touches, and only that."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.planning.samples import SMALL, arm, block, request, robot, walls
from yarm.planning.model.types import FleetPlan, Goal, GoalKind, PlanStatus, RobotPlan, Waypoint
from yarm.planning.verification.bruteforce import touches

OPEN = np.zeros(SMALL.shape, dtype=bool)


def plan(**steps: Waypoint) -> FleetPlan:
    plans = {name: RobotPlan(name, "", PlanStatus.SOLVED, step=step) for name, step in steps.items()}
    return FleetPlan(PlanStatus.SOLVED, "", plans)


def test_a_way_through_a_wall_touches_and_one_right_beside_it_does_not() -> None:
    ask = request(SMALL, walls(SMALL, [(6, 8, 0, 6)]), [robot("a", (2, 5), block(1, 1))])
    assert touches(ask, plan(a=Waypoint((10, 5), 0.0))) == ["a touches the map at (6, 5, 0)"]
    beside = request(SMALL, walls(SMALL, [(6, 8, 0, 5)]), [robot("a", (2, 5), block(1, 1))])
    assert touches(beside, plan(a=Waypoint((10, 5), 0.0))) == []


def test_what_a_turn_sweeps_counts() -> None:
    ask = request(SMALL, walls(SMALL, [(6, 7, 4, 5)]), [robot("a", (8, 6), arm(3))])
    ends_only = request(SMALL, OPEN, [robot("a", (8, 6), arm(3))])
    assert touches(ends_only, plan(a=Waypoint((8, 6), math.pi / 2))) == []
    assert "a touches the map" in touches(ask, plan(a=Waypoint((8, 6), math.pi / 2)))[0]


def test_robots_that_cross_touch_whoever_moves() -> None:
    ask = request(SMALL, OPEN, [robot("a", (2, 5), block(1, 1)), robot("b", (6, 5), block(1, 1))])
    assert touches(ask, plan(a=Waypoint((10, 5), 0.0))) == ["a and b touch at (6, 5, 0)"]
    assert touches(ask, plan(a=Waypoint((10, 5), 0.0), b=Waypoint((6, 9), 0.0))) == ["a and b touch at (6, 5, 0)"]
    assert touches(ask, plan()) == []


@pytest.mark.parametrize(("column", "found"), [((-1, 5), ["a leaves the grid at (-1, 5, 0)"]), ((0, 5), [])])
def test_leaving_the_grid_is_found(column: tuple, found: list) -> None:
    ask = request(SMALL, OPEN, [robot("a", (2, 5), block(1, 1))])
    assert touches(ask, plan(a=Waypoint(column, 0.0))) == found


def test_debris_that_is_somebodys_goal_is_nothing_to_touch() -> None:
    debris = Goal("d", GoalKind.DEBRIS, (6, 5), np.array([(6, 5, 0)]))
    occupied = walls(SMALL, [(6, 7, 5, 6)]) & (np.arange(4) == 0)
    ask = request(SMALL, occupied, [robot("a", (2, 5), block(1, 1))], [debris])
    assert touches(ask, plan(a=Waypoint((6, 5), 0.0))) == []
