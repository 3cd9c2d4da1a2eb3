"""What is wrong with a request: status and a sentence that names robot, number and limit."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from python.planning.samples import SMALL, block, request, robot
from yarm.geometry import Mask
from yarm.planning.model import request_check as check
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, PlanStatus, RobotPlan

OPEN = np.zeros(SMALL.shape, dtype=bool)
CART = robot("cart", (3, 3), block(2, 2))
CRATE = np.array([(8, 8, 0), (8, 8, 1)])


def asked(**changes: Any) -> PlanRequest:
    """A good request: two robots, a goal each."""
    occupied = OPEN.copy()
    occupied[tuple(CRATE.T)] = True
    wanted = [Goal("g0", GoalKind.TARGET, (10, 3)), Goal("g1", GoalKind.DEBRIS, (10, 9), np.array([(10, 9, 3)]))]
    ask = request(SMALL, occupied, [CART, robot("b", (3, 9), block(1, 1))], wanted, objects={"crate": CRATE})
    return replace(ask, **changes)


def test_nothing_is_wrong_with_a_good_request() -> None:
    ask = asked()
    assert check.world_fault(ask) == "" and check.faulty_plans(ask) == {}
    assert [check.robot_fault(one, ask) for one in ask.robots] == [None, None]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"occupied": np.zeros((3, 3, 3), dtype=bool)}, "map of shape (3, 3, 3) does not have the (16, 12, 4) cells"),
        ({"forbidden": np.zeros((3, 3), dtype=bool)}, "forbidden columns of shape (3, 3) must be (16, 12)"),
        ({"robots": (CART, CART)}, "more than one is called cart"),
        ({"assignments": {"ghost": "g0"}}, "robots that are not there: ghost"),
    ],
)
def test_what_makes_the_whole_request_unusable(changes: Any, words: str) -> None:
    ask = asked(**changes)
    assert words in check.world_fault(ask)
    answer = check.refused(ask, check.world_fault(ask))
    assert answer.status is PlanStatus.INVALID_START and set(answer.robots) == set(ask.assignments)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mask": Mask(np.zeros((0, 3), dtype=np.int64))}, "cart has no cells"),
        ({"mask": block(17, 1)}, "cart is (17, 1, 2) cells, larger than the grid"),
        ({"yaw_rad": math.nan}, "cart has a pose that is not finite"),
        ({"position_m": (0.3, math.inf)}, "cart has a pose that is not finite"),
        ({"column": (16, 3)}, "cart has its end effector in column (16, 3), outside the grid"),
        ({"column": (3, -1)}, "cart has its end effector in column (3, -1), outside the grid"),
    ],
)
def test_what_makes_a_robot_unusable(changes: Any, words: str) -> None:
    broken = replace(CART, **changes)
    ask = asked(robots=(broken, robot("b", (3, 9), block(1, 1))))
    fault = check.robot_fault(broken, ask)
    assert fault is not None and fault[0] is PlanStatus.INVALID_START and words in fault[1]
    plans = check.faulty_plans(ask)
    assert set(plans) == {"cart"} and plans["cart"].reason == fault[1]


def test_a_robot_inside_an_object_is_told_which_and_where() -> None:
    ask = asked(robots=(replace(CART, column=(8, 7)), robot("b", (3, 9), block(1, 1))))
    fault = check.start_collision(ask.robots[0], ask)
    assert fault == (PlanStatus.INVALID_START, "cart overlaps crate in 2 cells, one is (8, 8, 0)")


def test_a_map_with_robots_in_it_is_refused() -> None:
    """Whoever paints the robot's own cells into the map is told, instead of a robot that can go nowhere."""
    painted = asked().occupied.copy()
    painted[3:5, 3:5, :2] = True
    fault = check.start_collision(CART, asked(occupied=painted))
    assert fault is not None and fault[0] is PlanStatus.INVALID_START
    assert fault[1] == "cart stands in 8 cells that the map without robots has as occupied, one is (3, 3, 0)"
    assert check.start_collision(CART, asked(occupied=painted, objects={})) == fault, "with or without names"


def test_a_robot_may_stand_over_debris_that_is_a_goal() -> None:
    debris = Goal("d", GoalKind.DEBRIS, (4, 4), np.array([(4, 4, 1)]))
    occupied = asked().occupied.copy()
    occupied[4, 4, 1] = True
    ask = asked(goals={"d": debris}, assignments={}, occupied=occupied, objects={"d": debris.cells})
    assert check.start_collision(CART, ask) is None


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (Goal("g0", GoalKind.TARGET, (16, 0)), "g0 is in column (16, 0), outside the 16 x 12 columns"),
        (Goal("g0", GoalKind.TARGET, (math.nan, 0)), "g0 has a column that is not finite"),  # type: ignore[arg-type]
        (Goal("g0", GoalKind.TARGET, (1, 0), yaw_rad=math.inf), "g0 wants a heading that is not finite"),
        (Goal("other", GoalKind.TARGET, (1, 0)), "cart is assigned to g0, which is not among the goals"),
    ],
)
def test_what_makes_a_goal_unusable(goal: Goal, words: str) -> None:
    fault = check.goal_fault(CART, asked(goals={goal.name: goal}, assignments={"cart": "g0"}))
    assert fault == (PlanStatus.INVALID_GOAL, words)


def test_the_map_for_planning_has_no_assigned_debris_and_the_robots_that_are_left_out() -> None:
    ask = asked()
    occupied = ask.occupied.copy()
    occupied[10, 9, 3] = True
    ask = replace(ask, occupied=occupied)
    assert np.argwhere(check.robotless_grid(ask, ask.robots)).tolist() == CRATE.tolist()
    assert check.robotless_grid(replace(ask, assignments={}), ask.robots)[10, 9, 3], "nobody's goal is an obstacle"
    without_b = check.robotless_grid(ask, ask.robots[:1])
    assert without_b[3, 9, :2].all() and without_b.sum() == 4
    assert occupied[10, 9, 3], "the request's own map is left as it is"


def test_objects_are_named_by_their_cells() -> None:
    ask = asked()
    assert check.objects_at(CRATE, ask) == "crate"
    assert check.objects_at(np.array([(3, 9, 0), (8, 8, 0)]), ask) == "crate, robot b"
    assert check.objects_at(np.array([(0, 0, 0)]), ask) == "something unknown"
    assert check.objects_at(np.zeros((0, 3), dtype=np.int64), ask) == "the border of the volume"


def test_the_worst_status_wins_with_its_reason() -> None:
    plans = {
        name: RobotPlan(name, "g", status, name)
        for name, status in (("a", PlanStatus.TIMEOUT), ("b", PlanStatus.INVALID_GOAL), ("c", PlanStatus.SOLVED))
    }
    assert check.worst(plans) == (PlanStatus.INVALID_GOAL, "b")
    assert check.worst({}) == (PlanStatus.SOLVED, "")
