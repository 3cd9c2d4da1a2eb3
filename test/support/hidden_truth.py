"""Whether planned ways lead into things that no camera sees, against the simulator: random cells, Kinect noise on.

A trial is a cell with robots at random places, of whose cameras some are silent. Ways are planned to random goals. Then
a thing that nobody registered walks in from outside, to where it is hidden, and stops; if perception does not show it
there, ways are planned to places in it. All on the map as perception shows it, under each policy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from support.perception_chain import ChainMap
from support.simulated_cell import CAMERAS, SimulatedCell
from yarm.commander.cell_state import CellState
from yarm.commander.params import CommanderParams
from yarm.geometry import BoolArray, CellMap, GridSpec, IntArray, MappedObject
from yarm.geometry.kinds import ObjectKind
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.hidden import HiddenPolicy
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, PlanStatus, Robot, Waypoint
from yarm.planning.verification.checker import sweep_of
from yarm.robots.ankurbot import ANKURBOT_BEAMS, ANKURBOT_DISCS, ARM_REACH_M
from yarm.robots.shapes import RobotShape
from yarm.sim.scenes.bodies import SpawnError
from yarm.sim.scenes.specs import ThingSpec

SPEC = GridSpec()
SHAPE = RobotShape(ANKURBOT_DISCS, ANKURBOT_BEAMS)
THING_M = (0.25, 0.25, 0.30)
WALK_MPS = 1.6
TICKS_A_SET = 4
"""15 sets a second, to save time; the tracker counts seconds, not sets."""
CALIBRATION_SETS = 5
REST_SETS = 4
UID = 1
TRIES = 400


@dataclass
class Count:
    """What became of the plans of some trials, under one policy.

    Attributes:
        hidden: things that perception did not show when the plans were made.
        driven_into: of these, those that some planned way leads into.
        feasible: goals that the policy ``free`` has a way to, where nothing is hidden.
        reached: of these, those that this policy has a way to.
    """

    hidden: int = 0
    driven_into: int = 0
    feasible: int = 0
    reached: int = 0


COUNTED = tuple(vars(Count()))
"""What is counted, in order."""


@dataclass
class Tally:
    """Counts by policy."""

    counts: Dict[HiddenPolicy, Count] = field(default_factory=lambda: {policy: Count() for policy in HiddenPolicy})


class TruthCell:
    """A simulated cell, and one Commander's view of it for each policy."""

    def __init__(self, rng: np.random.Generator, scene: str, silent: int, fenced: bool) -> None:
        """Robots at random places; ``silent`` of the cameras will have no view after calibration."""
        self.cell = SimulatedCell(scene, visibility=True, places=_places(rng))
        params = CommanderParams(starts_clear=True, fenced=fenced)
        self.views = {p: CellState(replace(params, hidden=p.value)) for p in HiddenPolicy}
        for view in self.views.values():
            view.kinds = {body.name: body.kind for body in self.cell.world.bodies.values()}
            view.shapes = {name: SHAPE for name, kind in view.kinds.items() if kind == ObjectKind.MOBILE}
        self.map: Optional[CellMap] = None
        self.cell.world.run(0.5)
        for number in range(CALIBRATION_SETS + REST_SETS):
            self.look(calibrating=number < CALIBRATION_SETS)
        self.cell.silent = tuple(sorted(int(c) for c in rng.choice(CAMERAS, silent, replace=False)))
        self.look()

    def look(self, calibrating: bool = False) -> CellMap:
        """The next set's map, shown to everybody."""
        found = self.cell.next_set(calibrating, TICKS_A_SET)
        self.map = _cell_map(self.cell, found)
        for view in self.views.values():
            view.take_map(self.map)
        return self.map

    def walk_in(self, place: Tuple[float, float], start: Tuple[float, float]) -> bool:
        """Let a thing walk from outside the volume to a place; false when it walks into somebody."""
        world = self.cell.world
        try:
            spec = ThingSpec("thing", ObjectKind.OBSTACLE, *start, 0.5 * THING_M[2] + 0.01, 0.0, THING_M, False)
            world.spawn(spec)
        except SpawnError:
            return False
        world.failures()
        way = np.subtract(place, start)
        world.walk("thing", float(way[0]), float(way[1]), WALK_MPS)
        self.cell.tell()
        sets = math.ceil(float(np.hypot(*way)) / WALK_MPS * 60.0 / TICKS_A_SET) + REST_SETS
        for _ in range(sets):
            self.look()
        return not any("thing" in (c.a.body, c.b.body) for c in world.failures())

    @property
    def thing_cells(self) -> BoolArray:
        """(gx, gy, gz) cells that the thing is in by more than a centimetre."""
        body = self.cell.world.bodies["thing"]
        pose = self.cell.world.transforms()[body.seed_frame]
        return _cells_at(float(pose[0, 3]), float(pose[1, 3]))

    def shown(self) -> bool:
        """Whether the map has something in one of the thing's cells, or beside one."""
        assert self.map is not None
        near = np.argwhere(self.thing_cells)
        low, high = near.min(axis=0) - 1, near.max(axis=0) + 2
        box = tuple(slice(max(0, a), b) for a, b in zip(low, high))
        return any(
            name.startswith("unknown_") and _any_in(found.cells, box) for name, found in self.map.objects.items()
        )

    def ways(self, policy: HiddenPolicy, robot: str, goals: Sequence[Waypoint]) -> List[Optional[BoolArray]]:
        """What a robot sweeps on the way to each goal, (gx, gy, gz); None without a way."""
        view = self.views[policy]
        targets = [Goal("goal", GoalKind.TARGET, at.column, yaw_rad=at.yaw_rad) for at in goals]
        return [_swept(view.request({"goal": target}, {robot: "goal"}), robot) for target in targets]

    def close(self) -> None:
        """Free it."""
        self.cell.close()


