"""A robot's cells as columns relative to its end effector: at one heading, or swept by a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Dict, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, IntArray, Mask
from yarm.planning.bitboard import Board, Layers, Layout, band_rows, dilated, shifted, smear

Group = Tuple[int, IntArray]
"""Bits of the heights occupied, and the (n, 2) relative columns occupied at exactly these heights."""

ARC_CELLS = 0.1
"""Largest way of a shape's outermost point between two sampled angles of a turn, cells."""


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

    def turned(self, start_rad: float, angle_rad: float, resolution: FloatArray) -> Shape:
        """What the shape covers while it turns about the end effector.

        Every column is a solid rectangle; every column that it overlaps at one of many angles is covered.

        Args:
            start_rad: first angle, relative to the shape as it is.
            angle_rad: angle turned from there; 0 for the shape at the first angle alone.
            resolution: size of a cell, m.
        """
        if angle_rad == 0.0 and start_rad == 0.0:
            return self
        size = resolution[:2]
        reach = max(float(np.linalg.norm((np.abs(columns) + 0.5) * size, axis=1).max()) for _, columns in self.groups)
        count = math.ceil(abs(angle_rad) * reach / (ARC_CELLS * float(size.min())))
        angles = start_rad + np.linspace(0.0, angle_rad, count + 1)
        touched = [(bits, _overlapped(columns, angles, size)) for bits, columns in self.groups]
        return Shape(self.layout, tuple((bits, self._distinct(xy[:, 0], xy[:, 1])) for bits, xy in touched))

    def quarters(self, count: int) -> Shape:
        """The shape turned by a number of right angles; for cells as wide as they are long."""
        return Shape(self.layout, tuple((bits, _quarters(columns, count)) for bits, columns in self.groups))

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


def _quarters(columns: IntArray, quarter: int) -> IntArray:
    """Columns (n, 2) turned by a number of right angles."""
    x, y = columns[:, 0], columns[:, 1]
    turned = ((x, y), (-y, x), (-x, -y), (y, -x))[quarter % 4]
    return np.stack(turned, axis=-1)


def _overlapped(columns: IntArray, angles: FloatArray, size: FloatArray) -> IntArray:
    """Columns (k, 2), some repeated, overlapped by columns (n, 2) turned about the origin by any of the angles (a,).

    Two rectangles overlap when their shadows do on each of their four sides' directions.
    """
    centers = (columns * size).astype(np.float32)
    touching = np.float32(1e-6)
    c, s = (np.abs(v).astype(np.float32)[:, None, None] for v in (np.cos(angles), np.sin(angles)))
    cos, sin = (v.astype(np.float32)[:, None] for v in (np.cos(angles), np.sin(angles)))
    x = cos * centers[:, 0] - sin * centers[:, 1]
    y = sin * centers[:, 0] + cos * centers[:, 1]
    home_x, home_y = np.rint(x / size[0]).astype(np.int64), np.rint(y / size[1]).astype(np.int64)
    around = np.arange(-1, 2)
    ix = (home_x[..., None] + np.repeat(around, 3)).astype(np.int64)
    iy = (home_y[..., None] + np.tile(around, 3)).astype(np.int64)
    dx = (ix * size[0]).astype(np.float32) - x[..., None]
    dy = (iy * size[1]).astype(np.float32) - y[..., None]
    half_x, half_y = np.float32(size[0] / 2), np.float32(size[1] / 2)
    hit = np.abs(dx) < half_x + c * half_x + s * half_y - touching
    hit &= np.abs(dy) < half_y + s * half_x + c * half_y - touching
    along, across = cos[..., None] * dx + sin[..., None] * dy, cos[..., None] * dy - sin[..., None] * dx
    hit &= np.abs(along) < half_x + c * half_x + s * half_y - touching
    hit &= np.abs(across) < half_y + s * half_x + c * half_y - touching
    return np.stack([ix[hit], iy[hit]], axis=-1)
