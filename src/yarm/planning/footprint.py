"""A robot's cells as columns relative to its end effector: at one heading, or swept by a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Dict, List, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, IntArray, Mask
from yarm.planning.bitboard import Board, Layers, Layout, band_rows, dilated, shifted, smear

Group = Tuple[int, IntArray]
"""Bits of the heights occupied, and the (n, 2) relative columns occupied at exactly these heights."""

_SAMPLES = 3


@dataclass(frozen=True, eq=False)
class Shape:
    """Cells of a robot relative to its end effector's column, grouped by equal columns.

    Attributes:
        layout: the boards' layout; its border is wider than the shape.
        groups: the columns, grouped by the heights they occupy; a column may be in several groups.
    """

    layout: Layout
    groups: Tuple[Group, ...]

    @staticmethod
    def of_mask(mask: Mask, layout: Layout) -> Shape:
        """Shape of a mask; cells above or below the grid are left out."""
        gz = layout.shape[2]
        cells = mask.cells[(mask.cells[:, 2] >= 0) & (mask.cells[:, 2] < gz)]
        keys, owner = np.unique(cells[:, 0] * 2**20 + cells[:, 1] + 2**19, return_inverse=True)
        bits = np.zeros(len(keys), dtype=np.int64)
        np.bitwise_or.at(bits, owner, np.left_shift(np.int64(1), cells[:, 2]))
        columns = np.stack([keys >> 20, (keys & (2**20 - 1)) - 2**19], axis=-1)
        return Shape(layout, tuple((int(value), columns[bits == value]) for value in np.unique(bits)))

    @cached_property
    def bounds(self) -> Tuple[int, int, int, int]:
        """Least and greatest relative x, least and greatest relative y."""
        columns = np.concatenate([columns for _, columns in self.groups] or [np.zeros((1, 2), dtype=np.int64)])
        low, high = columns.min(axis=0), columns.max(axis=0)
        return int(low[0]), int(high[0]), int(low[1]), int(high[1])

    @cached_property
    def layers(self) -> Layers:
        """The cells with the end effector in column (0, 0)."""
        layers = [0] * self.layout.shape[2]
        for bits, columns in self.groups:
            board = self.layout.board_of_columns(columns)
            for z in range(len(layers)):
                if bits >> z & 1:
                    layers[z] |= board
        return tuple(layers)

    @cached_property
    def grown(self) -> Layers:
        """The cells with a margin of one cell."""
        return dilated(self.layers, self.layout.stride)

    @cached_property
    def _rows(self) -> Tuple[Tuple[int, Tuple[Tuple[int, int], ...]], ...]:
        """For each group its bits and the runs (offset in bits, length) of columns side by side in y."""
        result = []
        for bits, columns in self.groups:
            offsets = np.sort(columns[:, 0] * self.layout.stride + columns[:, 1])
            first = np.flatnonzero(np.diff(offsets, prepend=offsets[0] - 2) != 1)
            lengths = np.diff(first, append=len(offsets))
            result.append((bits, tuple((int(offsets[f]), int(n)) for f, n in zip(first, lengths))))
        return tuple(result)

    def at(self, column: Tuple[int, int]) -> Layers:
        """The cells with the end effector in a column."""
        offset = column[0] * self.layout.stride + column[1]
        return tuple(shifted(layer, offset) for layer in self.layers)

    def swept(self, start: Tuple[int, int], end: Tuple[int, int]) -> Layers:
        """The cells swept when the end effector goes straight from one column's centre to another's."""
        stride = self.layout.stride
        rows = band_rows(end[0] - start[0], end[1] - start[1])
        base = min(start[0], end[0]) * stride + min(start[1], end[1])
        swept: Dict[Board, Board] = {0: 0}
        for layer in set(self.layers) - {0}:
            runs: Dict[int, Board] = {}
            board = 0
            for i, j0, j1 in rows:
                length = j1 - j0 + 1
                if length not in runs:
                    runs[length] = smear(layer, length)
                board |= runs[length] << (i * stride + j0)
            swept[layer] = shifted(board, base)
        return tuple(swept[layer] for layer in self.layers)

    def blocked_by(self, occupied: Layers) -> Board:
        """Columns of the end effector at which the shape overlaps occupied cells (a configuration-space obstacle).

        True only for columns from which the shape lies within the layout's border; that is every column of the grid.
        """
        blocked = 0
        for bits, runs in self._rows:
            board, z, rest = 0, 0, bits
            while rest:
                if rest & 1:
                    board |= occupied[z]
                z, rest = z + 1, rest >> 1
            if board:
                smeared: Dict[int, Board] = {}
                for offset, length in runs:
                    if length not in smeared:
                        smeared[length] = smear_down(board, length)
                    blocked |= shifted(smeared[length], -offset)
        return blocked

    def turned(self, angles_rad: Sequence[float], resolution: FloatArray) -> Shape:
        """The shape turned about the end effector by every one of the angles, as one union.

        Every column is sampled by 3 x 3 points, each carried to its new column, as ``Mask.turned`` does.
        """
        spread = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
        du, dv = (grid.ravel() for grid in np.meshgrid(spread, spread, indexing="ij"))
        cosines, sines = np.cos(angles_rad), np.sin(angles_rad)
        groups: List[Group] = []
        for bits, columns in self.groups:
            x = ((columns[:, 0, None] + du) * resolution[0]).ravel()
            y = ((columns[:, 1, None] + dv) * resolution[1]).ravel()
            tx = np.rint((cosines[:, None] * x - sines[:, None] * y) / resolution[0]).astype(np.int64)
            ty = np.rint((sines[:, None] * x + cosines[:, None] * y) / resolution[1]).astype(np.int64)
            groups.append((bits, self._distinct(tx.ravel(), ty.ravel())))
        return Shape(self.layout, tuple(groups))

    def _distinct(self, x: IntArray, y: IntArray) -> IntArray:
        reach = self.layout.border
        flags = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.bool_)
        flags[x + reach, y + reach] = True
        return np.argwhere(flags) - reach


def smear_down(board: Board, length: int) -> Board:
    """Union of the board shifted down by 0, 1, ... length - 1 bits."""
    done = 1
    while done < length:
        step = min(done, length - done)
        board |= board >> step
        done += step
    return board


def border_for(masks: Sequence[Mask]) -> int:
    """Border a layout needs so that each of the masks, at any heading, can stand in any column of the grid."""
    reach = 0.0
    for mask in masks:
        if len(mask.cells):
            reach = max(reach, float(np.hypot(mask.cells[:, 0], mask.cells[:, 1]).max()))
    return math.ceil(reach) + 3


def turn_samples(angle_rad: float, step_rad: float) -> FloatArray:
    """Angles from 0 to the turn's angle, both included, at most a step apart."""
    return np.linspace(0.0, angle_rad, max(2, math.ceil(abs(angle_rad) / step_rad) + 1))
