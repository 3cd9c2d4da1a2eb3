"""What was looked for and not seen: left for last, and looked for again when the map near it changes."""

from __future__ import annotations

from typing import Optional

import numpy as np
from scipy import ndimage

from yarm.exploration.squares import Squares
from yarm.geometry import BoolArray, IntArray
from yarm.navigation.grid_map import GridMap

EDGE_M = 0.05
MOST = 3
"""What has failed so often comes back only when everything else is done."""


class FailedViews:
    """Squares of ground, in the map frame, that a look did not show.

    Args:
        near_change_m: a square comes back when the map changes within this of it.
    """

    def __init__(self, near_change_m: float) -> None:
        self._near_change_m = near_change_m
        self._squares = Squares(EDGE_M)
        self._times: IntArray = np.zeros(self._squares.count**2, np.int64)
        self._out: BoolArray = np.zeros(self._squares.count**2, bool)
        self._last: Optional[GridMap] = None

    def add(self, grid_map: GridMap, cells: IntArray) -> None:
        """A look did not show these cells (n, 2)."""
        at = self._squares.of_points(grid_map.centres_of(cells))
        self._times[at] += 1
        self._out[at] = True

    def any(self) -> bool:
        """Whether anything is left for last."""
        return bool(self._out.any())

    def clear(self) -> None:
        """Everything may be looked for again."""
        self._out[:] = False

    def over(self, grid_map: GridMap) -> BoolArray:
        """(rows, columns) which cells of a map are left for last."""
        found: BoolArray = self._out.take(self._squares.of_map(grid_map))
        return found

    def map_changed(self, grid_map: GridMap) -> None:
        """A new map: what lies near its changes comes back; everything does when the map has other cells."""
        last, self._last = self._last, grid_map
        if last is None or not self._out.any():
            return
        if last.cells.shape != grid_map.cells.shape or last.origin != grid_map.origin:
            self._out &= self._times >= MOST
            return
        changed = last.unknown != grid_map.unknown
        reach = max(1, round(self._near_change_m / grid_map.resolution_m))
        near = np.argwhere(ndimage.maximum_filter(changed, 2 * reach + 1))
        at = self._squares.of_points(grid_map.centres_of(near))
        self._out[at] &= self._times[at] >= MOST
