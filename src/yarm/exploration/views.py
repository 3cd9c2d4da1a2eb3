"""What a look around from a place would newly see: rays over the map, for many places at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Iterator, Sequence, Tuple, Union

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
Steps = Union[slice, IntArray]
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
        radii = np.arange(1, self._steps + 1, dtype=float)
        area = radii * (2.0 * np.pi / settings.directions)
        area[radii * resolution < settings.near_m] = 0.0
        self._area = area.astype(np.float32)

    def gains(self, cells: IntArray) -> FloatArray:
        """(n, directions) worth of what a ray from each of cells (n, 2) would see, direction 0 along x."""
        count, rays = len(cells), self._settings.directions
        start = np.repeat(self._flat(cells[:, 0], cells[:, 1]), rays)
        total = np.zeros(count * rays, np.float32)
        for first, alive, at, left in self._walk(start, np.tile(np.arange(rays), count), rays):
            area = self._area[first : first + BLOCK]
            if area.any():  # what is too near to be seen only ends rays
                np.multiply(left, self._worth.take(at), out=left)
                total[alive] += area @ left
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
        at = base + _fan(self._map.origin.yaw_rad, settings.directions, self._steps, self._width)[rays]
        flat = np.unique(at[(self._left(at) > self._ends_shown) & (self._worth.take(at) > 0.0)])
        shown: IntArray = np.stack([flat // self._width - self._pad, flat % self._width - self._pad], axis=1)
        return shown

    def together(self, tours: Sequence[Sequence[Look]]) -> FloatArray:
        """(n,) worth of what the looks of each tour show, every cell that a ray hits counted once, at its best."""
        looks = list(dict.fromkeys(look for tour in tours for look in tour))
        number = {look: i for i, look in enumerate(looks)}
        cells, worth, ends = self._seen_by(looks)
        sums = np.zeros(len(tours))
        best = np.zeros(len(self._worth), np.float32)
        inside = slice(self._pad, -self._pad)
        known = best.reshape(-1, self._width)[inside, inside]
        for i, tour in enumerate(tours):
            parts = [slice(ends[number[look]], ends[number[look] + 1]) for look in tour]
            at = np.concatenate([cells[part] for part in parts])
            _raise(best, at, np.concatenate([worth[part] for part in parts]))
            sums[i] = known.sum(dtype=float)
            best[at] = 0.0
        return sums

    def _seen_by(self, looks: Sequence[Look]) -> Tuple[IntArray, RayArray, IntArray]:
        """Flat numbers (m,) of the cells that looks show, their worth (m,), and (n + 1,) where each look's begin."""
        angles = 2.0 * np.pi * np.arange(FINE) / FINE
        places = np.array([place for place, _, _ in looks])
        heading = np.array([look[1] for look in looks])[:, None]
        turn = np.array([look[2] for look in looks])[:, None]
        apart = np.abs(np.remainder(angles - heading - 0.5 * turn + np.pi, 2.0 * np.pi) - np.pi)
        of, ray = np.nonzero(apart <= 0.5 * (np.abs(turn) + self._settings.fov_rad))
        start = self._flat(places[:, 0], places[:, 1])[of]
        near = int(self._settings.near_m / self._map.resolution_m)
        found = [(np.zeros(0, np.int64), np.zeros(0, np.float32), np.zeros(0, np.int64))]
        for first, alive, at, left in self._walk(start, ray, FINE):
            if first + BLOCK <= near:
                continue
            worth = self._worth.take(at)
            counts = (left > self._ends) & (worth > 0.0)
            counts[: max(near - first, 0)] = False
            owner = np.broadcast_to(of[alive], at.shape)
            found.append((at[counts], left[counts] * worth[counts], owner[counts]))
        cells, shown, owners = (np.concatenate(parts) for parts in zip(*found))
        order = np.argsort(owners.astype(np.int16), kind="stable")
        ends = np.concatenate([[0], np.cumsum(np.bincount(owners, minlength=len(looks)))])
        return cells[order], shown[order], ends

    def _walk(self, start: IntArray, ray: IntArray, rays: int) -> Iterator[Tuple[int, Steps, IntArray, RayArray]]:
        """Go along rays until they end, some steps at a time.

        Args:
            start: (n,) flat numbers of the cells where they begin.
            ray: (n,) their directions, of so many all round.
            rays: directions all round.

        Yields:
            The first of these steps, which rays are alive, the flat numbers of the cells there and what is left of the
            rays behind them, (steps, rays alive).
        """
        # Steps run along the first axis here: a few long rows are gone through quickly, many short ones are not.
        by_step = _fan_by_step(self._map.origin.yaw_rad, rays, self._steps, self._width)
        left = np.ones(len(start), np.float32)
        alive: Steps = slice(None)
        for first in range(0, self._steps, BLOCK):
            at = by_step[first : first + BLOCK].take(ray, axis=1)
            at += start
            share = self._passed.take(at)
            share[0] *= left
            np.multiply.accumulate(share, axis=0, out=share)
            left = share[-1].copy()
            yield first, alive, at, share
            kept = np.flatnonzero(left > self._ends)
            if len(kept) == 0:
                break
            start, ray, left = start[kept], ray[kept], left[kept]
            alive = kept if isinstance(alive, slice) else alive[kept]

    def _flat(self, rows: IntArray, columns: IntArray) -> IntArray:
        flat: IntArray = (rows + self._pad) * self._width + columns + self._pad
        return flat

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


@lru_cache(maxsize=8)
def _fan_by_step(yaw_rad: float, directions: int, steps: int, width: int) -> IntArray:
    """The same, (steps, directions)."""
    by_step: IntArray = np.ascontiguousarray(_fan(yaw_rad, directions, steps, width).T)
    by_step.setflags(write=False)
    return by_step


def _raise(best: RayArray, at: IntArray, values: RayArray) -> None:
    """Let no value of an array be less than any that is given (n,) for its place (n,); places come more than once."""
    while True:
        more = values > best[at]
        if not more.any():
            return
        at, values = at[more], values[more]
        best[at] = values  # of several for a place any one may stay: the greater ones come again


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
