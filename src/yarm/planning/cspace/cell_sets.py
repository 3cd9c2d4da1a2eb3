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

Board = int
"""A set of columns."""

Layers = Tuple[int, ...]
"""A set of cells: one board for each height z."""


@dataclass(frozen=True)
class Layout:
    """How columns are laid out in a board.

    Attributes:
        shape: cells of the grid along x, y, z.
        border: columns around the grid on each side that a board can still hold.
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

    def rectangle(self, x0: int, x1: int, y0: int, y1: int) -> Board:
        """Board of the columns x0 <= x <= x1, y0 <= y <= y1; empty when there are none."""
        if x1 < x0 or y1 < y0:
            return 0
        row = (1 << (y1 - y0 + 1)) - 1
        return _repeat(row, x1 - x0 + 1, self.stride) << self.bit(x0, y0)

    @cached_property
    def field(self) -> Board:
        """Board of every column of the grid."""
        return self.rectangle(0, self.shape[0] - 1, 0, self.shape[1] - 1)

    def board_of_columns(self, columns: npt.ArrayLike) -> Board:
        """Board of columns (n, 2), each at most ``border`` outside the grid."""
        xy = np.asarray(columns, dtype=np.int64).reshape(-1, 2)
        return _pack(self._bits(xy[:, 0], xy[:, 1]), self.size)

    def board_of_image(self, image: BoolArray) -> Board:
        """Board of a boolean image (gx, gy)."""
        return self.board_of_columns(np.argwhere(image))

    def image_of_board(self, board: Board) -> BoolArray:
        """Boolean image (gx, gy) of the columns of a board that lie in the grid."""
        raw = np.frombuffer(board.to_bytes((self.size + 7) // 8, "little"), dtype=np.uint8)
        bits = np.unpackbits(raw, bitorder="little")[: self.size].astype(np.bool_)
        b = self.border
        image = bits.reshape(-1, self.stride)[b : b + self.shape[0], b : b + self.shape[1]]
        return np.ascontiguousarray(image)

    def layers_of_cells(self, cells: IntArray) -> Layers:
        """Layers of cells (n, 3), each at most ``border`` outside the grid in x and y; other heights are ignored."""
        gz = self.shape[2]
        inside = (cells[:, 2] >= 0) & (cells[:, 2] < gz)
        x, y, z = cells[inside].T
        flags = np.zeros((gz, self.size), dtype=np.uint8)
        flags[z, self._bits(x, y)] = 1
        packed = np.packbits(flags, axis=1, bitorder="little")
        return tuple(int.from_bytes(row.tobytes(), "little") for row in packed)

    def layers_of_grid(self, occupied: BoolArray) -> Layers:
        """Layers of a boolean grid (gx, gy, gz)."""
        gx, gy, gz = self.shape
        b = self.border
        flags = np.zeros((gz, gx + 2 * b, self.stride), dtype=np.uint8)
        flags[:, b : b + gx, b : b + gy] = occupied.transpose(2, 0, 1)
        packed = np.packbits(flags.reshape(gz, -1), axis=1, bitorder="little")
        return tuple(int.from_bytes(row.tobytes(), "little") for row in packed)

    def cells_of_layers(self, layers: Layers) -> IntArray:
        """Cells (n, 3) of layers that lie in the grid."""
        grid = np.stack([self.image_of_board(board) for board in layers], axis=-1)
        return np.argwhere(grid).astype(np.int64)

    @cached_property
    def size(self) -> int:
        """Number of bits of a board."""
        return (self.shape[0] + 2 * self.border) * self.stride

    def _bits(self, x: IntArray, y: IntArray) -> IntArray:
        bits: IntArray = (x + self.border) * self.stride + y + self.border
        return bits


def shifted(board: Board, bits: int) -> Board:
    """The board moved up by a number of bits (down when negative)."""
    return board << bits if bits >= 0 else board >> -bits


def dilated(layers: Layers, stride: int) -> Layers:
    """Layers grown by a margin of one cell: every cell that has a set one among itself and its 26 neighbours."""
    grown = []
    for z, layer in enumerate(layers):
        below = layers[z - 1] if z else 0
        above = layers[z + 1] if z + 1 < len(layers) else 0
        column = layer | below | above
        if column:
            row = column | column << 1 | column >> 1
            column = row | row << stride | row >> stride
        grown.append(column)
    return tuple(grown)


def union(a: Layers, b: Layers) -> Layers:
    """Cells in either."""
    return tuple(p | q for p, q in zip(a, b))


def intersection(a: Layers, b: Layers) -> Layers:
    """Cells in both."""
    return tuple(p & q for p, q in zip(a, b))


def difference(a: Layers, b: Layers) -> Layers:
    """Cells in the first but not in the second."""
    return tuple(p & ~q for p, q in zip(a, b))


def overlap(a: Layers, b: Layers) -> bool:
    """Whether a cell is in both."""
    return any(p & q for p, q in zip(a, b))


@lru_cache(maxsize=16384)
def band(dx: int, dy: int, stride: int) -> Board:
    """Columns that a unit square overlaps on its straight way from (0, 0) to (dx, dy), ends included.

    The board's bit ``i * stride + j`` stands for the column (i, j) counted from the lowest x and lowest y of the two
    ends; shift it by the bit of that corner.
    """
    board = 0
    for i, j0, j1 in band_rows(dx, dy):
        board |= ((1 << (j1 - j0 + 1)) - 1) << (i * stride + j0)
    return board


@lru_cache(maxsize=16384)
def band_rows(dx: int, dy: int) -> Tuple[Tuple[int, int, int], ...]:
    """The columns of ``band`` as rows (i, first j, last j).

    At the time t the square overlaps (i, j) when |i - t dx| < 1 and |j - t dy| < 1; so row i is met for t between
    (i - 1) / dx and (i + 1) / dx, and j runs from the floor to the ceiling of t dy over that time.
    """
    nx, ny = abs(dx), abs(dy)
    if nx == 0:
        return ((0, 0, ny),)
    rows: List[Tuple[int, int, int]] = []
    for i in range(nx + 1):
        j0 = ny * max(0, i - 1) // nx
        j1 = -((-ny * min(nx, i + 1)) // nx)
        rows.append((i, j0, j1))
    if (dx < 0) != (dy < 0):
        rows = [(i, ny - j1, ny - j0) for i, j0, j1 in rows]
    return tuple(rows)


def smear(board: Board, length: int) -> Board:
    """Union of the board shifted by 0, 1, ... length - 1 bits."""
    done = 1
    while done < length:
        step = min(done, length - done)
        board |= board << step
        done += step
    return board


def bits_of(board: Board) -> List[int]:
    """Numbers of the set bits, ascending."""
    bits = []
    while board:
        low = board & -board
        bits.append(low.bit_length() - 1)
        board ^= low
    return bits


def _repeat(row: int, times: int, stride: int) -> Board:
    board, have = row, 1
    while have < times:
        step = min(have, times - have)
        board |= board << (step * stride)
        have += step
    return board


def _pack(bits: IntArray, size: int) -> Board:
    flags = np.zeros(size, dtype=np.uint8)
    flags[bits] = 1
    return int.from_bytes(np.packbits(flags, bitorder="little").tobytes(), "little")


def union_of(boards: Sequence[Board]) -> Board:
    """Columns in any of the boards."""
    result = 0
    for board in boards:
        result |= board
    return result
