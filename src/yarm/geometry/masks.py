"""Robot masks: the cells a robot occupies, relative to the column of its end effector."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import GridError, GridSpec, IntArray


@dataclass(frozen=True, eq=False)
class Mask:
    """Cells of a robot relative to its end effector's column.

    Attributes:
        cells: (n, 3) int64: dx, dy from the end effector's column, and the absolute z; distinct, ordered.
        yaw_rad: heading the cells are valid for, rad.
    """

    cells: IntArray
    yaw_rad: float = 0.0

    @staticmethod
    def from_cells(cells: npt.ArrayLike, column: Tuple[int, int], yaw_rad: float = 0.0) -> Mask:
        """Mask of absolute cells (n, 3) of a robot whose end effector is in the given column.

        Raises:
            GridError: no cells.
        """
        relative = np.unique(np.asarray(cells, dtype=np.int64).reshape(-1, 3) - (column[0], column[1], 0), axis=0)
        if len(relative) == 0:
            raise GridError("a robot's mask must have at least one cell")
        return Mask(relative, yaw_rad)

    def at(self, column: Tuple[int, int]) -> IntArray:
        """Absolute cells (n, 3), possibly outside the grid, with the end effector in the given column."""
        return self.cells + np.array([column[0], column[1], 0], dtype=np.int64)

    def turned_by_quarters(self, quarters: int) -> Mask:
        """The mask after turning about the end effector by right angles, counter-clockwise; columns are squares."""
        x, y, z = self.cells.T
        for _ in range(quarters % 4):
            x, y = -y, x
        cells = np.stack([x, y, z], axis=-1)
        return Mask(cells[np.lexsort((z, y, x))], self.yaw_rad + quarters * 0.5 * math.pi)

    def turned(self, angle_rad: float, spec: GridSpec, samples: int = 3) -> Mask:
        """The mask after turning about the end effector by the angle.

        Every cell is sampled by ``samples`` x ``samples`` points and each point is carried to its new cell, so that
        a turned solid keeps no holes; the result covers the turned shape.
        """
        offsets = (np.arange(samples) + 0.5) / samples - 0.5
        du, dv = np.meshgrid(offsets, offsets, indexing="ij")
        res_x, res_y, _ = spec.resolution
        x = (self.cells[:, 0, None] + du.ravel()) * res_x
        y = (self.cells[:, 1, None] + dv.ravel()) * res_y
        c, s = math.cos(angle_rad), math.sin(angle_rad)
        columns = np.stack([np.rint((c * x - s * y) / res_x), np.rint((s * x + c * y) / res_y)], axis=-1)
        z = np.broadcast_to(self.cells[:, 2, None, None], (*columns.shape[:2], 1))
        cells = np.concatenate([columns, z], axis=-1).reshape(-1, 3).astype(np.int64)
        return Mask(np.unique(cells, axis=0), self.yaw_rad + angle_rad)
