"""A cleaning round: which cells of a floor a robot's body may stand on, and the way that takes it over all of them.

The robot keeps one heading while it goes from cell to cell: an arm that reaches out over tables and through gaps does
not swing. Of the headings it can turn to where it stands it takes the one that covers most.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, List, Optional, Sequence, Tuple

import fcl
import numpy as np

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2, quaternion_from_rpy, transform_matrix, wrap_angle
from yarm.geometry.solids import Solid
from yarm.manipulation.coverage.floor import Floor
from yarm.manipulation.coverage.spanning_tree import Cell, Coverage, cover
from yarm.manipulation.obstacles.fcl_bodies import fcl_geometry, fcl_manager, fcl_object

MARGIN_M = 0.06
"""Distance that the robot's solids keep to everything."""
STEP_M = 0.05
TURN_STEP_RAD = math.radians(4.0)
HEADINGS = 4
"""Headings that are tried: the robot's own, and the others evenly spread."""
OVER_M = 0.10
"""A cell counts as gone over when the body's middle came so near to its centre."""
MOST_NAMED = 12


class SweepError(ValueError):
    """No round can be planned; the message says why."""


@dataclass(frozen=True, eq=False)
class SweepPlan:
    """A round over a floor.

    Attributes:
        floor: cells, free where the body may stand with the round's heading.
        heading_rad: kept all along.
        coverage: the order of the cells.
        stops: poses of the body at which the way turns, the first cell and the last among them.
    """

    floor: Floor
    heading_rad: float
    coverage: Coverage
    stops: Tuple[Pose2, ...]

    def gone_over(self, track: FloatArray) -> BoolArray:
        """Which cells (gx, gy) a track (n, 2) of the body's middle, metres, went over."""
        cells = np.argwhere(np.ones(self.floor.free.shape, dtype=bool))
        centres = self.floor.centre(cells)
        if not len(track):
            return np.zeros(self.floor.free.shape, dtype=bool)
        nearest = np.array([np.min(np.linalg.norm(track - centre, axis=1)) for centre in centres])
        return np.asarray((nearest < OVER_M).reshape(self.floor.free.shape))


class RobotSpace:
    """Where a robot of known solids may stand on a floor among other solids. Not thread-safe."""

    def __init__(self, robot: Sequence[Solid], things: Sequence[Solid], margin_m: float = MARGIN_M) -> None:
        """Build it.

        Args:
            robot: solids in the frame of the body: origin on the floor under its middle.
            things: what stands about, world.
            margin_m: distance kept.
        """
        self._poses = [solid.pose for solid in robot]
        self._parts = [fcl_object(fcl_geometry(solid, margin_m), solid.pose) for solid in robot]
        self._robot = fcl_manager(self._parts)
        self._things = fcl_manager([fcl_object(fcl_geometry(solid), solid.pose) for solid in things])
        self._empty = not (robot and things)

    def free(self, pose: Pose2) -> bool:
        """Whether nothing is nearer than the margin with the body at a pose."""
        if self._empty:
            return True
        quaternion = quaternion_from_rpy(0.0, 0.0, pose.yaw_rad)
        T_world_body = transform_matrix((pose.x, pose.y, 0.0), quaternion)
        for part, T_body_solid in zip(self._parts, self._poses):
            placed = T_world_body @ T_body_solid
            part.setTransform(fcl.Transform(placed[:3, :3], placed[:3, 3]))
        self._robot.update()
        data = fcl.CollisionData()
        self._robot.collide(self._things, data, fcl.defaultCollisionCallback)
        return not data.result.is_collision

    def straight(self, start: Pose2, goal: Pose2) -> bool:
        """Whether it may go straight from one pose to another, turning evenly on the way."""
        return all(self.free(pose) for pose in _between(start, goal))


