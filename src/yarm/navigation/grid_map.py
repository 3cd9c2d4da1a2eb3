"""A flat occupancy map, as nav_msgs/OccupancyGrid has it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2, pairs

CellArray = npt.NDArray[np.int8]
UNKNOWN = -1
FREE_AT_MOST = 25
"""Values from 0 to this are free."""
OCCUPIED_AT_LEAST = 65
"""Values from this to 100 are occupied; what lies between counts as unknown."""


@dataclass(frozen=True, eq=False)
class GridMap:
    """Cells of a map.

    Attributes:
        cells: (rows, columns) int8, -1 unknown, 0 to 100 occupied; row 0 at the least y, column 0 at the least x.
        resolution_m: side of a cell.
        origin: pose of the outer corner of cell (0, 0) in the map frame; its yaw is 0 unless a file says otherwise.
    """

    cells: CellArray
    resolution_m: float
    origin: Pose2

    @property
    def rows(self) -> int:
        """Number of rows, along y."""
        return int(self.cells.shape[0])

    @property
    def columns(self) -> int:
        """Number of columns, along x."""
        return int(self.cells.shape[1])

    @property
    def free(self) -> BoolArray:
        """(rows, columns) which cells are free."""
        free: BoolArray = (self.cells >= 0) & (self.cells <= FREE_AT_MOST)
        return free

    @property
    def occupied(self) -> BoolArray:
        """(rows, columns) which cells are occupied."""
        occupied: BoolArray = self.cells >= OCCUPIED_AT_LEAST
        return occupied

    @property
    def unknown(self) -> BoolArray:
        """(rows, columns) which cells are neither free nor occupied."""
        unknown: BoolArray = ~(self.free | self.occupied)
        return unknown

    @property
    def known_m2(self) -> float:
        """Area of the free and occupied cells."""
        return float(np.count_nonzero(~self.unknown)) * self.resolution_m**2

    def cell_of(self, x: float, y: float) -> Tuple[int, int]:
        """Row and column of a point of the map frame, metres; it may lie outside the map."""
        local = self.origin.inverse().compose(Pose2(x, y))
        return math.floor(local.y / self.resolution_m), math.floor(local.x / self.resolution_m)

    def cells_of(self, points: FloatArray) -> IntArray:
        """(n, 2) rows and columns of points (n, 2) of the map frame, metres; they may lie outside the map."""
        c, s = np.cos(self.origin.yaw_rad), np.sin(self.origin.yaw_rad)
        dx, dy = points[:, 0] - self.origin.x, points[:, 1] - self.origin.y
        local = pairs(c * dy - s * dx, c * dx + s * dy)
        cells: IntArray = np.floor(local / self.resolution_m).astype(np.int64)
        return cells

    def centre_of(self, row: int, column: int) -> Tuple[float, float]:
        """Centre x, y of a cell in the map frame, metres."""
        c, s = math.cos(self.origin.yaw_rad), math.sin(self.origin.yaw_rad)
        x, y = (column + 0.5) * self.resolution_m, (row + 0.5) * self.resolution_m
        return self.origin.x + c * x - s * y, self.origin.y + s * x + c * y

    def centres_of(self, cells: IntArray) -> FloatArray:
        """(n, 2) centres x, y of cells (n, 2) of row and column in the map frame, metres."""
        c, s = np.cos(self.origin.yaw_rad), np.sin(self.origin.yaw_rad)
        x, y = (cells[:, 1] + 0.5) * self.resolution_m, (cells[:, 0] + 0.5) * self.resolution_m
        return pairs(self.origin.x + c * x - s * y, self.origin.y + s * x + c * y)

    def inside(self, row: int, column: int) -> bool:
        """Whether the cell is in the map."""
        return 0 <= row < self.rows and 0 <= column < self.columns
