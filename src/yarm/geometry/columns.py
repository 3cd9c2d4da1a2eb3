"""Column bit images: a 3-D cell set as one integer a column, bit z set when cell (x, y, z) is in the set.

A 50 x 50 x 20 grid becomes 2 500 integers; union, overlap and margin of whole cell sets become a few array
operations. Images are (gx, gy) arrays of int64 (docs/conventions.md, "Column images").
"""

from __future__ import annotations

from typing import Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import GridError, IntArray

ColumnImage = IntArray


def columns_from_grid(occupied: npt.ArrayLike) -> ColumnImage:
    """Column image (gx, gy) of an array (gx, gy, gz): a cell is set where the value is not 0."""
    grid = np.asarray(occupied)
    if grid.ndim != 3:
        raise GridError(f"grid of shape {grid.shape} must have three axes x, y, z")
    weights = np.left_shift(np.int64(1), np.arange(grid.shape[2], dtype=np.int64))
    image: ColumnImage = (grid != 0) @ weights
    return image


def columns_from_cells(cells: npt.ArrayLike, shape: Tuple[int, int]) -> ColumnImage:
    """Column image of the given columns' shape (gx, gy) from cells (n, 3), all inside."""
    ijk = np.asarray(cells, dtype=np.int64).reshape(-1, 3)
    if len(ijk) and not (np.all(ijk >= 0) and np.all(ijk[:, :2] < np.asarray(shape))):
        raise GridError(f"cells must lie inside the {shape[0]} x {shape[1]} columns")
    image: ColumnImage = np.zeros(shape, dtype=np.int64)
    np.bitwise_or.at(image, (ijk[:, 0], ijk[:, 1]), np.left_shift(np.int64(1), ijk[:, 2]))
    return image


def grid_from_columns(image: ColumnImage, gz: int) -> npt.NDArray[np.bool_]:
    """Boolean array (gx, gy, gz) of a column image."""
    bits = np.arange(gz, dtype=np.int64)
    result: npt.NDArray[np.bool_] = (image[:, :, None] >> bits) & 1 == 1
    return result


def cells_from_columns(image: ColumnImage, gz: int) -> IntArray:
    """Cells (n, 3), ordered by x, y, z, of a column image."""
    return np.argwhere(grid_from_columns(image, gz)).astype(np.int64)


def shifted(image: ColumnImage, dx: int, dy: int) -> ColumnImage:
    """The image moved by (dx, dy) cells; what leaves the grid is lost, what enters is empty."""
    result = np.zeros_like(image)
    gx, gy = image.shape
    if abs(dx) < gx and abs(dy) < gy:
        result[max(dx, 0) : gx + min(dx, 0), max(dy, 0) : gy + min(dy, 0)] = image[
            max(-dx, 0) : gx + min(-dx, 0), max(-dy, 0) : gy + min(-dy, 0)
        ]
    return result


def dilated(image: ColumnImage, gz: int, cells: int = 1) -> ColumnImage:
    """The image inflated by a margin: every cell whose 26 neighbours include a set one, ``cells`` times over."""
    full = (np.int64(1) << np.int64(gz)) - np.int64(1)
    inflated = image
    for _ in range(cells):
        inflated = (inflated | (inflated << np.int64(1)) | (inflated >> np.int64(1))) & full
        inflated = inflated | shifted(inflated, 1, 0) | shifted(inflated, -1, 0)
        inflated = inflated | shifted(inflated, 0, 1) | shifted(inflated, 0, -1)
    return inflated
