"""Stepping a fleet to its end: what is counted, and when it is given up."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.planning.model.types import (
    FleetPlan,
    Goal,
    GoalKind,
    PlanRequest,
    PlanStatus,
    RobotPlan,
    StepCheck,
    Waypoint,
)
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand
from yarm.planning.scenes.stepping import SteppedRun, step_to_end

SPEC = GridSpec((12, 10, 1), (0.0, 0.0, 0.0), (1.2, 1.0, 0.1))
POINT = np.zeros((1, 3), dtype=np.int64)
Step = Tuple[Tuple[int, int], float]


class Script:
    """A planner that sends what it was told, plan after plan; then it lets everybody wait."""

    def __init__(self, *plans: Dict[str, Step], status: PlanStatus = PlanStatus.SOLVED, reason: str = "") -> None:
        self.plans = list(plans)
        self.status, self.reason, self.resets = status, reason, 0

    def reset(self) -> None:
        self.resets += 1

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        steps = self.plans.pop(0) if self.plans else {}
        robots = {}
        for robot in request.robots:
            step = Waypoint(*steps[robot.name]) if robot.name in steps else None
            path = (Waypoint(robot.column, robot.yaw_rad), *([step] if step else []))
            robots[robot.name] = RobotPlan(robot.name, "", self.status, self.reason, path, step)
        return FleetPlan(self.status, self.reason, robots, planning_ms=2.0)


def scene(*boxes: Box, yaw_rad: float = math.nan) -> PlanScene:
    robots = tuple(SceneRobot(name, Stand((1, y), 0.0), POINT) for name, y in (("a", 2), ("b", 7)))
    wanted = None if math.isnan(yaw_rad) else yaw_rad
    goals = {"g": Goal("g", GoalKind.TARGET, (9, 2), yaw_rad=wanted)}
    return PlanScene(SPEC, boxes, robots, goals, {"a": "g"})


def run(planner: Script, of: PlanScene, **more: object) -> SteppedRun:
    return step_to_end(of, planner, np.random.default_rng(0), **more)  # type: ignore[arg-type]


def test_what_is_counted() -> None:
    planner = Script({"a": ((5, 2), 0.0), "b": ((1, 8), 0.0)}, {"a": ((9, 2), 0.0)})
    done = run(planner, scene())
    assert (done.status, done.reason, done.steps, done.refused) == (PlanStatus.SOLVED, "", 2, 0)
    assert done.sum_of_costs == 9.0 and done.makespan == 8.0 and done.min_clearance_cells == 4
    assert [stand.column for stand in done.trails["a"]] == [(1, 2), (5, 2), (9, 2)]
    assert done.ms == [2.0, 2.0] and done.percentile_ms(50.0) == 2.0 and planner.resets == 1


def test_a_goal_is_reached_at_its_heading_only() -> None:
    askew = run(Script({"a": ((9, 2), 0.0)}), scene(yaw_rad=math.pi / 2))
    assert askew.status is PlanStatus.TIMEOUT and "5 in a row without motion" in askew.reason
    assert run(Script({"a": ((9, 2), math.pi / 2)}), scene(yaw_rad=math.pi / 2)).status is PlanStatus.SOLVED


def test_a_refused_step_moves_nobody_and_is_told() -> None:
    seen: List[StepCheck] = []
    through_the_box = Script({"a": ((9, 2), 0.0)})
    done = run(through_the_box, scene((4, 6, 0, 10, 0, 1)), observe=lambda ask, plan, verdict: seen.append(verdict))
    assert done.status is PlanStatus.TIMEOUT and done.refused == 1 and done.sum_of_costs == 0.0
    assert "would touch boxes[0]" in done.refusals[0] and done.refusals[0] in done.reason
    assert [verdict.safe for verdict in seen] == [False, True, True, True, True]


def test_an_infeasible_plan_ends_it_at_once() -> None:
    done = run(Script(status=PlanStatus.INFEASIBLE, reason="walled in"), scene())
    assert (done.status, done.reason, len(done.ms)) == (PlanStatus.INFEASIBLE, "walled in", 1)


def test_waiting_is_patience_and_steps_have_an_end() -> None:
    assert len(run(Script(), scene(), patience=3).ms) == 3
    dither = Script(*({"a": ((1 + k % 2, 2), 0.0)} for k in range(1, 20)))
    done = run(dither, scene(), most_steps=8)
    assert done.status is PlanStatus.TIMEOUT and len(done.ms) == 8 and "after 8 plans" in done.reason


def test_replans_are_plans_that_are_not_the_rest_of_the_one_before() -> None:
    straight = run(Script({"a": ((5, 2), 0.0)}, {"a": ((9, 2), 0.0)}), scene())
    assert straight.replans == 1, "the second waypoint was not in the first plan"


def test_nothing_planned_has_no_percentile() -> None:
    assert SteppedRun().percentile_ms(99.0) == 0.0
    assert run(Script(), scene(), assignments={}).status is PlanStatus.SOLVED


@pytest.mark.parametrize("clearance", [True, False])
def test_clearance_is_measured_when_asked_for(clearance: bool) -> None:
    done = run(Script({"a": ((9, 2), 0.0)}), scene((5, 6, 5, 6, 0, 1)), clearance=clearance)
    assert done.min_clearance_cells == (2 if clearance else None)
