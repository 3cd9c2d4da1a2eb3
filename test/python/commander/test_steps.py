"""What is sent of a plan (the safe part, everything, or everything with what the checker has against it), and when a
step under way is called off.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Dict, List, Optional, Sequence, Set

import numpy as np
import pytest

from python.commander import fake_cell
from python.commander.fake_cell import FakeCell
from python.planning.samples import SMALL, block, request, robot
from yarm.commander.params import CommanderParams
from yarm.commander.steps import StepGuard, safe_part, steps_of
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, RobotPlan, StepCheck, Waypoint

START = (0.65, 1.6, math.pi)
TARGET = (-0.85, -1.65)
"""On the other side of the table."""


class StraightOn:
    """Sends everybody towards its goal, 8 cells at a time, through whatever stands there."""

    def plan(self, ask: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        plans = {}
        for one in ask.robots:
            goal = ask.goals[ask.assignments[one.name]]
            way = np.subtract(goal.column, one.column)
            share = min(1.0, 8.0 / max(1.0, float(np.hypot(*way))))
            x, y = (round(a + share * d) for a, d in zip(one.column, way))
            path = (Waypoint(one.column, one.yaw_rad), Waypoint((x, y), one.yaw_rad))
            plans[one.name] = RobotPlan(one.name, goal.name, PlanStatus.SOLVED, "", path, path[1])
        return FleetPlan(PlanStatus.SOLVED, "", plans)

    def reset(self) -> None:
        """Nothing is remembered."""


def run_mission(monkeypatch: pytest.MonkeyPatch, mode: str) -> FakeCell:
    monkeypatch.setattr(fake_cell, "make_planner", lambda *_: StraightOn())
    cell = FakeCell(CommanderParams(check_steps=mode), ankurbot_1=START)
    cell.targets = {"target_1": TARGET}
    cell.calibrate()
    assert cell.request(jump_state=5).success
    cell.run_for(40.0)
    return cell


def test_report_sends_what_the_checker_refuses_and_counts_it(monkeypatch: pytest.MonkeyPatch, execution: str) -> None:
    cell = run_mission(monkeypatch, "report")
    assert cell.status.outcome == "succeeded"
    refused = [bool(shown.refused) for shown in cell.shown]
    every_plan_is_a_step = execution == "steps"
    for shown in cell.shown:
        assert shown.sent == ("ankurbot_1",) or not (shown.refused or every_plan_is_a_step)
    assert 1 <= sum(refused) < len(refused)
    assert [shown.refusals for shown in cell.shown] == list(np.cumsum(refused))
    assert sum("a step was sent that the checker refuses: " in text for text in cell.said) == sum(refused)


@pytest.mark.usefixtures("execution")
def test_true_sends_nothing_that_the_checker_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = run_mission(monkeypatch, "true")
    assert cell.touches == []
    assert cell.status.outcome == ""
    refused = [shown for shown in cell.shown if shown.refused]
    assert refused and all(shown.sent == () for shown in refused)
    assert cell.shown[-1].refusals == len(refused)


@pytest.mark.usefixtures("execution")
def test_false_asks_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    cell = run_mission(monkeypatch, "false")
    assert cell.status.outcome == "succeeded"
    assert all(shown.refused == "" and shown.refusals == 0 for shown in cell.shown)


OPEN = np.zeros(SMALL.shape, dtype=bool)
ROBOTS = [robot("a", (2, 2), block(1, 1)), robot("b", (2, 6), block(1, 1)), robot("c", (2, 10), block(1, 1))]
ASK = request(SMALL, OPEN, ROBOTS)


def plan(**steps: Optional[Waypoint]) -> FleetPlan:
    plans = {name: RobotPlan(name, "", PlanStatus.SOLVED, step=step) for name, step in steps.items()}
    return FleetPlan(PlanStatus.SOLVED, "", plans)


class Checker:
    """Refuses every plan that moves two robots of a pair; remembers what it was asked."""

    def __init__(self, *pairs: Set[str]) -> None:
        self.pairs = pairs
        self.asked: List[List[str]] = []

    def __call__(self, ask: PlanRequest, fleet_plan: FleetPlan) -> StepCheck:
        moving = sorted(steps_of(fleet_plan))
        self.asked.append(moving)
        bad = [pair for pair in self.pairs if pair <= set(moving)]
        return StepCheck(not bad, f"{sorted(bad[0])} would touch" if bad else "")


def sent(checker: Checker, fleet_plan: FleetPlan) -> Dict[str, Waypoint]:
    return safe_part(ASK, fleet_plan, checker).steps


EAST = {one.name: Waypoint((8, one.column[1]), 0.0) for one in ROBOTS}


def test_steps_are_those_of_robots_that_move_by_name() -> None:
    assert list(steps_of(plan(c=EAST["c"], a=EAST["a"], b=None))) == ["a", "c"]


def test_a_safe_plan_is_sent_whole_after_one_check() -> None:
    checker = Checker()
    checked = safe_part(ASK, plan(**EAST), checker)
    assert checked.steps == EAST and checked.refused == "" and len(checker.asked) == 1


def test_nothing_to_send_is_nothing_to_check() -> None:
    checker = Checker()
    assert sent(checker, plan(a=None)) == {} and checker.asked == []


def test_of_a_refused_plan_as_many_go_as_are_safe_together() -> None:
    checked = safe_part(ASK, plan(**EAST), Checker({"a", "b"}))
    assert set(checked.steps) == {"a", "c"} and checked.refused == "['a', 'b'] would touch"
    assert sent(Checker({"a"}), plan(**EAST)) == {"b": EAST["b"], "c": EAST["c"]}


def test_the_one_step_of_a_refused_plan_is_not_tried_again() -> None:
    checker = Checker({"a"})
    checked = safe_part(ASK, plan(a=EAST["a"], b=None), checker)
    assert checked.steps == {} and checked.refused and len(checker.asked) == 1


def test_the_real_checker_lets_those_go_that_do_not_cross() -> None:
    crossing = plan(a=Waypoint((2, 9), 0.0), b=Waypoint((8, 6), 0.0), c=Waypoint((8, 10), 0.0))
    checked = safe_part(ASK, crossing)
    assert "would" in checked.refused and set(checked.steps) in ({"b", "c"}, {"c"})
    assert safe_part(ASK, replace(crossing, robots={n: crossing.robots[n] for n in checked.steps})).refused == ""


def occupied(*cells: Sequence[int]) -> np.ndarray:
    grid = OPEN.copy()
    for cell in cells:
        grid[tuple(cell)] = True
    return grid


def test_a_way_that_is_taken_several_maps_in_a_row_is_an_alarm() -> None:
    guard = StepGuard(3)
    guard.watch(ASK, ROBOTS[0], EAST["a"])
    taken = occupied((5, 2, 0))
    assert guard.alarms(taken) == [] and guard.alarms(taken) == []
    ((name, cells),) = guard.alarms(taken)
    assert name == "a" and cells.tolist() == [[5, 2, 0]]


def test_noise_in_between_and_beside_is_none() -> None:
    guard = StepGuard(2)
    guard.watch(ASK, ROBOTS[0], EAST["a"])
    for _ in range(3):
        assert guard.alarms(occupied((5, 2, 0))) == []
        assert guard.alarms(OPEN) == []
        assert guard.alarms(occupied((5, 3, 0), (5, 2, 2))) == [], "beside the way, and above the robot"


def test_a_step_that_ended_is_watched_no_more_and_a_new_one_counts_anew() -> None:
    guard = StepGuard(2)
    guard.watch(ASK, ROBOTS[0], EAST["a"])
    assert guard.alarms(occupied((5, 2, 0))) == []
    guard.watch(ASK, ROBOTS[0], EAST["a"])
    assert guard.alarms(occupied((5, 2, 0))) == []
    assert len(guard.alarms(occupied((5, 2, 0)))) == 1
    guard.forget("a")
    guard.forget("a")
    assert guard.alarms(occupied((5, 2, 0))) == []


def test_what_a_robot_has_outside_the_volume_is_not_looked_up() -> None:
    outside = robot("a", (1, 2), block(1, 1))
    outside = replace(outside, mask=replace(outside.mask, cells=np.array([[0, 0, 0], [-3, 0, 0]])))
    guard = StepGuard(1)
    guard.watch(request(SMALL, OPEN, [outside]), outside, Waypoint((3, 2), 0.0))
    assert [name for name, _ in guard.alarms(np.ones(SMALL.shape, dtype=bool))] == ["a"]
    assert guard.alarms(occupied((14, 2, 0), (15, 2, 0))) == []
