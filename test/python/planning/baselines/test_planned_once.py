"""A planner that is asked once: first paths are followed waypoint by waypoint, whatever the map shows meanwhile."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np

from python.planning.samples import block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.baselines.planned_once import PlannedOnce
from yarm.planning.model.types import FleetPlan, Goal, PlanRequest, PlanStatus, RobotPlan, Waypoint

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)
Column = Tuple[int, int]


class ByTheMiddle:
    """Plans by way of (15, 12), and counts how often it is asked."""

    def __init__(self) -> None:
        self.asked = 0

    def plan(self, ask: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        self.asked += 1
        plans = {}
        for one in ask.robots:
            goal = ask.goals[ask.assignments[one.name]]
            path = tuple(Waypoint(column, 0.0) for column in (one.column, (15, 12), goal.column))
            plans[one.name] = RobotPlan(one.name, goal.name, PlanStatus.SOLVED, "", path, path[1], 24.0)
        return FleetPlan(PlanStatus.SOLVED, "", plans)

    def reset(self) -> None:
        self.asked = 0


def steps(planner: PlannedOnce, ask: PlanRequest) -> List[object]:
    plans = planner.plan(ask, np.random.default_rng(0)).robots
    return [None if plan.step is None else plan.step.column for _, plan in sorted(plans.items())]


def ask_at(a: Column, b: Column, goal: Column = (26, 6), occupied: np.ndarray = OPEN) -> PlanRequest:
    goals = [Goal("t", "Target", goal), Goal("u", "Target", (26, 20))]
    return request(SPEC, occupied, [robot("a", a, block(1, 1)), robot("b", b, block(1, 1))], goals)


def test_each_robot_follows_its_first_path_to_the_end_without_looking() -> None:
    inner = ByTheMiddle()
    planner = PlannedOnce(inner)
    assert steps(planner, ask_at((2, 6), (2, 20))) == [(15, 12), (15, 12)]
    wall = walls(SPEC, [(20, 21, 0, 24)])
    assert steps(planner, ask_at((15, 12), (9, 16), occupied=wall)) == [(26, 6), (15, 12)]
    assert steps(planner, ask_at((26, 6), (15, 12), occupied=wall)) == [None, (26, 20)]
    assert inner.asked == 1


def test_a_goal_that_has_moved_is_planned_again_and_the_others_path_stays() -> None:
    inner = ByTheMiddle()
    planner = PlannedOnce(inner)
    steps(planner, ask_at((2, 6), (2, 20)))
    steps(planner, ask_at((15, 12), (15, 12)))
    assert steps(planner, ask_at((15, 12), (15, 12), goal=(26, 4))) == [(15, 12), (26, 20)]
    assert inner.asked == 2


def test_reset_forgets_the_paths() -> None:
    planner = PlannedOnce(ByTheMiddle())
    steps(planner, ask_at((2, 6), (2, 20)))
    planner.reset()
    assert steps(planner, ask_at((15, 12), (2, 20))) == [(15, 12), (15, 12)]
