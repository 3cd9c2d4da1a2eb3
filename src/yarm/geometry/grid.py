"""The occupancy grid's geometry: which cell a point lies in and where a cell is (docs/conventions.md, "Grid")."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Tuple

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]
BoolArray = npt.NDArray[np.bool_]

MAX_COLUMN_CELLS = 63
"""Most cells a column may have, so that a column fits one signed 64-bit integer (see ``columns``)."""


class GridError(ValueError):
    """A grid specification or an array handed to it is wrong; the message names the value and what was expected."""


@dataclass(frozen=True)
class GridSpec:
    """A box of space cut into equal cells.

    Attributes:
        shape: number of cells along world x, y, z.
        lower: lower corner, metres, world.
        upper: upper corner (exclusive), metres, world.
    """

    shape: Tuple[int, int, int] = (50, 50, 20)
    lower: Tuple[float, float, float] = (-2.5, -2.5, 0.01)
    upper: Tuple[float, float, float] = (2.5, 2.5, 1.3)

    def __post_init__(self) -> None:
        """Refuse a grid that has no cells or no volume, naming every fault at once.

        Raises:
            GridError: a shape, bound or column height out of range.
        """
        faults = []
        if len(self.shape) != 3 or any(int(n) != n or n < 1 for n in self.shape):
            faults.append(f"shape {self.shape} must be three whole numbers >= 1")
        elif self.shape[2] > MAX_COLUMN_CELLS:
            faults.append(f"shape z {self.shape[2]} must be <= {MAX_COLUMN_CELLS}, so that a column fits one integer")
        bounds = np.array([self.lower, self.upper], dtype=float)
        if bounds.shape != (2, 3) or not np.all(np.isfinite(bounds)) or not np.all(bounds[0] < bounds[1]):
            faults.append(f"lower {self.lower} must be finite and below upper {self.upper} on each axis")
        if faults:
            raise GridError("grid: " + "; ".join(faults))

    @cached_property
    def resolution(self) -> FloatArray:
        """Size of a cell along x, y, z, metres; shape (3,), not to be written to."""
        extent: FloatArray = np.subtract(self.upper, self.lower)
        size: FloatArray = extent / np.asarray(self.shape, dtype=float)
        size.flags.writeable = False
        return size

    @property
    def n_cells(self) -> int:
        """Number of cells."""
        return self.shape[0] * self.shape[1] * self.shape[2]

    def cells_of(self, points: npt.ArrayLike) -> Tuple[IntArray, BoolArray]:
        """Cell of each point: floor((p - lower) / resolution).

        Args:
            points: (..., 3), metres, world; NaN counts as outside.

        Returns:
            cells (..., 3), meaningful only where inside, and inside (...): false for a point outside the box, which
            has no cell.
        """
        xyz = _last_axis(points, 3)
        with np.errstate(invalid="ignore"):
            scaled = np.floor((xyz - np.asarray(self.lower)) / self.resolution)
            inside = np.all((scaled >= 0) & (scaled < np.asarray(self.shape)), axis=-1)
            inside &= np.all(xyz < np.asarray(self.upper), axis=-1)
        return np.where(inside[..., None], scaled, -1.0).astype(np.int64), inside

    def cells_inside(self, points: npt.ArrayLike) -> IntArray:
        """Distinct cells, (n, 3) ordered by x, y, z, of those points (m, 3) that lie in the grid."""
        cells, inside = self.cells_of(points)
        return self.unravel(np.unique(self.ravel(cells[inside])))

    def centres(self, cells: npt.ArrayLike) -> FloatArray:
        """Centre of each cell; cells (..., 3), not necessarily inside -> points (..., 3), metres, world."""
        centre: FloatArray = np.asarray(self.lower) + (_last_axis(cells, 3) + 0.5) * self.resolution
        return centre

    def column_of(self, point: npt.ArrayLike) -> Tuple[int, int]:
        """Cell (x, y), possibly outside the grid, of one point (2,) or (3,), metres, world.

        Raises:
            GridError: the point is not finite.
        """
        xy = np.asarray(point, dtype=float)[:2]
        if not np.all(np.isfinite(xy)):
            raise GridError(f"point {point!r} must be finite")
        column = np.floor((xy - self.lower[:2]) / self.resolution[:2])
        return int(column[0]), int(column[1])

    def column_centre(self, column: Tuple[int, int]) -> Tuple[float, float]:
        """Centre (x, y) of a column of cells, metres, world."""
        x, y = np.asarray(self.lower[:2]) + (np.asarray(column, dtype=float) + 0.5) * self.resolution[:2]
        return float(x), float(y)

    def contains(self, cells: npt.ArrayLike) -> BoolArray:
        """Which of the cells (..., 3) are in the grid; shape (...)."""
        ijk = _last_axis(cells, 3)
        result: BoolArray = np.all((ijk >= 0) & (ijk < np.asarray(self.shape)), axis=-1)
        return result

    def ravel(self, cells: npt.ArrayLike) -> IntArray:
        """Row-major (x, y, z) index of each cell (..., 3), all inside -> (...)."""
        ijk = np.asarray(cells, dtype=np.int64)
        index: IntArray = (ijk[..., 0] * self.shape[1] + ijk[..., 1]) * self.shape[2] + ijk[..., 2]
        return index

    def unravel(self, indices: npt.ArrayLike) -> IntArray:
        """Cells (..., 3) of row-major indices (...)."""
        return np.stack(np.unravel_index(np.asarray(indices, dtype=np.int64), self.shape), axis=-1).astype(np.int64)


def _last_axis(values: npt.ArrayLike, n: int) -> FloatArray:
    array = np.asarray(values, dtype=float)
    if array.size == 0 and array.ndim < 2:
        return np.zeros((0, n))
    if array.shape[-1:] != (n,):
        raise GridError(f"array of shape {array.shape} must end in an axis of {n}")
    return array
