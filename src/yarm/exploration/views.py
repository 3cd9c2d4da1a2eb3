"""What a look around from a place would newly see: rays over the map, for many places at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray
from yarm.navigation.grid_map import GridMap

MOST_DECAY_M = 1000.0


@dataclass(frozen=True)
class ViewSettings:
    """The camera, and how it is imitated.

    Attributes:
        fov_rad: of the camera.
        range_m: farther is not trusted.
        near_m: nearer is not seen.
        directions: rays all round.
        through_m: so much unknown ground a ray passes before it ends: what lies behind is a guess.
        tight_m: unknown ground with less clearance than this is most likely a part of the wall that is not seen yet ...
        tight_factor: ... and ends a ray so many times as soon.
        decay_m: behind each such length of unknown ground a cell counts 1/e of what it would at the edge; at most
            MOST_DECAY_M, since a ray's way through unknown ground is reckoned by what is left of it.

    Raises:
        ValueError: decay_m is more than that.
    """

    fov_rad: float = np.pi / 3.0
    range_m: float = 4.5
    near_m: float = 0.45
    directions: int = 72
    through_m: float = 1.5
    tight_m: float = 0.2
    tight_factor: float = 6.0
    decay_m: float = 0.8

    def __post_init__(self) -> None:
        if not 0.0 < self.decay_m <= MOST_DECAY_M:
            raise ValueError(f"decay_m is {self.decay_m}: it must be above 0 and at most {MOST_DECAY_M:g}")


RayArray = npt.NDArray[np.float32]
Look = Tuple[Tuple[int, int], float, float]
"""A cell to look from, the heading before and the turn after it, radians, + = left."""
FINE = 180
"""Rays all round when cells are counted one by one."""
BLOCK = 8
"""Steps of a ray between two clearings of rays that have ended."""


class Views:
    """Rays over one map.

    Args:
        grid_map: the map.
        worth: (rows, columns) how much seeing a cell would add, in cells; 0 for what is known.
        room_m: (rows, columns) clearance of each cell, metres.
        settings: of the camera.
    """

    def __init__(
        self, grid_map: GridMap, worth: FloatArray, room_m: FloatArray, settings: ViewSettings = ViewSettings()
    ) -> None:
        self._map = grid_map
        self._settings = settings
        resolution = grid_map.resolution_m
        self._steps = int(settings.range_m / resolution)
        self._pad = self._steps + 2
        self._width = grid_map.columns + 2 * self._pad
        # A step of a ray looks up what is left of it behind a cell, as a share, and what seeing the cell adds.
        tight = grid_map.unknown & (room_m < settings.tight_m)
        passed = np.where(grid_map.unknown, np.where(tight, self._fade(settings.tight_factor), self._fade(1.0)), 1.0)
        self._passed = _framed(np.where(grid_map.occupied, 0.0, passed), self._pad)
        self._worth = _framed(np.where(grid_map.occupied, 0.0, worth), self._pad)
        through = round(settings.through_m / resolution)
        self._ends = self._fade(through - 0.5)
        self._ends_shown = self._fade(through + BLOCK + 0.5)
        self._offsets = _fan(grid_map.origin.yaw_rad, settings.directions, self._steps, self._width)
        radii = np.arange(1, self._steps + 1, dtype=float)
        area = radii * (2.0 * np.pi / settings.directions)
        area[radii * resolution < settings.near_m] = 0.0
        self._area = area.astype(np.float32)

    def gains(self, cells: IntArray) -> FloatArray:
        """(n, directions) worth of what a ray from each of cells (n, 2) would see, direction 0 along x."""
        count, rays = len(cells), self._settings.directions
        base = (cells[:, 0] + self._pad) * self._width + cells[:, 1] + self._pad
        by_step = np.ascontiguousarray(self._offsets.T)
        start = np.repeat(base, rays)
        ray = np.tile(np.arange(rays), count)
        total = np.zeros(count * rays, np.float32)
        left = np.ones(count * rays, np.float32)
        alive = np.arange(count * rays)
        for first in range(0, self._steps, BLOCK):
            # Steps run along the first axis here: a few long rows are gone through quickly, many short ones are not.
            at = start[alive] + by_step[first : first + BLOCK, ray[alive]]
            share = self._passed.take(at)
            share[0] *= left[alive]
            np.multiply.accumulate(share, axis=0, out=share)
            left[alive] = share[-1]
            share *= self._worth.take(at)
            total[alive] += self._area[first : first + BLOCK] @ share
            alive = alive[left[alive] > self._ends]
            if len(alive) == 0:
                break
        gains: FloatArray = total.reshape(count, rays).astype(float)
        return gains

    def shown(self, cell: Tuple[int, int], heading_rad: float, turn_rad: float) -> IntArray:
        """(n, 2) cells worth seeing that a turn at a place would show, by the same rays as the gain."""
        settings = self._settings
        middle = heading_rad + 0.5 * turn_rad
        angles = 2.0 * np.pi * np.arange(settings.directions) / settings.directions
        apart = np.abs(np.remainder(angles - middle + np.pi, 2.0 * np.pi) - np.pi)
        rays = apart <= 0.5 * (abs(turn_rad) + settings.fov_rad)
        base = (cell[0] + self._pad) * self._width + cell[1] + self._pad
        at = base + self._offsets[rays]
        flat = np.unique(at[(self._left(at) > self._ends_shown) & (self._worth.take(at) > 0.0)])
        shown: IntArray = np.stack([flat // self._width - self._pad, flat % self._width - self._pad], axis=1)
        return shown

    def together(self, looks: Sequence[Look]) -> float:
        """Worth of what several looks show, every cell that a ray hits counted once, at its best."""
        fine = _fan(self._map.origin.yaw_rad, FINE, self._steps, self._width)
        angles = 2.0 * np.pi * np.arange(FINE) / FINE
        rays = []
        for (row, column), heading_rad, turn_rad in looks:
            apart = np.abs(np.remainder(angles - heading_rad - 0.5 * turn_rad + np.pi, 2.0 * np.pi) - np.pi)
            chosen = apart <= 0.5 * (abs(turn_rad) + self._settings.fov_rad)
            rays.append((row + self._pad) * self._width + column + self._pad + fine[chosen])
        at = np.concatenate(rays)
        left, worth = self._left(at), self._worth.take(at)
        counts = (left > self._ends) & (worth > 0.0)
        counts[:, : int(self._settings.near_m / self._map.resolution_m)] = False
        cells, worth = at[counts], left[counts] * worth[counts]
        order = np.argsort(worth, kind="stable")
        best = np.zeros(len(self._worth), np.float32)
        best[cells[order]] = worth[order]
        return float(best.sum())

    def _fade(self, cells: float) -> float:
        """What is left of a ray behind so many cells of unknown ground, as a share."""
        return float(np.exp(-cells * self._map.resolution_m / self._settings.decay_m))

    def _left(self, at: IntArray) -> RayArray:
        """(rays, steps) what is left of rays behind the cells, by their flat numbers, that they pass."""
        left: RayArray = np.multiply.accumulate(self._passed.take(at), axis=1)
        return left


@lru_cache(maxsize=8)
def _fan(yaw_rad: float, directions: int, steps: int, width: int) -> IntArray:
    """Flat offsets (directions, steps) of the cells along each ray, over a map that is so many cells wide."""
    angles = 2.0 * np.pi * np.arange(directions) / directions - yaw_rad
    radii = np.arange(1, steps + 1, dtype=float)
    columns = np.rint(np.cos(angles)[:, None] * radii).astype(np.int64)
    rows = np.rint(np.sin(angles)[:, None] * radii).astype(np.int64)
    offsets: IntArray = rows * width + columns
    offsets.setflags(write=False)
    return offsets


def _framed(values: FloatArray, margin: int) -> RayArray:
    """Flat float32 copy of values (rows, columns) with so many zeros all round."""
    rows, columns = values.shape
    framed = np.zeros((rows + 2 * margin, columns + 2 * margin), np.float32)
    framed[margin : margin + rows, margin : margin + columns] = values
    return framed.ravel()


def sweeps(gains: FloatArray, heading_rad: FloatArray, turns_rad: FloatArray, fov_rad: float) -> FloatArray:
    """(n, turns) what is seen from each place when the robot arrives in a heading (n,) and then turns (m,), + = left.

    Args:
        gains: (n, directions), direction 0 along x.
        heading_rad: (n,) at arrival.
        turns_rad: (m,) turns in place, at most a full one.
        fov_rad: of the camera.
    """
    rays = gains.shape[1]
    summed = np.concatenate([np.zeros((len(gains), 1)), np.cumsum(np.tile(gains, (1, 3)), axis=1)], axis=1)
    per_ray = 2.0 * np.pi / rays
    low = heading_rad[:, None] + np.minimum(turns_rad, 0.0)[None, :] - 0.5 * fov_rad
    width = np.minimum(np.rint((np.abs(turns_rad) + fov_rad) / per_ray), rays).astype(np.int64)
    first = np.mod(np.rint(low / per_ray).astype(np.int64), rays)
    rows = np.arange(len(gains))[:, None]
    seen: FloatArray = summed[rows, first + width[None, :]] - summed[rows, first]
    return seen