def plan_sweep(
    space: RobotSpace, start: Pose2, half_m: float, cell_m: float, heading_rad: Optional[float] = None
) -> SweepPlan:
    """A round over the square floor from -half to half along both axes.

    Args:
        space: where the robot may stand.
        start: of the body.
        half_m: half the floor's side.
        cell_m: size of a cell.
        heading_rad: to keep; None for the one that covers most.

    Raises:
        SweepError: the start is not free, or no cell can be gone to from it.
    """
    if not space.free(start):
        raise SweepError(f"at ({start.x:.2f}, {start.y:.2f}) something is too near to the robot for it to move off")
    chosen = [heading_rad] if heading_rad is not None else _headings(start.yaw_rad)
    best: Optional[Tuple[Tuple[int, int], SweepPlan]] = None
    for number, heading in enumerate(chosen):
        turned = Pose2(start.x, start.y, heading)
        plan = _round(space, turned, half_m, cell_m) if space.straight(start, turned) else None
        if plan is not None:
            score = (int(plan.floor.free.sum()) - len(plan.coverage.unreachable), -number)
            best = max((best, (score, plan)), key=lambda item: item[0]) if best is not None else (score, plan)
    if best is None:
        words = ", ".join(f"{math.degrees(heading):.0f}" for heading in chosen)
        raise SweepError(
            f"from ({start.x:.2f}, {start.y:.2f}) no cell of the floor can be gone to with a heading of {words} deg"
        )
    return best[1]


def named_cells(floor: Floor, cells: IntArray) -> str:
    """Centres of cells (n, 2), metres, in words; the first ``MOST_NAMED`` of many."""
    shown = [f"({x:.2f}, {y:.2f})" for x, y in floor.centre(cells[:MOST_NAMED]).tolist()] if len(cells) else []
    more = len(cells) - len(shown)
    return ", ".join([*shown, f"{more} more"] if more else shown) or "none"


def corners(cells: IntArray) -> IntArray:
    """Of a way of cells (n, 2), each beside the one before, those at which it turns, with both ends (m, 2)."""
    steps = np.diff(cells, axis=0)
    turns = 1 + np.flatnonzero(np.any(steps[1:] != steps[:-1], axis=1))
    kept = sorted({0, *turns.tolist(), len(cells) - 1})
    return np.asarray(cells[kept])


def _headings(first_rad: float) -> List[float]:
    return [wrap_angle(first_rad + 2.0 * math.pi * turn / HEADINGS) for turn in range(HEADINGS)]


def _round(space: RobotSpace, start: Pose2, half_m: float, cell_m: float) -> Optional[SweepPlan]:
    """The round with the heading of the start; None when no cell can be gone to from there."""
    count = round(2.0 * half_m / cell_m)
    lower = np.full(2, -half_m)
    floor = Floor(lower, cell_m, np.ones((count, count), dtype=bool))
    free = np.zeros((count, count), dtype=bool)
    for x, y in np.argwhere(floor.free):
        free[x, y] = all(space.free(pose) for pose in _of_cell(floor, (int(x), int(y)), start.yaw_rad))
    floor = Floor(lower, cell_m, free)
    first = _first(space, floor, start)
    if first is None:
        return None
    coverage = cover(free, first)
    stops = [Pose2(x, y, start.yaw_rad) for x, y in floor.centre(corners(coverage.cells)).tolist()]
    return SweepPlan(floor, start.yaw_rad, coverage, tuple(stops))


def _of_cell(floor: Floor, cell: Cell, heading_rad: float) -> Iterator[Pose2]:
    """Poses of the body in a cell from which the way to any neighbour leads: its centre and the axes through it."""
    (x, y) = floor.centre([cell])[0].tolist()
    steps = math.ceil(0.5 * floor.cell_m / STEP_M)
    yield Pose2(x, y, heading_rad)
    for step in range(1, steps + 1):
        far = 0.5 * floor.cell_m * step / steps
        for dx, dy in ((far, 0.0), (-far, 0.0), (0.0, far), (0.0, -far)):
            yield Pose2(x + dx, y + dy, heading_rad)


def _first(space: RobotSpace, floor: Floor, start: Pose2) -> Optional[Cell]:
    """The nearest free cell that can be gone to straight."""
    cells = np.argwhere(floor.free)
    centres = floor.centre(cells)
    for index in np.argsort(np.linalg.norm(centres - (start.x, start.y), axis=1)):
        x, y = centres[index].tolist()
        if space.straight(start, Pose2(x, y, start.yaw_rad)):
            return int(cells[index][0]), int(cells[index][1])
    return None


def _between(start: Pose2, goal: Pose2) -> Iterator[Pose2]:
    turn = abs(wrap_angle(goal.yaw_rad - start.yaw_rad))
    steps = max(math.ceil(start.distance(goal) / STEP_M), math.ceil(turn / TURN_STEP_RAD), 1)
    for step in range(steps + 1):
        yield start.towards(goal, step / steps)
