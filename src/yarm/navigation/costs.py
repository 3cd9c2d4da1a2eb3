"""How much room there is on a flat map, and where a disc fits.

An occupied cell is a full square: a disc is clear when it touches none.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Optional

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, FloatArray, pairs
from yarm.navigation.grid_map import GridMap

FAR_M = 100.0
"""The clearance that is given where nothing is occupied at all."""


def clearance(grid_map: GridMap) -> FloatArray:
    """(rows, columns) distance from each cell's centre to the centre of the nearest occupied cell, metres."""
    occupied = grid_map.occupied
    if not occupied.any():
        return np.full(occupied.shape, FAR_M)
    distance: FloatArray = ndimage.distance_transform_edt(~occupied, sampling=grid_map.resolution_m)
    return distance


def passable(grid_map: GridMap, radius_m: float, unknown_passable: bool = False) -> BoolArray:
    """(rows, columns) whether a disc centred on the cell touches no occupied cell.

    Args:
        grid_map: the map.
        radius_m: of the disc, metres.
        unknown_passable: whether the disc's centre may be on an unknown cell; its rim may in any case.
    """
    fits = ~blocked(grid_map.occupied, radius_m / grid_map.resolution_m)
    return fits if unknown_passable else fits & grid_map.free


def blocked(occupied: BoolArray, radius_cells: float) -> BoolArray:
    """(rows, columns) whether a disc of this radius, in cells, centred on the cell touches an occupied square."""
    kernel = disc_kernel(radius_cells)
    reach = kernel.shape[0] // 2
    rows, columns = occupied.shape
    wide = np.zeros((rows + 2 * reach, columns + 2 * reach), bool)
    wide[reach : reach + rows, reach : reach + columns] = occupied
    touched = np.zeros_like(occupied)
    half_widths = kernel.sum(axis=1) // 2  # a row of the kernel is one run of cells about its middle
    inflated = wide[:, reach : reach + columns].copy()
    for width in range(int(half_widths.max(initial=-1)) + 1):
        if width:
            inflated |= wide[:, reach - width : reach - width + columns]
            inflated |= wide[:, reach + width : reach + width + columns]
        for row in np.flatnonzero(kernel.any(axis=1) & (half_widths == width)):
            touched |= inflated[row : row + rows]
    return touched


@lru_cache(maxsize=32)
def disc_kernel(radius_cells: float) -> BoolArray:
    """(k, k) cells whose squares a disc of this radius, in cells, touches when it stands on the middle one's centre."""
    reach = int(np.ceil(radius_cells + 0.5))
    gap = np.maximum(np.abs(np.arange(-reach, reach + 1)) - 0.5, 0.0)
    kernel: BoolArray = np.hypot(gap[:, None], gap[None, :]) < radius_cells
    kernel.setflags(write=False)
    return kernel


class Room:
    """The room around single points: exact distances to occupied squares within a reach.

    Args:
        grid_map: the map.
        reach_m: farther than this counts as this far.
    """

    def __init__(self, grid_map: GridMap, reach_m: float) -> None:
        self._map = grid_map
        self._reach_m = reach_m
        self._span = int(np.ceil(reach_m / grid_map.resolution_m)) + 1
        self._padded = np.pad(grid_map.occupied, self._span + 1)
        self._steps = np.arange(-self._span, self._span + 1)

    def distances(self, points: FloatArray) -> FloatArray:
        """(n,) distance of points (n, 2) of the map frame to the nearest occupied square, metres, at most the reach."""
        if len(points) == 0:
            return np.zeros(0)
        cells = self._map.cells_of(points)
        local = self._local(points)
        limit = np.array(self._map.cells.shape)
        held = np.clip(cells, -1, limit)
        steps, resolution = self._steps, self._map.resolution_m
        rows = held[:, 0, None] + steps[None, :]
        columns = held[:, 1, None] + steps[None, :]
        at = self._span + 1
        window = self._padded[
            np.clip(rows + at, 0, self._padded.shape[0] - 1)[:, :, None],
            np.clip(columns + at, 0, self._padded.shape[1] - 1)[:, None, :],
        ]
        gap_y = np.maximum(np.abs((rows + 0.5) * resolution - local[:, 1, None]) - 0.5 * resolution, 0.0)
        gap_x = np.maximum(np.abs((columns + 0.5) * resolution - local[:, 0, None]) - 0.5 * resolution, 0.0)
        square = gap_y[:, :, None] ** 2 + gap_x[:, None, :] ** 2
        square[~window] = np.inf
        nearest: FloatArray = np.sqrt(square.reshape(len(points), -1).min(axis=1))
        return np.minimum(nearest, self._reach_m)

    def _local(self, points: FloatArray) -> FloatArray:
        origin = self._map.origin
        c, s = np.cos(origin.yaw_rad), np.sin(origin.yaw_rad)
        dx, dy = points[:, 0] - origin.x, points[:, 1] - origin.y
        return pairs(c * dx + s * dy, c * dy - s * dx)


def near(grid_map: GridMap, x: float, y: float, radius_m: float) -> BoolArray:
    """(rows, columns) which cells have their centres within a radius of a point of the map frame, metres."""
    row, column = grid_map.cell_of(x, y)
    reach = radius_m / grid_map.resolution_m
    rows = np.arange(grid_map.rows)[:, None] - row
    columns = np.arange(grid_map.columns)[None, :] - column
    within: BoolArray = np.hypot(rows, columns) <= reach
    return within


def drive_cost(
    room_m: FloatArray,
    radius_m: float,
    comfort_m: Optional[float] = None,
    weight: float = 1.0,
    decay_per_m: float = 0.0,
) -> FloatArray:
    """(rows, columns) factor on the length of a way: 1 in the open, up to 1 + weight where the disc only just fits.

    Args:
        room_m: clearance, metres.
        radius_m: of the disc, metres.
        comfort_m: from this clearance on a cell costs its length only; the radius plus 0.2 m when not given.
        weight: what is added where there is no room to spare.
        decay_per_m: what is added falls exponentially at this rate, as in a costmap; 0: linearly.
    """
    comfort = radius_m + 0.2 if comfort_m is None else comfort_m
    factor: FloatArray
    if decay_per_m > 0.0:
        fall = np.exp(-decay_per_m * np.maximum(room_m - radius_m, 0.0))
        factor = 1.0 + weight * np.where(room_m < comfort, fall, 0.0)
        return factor
    short = np.clip((comfort - room_m) / max(comfort - radius_m, 1e-6), 0.0, 1.0)
    factor = 1.0 + weight * short
    return factor
