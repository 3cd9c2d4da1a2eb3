"""A planner that is asked once: every robot follows its first path to the end, as in the publication's first rows."""

from __future__ import annotations

from dataclasses import replace
from typing import Dict, Optional

import numpy as np

from yarm.planning.model import request_check as check
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest, PlanStatus, Robot, RobotPlan


class PlannedOnce:
    """Wraps a planner behind ``FleetPlanner``; a new goal, or one that has moved, is planned again. Not thread safe.

    Paths are followed without looking at the map: their steps are not promised to be safe.
    """

    def __init__(self, planner: FleetPlanner) -> None:
        """Nothing is planned yet.

        Args:
            planner: plans the first paths.
        """
        self._planner = planner
        self._left: Dict[str, RobotPlan] = {}

    def reset(self) -> None:
        """Forget the paths."""
        self._left = {}
        self._planner.reset()

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """The next waypoint of every robot's path; see ``FleetPlanner``."""
        robots = {robot.name: robot for robot in request.robots if robot.name in request.assignments}
        left = {name: self._rest(robot, request) for name, robot in robots.items()}
        kept = {name: plan for name, plan in left.items() if plan is not None}
        fresh = FleetPlan(PlanStatus.SOLVED, "", {})
        if len(kept) < len(robots):
            fresh = self._planner.plan(request, rng)
        plans = {**fresh.robots, **kept}
        self._left = {name: plan for name, plan in plans.items() if plan.status is PlanStatus.SOLVED and plan.path}
        if not plans:
            return fresh
        status, reason = check.worst(plans)
        return replace(fresh, status=status, reason=reason, robots=plans)

    def _rest(self, robot: Robot, request: PlanRequest) -> Optional[RobotPlan]:
        """What is left of a robot's path; None when there is none to its goal where that is now."""
        plan, name = self._left.get(robot.name), request.assignments[robot.name]
        goal = request.goals.get(name)
        if plan is None or goal is None or plan.goal != name or plan.path[-1].column != tuple(goal.column):
            return None
        if plan.step is not None and plan.step.column == tuple(robot.column):
            plan = replace(plan, path=plan.path[1:])
        length = sum(float(np.hypot(*np.subtract(a.column, b.column))) for a, b in zip(plan.path, plan.path[1:]))
        step = plan.path[1] if len(plan.path) > 1 else None
        return replace(plan, step=step, length_cells=length, planning_ms=0.0)
