"""Sets of columns as one big integer each, and sets of cells as one integer for each height.

Union, shift and overlap of whole maps cost a fraction of a microsecond (docs/planning.md, "How it becomes fast").

Bit ``(x + border) * stride + (y + border)`` stands for column (x, y). The border around the grid is wide enough for
every robot, so that shifting a shape by any column of the grid neither loses a bit nor carries one into a wrong row.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import BoolArray, IntArray

ColumnSet = int
"""A set of columns, one bit for each, as ``Layout`` says."""

CellSet = Tuple[int, ...]
"""A set of cells: one set of columns for each height z."""


@dataclass(frozen=True)
class Layout:
    """How columns are laid out in a set of columns.

    Attributes:
        shape: cells of the grid along x, y, z.
        border: columns around the grid on each side that a set of columns can still hold.
    """

    shape: Tuple[int, int, int]
    border: int

    @cached_property
    def stride(self) -> int:
        """Distance in bits between (x, y) and (x + 1, y)."""
        return self.shape[1] + 2 * self.border

    def bit(self, x: int, y: int) -> int:
        """Number of the bit of a column."""
        return (x + self.border) * self.stride + y + self.border

    def rectangle(self, x0: int, x1: int, y0: int, y1: int) -> ColumnSet:
        """Set of the columns x0 <= x <= x1, y0 <= y <= y1; empty when there are none."""
        if x1 < x0 or y1 < y0:
            return 0
        row = (1 << (y1 - y0 + 1)) - 1
        return _repeat(row, x1 - x0 + 1, self.stride) << self.bit(x0, y0)

    @cached_property
    def field(self) -> ColumnSet:
        """Set of every column of the grid."""
        return self.rectangle(0, self.shape[0] - 1, 0, self.shape[1] - 1)

    def set_of_columns(self, columns: npt.ArrayLike) -> ColumnSet:
        """Set of columns (n, 2), each at most ``border`` outside the grid."""
        xy = np.asarray(columns, dtype=np.int64).reshape(-1, 2)
        return _pack(self.bits(xy[:, 0], xy[:, 1]), self.size)

    def set_of_image(self, image: BoolArray) -> ColumnSet:
        """Set of a boolean image (gx, gy)."""
        return self.set_of_columns(np.argwhere(image))

    def image_of_set(self, column_set: ColumnSet) -> BoolArray:
        """Boolean image (gx, gy) of a set's columns that lie in the grid."""
        b = self.border
        image = self._bits_of_set(column_set).reshape(-1, self.stride)[b : b + self.shape[0], b : b + self.shape[1]]
        return np.ascontiguousarray(image)

    def windows_of_sets(self, column_sets: Sequence[ColumnSet]) -> BoolArray:
        """Boolean images (n, 2 border + 1, 2 border + 1) of the sets' columns around column (0, 0)."""
        side = 2 * self.border + 1
        within, count = (1 << side * self.stride) - 1, (side * self.stride + 7) // 8
        raw = b"".join((column_set & within).to_bytes(count, "little") for column_set in column_sets)
        packed = np.frombuffer(raw, dtype=np.uint8).reshape(-1, count)
        bits = np.unpackbits(packed, axis=1, bitorder="little")[:, : side * self.stride]
        windows: BoolArray = bits.reshape(-1, side, self.stride)[:, :, :side].astype(np.bool_)
        return windows

    def sets_of_windows(self, windows: BoolArray) -> Tuple[ColumnSet, ...]:
        """The sets whose ``windows_of_sets`` some images are."""
        flags = np.zeros((*windows.shape[:2], self.stride), dtype=np.uint8)
        flags[:, :, : windows.shape[2]] = windows
        packed = np.packbits(flags.reshape(len(windows), -1), axis=1, bitorder="little")
        return tuple(int.from_bytes(row.tobytes(), "little") for row in packed)

    def _bits_of_set(self, column_set: ColumnSet) -> BoolArray:
        raw = np.frombuffer(column_set.to_bytes((self.size + 7) // 8, "little"), dtype=np.uint8)
        bits: BoolArray = np.unpackbits(raw, bitorder="little")[: self.size].astype(np.bool_)
        return bits

    def set_of_cells(self, cells: IntArray) -> CellSet:
        """The set of cells (n, 3), each at most ``border`` outside the grid in x and y; other heights are ignored."""
        gz = self.shape[2]
        inside = (cells[:, 2] >= 0) & (cells[:, 2] < gz)
        x, y, z = cells[inside].T
        return self.sets_of_bits(z, self.bits(x, y), gz)

    def set_of_grid(self, occupied: BoolArray) -> CellSet:
        """The set of a boolean grid (gx, gy, gz)."""
        gx, gy, gz = self.shape
        flags = np.zeros((gz, gx, self.stride), dtype=np.uint8)
        flags[:, :, :gy] = occupied.transpose(2, 0, 1)
        packed = np.packbits(flags.reshape(gz, -1), axis=1, bitorder="little")
        origin = self.bit(0, 0)
        return tuple(int.from_bytes(row.tobytes(), "little") << origin for row in packed)

    def cells_of_set(self, cell_set: CellSet) -> IntArray:
        """Cells (n, 3) of a set that lie in the grid."""
        grid = np.stack([self.image_of_set(column_set) for column_set in cell_set], axis=-1)
        return np.argwhere(grid).astype(np.int64)

    @cached_property
    def size(self) -> int:
        """Number of bits of a set of columns."""
        return (self.shape[0] + 2 * self.border) * self.stride

    def sets_of_bits(self, which: IntArray, bits: IntArray, count: int) -> Tuple[ColumnSet, ...]:
        """So many sets of columns from numbers of bits (n,) and the number (n,) of the set that each is in."""
        flags = np.zeros((count, self.size), dtype=np.uint8)
        flags[which, bits] = 1
        packed = np.packbits(flags, axis=1, bitorder="little")
        return tuple(int.from_bytes(row.tobytes(), "little") for row in packed)

    def bits(self, x: IntArray, y: IntArray) -> IntArray:
        """Numbers of the bits of columns x (n,), y (n,)."""
        bits: IntArray = (x + self.border) * self.stride + y + self.border
        return bits


def shifted(column_set: ColumnSet, bits: int) -> ColumnSet:
    """The set moved up by a number of bits (down when negative)."""
    return column_set << bits if bits >= 0 else column_set >> -bits


def dilated(cell_set: CellSet, stride: int) -> CellSet:
    """The set inflated by a margin of one cell: every cell that has a set one among itself and its 26 neighbours."""
    inflated = []
    for z, layer in enumerate(cell_set):
        below = cell_set[z - 1] if z else 0
        above = cell_set[z + 1] if z + 1 < len(cell_set) else 0
        column = layer | below | above
        if column:
            row = column | column << 1 | column >> 1
            column = row | row << stride | row >> stride
        inflated.append(column)
    return tuple(inflated)


def union(a: CellSet, b: CellSet) -> CellSet:
    """Cells in either."""
    return tuple(p | q for p, q in zip(a, b))


def intersection(a: CellSet, b: CellSet) -> CellSet:
    """Cells in both."""
    return tuple(p & q for p, q in zip(a, b))


def difference(a: CellSet, b: CellSet) -> CellSet:
    """Cells in the first but not in the second."""
    return tuple(p & ~q for p, q in zip(a, b))


def overlap(a: CellSet, b: CellSet) -> bool:
    """Whether a cell is in both."""
    return any(p & q for p, q in zip(a, b))


@lru_cache(maxsize=16384)
def band(dx: int, dy: int, stride: int) -> ColumnSet:
    """Columns that a unit square overlaps on its straight way from (0, 0) to (dx, dy), ends included.

    The set's bit ``i * stride + j`` stands for the column (i, j) counted from the lowest x and lowest y of the two
    ends; shift it by the bit of that corner.
    """
    column_set = 0
    for i, j0, j1 in band_rows(dx, dy):
        column_set |= ((1 << (j1 - j0 + 1)) - 1) << (i * stride + j0)
    return column_set


@lru_cache(maxsize=16384)
def band_rows(dx: int, dy: int) -> Tuple[Tuple[int, int, int], ...]:
    """The columns of ``band`` as rows (i, first j, last j).

    At the time t the square overlaps (i, j) when |i - t dx| < 1 and |j - t dy| < 1; so row i is met for t between
    (i - 1) / dx and (i + 1) / dx, and j runs from the floor to the ceiling of t dy over that time.
    """
    nx, ny = abs(dx), abs(dy)
    if nx == 0:
        return ((0, 0, ny),)
    rows = [(i, ny * (i - 1) // nx, -(-ny * (i + 1) // nx)) for i in range(nx + 1)]
    rows[0], rows[nx] = (0, 0, rows[0][2]), (nx, rows[nx][1], ny)
    if (dx < 0) != (dy < 0):
        rows = [(i, ny - j1, ny - j0) for i, j0, j1 in rows]
    return tuple(rows)


def smear(column_set: ColumnSet, length: int) -> ColumnSet:
    """Union of the set shifted by 0, 1, ... length - 1 bits."""
    done = 1
    while done < length:
        step = min(done, length - done)
        column_set |= column_set << step
        done += step
    return column_set


def bits_of(column_set: ColumnSet) -> List[int]:
    """Numbers of the set bits, ascending."""
    bits = []
    while column_set:
        low = column_set & -column_set
        bits.append(low.bit_length() - 1)
        column_set ^= low
    return bits


def _repeat(row: int, times: int, stride: int) -> ColumnSet:
    column_set, have = row, 1
    while have < times:
        step = min(have, times - have)
        column_set |= column_set << (step * stride)
        have += step
    return column_set


def _pack(bits: IntArray, size: int) -> ColumnSet:
    flags = np.zeros(size, dtype=np.uint8)
    flags[bits] = 1
    return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")