def run_trial(seed: int, silent: int, goals: int, tally: Tally, fenced: bool = True) -> None:
    """One trial, of whose cameras so many are silent; so many goals a robot, counts into ``tally``."""
    rng = np.random.default_rng(seed)
    cell = TruthCell(rng, "3m", silent, fenced)
    try:
        robots = sorted(cell.views[HiddenPolicy.FREE].robots)
        _count_feasible(cell, rng, robots, goals, tally)
        place = _hiding_place(cell, rng)
        start = None if place is None else _start(cell, rng, place)
        if place is None or start is None or not cell.walk_in(place, start) or cell.shown():
            return
        places = {robot: _places_in(rng, cell, robot, goals) for robot in robots}
        for policy, count in tally.counts.items():
            ways = [way for robot in robots for way in cell.ways(policy, robot, places[robot])]
            count.hidden += 1
            count.driven_into += any(way is not None and bool((way & cell.thing_cells).any()) for way in ways)
    finally:
        cell.close()


def _count_feasible(cell: TruthCell, rng: np.random.Generator, robots: List[str], goals: int, tally: Tally) -> None:
    columns = [(int(x), int(y)) for x, y in rng.integers(0, 50, (goals, 2))]
    for robot in robots:
        yaw_rad = cell.views[HiddenPolicy.FREE].robots[robot].nominal_yaw_rad
        places = [Waypoint(c, yaw_rad + float(rng.integers(4)) * math.pi / 2) for c in columns]
        ways = {policy: cell.ways(policy, robot, places) for policy in tally.counts}
        feasible = [i for i, way in enumerate(ways[HiddenPolicy.FREE]) if way is not None]
        for policy, count in tally.counts.items():
            count.feasible += len(feasible)
            count.reached += sum(ways[policy][i] is not None for i in feasible)


def _hiding_place(cell: TruthCell, rng: np.random.Generator) -> Optional[Tuple[float, float]]:
    """Where the thing would stand with all its cells hidden, and nobody in them; None when there is no such place."""
    assert cell.map is not None and cell.map.visibility is not None
    hidden = cell.map.visibility.unseen & (cell.map.grid == 0)
    nx, ny, nz = (math.ceil(size / step) for size, step in zip(THING_M, SPEC.resolution))
    room = np.ones((SPEC.shape[0] - nx, SPEC.shape[1] - ny), dtype=bool)
    for x in range(nx):
        for y in range(ny):
            room &= hidden[x : x + room.shape[0], y : y + room.shape[1], :nz].all(axis=2)
    places = np.argwhere(room)
    if not len(places):
        return None
    corner = SPEC.lower[:2] + places[rng.integers(len(places))] * np.asarray(SPEC.resolution[:2])
    middle = corner + 0.5 * np.array([nx, ny]) * np.asarray(SPEC.resolution[:2])
    return float(middle[0]), float(middle[1])


