"""YARM as it was published, flaws and all, to reproduce its results; ``YarmPlanner`` is the one to use.

Faithful in what shows: particles drawn independently; turns sampled every 10 degrees and translations at whole cells,
by cell centres; a margin around what stands in the map, none between robots; touching costs, it does not forbid; the
queue counts waypoints, not distance.

Dynamic re-planning, as published. The remembered path stands as it was planned: waypoints that were reached are not
taken off it, and it is never checked again. It is measured from where the robot is. A new path that is shorter is taken
if its first step was found free; if not, the robot stays where it is and goes on remembering the old one. Else the
remembered path is taken if its first step was free when it was planned, and failing that the new one. When the
remembered path is taken and its first waypoint is near (the robot stands on it, as a rule), that waypoint is dropped
for good and the robot goes to the next one, whatever is on the way.
"""

from __future__ import annotations

import dataclasses
import math
import time
from dataclasses import dataclass, field
from typing import Dict, List, Optional, Sequence, Set, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, FloatArray, IntArray, wrap_angle
from yarm.params import build
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import (
    Column,
    FleetPlan,
    GivenGraph,
    Goal,
    PlanRequest,
    PlanStatus,
    Robot,
    RobotPlan,
    Waypoint,
)
from yarm.planning.roadmap.cost_queue import CostQueue
from yarm.planning.roadmap.graph import Neighbours, delaunay_edges, neighbours_of
from yarm.planning.roadmap.particles import random_particles

TURN_STEP_DEG = 10.0
NEAR_CELLS = 3.0
"""A remembered path's first waypoint this near is left out when another follows."""


@dataclass(frozen=True)
class Node:
    """A waypoint of a list: column, heading relative to the start (rad), and whether the way to it touches."""

    column: Column
    turn_rad: float
    touches: bool


NodeList = Tuple[Node, ...]


@dataclass(frozen=True)
class Route:
    """A path as it was planned: its waypoints, and for each whether the way to it was found to touch something."""

    path: Tuple[Waypoint, ...]
    touches: Tuple[bool, ...]

    @property
    def blocked(self) -> bool:
        """Whether its first step touches; one that ends where it begins has none."""
        return len(self.path) > 1 and self.touches[1]

    @property
    def length_cells(self) -> float:
        """Sum of the straight ways."""
        return sum(math.dist(a.column, b.column) for a, b in zip(self.path, self.path[1:]))

    def seen_from(self, here: Waypoint) -> Route:
        """The same path from where the robot is in place of where it began."""
        return Route((here, *self.path[1:]), self.touches)

    def without_near_waypoint(self) -> Route:
        """Without its first waypoint when that is near and another follows; the new way is not checked."""
        if len(self.path) > 2 and math.dist(self.path[0].column, self.path[1].column) <= NEAR_CELLS:
            return Route((self.path[0], *self.path[2:]), (self.touches[0], *self.touches[2:]))
        return self


@dataclass
class _Search:
    """One robot's part of the search."""

    robot: Robot
    goal: Goal
    cells: FloatArray
    visited: Set[Column] = field(default_factory=set)
    queue: CostQueue[NodeList] = field(default_factory=CostQueue)
    best: NodeList = ()
    finished: bool = False

    @property
    def open(self) -> bool:
        """Whether it has neither arrived nor run out of lists."""
        return not self.finished and not self.queue.is_empty


