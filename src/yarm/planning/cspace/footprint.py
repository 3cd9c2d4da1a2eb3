"""A robot's cells as columns relative to its end effector: at one heading, or swept by a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Dict, List, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, IntArray, Mask
from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, Layout, band_rows, bits_of, dilated, shifted, smear

Group = Tuple[int, ColumnSet]
"""Bits of the heights occupied, and the relative columns occupied at exactly these heights, around column (0, 0)."""

Turn = Tuple[float, float, float, float]
"""First angle and angle turned from there, rad; size of a cell along x and y, m."""

ARC_CELLS = 0.1
"""Largest way of a shape's outermost point between two sampled angles of a turn, cells."""
_RIGHT_ANGLE = 0.5 * math.pi


@dataclass(frozen=True, eq=False)
class Shape:
    """Cells of a robot relative to its end effector's column, grouped by equal columns.

    Attributes:
        layout: the sets of columns' layout; its border is wider than the shape.
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
        groups: Dict[int, ColumnSet] = {}
        for key, value in zip(keys.tolist(), bits.tolist()):
            column = 1 << layout.bit(key >> 20, (key & (2**20 - 1)) - 2**19)
            groups[value] = groups.get(value, 0) | column
        return Shape(layout, tuple(sorted(groups.items())))

    @cached_property
    def column_set(self) -> ColumnSet:
        """Every relative column occupied at some height."""
        column_set = 0
        for _, columns in self.groups:
            column_set |= columns
        return column_set

    @cached_property
    def bounds(self) -> Tuple[int, int, int, int]:
        """Least and greatest relative x, least and greatest relative y."""
        columns = columns_of(self.column_set or 1 << self.layout.bit(0, 0), self.layout)
        xs, ys = [x for x, _ in columns], [y for _, y in columns]
        return min(xs), max(xs), min(ys), max(ys)

    @cached_property
    def reach(self) -> float:
        """Distance, cells, of the outermost column's centre at most."""
        x0, x1, y0, y1 = self.bounds
        return math.hypot(max(-x0, x1), max(-y0, y1))

    @cached_property
    def cell_set(self) -> CellSet:
        """The cells with the end effector in column (0, 0)."""
        cell_set = [0] * self.layout.shape[2]
        for bits, columns in self.groups:
            for z in range(len(cell_set)):
                if bits >> z & 1:
                    cell_set[z] |= columns
        return tuple(cell_set)

    @cached_property
    def inflated(self) -> CellSet:
        """The cells with a margin of one cell."""
        return dilated(self.cell_set, self.layout.stride)

    @cached_property
    def _rows(self) -> Tuple[Tuple[int, Tuple[Tuple[int, int], ...]], ...]:
        """For each group its bits and the runs (offset in bits, length) of columns side by side in y."""
        origin = self.layout.bit(0, 0)
        result = []
        for bits, columns in self.groups:
            runs = []
            rest = columns
            while rest:
                low = rest & -rest
                first = low.bit_length() - 1
                after = (rest >> first) + 1
                length = (after & -after).bit_length() - 1
                runs.append((first - origin, length))
                rest &= ~(((1 << length) - 1) << first)
            result.append((bits, tuple(runs)))
        return tuple(result)

    def at(self, column: Tuple[int, int]) -> CellSet:
        """The cells with the end effector in a column."""
        offset = column[0] * self.layout.stride + column[1]
        return tuple(shifted(layer, offset) for layer in self.cell_set)

    def swept(self, start: Tuple[int, int], end: Tuple[int, int]) -> CellSet:
        """The cells swept when the end effector goes straight from one column's centre to another's."""
        stride = self.layout.stride
        rows = band_rows(end[0] - start[0], end[1] - start[1])
        base = min(start[0], end[0]) * stride + min(start[1], end[1])
        swept: Dict[ColumnSet, ColumnSet] = {0: 0}
        for layer in set(self.cell_set) - {0}:
            runs: Dict[int, ColumnSet] = {}
            column_set = 0
            for i, j0, j1 in rows:
                length = j1 - j0 + 1
                if length not in runs:
                    runs[length] = smear(layer, length)
                column_set |= runs[length] << (i * stride + j0)
            swept[layer] = shifted(column_set, base)
        return tuple(swept[layer] for layer in self.cell_set)

    def blocked_by(self, occupied: CellSet) -> ColumnSet:
        """Columns of the end effector at which the shape overlaps occupied cells: a configuration-space obstacle.

        T. Lozano-Perez, "Spatial planning: a configuration space approach", IEEE Transactions on Computers 32, 1983.

        True only for columns from which the shape lies within the layout's border; that is every column of the grid.
        """
        blocked = 0
        for bits, runs in self._rows:
            column_set, z, rest = 0, 0, bits
            while rest:
                if rest & 1:
                    column_set |= occupied[z]
                z, rest = z + 1, rest >> 1
            if column_set:
                smeared: Dict[int, ColumnSet] = {}
                for offset, length in runs:
                    if length not in smeared:
                        smeared[length] = smear_down(column_set, length)
                    blocked |= smeared[length] >> offset if offset >= 0 else smeared[length] << -offset
        return blocked

    def turned(self, start_rad: float, angle_rad: float, resolution: FloatArray) -> Shape:
        """What the shape covers while it turns about the end effector.

        Every column is a solid rectangle; every column that it overlaps at one of many angles is covered.

        Args:
            start_rad: first angle, relative to the shape as it is.
            angle_rad: angle turned from there, positive; 0 for the shape at the first angle alone.
            resolution: size of a cell, m.
        """
        quarter = round(start_rad / _RIGHT_ANGLE)
        if resolution[0] != resolution[1] or abs(start_rad - quarter * _RIGHT_ANGLE) >= 1e-6:
            return self._covered((start_rad, angle_rad, float(resolution[0]), float(resolution[1])))
        if angle_rad not in self._from_here:
            self._from_here[angle_rad] = self._covered((0.0, angle_rad, float(resolution[0]), float(resolution[1])))
        return self._from_here[angle_rad].turned_by_quarters(quarter % 4)

    def turned_by_quarters(self, quarters: int) -> Shape:
        """The shape turned about the end effector by right angles, counter-clockwise; cells are squares."""
        if quarters == 0:
            return self
        layout = self.layout
        turned = [layout.set_of_window(np.rot90(layout.window_of_set(columns), quarters)) for _, columns in self.groups]
        return Shape(layout, tuple((bits, columns) for (bits, _), columns in zip(self.groups, turned)))

    @cached_property
    def _from_here(self) -> Dict[float, Shape]:
        """What the shape covers while it turns from its present heading by some angles."""
        return {}

    def _covered(self, turn: Turn) -> Shape:
        groups = []
        for bits, columns in self.groups:
            covered = 0
            for x, y in columns_of(columns, self.layout):
                covered |= _turned_column(x, y, turn, self.layout)
            groups.append((bits, covered))
        return Shape(self.layout, tuple(groups))


