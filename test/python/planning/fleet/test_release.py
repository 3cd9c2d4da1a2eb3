"""The dependency graph of a joint plan: what waits, what is released, and what never ends."""

from __future__ import annotations

from typing import Tuple

import numpy as np
import pytest

from python.planning.samples import SMALL, block, request, robot
from yarm.planning.fleet.release import ReleaseOrder, moves_of
from yarm.planning.model.types import FleetPlan, PlannedMove, PlanStatus, RobotPlan, Waypoint


def move(name: str, x0: int, x1: int, *after: int, behind: Tuple[str, ...] = ()) -> PlannedMove:
    return PlannedMove(name, Waypoint((x0, 0), 0.0), Waypoint((x1, 0), 0.0), after, behind)


PLAN = (move("a", 0, 1), move("a", 1, 2), move("b", 5, 1, 0, 1), move("c", 8, 9))


def test_a_move_is_released_as_soon_as_what_it_touches_has_ended_whatever_others_do() -> None:
    order = ReleaseOrder(PLAN)
    assert order.ready() == [0, 3]
    order.release(0)
    order.release(3)
    assert order.ready() == []
    order.finish("a")
    assert order.waits_for(2) == ("a",)
    assert order.release(1) == PLAN[1]
    order.finish("a")
    assert order.ready() == [2]
    assert order.left == (2, 3)


def test_a_move_waits_for_what_was_under_way_before_the_plan() -> None:
    order = ReleaseOrder([move("a", 1, 2), move("b", 5, 1, behind=("a",))], ["a"])
    assert order.ready() == []
    assert order.waits_for(0) == order.waits_for(1) == ("a",)
    order.finish("a")
    assert order.ready() == [0, 1]


def test_a_move_waits_only_until_what_it_touches_has_been_passed() -> None:
    past = set()
    order = ReleaseOrder(PLAN, passed=lambda robot, move: (robot, move.robot) in past)
    past.add(("a", "b"))
    order.release(0)
    assert order.waits_for(2) == ("a",), "the second of its moves has not begun"
    order.finish("a")
    past.clear()
    order.release(1)
    assert order.waits_for(2) == ("a",)
    past.add(("a", "b"))
    assert order.release(2) == PLAN[2]


def test_what_was_under_way_before_the_plan_is_passed_too_but_nobody_passes_himself() -> None:
    moves = [move("a", 1, 2), move("b", 5, 1, behind=("a",))]
    order = ReleaseOrder(moves, ["a"], passed=lambda robot, other: True)
    assert order.ready() == [1]
    assert order.waits_for(0) == ("a",)


def test_a_robot_under_way_may_go_on_with_a_move_that_waits_for_nobody_else() -> None:
    order = ReleaseOrder([*PLAN[:2], move("b", 5, 1, 0, 1), move("b", 1, 0)])
    assert order.onward("b") is None
    order.release(0)
    assert order.onward("a") == 1
    order.release(1)
    assert order.onward("a") is None
    assert order.waits_for(2) == ("a",)
    order.finish("a")
    assert order.left == (2, 3), "all that it was given has ended"
    order.release(2)
    assert order.onward("b") == 3
    before = ReleaseOrder([move("a", 1, 2), move("b", 5, 1, behind=("a",))], ["a", "b"])
    assert (before.onward("a"), before.onward("b")) == (0, None)
    before.release(0)
    before.finish("a")
    assert before.left == (1,)


def test_what_waits_for_a_robot_that_stops_short_waits_for_ever_and_nobody_else() -> None:
    order = ReleaseOrder(PLAN)
    order.release(0)
    order.release(3)
    order.finish("c")
    assert order.ready() == []
    assert order.waits_for(2) == ("a",)


def test_what_is_not_ready_cannot_be_released() -> None:
    order = ReleaseOrder(PLAN)
    with pytest.raises(ValueError, match="move 2 of b cannot be released: it waits for a"):
        order.release(2)


def test_a_planner_without_an_order_has_its_steps_made() -> None:
    fleet = [robot("a", (2, 2), block(1, 1)), robot("b", (9, 9), block(1, 1))]
    asked = request(SMALL, np.zeros(SMALL.shape, dtype=bool), fleet)
    there = Waypoint((5, 2), 0.0)
    plans = {"a": RobotPlan("a", "g", PlanStatus.SOLVED, step=there), "b": RobotPlan("b", "h", PlanStatus.SOLVED)}
    found = moves_of(asked, FleetPlan(PlanStatus.SOLVED, "", plans))
    assert found == (PlannedMove("a", Waypoint((2, 2), 0.0), there),)