class OriginalPlanner:
    """The published planner behind ``FleetPlanner``. Not thread safe."""

    def __init__(self, params: Optional[PlannerParams] = None) -> None:
        """A planner without memory.

        Raises:
            ParamError: a parameter is out of range.
        """
        self.params = build(PlannerParams, dataclasses.asdict(params or PlannerParams()))
        self._kept: Dict[str, Tuple[str, Route]] = {}

    def reset(self) -> None:
        """Forget the previous plan."""
        self._kept = {}

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """Plan one step for the fleet; see ``FleetPlanner``. Steps are not promised to be safe."""
        began = time.perf_counter()
        fault = check.world_fault(request)
        if fault:
            return check.refused(request, fault)
        plans = check.faulty_plans(request)
        searches = self._searches(request, plans)
        particles = self._particles(request, searches, rng)
        edges = delaunay_edges(particles)
        problem = _Map(request, particles, neighbours_of(len(particles), edges), self.params)
        rounds = 0
        while rounds < self.params.iteration_limit and any(search.open for search in searches):
            problem.round(searches)
            rounds += 1
        for search in searches:
            plans[search.robot.name] = self._decide(search, request, rounds)
        elapsed = 1e3 * (time.perf_counter() - began)
        plans = {n: dataclasses.replace(p, planning_ms=elapsed / len(plans)) for n, p in plans.items()}
        status, reason = check.worst(plans)
        return FleetPlan(status, reason, plans, rounds, elapsed, GivenGraph(particles, edges))

    def _searches(self, request: PlanRequest, faulty: Dict[str, RobotPlan]) -> List[_Search]:
        searches = []
        for robot in request.robots:
            goal = check.assigned_goal(robot, request)
            if goal is None or robot.name in faulty:
                continue
            search = _Search(robot, goal, robot.mask.cells.astype(float))
            start = Node((int(robot.column[0]), int(robot.column[1])), 0.0, False)
            search.visited.add(start.column)
            search.queue.push(math.dist(start.column, goal.column), (start,))
            searches.append(search)
        return searches

    def _particles(self, request: PlanRequest, searches: Sequence[_Search], rng: np.random.Generator) -> IntArray:
        """The random draw, and every robot's and goal's column, each once."""
        shape = request.spec.shape[:2]
        drawn = random_particles(self.params.particles, (shape[0], shape[1]), rng)
        ends = [column for search in searches for column in (search.robot.column, search.goal.column)]
        together = np.concatenate([drawn, np.array(ends, dtype=np.int64).reshape(-1, 2)])
        distinct: IntArray = np.unique(together, axis=0)
        return distinct

    def _decide(self, search: _Search, request: PlanRequest, rounds: int) -> RobotPlan:
        """Dynamic re-planning: the new path, the remembered one, or none (see the module)."""
        robot, goal = search.robot, search.goal
        new = None
        if search.finished:
            path = tuple(Waypoint(node.column, wrap_angle(robot.yaw_rad + node.turn_rad)) for node in search.best)
            new = Route(path, tuple(node.touches for node in search.best))
        old = self._remembered(robot, goal)
        chosen = _choose(new, old)
        if chosen is None:
            reason = f"{robot.name} found no list of waypoints to {goal.name} in {rounds} rounds"
            if new is not None or old is not None:
                reason = f"{robot.name} stays: the next step of its path to {goal.name} touches something"
            return RobotPlan(robot.name, goal.name, PlanStatus.TIMEOUT, reason)
        self._kept[robot.name] = (goal.name, chosen)
        step = chosen.path[1] if len(chosen.path) > 1 else None
        return RobotPlan(robot.name, goal.name, PlanStatus.SOLVED, "", chosen.path, step, chosen.length_cells)

    def _remembered(self, robot: Robot, goal: Goal) -> Optional[Route]:
        """The remembered path to the goal, from the robot's present pose."""
        name, route = self._kept.get(robot.name, ("", Route((), ())))
        if name != goal.name or len(route.path) < 2 or route.path[-1].column != tuple(goal.column):
            return None
        return route.seen_from(Waypoint((int(robot.column[0]), int(robot.column[1])), robot.yaw_rad))


def _choose(new: Optional[Route], old: Optional[Route]) -> Optional[Route]:
    """Which of the two a robot takes; None when it stays."""
    if new is not None and (old is None or new.length_cells < old.length_cells):
        return None if new.blocked else new
    if old is not None and not old.blocked:
        return old.without_near_waypoint()
    return new if new is not None and not new.blocked else None


