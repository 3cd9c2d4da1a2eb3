"""What a map is worth against the true arena: share, error of its walls, obstacles detected."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Set, Tuple

import numpy as np
from scipy.ndimage import distance_transform_edt, maximum_filter

from yarm.experiments.explore.record import IN_WORLD
from yarm.experiments.statistics import percentile
from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import CAMERA_Z_M
from yarm.sim.checks.arena_check import EDGE_M, Mappable, mappable
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, BlockKind
from yarm.sim.scenes.arena_maker import outline_of

BESIDE_M = 1.5 * EDGE_M
"""A free cell this near to a thing may be occupied in the map: an outline falls on one cell or the next."""
DETECTED_M = 0.10
DETECTED_SHARE = 0.5
OUTLINE_STEP_M = 0.02
SPURIOUS_M = 0.10
FIT_STEPS = 15
FIT_REACH_M = 0.30
"""Occupied cells farther from any surface take no part in the fit."""


@dataclass(frozen=True)
class WallError:
    """Distances of the occupied cells' centres to the nearest true surface.

    Attributes:
        mean_m: NaN without occupied cells, as the others.
        p95_m: 95th percentile.
        spurious: share of them farther than 0.10 m.
        cells: how many there are.
    """

    mean_m: float
    p95_m: float
    spurious: float
    cells: int


@dataclass(frozen=True, eq=False)
class Obstacle:
    """Something in the room that is no wall.

    Attributes:
        name: of the block.
        low: the scan does not see it.
        outline: (n, 2) points of what of its outline can be seen, world, metres.
    """

    name: str
    low: bool
    outline: FloatArray


class Judge:
    """Knows one arena; made once, asked about many maps."""

    def __init__(self, arena: Arena, truth: Optional[Mappable] = None) -> None:
        """Work out what is mappable, unless it is handed in."""
        self.arena = arena
        self.truth = mappable(arena) if truth is None else truth
        self.boxes = FlatBoxes(arena.blocks)
        centres = self.truth.cells.centres()
        free, faces = self.truth.free.ravel(), self.truth.faces.ravel()
        self._free, self._faces = centres[free], centres[faces]
        self._beside: BoolArray = self.truth.cells.gap_m.ravel()[free] <= BESIDE_M
        self.obstacles = self._obstacles()
        nowhere: IntArray = np.zeros((0, 2), dtype=np.int64)
        self._look_up: Tuple[object, IntArray, IntArray] = (None, nowhere, nowhere)

    def share(self, grid_map: GridMap, world_from_map: Pose2 = IN_WORLD) -> float:
        """Of the mappable cells, those that the map knows, and right.

        A free cell is right where the map is free, or occupied right beside a thing; a face where the map is occupied
        in its cell or one of the eight around it.
        """
        free, faces = self._cells(grid_map, world_from_map)
        occupied = grid_map.occupied
        wide: BoolArray = maximum_filter(occupied, size=3, mode="constant")
        right = _at(grid_map.free, free) | (_at(occupied, free) & self._beside)
        total = len(free) + len(faces)
        return (int(right.sum()) + int(_at(wide, faces).sum())) / total if total else math.nan

    def detected(self, grid_map: GridMap, world_from_map: Pose2, among: Optional[Set[str]] = None) -> Set[str]:
        """Names of the obstacles, of those asked about, that are in the map: half of their visible outline is."""
        asked = [o for o in self.obstacles if among is None or o.name in among]
        if not asked or not grid_map.occupied.any():
            return set()
        distance = distance_transform_edt(~grid_map.occupied, sampling=grid_map.resolution_m)
        near: BoolArray = distance <= DETECTED_M
        found = set()
        for obstacle in asked:
            cells = grid_map.cells_of(world_from_map.inverse().moved(obstacle.outline))
            if _at(near, cells).mean() >= DETECTED_SHARE:
                found.add(obstacle.name)
        return found

    def occupied_points(self, grid_map: GridMap, world_from_map: Pose2 = IN_WORLD) -> FloatArray:
        """(n, 2) centres of the occupied cells in the world, metres."""
        rows, columns = np.nonzero(grid_map.occupied)
        return world_from_map.moved(grid_map.centres_of(np.stack([rows, columns], axis=1)))

    def wall_error(self, points: FloatArray) -> WallError:
        """Of occupied cells at points (n, 2), world, metres."""
        if not len(points):
            return WallError(math.nan, math.nan, math.nan, 0)
        off = np.abs(self.boxes.signed(points)).min(axis=1)
        return WallError(float(off.mean()), percentile(list(off), 95), float((off > SPURIOUS_M).mean()), len(points))

    def best_fit(self, points: FloatArray) -> Pose2:
        """The rigid motion of points (n, 2) that brings them nearest to the true surfaces, as a pose in the world."""
        fit = Pose2(0.0, 0.0)
        for _ in range(FIT_STEPS):
            moved = fit.moved(points)
            target = self.boxes.closest(moved)
            near = np.hypot(*(target - moved).T) <= FIT_REACH_M
            if near.sum() < 3:
                break
            fit = _rigid(moved[near], target[near]).compose(fit)
        return fit

    def _obstacles(self) -> Tuple[Obstacle, ...]:
        cells = self.truth.cells
        to_free = distance_transform_edt(~self.truth.free, sampling=EDGE_M)
        found: List[Obstacle] = []
        for i, block in enumerate(self.arena.blocks):
            if block.kind == BlockKind.WALL:
                continue
            outline = outline_of(block, OUTLINE_STEP_M)
            others = self.boxes.subset(np.delete(np.arange(len(self.boxes)), i))
            bare = others.signed(outline).min(axis=1, initial=math.inf) > 0.01
            index = np.floor((outline - np.array(cells.origin)) / EDGE_M).astype(np.int64)[:, ::-1]
            inside = np.all((index >= 0) & (index < np.array(to_free.shape)), axis=1)
            seen = bare & inside
            seen[seen] = to_free[index[seen, 0], index[seen, 1]] <= BESIDE_M
            if seen.any():
                found.append(Obstacle(block.name, block.size[2] < CAMERA_Z_M, outline[seen]))
        return tuple(found)

    def _cells(self, grid_map: GridMap, world_from_map: Pose2) -> Tuple[IntArray, IntArray]:
        """Cells of the map that hold the free and the face centres; kept for maps on the same raster."""
        raster = (grid_map.origin, grid_map.resolution_m, world_from_map)
        if self._look_up[0] != raster:
            to_map = world_from_map.inverse()
            free, faces = (grid_map.cells_of(to_map.moved(points)) for points in (self._free, self._faces))
            self._look_up = (raster, free, faces)
        return self._look_up[1], self._look_up[2]


class Watcher:
    """Follows a run: gives the share for each map, and keeps when each obstacle was first in one."""

    def __init__(self, judge: Judge, world_from_map: Pose2 = IN_WORLD) -> None:
        """Nothing seen yet."""
        self._judge = judge
        self._world_from_map = world_from_map
        self._unseen = {obstacle.name for obstacle in judge.obstacles}
        self.first_seen: Dict[str, float] = {}

    def __call__(self, now_s: float, grid_map: GridMap) -> float:
        """Share of the arena in this map."""
        for name in sorted(self._judge.detected(grid_map, self._world_from_map, self._unseen)):
            self.first_seen[name] = now_s
            self._unseen.discard(name)
        return self._judge.share(grid_map, self._world_from_map)


def _at(values: BoolArray, cells: IntArray) -> BoolArray:
    """Values at cells (n, 2); False outside."""
    rows, columns = cells[:, 0], cells[:, 1]
    inside = (rows >= 0) & (columns >= 0) & (rows < values.shape[0]) & (columns < values.shape[1])
    found: BoolArray
    if inside.all():
        found = values[rows, columns]
        return found
    found = np.zeros(len(cells), dtype=bool)
    found[inside] = values[cells[inside, 0], cells[inside, 1]]
    return found


def _rigid(points: FloatArray, targets: FloatArray) -> Pose2:
    """The motion that brings points (n, 2) nearest to their targets in the least-squares sense."""
    middle, target = points.mean(axis=0), targets.mean(axis=0)
    a, b = points - middle, targets - target
    yaw = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    turned = Pose2(0.0, 0.0, yaw).moved(middle[None])[0]
    return Pose2(float(target[0] - turned[0]), float(target[1] - turned[1]), yaw)
