"""A robot's cells as columns relative to its end effector: at one heading, or swept by a turn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Dict, Iterable, List, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray, IntArray, Mask
from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, Layout, band_rows, bits_of, dilated, shifted, smear

Group = Tuple[int, ColumnSet]
"""Bits of the heights occupied, and the relative columns occupied at exactly these heights, around column (0, 0)."""

Turn = Tuple[float, float, float, float]
"""First angle and angle turned from there, rad; size of a cell along x and y, m."""

ARC_CELLS = 0.1
"""Largest way of a shape's outermost point between two sampled angles of a turn, cells."""
_AT_ONCE = 64
"""Columns turned at once: more take no less time each, and memory."""
_RIGHT_ANGLE = 0.5 * math.pi
_SAME_RAD = 1e-6


class Smears:
    """Occupied cells as shapes need them, each made when first asked for and kept.

    A shape at several headings, and shapes of equal heights, need the same.
    """

    def __init__(self, occupied: CellSet) -> None:
        """Of cells that shapes are held against."""
        self._occupied = occupied
        self._known: Dict[int, Dict[int, ColumnSet]] = {}

    def at(self, bits: int) -> Dict[int, ColumnSet]:
        """What is occupied at some of the heights ``bits``, by length (see ``smear_down``): 1 and what is known."""
        known = self._known.get(bits)
        if known is None:
            column_set = 0
            for z, layer in enumerate(self._occupied):
                if bits >> z & 1:
                    column_set |= layer
            known = self._known[bits] = {1: column_set}
        return known


def smear_down(known: Dict[int, ColumnSet], length: int) -> ColumnSet:
    """Union of ``known[1]`` shifted down by 0, 1, ... length - 1 bits; it and the lesser ones it needs are added."""
    if length not in known:
        half = (length + 1) // 2
        column_set = smear_down(known, half)
        known[length] = column_set | column_set >> length - half
    return known[length]


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
        stride, border = self.layout.stride, self.layout.border
        columns = self.column_set or 1 << self.layout.bit(0, 0)
        low, high = ((columns & -columns).bit_length() - 1) // stride, (columns.bit_length() - 1) // stride
        rows, folded = columns >> low * stride, 0
        while rows:
            folded |= rows & (1 << stride) - 1
            rows >>= stride
        first, last = (folded & -folded).bit_length() - 1, folded.bit_length() - 1
        return low - border, high - border, first - border, last - border

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
    def _rows(self) -> Tuple[Tuple[int, Tuple[Tuple[int, Tuple[int, ...]], ...]], ...]:
        """For each group its bits and, by length, the offsets in bits of runs of columns side by side in y."""
        origin = self.layout.bit(0, 0)
        result = []
        for bits, columns in self.groups:
            runs: Dict[int, List[int]] = {}
            rest = columns
            while rest:
                low = rest & -rest
                first = low.bit_length() - 1
                after = (rest >> first) + 1
                length = (after & -after).bit_length() - 1
                runs.setdefault(length, []).append(first - origin)
                rest &= ~(((1 << length) - 1) << first)
            result.append((bits, tuple((length, tuple(offsets)) for length, offsets in sorted(runs.items()))))
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
        return self.blocked_among(Smears(occupied))

    def blocked_among(self, smears: Smears) -> ColumnSet:
        """The same for cells that other shapes are held against too."""
        blocked = 0
        for bits, runs in self._rows:
            known = smears.at(bits)
            if known[1]:
                for length, offsets in runs:
                    smeared = known.get(length) or smear_down(known, length)
                    for offset in offsets:
                        blocked |= smeared >> offset if offset >= 0 else smeared << -offset
        return blocked

    def turned(self, start_rad: float, angle_rad: float, resolution: FloatArray) -> Shape:
        """What the shape covers while it turns about the end effector.

        Every column is a solid rectangle; every column that it overlaps at one of many angles is covered.

        Args:
            start_rad: first angle, relative to the shape as it is.
            angle_rad: angle turned from there, positive; 0 for the shape at the first angle alone.
            resolution: size of a cell, m.
        """
        if resolution[0] != resolution[1]:
            return self._covered((start_rad, angle_rad, float(resolution[0]), float(resolution[1])))
        quarters = math.floor((start_rad + _SAME_RAD) / _RIGHT_ANGLE)
        rest = start_rad - quarters * _RIGHT_ANGLE
        turn = (0.0 if abs(rest) < _SAME_RAD else round(rest, 9), angle_rad)
        if turn not in self._from_here:
            self._from_here[turn] = self._covered((*turn, float(resolution[0]), float(resolution[1])))
        return self._from_here[turn].turned_by_quarters(quarters % 4)

    def common(self, other: Shape) -> Shape:
        """The cells that are in another shape too."""
        pairs = [(p & q, a & b) for p, a in self.groups for q, b in other.groups]
        return Shape(self.layout, _grouped([(bits, columns) for bits, columns in pairs if bits and columns]))

    def together(self, *others: Shape) -> Shape:
        """The cells that are in any of the shapes."""
        return Shape(self.layout, _grouped([*self.groups, *(group for other in others for group in other.groups)]))

    def turned_by_quarters(self, quarters: int) -> Shape:
        """The shape turned about the end effector by right angles, counter-clockwise; cells are squares."""
        if quarters == 0:
            return self
        turned = self.layout.sets_of_windows(np.rot90(self._windows, quarters, axes=(1, 2)))
        return Shape(self.layout, tuple((bits, columns) for (bits, _), columns in zip(self.groups, turned)))

    @cached_property
    def _from_here(self) -> Dict[Tuple[float, float], Shape]:
        """What the shape covers in turns that start in the first quarter, by start and angle; the rest is symmetry."""
        return {}

    @cached_property
    def _windows(self) -> BoolArray:
        """Image of each group."""
        return self.layout.windows_of_sets([columns for _, columns in self.groups])

    @cached_property
    def _columns(self) -> List[List[Tuple[int, int]]]:
        """Columns (x, y) of each group."""
        return [columns_of(columns, self.layout) for _, columns in self.groups]

    def _covered(self, turn: Turn) -> Shape:
        table = turned_columns(turn, self.layout)
        table.add(column for columns in self._columns for column in columns)
        groups = []
        for (bits, _), columns in zip(self.groups, self._columns):
            covered = 0
            for column in columns:
                covered |= table[column]
            groups.append((bits, covered))
        return Shape(self.layout, tuple(groups))


