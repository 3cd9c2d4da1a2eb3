"""A map and what the scan has seen that is not in it: marked where a beam ends, cleared where beams pass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.costs import clearance, near
from yarm.navigation.grid_map import FREE_AT_MOST, UNKNOWN, CellArray, GridMap

LETHAL, INSCRIBED = 100, 99
"""Values of a costmap's message: something is in the cell; a disc on the cell's middle touches something."""

BLIND_M = 0.45
"""What is nearer than this to the robot's middle the scan does not see: its least range, from the sensor."""


@dataclass(frozen=True)
class CostmapSettings:
    """How obstacles are taken from scans.

    Attributes:
        obstacle_range_m: what is farther is not marked.
        raytrace_range_m: what is farther is not cleared.
        least_beams: so many beams must end in a cell to mark it.
        least_m: ends of beams nearer to the robot's middle are the robot itself.
    """

    obstacle_range_m: float = 2.5
    raytrace_range_m: float = 3.0
    least_beams: int = 2
    least_m: float = 0.18


class Costmap:
    """A map, marks in its cells, and their union.

    Attributes:
        static: the map as it was given.
        version: changes whenever the union does.
    """

    def __init__(self, static: GridMap, settings: Optional[CostmapSettings] = None) -> None:
        """Nothing seen yet."""
        self._settings = settings or CostmapSettings()
        self.static = static
        self.version = 0
        self._marks: BoolArray = np.zeros(static.cells.shape, bool)
        self._freed: BoolArray = np.zeros(static.cells.shape, bool)
        around = np.ones((3, 3), bool)
        self._explained: BoolArray = ndimage.binary_dilation(static.occupied, around)
        self._merged: Optional[GridMap] = None

    @property
    def marked(self) -> BoolArray:
        """(rows, columns) cells that are taken by something that the map does not have."""
        return self._marks

    @property
    def grid(self) -> GridMap:
        """The union: the map's cells, marks occupied."""
        if self._merged is None:
            cells: CellArray = self.static.cells.copy()
            cells[self._freed & (cells == UNKNOWN)] = FREE_AT_MOST
            cells[self._marks] = LETHAL
            self._merged = GridMap(cells, self.static.resolution_m, self.static.origin)
        return self._merged

    def see(self, pose: Pose2, scan: Scan) -> None:
        """Take in a scan that was made with the robot's base at a pose of the map."""
        before = self._marks.copy()
        self._clear_passed(pose.compose(scan.sensor), scan)
        self._mark_ends(pose, scan)
        if not np.array_equal(before, self._marks):
            self._changed()

    def clear(self, robot: Optional[Pose2] = None) -> None:
        """Forget everything that was seen, but what is so near to the robot that no scan would see it again."""
        blind = near(self.static, robot.x, robot.y, BLIND_M) if robot is not None else np.zeros_like(self._marks)
        kept = self._marks & blind
        if not np.array_equal(kept, self._marks):
            self._marks = kept
            self._changed()

    def clear_unknown(self, pose: Pose2, radius_m: float) -> None:
        """Take unknown cells around the robot for free from now on."""
        freed = self._freed | near(self.static, pose.x, pose.y, radius_m)
        if not np.array_equal(freed, self._freed):
            self._freed = freed
            self._changed()

    def _changed(self) -> None:
        self._merged = None
        self.version += 1

    def _mark_ends(self, pose: Pose2, scan: Scan) -> None:
        """Cells in which enough beams end, unless the map has something there or beside."""
        points = scan.points()
        away = np.hypot(points[:, 0], points[:, 1])
        sensed = np.hypot(points[:, 0] - scan.sensor.x, points[:, 1] - scan.sensor.y)
        points = points[(away > self._settings.least_m) & (sensed <= self._settings.obstacle_range_m)]
        cells = self._inside(self.static.cells_of(pose.moved(points)))
        counts = np.zeros(self._marks.shape, np.int64)
        np.add.at(counts, (cells[:, 0], cells[:, 1]), 1)
        self._marks |= (counts >= self._settings.least_beams) & ~self._explained

    def _clear_passed(self, camera: Pose2, scan: Scan) -> None:
        """Give up marks that beams pass: of the beams over one none ends before its far side, and one is valid."""
        marked = np.argwhere(self._marks)
        if len(marked) == 0:
            return
        cell = self.static.resolution_m
        local = camera.inverse().moved(self.static.centres_of(marked))
        distance, bearing = np.hypot(local[:, 0], local[:, 1]), np.arctan2(local[:, 1], local[:, 0])
        first = np.ceil((bearing - 0.5 * cell / np.maximum(distance, cell) - scan.angle_min_rad) / _step(scan))
        last = np.floor((bearing + 0.5 * cell / np.maximum(distance, cell) - scan.angle_min_rad) / _step(scan))
        ranges = np.where(scan.valid(), scan.ranges, np.nan)
        for i in np.flatnonzero((distance <= self._settings.raytrace_range_m) & (last >= 0) & (first < len(ranges))):
            beams = ranges[max(int(first[i]), 0) : int(last[i]) + 1]
            beams = beams[~np.isnan(beams)]
            if len(beams) and bool(np.all(beams > distance[i] + cell)):
                self._marks[marked[i, 0], marked[i, 1]] = False

    def _inside(self, cells: IntArray) -> IntArray:
        shape = np.array(self._marks.shape)
        kept: IntArray = cells[np.all((cells >= 0) & (cells < shape), axis=1)]
        return kept


def _step(scan: Scan) -> float:
    return max(scan.angle_increment_rad, 1e-9)


def inflated(grid: GridMap, radius_m: float, inflation_m: float, scaling_per_m: float) -> CellArray:
    """(rows, columns) values of a costmap's message: 100 taken, 99 a disc touches, then falling, -1 not known.

    Args:
        grid: the map.
        radius_m: of the disc.
        inflation_m: farther from anything there is no cost.
        scaling_per_m: how fast the cost falls beyond the disc's radius.
    """
    room = clearance(grid)
    fall = (INSCRIBED - 1) * np.exp(-scaling_per_m * np.maximum(room - radius_m, 0.0))
    values = np.where(room <= inflation_m, fall, 0.0)
    values[room <= radius_m] = INSCRIBED
    values[grid.unknown & (room > radius_m)] = UNKNOWN
    values[grid.occupied] = LETHAL
    made: CellArray = values.astype(np.int8)
    return made


def window(grid: GridMap, pose: Pose2, side_m: float) -> GridMap:
    """The part of a map around a pose, at most a square of this side; at least one cell."""
    row, column = grid.cell_of(pose.x, pose.y)
    reach = math.ceil(0.5 * side_m / grid.resolution_m)
    top, left = (int(np.clip(v - reach, 0, n - 1)) for v, n in zip((row, column), grid.cells.shape))
    bottom, right = (int(np.clip(v + reach + 1, 1, n)) for v, n in zip((row, column), grid.cells.shape))
    cells: CellArray = grid.cells[top : max(bottom, top + 1), left : max(right, left + 1)]
    corner = grid.origin.compose(Pose2(left * grid.resolution_m, top * grid.resolution_m))
    return GridMap(cells, grid.resolution_m, corner)


def points_near(grid: GridMap, pose: Pose2, reach_m: float) -> FloatArray:
    """(n, 2) middles of the occupied cells around a pose, in its own axes, metres."""
    part = window(grid, pose, 2.0 * reach_m)
    return pose.inverse().moved(part.centres_of(np.argwhere(part.occupied)))
