"""Squares of ground anchored at the map frame's origin: what is remembered there survives any change of the map."""

from __future__ import annotations

from typing import Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, IntArray, Pose2
from yarm.navigation.grid_map import GridMap

HALF_M = 25.0
"""Ground up to this far from the map frame's origin is remembered; what lies beyond falls on the outermost squares."""

Index = Tuple[IntArray, IntArray]
"""Rows and columns of an array of squares."""


class Squares:
    """Where points and the cells of maps fall.

    Args:
        edge_m: of a square.
    """

    def __init__(self, edge_m: float) -> None:
        self.edge_m = edge_m
        self.count = round(2.0 * HALF_M / edge_m)
        self._of: Optional[Tuple[Tuple[int, ...], float, Pose2]] = None
        self._cells: Index = (np.zeros((0, 0), np.int64), np.zeros((0, 0), np.int64))

    def of_points(self, points: FloatArray) -> Index:
        """Index (n,) of points (n, 2) of the map frame, metres."""
        at = np.clip(np.floor((points + HALF_M) / self.edge_m), 0, self.count - 1).astype(np.int64)
        return at[:, 1], at[:, 0]

    def of_map(self, grid_map: GridMap) -> Index:
        """Index (rows, columns) of the centres of a map's cells; kept while maps have the same cells."""
        key = (grid_map.cells.shape, grid_map.resolution_m, grid_map.origin)
        if key != self._of:
            cells = np.argwhere(np.ones(grid_map.cells.shape, bool))
            rows, columns = self.of_points(grid_map.centres_of(cells))
            self._of = key
            self._cells = (rows.reshape(grid_map.cells.shape), columns.reshape(grid_map.cells.shape))
        return self._cells

    def centres(self, first: int, last: int) -> FloatArray:
        """(last - first,) coordinate of the centres of squares, metres, along either axis."""
        centres: FloatArray = (np.arange(first, last) + 0.5) * self.edge_m - HALF_M
        return centres

    def span(self, at_m: float, reach_m: float) -> slice:
        """Squares along one axis within a reach of a coordinate, metres."""
        first = int((at_m - reach_m + HALF_M) / self.edge_m)
        last = int((at_m + reach_m + HALF_M) / self.edge_m) + 1
        return slice(min(max(first, 0), self.count), min(max(last, 0), self.count))