def columns_of(column_set: ColumnSet, layout: Layout) -> List[Tuple[int, int]]:
    """Columns (x, y) of a set of columns, in order, those on its border too."""
    stride, border = layout.stride, layout.border
    return [(bit // stride - border, bit % stride - border) for bit in bits_of(column_set)]


def smear_down(column_set: ColumnSet, length: int) -> ColumnSet:
    """Union of the set shifted down by 0, 1, ... length - 1 bits."""
    done = 1
    while done < length:
        step = min(done, length - done)
        column_set |= column_set >> step
        done += step
    return column_set


def border_for(masks: Sequence[Mask]) -> int:
    """Border a layout needs so that each of the masks, at any heading, can stand in any column of the grid."""
    reach = 0.0
    for mask in masks:
        if len(mask.cells):
            reach = max(reach, float(np.hypot(mask.cells[:, 0], mask.cells[:, 1]).max()))
    return math.ceil(reach) + 3


@lru_cache(maxsize=32768)
def _turned_column(x: int, y: int, turn: Turn, layout: Layout) -> ColumnSet:
    """Columns overlapped by one column turned about the origin.

    Args:
        x: the column's x before the turn.
        y: the column's y before the turn.
        turn: see ``Turn``.
        layout: of the sets.

    Between two sampled angles a point is at most ``between`` further out than at the nearer one, so what is touched
    between two samples is found too.
    """
    start, angle, *size = turn
    if start == 0.0 and angle == 0.0:
        return 1 << layout.bit(x, y)
    reach = math.hypot((abs(x) + 0.5) * size[0], (abs(y) + 0.5) * size[1])
    count = math.ceil(abs(angle) * reach / (ARC_CELLS * min(size)))
    angles = start + np.linspace(0.0, angle, count + 1)
    between = reach * (angle / max(count, 1) / 2.0) ** 2 / 2.0
    wider = np.full(count + 1, between)
    wider[[0, -1]] = -1e-6
    return layout.set_of_columns(_overlapped((x * size[0], y * size[1]), angles, wider, size))


def _overlapped(centre: Tuple[float, float], angles: FloatArray, wider: FloatArray, size: Sequence[float]) -> IntArray:
    """Columns (k, 2), some repeated, overlapped by a cell at ``centre`` turned about the origin by the angles (a,).

    Two rectangles overlap when their shadows do on each of their four sides' directions (separating axes: S.
    Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996); ``wider`` (a,), m, is added to the shadows.
    """
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    c, s = np.abs(cos), np.abs(sin)
    x, y = cos * centre[0] - sin * centre[1], sin * centre[0] + cos * centre[1]
    ix = np.rint(x / size[0]).astype(np.int64) + np.repeat(np.arange(-1, 2), 3)
    iy = np.rint(y / size[1]).astype(np.int64) + np.tile(np.arange(-1, 2), 3)
    dx, dy = ix * size[0] - x, iy * size[1] - y
    half_x, half_y = size[0] / 2.0, size[1] / 2.0
    limit_x = half_x + c * half_x + s * half_y + wider[:, None]
    limit_y = half_y + s * half_x + c * half_y + wider[:, None]
    hit = (np.abs(dx) < limit_x) & (np.abs(dy) < limit_y)
    hit &= (np.abs(cos * dx + sin * dy) < limit_x) & (np.abs(cos * dy - sin * dx) < limit_y)
    return np.stack([ix[hit], iy[hit]], axis=-1)