def _start(cell: TruthCell, rng: np.random.Generator, place: Tuple[float, float]) -> Optional[Tuple[float, float]]:
    """A point 0.4 m outside the volume from which a straight way leads to a place past everybody; None without one."""
    assert cell.map is not None
    sides = [(2.9, place[1]), (-2.9, place[1]), (place[0], 2.9), (place[0], -2.9)]
    free = []
    for side in sides:
        points = np.linspace(side, place, 1 + math.ceil(math.dist(side, place) / 0.05))
        if not any((cell.map.grid[_cells_at(x, y)] > 0).any() for x, y in points):
            free.append(side)
    return free[int(rng.integers(len(free)))] if free else None


def _cells_at(x: float, y: float) -> BoolArray:
    """(gx, gy, gz) cells that the thing is in by more than a centimetre when it stands there."""
    middle = np.array([x, y, 0.5 * THING_M[2] + 0.01])
    half = 0.5 * np.array(THING_M) - 0.01
    first = np.floor((middle - half - SPEC.lower) / SPEC.resolution).astype(int)
    last = np.floor((middle + half - SPEC.lower) / SPEC.resolution).astype(int)
    cells = np.zeros(SPEC.shape, dtype=bool)
    cells[tuple(slice(max(0, a), max(0, b + 1)) for a, b in zip(first, last))] = True
    return cells


def _places_in(rng: np.random.Generator, cell: TruthCell, robot: str, goals: int) -> List[Waypoint]:
    """Random places of a robot, wholly inside the volume, at which it would be in the thing."""
    thing, places = cell.thing_cells, []
    middle = np.argwhere(thing).mean(axis=0)[:2]
    yaw_rad = cell.views[HiddenPolicy.FREE].robots[robot].nominal_yaw_rad
    for _ in range(TRIES):
        column = tuple(int(v) for v in np.rint(middle + rng.uniform(-13.0, 13.0, 2)))
        at = Waypoint((column[0], column[1]), yaw_rad + float(rng.integers(4)) * math.pi / 2)
        cells = SHAPE.mask(SPEC, at.yaw_rad).at(at.column)
        if len(places) < goals and SPEC.contains(cells).all() and thing[tuple(cells.T)].any():
            places.append(at)
    return places


def _swept(request: PlanRequest, robot: str) -> Optional[BoolArray]:
    plan = YarmPlanner().plan(request, np.random.default_rng(1)).robots.get(robot)
    if plan is None or plan.status is not PlanStatus.SOLVED:
        return None
    swept = np.zeros(SPEC.shape, dtype=bool)
    here: Robot = next(r for r in request.robots if r.name == robot)
    for waypoint in plan.path[1:]:
        cells: IntArray = sweep_of(request, here, waypoint).cells
        swept[tuple(cells[SPEC.contains(cells)].T)] = True
        here = Robot(robot, waypoint.column, waypoint.yaw_rad, SHAPE.mask(SPEC, waypoint.yaw_rad))
    return swept


def _any_in(cells: IntArray, box: Tuple[slice, ...]) -> bool:
    low, high = np.array([s.start for s in box]), np.array([s.stop for s in box])
    return bool(np.any(np.all((cells >= low) & (cells < high), axis=1)))


def _places(rng: np.random.Generator) -> List[Tuple[float, float, float]]:
    """Middles of robots, x, y, metres, and headings, rad, apart from each other and from table and stand."""
    places: List[Tuple[float, float, float]] = []
    while len(places) < 3:
        x, y = rng.uniform(-2.0, 2.0, 2)
        yaw_rad = float(rng.choice([0.0, 0.5, 1.0, 1.5]) * math.pi)
        tip = (x + ARM_REACH_M * math.cos(yaw_rad), y + ARM_REACH_M * math.sin(yaw_rad))
        inside = max(map(abs, tip)) < 2.4
        apart = all(math.dist((x, y), other[:2]) > 1.9 for other in places)
        if inside and apart and max(abs(x + 0.4) - 1.0, abs(y) - 0.6) > 0.6:
            places.append((float(x), float(y), yaw_rad))
    return places


def _cell_map(cell: SimulatedCell, found: ChainMap) -> CellMap:
    poses, objects = dict(cell.world.transforms()), {}
    for name, cells in found.cells.items():
        body = cell.world.bodies.get(name)
        pose = np.eye(4) if body is None else poses[body.seed_frame]
        kind = str(ObjectKind.OBSTACLE) if body is None else str(body.kind)
        yaw = math.atan2(pose[1, 0], pose[0, 0])
        x, y, z = (float(v) for v in pose[:3, 3])
        objects[name] = MappedObject(
            name, kind, UID, (x, y, z), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)), cells
        )
    return CellMap(cell.world.time_ns * 1e-9, SPEC, found.grid, objects, found.visibility)
