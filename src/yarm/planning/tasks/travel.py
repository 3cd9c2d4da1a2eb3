"""Travel distances in configuration space: what the task queue assigns by."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray
from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, shifted, union
from yarm.planning.cspace.robot_space import Pose, RobotSpace, ShapeCache, View, poses_touch
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem, explain_failure, turns_of
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Column, Goal, PlanRequest
from yarm.planning.roadmap.roadmap import even_roadmap
from yarm.planning.roadmap.search import flood, path_cost, reachable, shortened

Held = Tuple[str, Goal]
"""A robot and the goal it holds."""


class Travel:
    """Distances between robots and goals in one map, the robots themselves taken away, each made when asked for."""

    def __init__(self, request: PlanRequest, params: PlannerParams) -> None:
        """Map, robots and goals of a request; its assignments are not read."""
        self._request = request
        self._particles, self._most = params.particles_first, params.particles
        self._turns = turns_of(params.turns_deg, params.turn_deg_per_cell)
        self._cache = ShapeCache()
        self._robots = {robot.name: robot for robot in request.robots}
        self._worlds: Dict[Tuple[str, str], Optional[PlanningProblem]] = {}
        self._arrived: Dict[Tuple[str, str], List[Pose]] = {}
        self._distances: Dict[Tuple[str, str], Tuple[float, str]] = {}

    def distance(self, robot: str, goal: Goal) -> Tuple[float, str]:
        """Cost of a robot's way to a goal, cells (turns included); infinite, with the reason, when there is none."""
        key = (robot, goal.name)
        if key not in self._distances:
            self._distances[key] = self._measure(robot, goal)
        return self._distances[key]

    def onward(self, robot: str, goal: Goal) -> float:
        """Cost of a robot's way from a goal to the nearest of its onward columns, cells; infinite without a way."""
        if not goal.onward:
            return 0.0
        problem = self._problem(robot, goal)
        if problem is None:
            return math.inf
        wanted = problem.layout.set_of_columns(np.array(goal.onward, dtype=np.int64))
        return self._way_from(problem, self._arrivals(robot, goal), lambda view, h: wanted & ~view.blocked(h))

    def distance_after(self, robot: str, first: Goal, goal: Goal) -> float:
        """Cost of a robot's way to a goal from where it stands on another, cells; infinite when there is none."""
        problem = self._problem(robot, goal)
        if problem is None:
            return math.inf
        bits = {h: problem.layout.set_of_columns(np.array([(x, y)])) for x, y, h in _stands(problem)}
        return self._way_from(problem, self._arrivals(robot, first), lambda view, h: bits.get(h, 0) & ~view.blocked(h))

    def _way_from(
        self, problem: PlanningProblem, starts: Sequence[Pose], wanted: Callable[[View, int], ColumnSet]
    ) -> float:
        """Cost of the way from the best of some poses of the robot of a world, cells."""
        view = View(problem.spaces[0], ())
        ways = [flood(view, pose, lambda h: wanted(view, h)) for pose in starts]
        return min((path_cost(view, shortened(view, way)) for way in ways if way is not None), default=math.inf)

    def _measure(self, robot: str, goal: Goal) -> Tuple[float, str]:
        problem = self._problem(robot, goal)
        request = replace(self._request, assignments={robot: goal.name}, goals={goal.name: goal})
        fault = check.world_fault(request) or check.robot_fault(self._robots[robot], request)
        fault = fault or check.goal_fault(self._robots[robot], request)
        if fault or problem is None:
            return math.inf, fault if isinstance(fault, str) else (fault[1] if fault else f"{robot} is not there")
        roadmap = even_roadmap((request.spec.shape[0], request.spec.shape[1]), self._particles, 0, 1.0, self._most)
        fleet = Fleet(problem.spaces, problem.targets, roadmap)
        path = fleet.alone(0)
        if path is None:
            return math.inf, explain_failure(problem, fleet, 0)[1]
        return path_cost(fleet.view(0, fleet.starts), path), ""

    def _problem(self, robot: str, goal: Optional[Goal]) -> Optional[PlanningProblem]:
        key = (robot, "" if goal is None else goal.name)
        if key not in self._worlds:
            goals = {} if goal is None else {goal.name: goal}
            assignments = {} if goal is None else {robot: goal.name}
            request = replace(self._request, assignments=assignments, goals=goals)
            usable = not check.world_fault(request)
            self._worlds[key] = PlanningProblem.of(request, self._turns, self._cache, robot) if usable else None
        return self._worlds[key]

    def compatible(self, one: str, goal: Goal, other: str, other_goal: Goal) -> bool:
        """Whether two robots can stand on two goals at the same time, the margin between them."""
        first, second = self._problem(one, goal), self._problem(other, other_goal)
        if first is None or second is None:
            return False
        mine, theirs = self._arrivals(one, goal), self._arrivals(other, other_goal)
        return any(not poses_touch(first.spaces[0], a, second.spaces[0], b) for a in mine for b in theirs)

    def _arrivals(self, robot: str, goal: Goal) -> List[Pose]:
        """Poses on a goal that a robot can come to."""
        key = (robot, goal.name)
        if key not in self._arrived:
            problem = self._problem(robot, goal)
            poses = [] if problem is None else _stands(problem)
            if problem is not None and len(poses) > 1:
                space = problem.spaces[0]
                reached = reachable(View(space, ()), space.start)
                poses = [(x, y, h) for x, y, h in poses if reached[h] >> space.layout.bit(x, y) & 1]
            self._arrived[key] = poses
        return self._arrived[key]

    def stands_in(self, robot: str, columns: BoolArray) -> bool:
        """Whether a robot has a cell in one of the columns (gx, gy)."""
        cells = self._robots[robot].cells
        inside = cells[self._request.spec.contains(cells)]
        return bool(columns[inside[:, 0], inside[:, 1]].any())

    def place_outside(
        self, robot: str, columns: BoolArray, held: Sequence[Held], waiting: Sequence[Goal]
    ) -> Optional[Tuple[Column, float]]:
        """Nearest column where a robot has no cell in ``columns`` and is in nobody's way.

        Args:
            robot: its name.
            columns: (gx, gy) columns to leave.
            held: goals that others are on their way to.
            waiting: goals others will want later; given up when there is no place otherwise.

        Returns:
            the place, and its cost, cells; None when there is none.
        """
        problem = self._problem(robot, None)
        if problem is None:
            return None
        space, layout = problem.spaces[0], problem.layout
        column_set = layout.set_of_image(columns)
        leave: CellSet = tuple(column_set for _ in range(layout.shape[2]))
        others = self._present(robot)
        for taken in (self._taken(robot, held, waiting), self._taken(robot, held, ()), []):
            keep_free = leave
            for cell_set in [*others, *taken]:
                keep_free = union(keep_free, cell_set)
            view = View(space, ())

            def wanted(h: int, keep_free: CellSet = keep_free, view: View = view) -> ColumnSet:
                return layout.field & ~space.shape(h).blocked_by(keep_free) & ~view.blocked(h)

            way = flood(view, space.start, wanted)
            if way is not None:
                return way[-1][:2], path_cost(view, way)
        return None

    def _present(self, robot: str) -> List[CellSet]:
        """The other robots, with their margin, where they stand."""
        cell_set = []
        for other in self._robots:
            problem = None if other == robot else self._problem(other, None)
            if problem is not None:
                cell_set.append(_grown_at(problem.spaces[0], problem.spaces[0].start))
        return cell_set

    def _taken(self, robot: str, held: Sequence[Held], waiting: Sequence[Goal]) -> List[CellSet]:
        """The other robots, with their margin, on goals they hold or may be given."""
        pairs = [(other, goal) for other, goal in held if other != robot]
        pairs += [(other, goal) for goal in waiting for other in self._robots if goal.robot in ("", other)]
        cell_set = []
        for other, goal in pairs:
            problem = self._problem(other, goal)
            if problem is not None:
                cell_set += [_grown_at(problem.spaces[0], pose) for pose in self._arrivals(other, goal)]
        return cell_set


def _stands(problem: PlanningProblem) -> List[Pose]:
    """Poses in which the one robot of a world can stand on its target."""
    target, space = problem.targets[0], problem.spaces[0]
    if target is None:
        return []
    view = View(space, ())
    headings = range(len(space.headings)) if target.heading is None else [target.heading]
    poses: List[Pose] = [(target.column[0], target.column[1], h) for h in headings]
    return [pose for pose in poses if view.stands(pose)]


def _grown_at(space: RobotSpace, pose: Pose) -> CellSet:
    offset = pose[0] * space.layout.stride + pose[1]
    return tuple(shifted(layer, offset) for layer in space.shape(pose[2]).inflated)