def _grouped(groups: Iterable[Group]) -> Tuple[Group, ...]:
    """The same cells with each column in one group, that of all its heights."""
    result: Dict[int, ColumnSet] = {}
    for bits, columns in groups:
        rest = columns
        for known, where in list(result.items()):
            both = where & rest
            if both:
                rest ^= both
                result[known] ^= both
                result[known | bits] = result.get(known | bits, 0) | both
        result[bits] = result.get(bits, 0) | rest
    return tuple(sorted((bits, columns) for bits, columns in result.items() if columns))


def columns_of(column_set: ColumnSet, layout: Layout) -> List[Tuple[int, int]]:
    """Columns (x, y) of a set of columns, in order, those on its border too."""
    stride, border = layout.stride, layout.border
    return [(bit // stride - border, bit % stride - border) for bit in bits_of(column_set)]


def border_for(masks: Sequence[Mask]) -> int:
    """Border a layout needs so that each of the masks, at any heading, can stand in any column of the grid."""
    reach = 0.0
    for mask in masks:
        if len(mask.cells):
            reach = max(reach, float(np.hypot(mask.cells[:, 0], mask.cells[:, 1]).max()))
    return math.ceil(reach) + 3


class _TurnedColumns:
    """Columns overlapped by a column turned about the origin, found for many at once when first asked for, and kept.

    Between two sampled angles a point is at most ``wider`` further out than at the nearer one, so what is touched
    between two samples is found too.
    """

    def __init__(self, turn: Turn, layout: Layout) -> None:
        """Of every column on one turn, see ``Turn``."""
        self._turn, self._layout = turn, layout
        self._known: Dict[Tuple[int, int], ColumnSet] = {}

    def __getitem__(self, column: Tuple[int, int]) -> ColumnSet:
        """Columns that one overlaps, x and y before the turn; it has been added."""
        return self._known[column]

    def add(self, columns: Iterable[Tuple[int, int]]) -> None:
        """Find what some columns overlap that are not known yet."""
        missing = sorted({column for column in columns if column not in self._known})
        start, angle, *size = self._turn
        if start == 0.0 and angle == 0.0:
            self._known.update({column: 1 << self._layout.bit(*column) for column in missing})
        elif missing:
            for part in range(0, len(missing), _AT_ONCE):
                self._find(missing[part : part + _AT_ONCE], start, angle, size)

    def _find(self, columns: List[Tuple[int, int]], start: float, angle: float, size: Sequence[float]) -> None:
        owner, angles, wider = _samples(np.array(columns), start, angle, size)
        centres = np.array(columns)[owner] * np.asarray(size)
        whose, bits = _overlapped(centres, angles, wider, size, self._layout)
        self._known.update(zip(columns, self._layout.sets_of_bits(owner[whose], bits, len(columns))))


@lru_cache(maxsize=128)
def turned_columns(turn: Turn, layout: Layout) -> _TurnedColumns:
    """What columns overlap on a turn, kept for all shapes; ``cache_clear`` forgets it."""
    return _TurnedColumns(turn, layout)


def _samples(
    columns: IntArray, start: float, angle: float, size: Sequence[float]
) -> Tuple[IntArray, FloatArray, FloatArray]:
    """When columns (n, 2) are looked at on a turn: which (a,), its angle (a,), rad, how much wider it is (a,), m."""
    reach = np.hypot(*((np.abs(columns) + 0.5) * size).T)
    count = np.ceil(abs(angle) * reach / (ARC_CELLS * min(size))).astype(np.int64)
    owner = np.repeat(np.arange(len(columns)), count + 1)
    last = np.cumsum(count + 1) - 1
    step = angle / np.maximum(count, 1)
    angles = (np.arange(len(owner)) - (last - count)[owner]) * step[owner]
    angles[last[count > 0]] = angle
    wider = (reach * (step / 2.0) ** 2 / 2.0)[owner]
    wider[[*(last - count), *last]] = -1e-6
    return owner, start + angles, wider


def _overlapped(
    centres: FloatArray, angles: FloatArray, wider: FloatArray, size: Sequence[float], layout: Layout
) -> Tuple[IntArray, IntArray]:
    """Which of the cells at ``centres`` (a, 2), each turned by its angle (a,), overlap which columns: (k,), bits (k,).

    Two rectangles overlap when their shadows do on each of their four sides' directions (separating axes: S.
    Gottschalk, M. C. Lin, D. Manocha, "OBBTree", SIGGRAPH 1996); ``wider`` (a,), m, is added to the shadows.
    """
    cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
    c, s = np.abs(cos), np.abs(sin)
    x, y = cos * centres[:, :1] - sin * centres[:, 1:], sin * centres[:, :1] + cos * centres[:, 1:]
    ix = np.rint(x / size[0]).astype(np.int64) + np.repeat(np.arange(-1, 2), 3)
    iy = np.rint(y / size[1]).astype(np.int64) + np.tile(np.arange(-1, 2), 3)
    dx, dy = ix * size[0] - x, iy * size[1] - y
    half_x, half_y = size[0] / 2.0, size[1] / 2.0
    limit_x = half_x + c * half_x + s * half_y + wider[:, None]
    limit_y = half_y + s * half_x + c * half_y + wider[:, None]
    hit = (np.abs(dx) < limit_x) & (np.abs(dy) < limit_y)
    hit &= (np.abs(cos * dx + sin * dy) < limit_x) & (np.abs(cos * dy - sin * dx) < limit_y)
    return np.nonzero(hit)[0], layout.bits(ix[hit], iy[hit])