class _Map:
    """The map of a round, and what moving on it costs."""

    def __init__(
        self, request: PlanRequest, particles: IntArray, neighbours: Neighbours, params: PlannerParams
    ) -> None:
        usable = [robot for robot in request.robots if check.robot_fault(robot, request) is None]
        assigned = [robot for robot in usable if robot.name in request.assignments]
        self._fixed = _with_margin(request, assigned, params.original_margin_cells)
        self._shape = np.asarray(request.spec.shape)
        self._touch_cost = float(request.spec.n_cells)
        self._ratio = request.spec.resolution[1] / request.spec.resolution[0]
        self._columns = [(int(x), int(y)) for x, y in particles]
        self._index = {column: i for i, column in enumerate(self._columns)}
        self._neighbours = neighbours
        self._turns = [math.radians(angle) for angle in dict.fromkeys((0.0, *params.turns_deg))]
        self._shapes: Dict[Tuple[str, int], IntArray] = {}

    def round(self, searches: Sequence[_Search]) -> None:
        """Every unfinished robot takes its cheapest list and offers its neighbours, one robot after the other."""
        taken: Dict[str, IntArray] = {}
        for search in searches:
            if search.open:
                search.best = search.queue.pop()[1]
                search.finished = search.best[-1].column == tuple(search.goal.column)
            if search.best:
                taken[search.robot.name] = self._at(search, search.best[-1].column, search.best[-1].turn_rad)
        for search in searches:
            if search.finished or not search.best:
                continue
            others = self._fixed.copy()
            for name, cells in taken.items():
                if name != search.robot.name:
                    self._mark(others, cells)
            swept = self._expand(search, others)
            taken[search.robot.name] = np.concatenate([taken[search.robot.name], *swept])

    def _expand(self, search: _Search, grid: BoolArray) -> List[IntArray]:
        """Push a list for every unvisited neighbour; what was swept for them."""
        last, swept = search.best[-1], []
        for p in self._neighbours[self._index[last.column]]:
            column = self._columns[p]
            if column in search.visited:
                continue
            options = []
            for turn in self._turns:
                cells = self._swept(search, last, column, turn)
                touches = self._is_taken(grid, cells)
                cost = self._touch_cost * touches + abs(math.degrees(turn)) / TURN_STEP_DEG
                options.append((cost, abs(turn), turn, touches, cells))
            cost, _, turn, touches, cells = min(options, key=lambda option: option[:3])
            node = Node(column, wrap_angle(last.turn_rad + turn), touches)
            cost += math.dist(column, search.goal.column) + len(search.best) + 1
            search.queue.push(cost, (*search.best, node))
            search.visited.add(column)
            swept.append(cells)
        return swept

    def _swept(self, search: _Search, last: Node, column: Column, turn: float) -> IntArray:
        """Cells (n, 3) on the way: turns of 10 degrees, then whole cells along the line."""
        steps = round(abs(math.degrees(turn)) / TURN_STEP_DEG)
        parts = [self._at(search, last.column, last.turn_rad + turn * k / steps) for k in range(1, steps)]
        dx, dy = column[0] - last.column[0], column[1] - last.column[1]
        count = max(1, abs(dx), abs(dy))
        for k in range(count + 1):
            place = (last.column[0] + round(dx * k / count), last.column[1] + round(dy * k / count))
            parts.append(self._at(search, place, last.turn_rad + turn))
        return np.concatenate(parts)

    def _at(self, search: _Search, column: Column, turn_rad: float) -> IntArray:
        """Cells of a robot at a column, turned by carrying the centre of every cell along."""
        degrees = round(math.degrees(turn_rad)) % 360
        key = (search.robot.name, degrees)
        if key not in self._shapes:
            c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
            x, y = search.cells[:, 0], search.cells[:, 1] * self._ratio
            turned = np.stack([c * x - s * y, (s * x + c * y) / self._ratio, search.cells[:, 2]], axis=-1)
            self._shapes[key] = np.unique(np.rint(turned).astype(np.int64), axis=0)
        return self._shapes[key] + np.array([column[0], column[1], 0], dtype=np.int64)

    def _is_taken(self, grid: BoolArray, cells: IntArray) -> bool:
        inside = np.all((cells >= 0) & (cells < self._shape), axis=1)
        taken = cells[inside]
        return not bool(inside.all()) or bool(grid[taken[:, 0], taken[:, 1], taken[:, 2]].any())

    def _mark(self, grid: BoolArray, cells: IntArray) -> None:
        inside = cells[np.all((cells >= 0) & (cells < self._shape), axis=1)]
        grid[inside[:, 0], inside[:, 1], inside[:, 2]] = True


def _with_margin(request: PlanRequest, robots: Sequence[Robot], margin_cells: int) -> BoolArray:
    """The robot-less map with its margin; where the robots stand the margin does not count, so that they can leave."""
    standing = check.robotless_grid(request, robots)
    if not margin_cells:
        return standing
    every_neighbour = np.ones((3, 3, 3), dtype=np.bool_)
    inflated: BoolArray = ndimage.binary_dilation(standing, every_neighbour, iterations=margin_cells)
    for robot in robots:
        cells = robot.cells[request.spec.contains(robot.cells)]
        inflated[cells[:, 0], cells[:, 1], cells[:, 2]] = False
    inflated |= standing
    return inflated
