"""Squares of ground anchored at the map frame's origin: what is remembered there survives any change of the map."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, IntArray, Pose2
from yarm.navigation.grid_map import GridMap

HALF_M = 25.0
"""Ground up to this far from the map frame's origin is remembered; what lies beyond falls on the outermost squares."""


class Squares:
    """Where points and the cells of maps fall.

    Args:
        edge_m: of a square.
    """

    def __init__(self, edge_m: float) -> None:
        self.edge_m = edge_m
        self.count = round(2.0 * HALF_M / edge_m)
        self._of: Optional[Tuple[Tuple[int, ...], float, Pose2]] = None
        self._cells: IntArray = np.zeros((0, 0), np.int64)

    def of_points(self, points: FloatArray) -> IntArray:
        """(n,) flat numbers of the squares of points (n, 2) of the map frame, metres; rows run along y."""
        at = np.clip(np.floor((points + HALF_M) / self.edge_m), 0, self.count - 1).astype(np.int64)
        flat: IntArray = at[:, 1] * self.count + at[:, 0]
        return flat

    def of_map(self, grid_map: GridMap) -> IntArray:
        """(rows, columns) flat numbers of the squares of a map's cells; kept while maps have the same cells."""
        key = (grid_map.cells.shape, grid_map.resolution_m, grid_map.origin)
        if key != self._of:
            cells = np.argwhere(np.ones(grid_map.cells.shape, bool))
            self._of = key
            self._cells = self.of_points(grid_map.centres_of(cells)).reshape(grid_map.cells.shape)
        return self._cells

    def centres(self, first: int, last: int) -> FloatArray:
        """(last - first,) coordinate of the centres of squares, metres, along either axis."""
        centres: FloatArray = (np.arange(first, last) + 0.5) * self.edge_m - HALF_M
        return centres

    def span(self, low_m: float, high_m: float) -> slice:
        """Squares along one axis from a coordinate to another, metres, those included where these lie."""
        first = int((low_m + HALF_M) / self.edge_m)
        last = int((high_m + HALF_M) / self.edge_m) + 1
        return slice(min(max(first, 0), self.count), min(max(last, 0), self.count))
