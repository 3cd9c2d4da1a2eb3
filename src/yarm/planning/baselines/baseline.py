"""What the planners that YARM is compared with have in common: the request is checked, a search makes plans of it."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.planning.cspace.cell_sets import CellSet, dilated, overlap
from yarm.planning.cspace.robot_space import Pose, ShapeCache
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem, explain_failure, turns_of
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, RobotPlan, Waypoint
from yarm.planning.roadmap.roadmap import Roadmap
from yarm.planning.roadmap.search import Path


@dataclass(frozen=True)
class Found:
    """What a search gave for one robot: a path, or the status and the reason why there is none."""

    path: Optional[Path] = None
    status: PlanStatus = PlanStatus.SOLVED
    reason: str = ""
    ms: float = 0.0


class BaselinePlanner(ABC):
    """A planner with the checks and tables of YARM and a search of its own. Not thread safe."""

    def __init__(self, params: Optional[PlannerParams] = None) -> None:
        """A planner; of the parameters it uses those about turns."""
        self.params = params or PlannerParams()
        self._turns = turns_of(self.params.turns_deg, self.params.turn_deg_per_cell)
        self._cache = ShapeCache()

    def reset(self) -> None:  # noqa: B027 (it has no plan to forget)
        """Nothing to forget: what is kept from plan to plan depends on shapes alone."""

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """Plan one step for the fleet; see ``FleetPlanner``."""
        began = time.perf_counter()
        fault = check.world_fault(request)
        if fault:
            return check.refused(request, fault)
        problem = PlanningProblem.of(request, self._turns, self._cache)
        plans = check.faulty_plans(request, () if problem is None else [robot.name for robot in problem.robots])
        rounds = 0
        if problem is not None:
            fleet = Fleet(problem.spaces, problem.targets, Roadmap.of(np.zeros((0, 2), dtype=np.int64)))
            active = []
            for i, robot in enumerate(problem.robots):
                if problem.targets[i] is None or robot.name in plans:
                    continue
                status, reason = (
                    explain_failure(problem, fleet, i) if not _can_stand_at_goal(fleet, i) else (PlanStatus.SOLVED, "")
                )
                if status is PlanStatus.SOLVED:
                    active.append(i)
                else:
                    plans[robot.name] = RobotPlan(robot.name, request.assignments[robot.name], status, reason)
            searched, rounds = self._plans(problem, fleet, active, rng)
            plans.update(searched)
        status, reason = check.worst(plans)
        return FleetPlan(status, reason, plans, rounds, 1e3 * (time.perf_counter() - began))

    @abstractmethod
    def _plans(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[str, RobotPlan], int]:
        """Plans of the active robots, and of others that step aside for them, and the rounds it took."""


class OneByOnePlanner(BaselinePlanner):
    """A planner that finds every robot's path anew at each step, the others standing, and remembers nothing.

    A robot makes its path's first move when that touches neither where the others stand nor what robots before it in
    the fleet do in the same step; else it waits. Nobody steps aside for anybody.
    """

    def _plans(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[str, RobotPlan], int]:
        found, rounds = self._search(problem, fleet, active, rng)
        return _robot_plans(problem, fleet, found), rounds

    @abstractmethod
    def _search(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[int, Found], int]:
        """What was found for each active robot, and the rounds it took."""


def goal_poses(fleet: Fleet, i: int) -> List[Pose]:
    """Poses at which a robot is at its target and clear of everything that never moves."""
    target = fleet.targets[i]
    if target is None:
        return []
    view = fleet.view(i, fleet.starts, range(len(fleet.spaces)))
    headings = range(len(fleet.spaces[i].headings)) if target.heading is None else [target.heading]
    poses: List[Pose] = [(*target.column, h) for h in headings]
    return [pose for pose in poses if view.stands(pose)]


def _can_stand_at_goal(fleet: Fleet, i: int) -> bool:
    return fleet.satisfied(i, fleet.starts[i]) or bool(goal_poses(fleet, i))


def _robot_plans(problem: PlanningProblem, fleet: Fleet, found: Dict[int, Found]) -> Dict[str, RobotPlan]:
    steps = _choose_steps(fleet, found)
    plans: Dict[str, RobotPlan] = {}
    for i, result in found.items():
        name = problem.robots[i].name
        headings = fleet.spaces[i].headings
        path = result.path or (fleet.starts[i],)
        waypoints = tuple(Waypoint((x, y), headings[h]) for x, y, h in path)
        step = waypoints[1] if i in steps else None
        length = sum(math.dist(a[:2], b[:2]) for a, b in zip(path, path[1:]))
        goal = problem.request.assignments[name]
        plans[name] = RobotPlan(name, goal, result.status, result.reason, waypoints, step, length, result.ms)
    return plans


def _choose_steps(fleet: Fleet, found: Dict[int, Found]) -> List[int]:
    """Robots that may make their path's first move now."""
    chosen: List[int] = []
    inflated: List[CellSet] = []
    for i, result in found.items():
        if result.path is None or len(result.path) < 2:
            continue
        start, end = result.path[0], result.path[1]
        if not fleet.view(i, fleet.starts).move(start, end):
            continue
        swept = fleet.spaces[i].swept(start, end)
        if any(overlap(swept, other) for other in inflated):
            continue
        chosen.append(i)
        inflated.append(dilated(swept, fleet.spaces[i].layout.stride))
    return chosen


def straightened(path: Sequence[Pose]) -> Path:
    """The same way with moves in one direction at one heading made one move."""
    result: List[Pose] = list(path[:1])
    for pose in path[1:]:
        if len(result) >= 2 and _in_line(result[-2], result[-1], pose):
            result[-1] = pose
        else:
            result.append(pose)
    return tuple(result)


def _in_line(a: Pose, b: Pose, c: Pose) -> bool:
    if not a[2] == b[2] == c[2]:
        return False
    first, second = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    return first[0] * second[1] == first[1] * second[0] and first[0] * second[0] + first[1] * second[1] > 0
