"""Configuration space of a fleet: where each end effector may stand, turn and go, as columns (docs/planning.md).

A *pose* is (x, y, h): a column of the grid and an index into the robot's headings. All tables are made when first
asked for and kept for the planning step; what depends on shapes alone is kept by ``ShapeCache`` for the next steps.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import remainder
from typing import Callable, Dict, List, Optional, Sequence, Tuple, TypeVar

import numpy as np

from yarm.geometry import FloatArray, Mask, wrap_angle
from yarm.planning.cspace.cell_sets import (
    CellSet,
    ColumnSet,
    Layout,
    band,
    difference,
    dilated,
    intersection,
    overlap,
    shifted,
    union,
)
from yarm.planning.cspace.footprint import Shape, Smears

T = TypeVar("T")
Pose = Tuple[int, int, int]
"""Column x, y of the end effector and index of the heading."""

SAME_HEADING_RAD = math.radians(0.5)
_HALF_TURN_RAD = math.radians(179.0)
_RIGHT_ANGLE = 0.5 * math.pi
_FULL_TURN_RAD = 2.0 * math.pi
_SAME_TURN_RAD = 1e-6


class ShapeCache:
    """What shapes alone determine, kept from one planning step to the next; the oldest is forgotten first."""

    def __init__(self, limit: int = 512) -> None:
        """Empty, for at most ``limit`` entries."""
        self._limit = limit
        self._entries: OrderedDict[object, object] = OrderedDict()

    def get(self, key: object, make: Callable[[], T]) -> T:
        """The entry of a key, made on the first demand."""
        if key in self._entries:
            self._entries.move_to_end(key)
        else:
            self._entries[key] = make()
            if len(self._entries) > self._limit:
                self._entries.popitem(last=False)
        return self._entries[key]  # type: ignore[return-value]

    def clear(self) -> None:
        """Forget everything."""
        self._entries.clear()


@dataclass(frozen=True)
class Turns:
    """Which turns a robot may make.

    Attributes:
        angles_rad: allowed turns relative to the present heading.
        rad_per_cell: angle that costs as much as one cell of travel.
    """

    angles_rad: Tuple[float, ...]
    rad_per_cell: float

    @property
    def least_rad(self) -> float:
        """Angle of the least allowed turn; 0 when there is none."""
        return min(map(abs, self.angles_rad), default=0.0)


def headings_from(
    yaw_rad: float, turns: Turns, wanted_rad: Optional[float], home_rad: Optional[float] = None, limit: int = 36
) -> Tuple[float, ...]:
    """Every heading reachable by allowed turns, the present one first.

    Those reachable so from ``home_rad`` follow when the present one is none of them, and the wanted one is the last.
    """
    headings = _closed(yaw_rad, turns, limit)
    if home_rad is not None and turns.angles_rad:
        home = _closed(home_rad, turns, limit)
        headings += [] if among(headings[0], home) else [other for other in home if not among(other, headings)]
    if wanted_rad is not None and not among(wanted_rad, headings):
        headings.append(wrap_angle(wanted_rad))
    return tuple(headings)


def among(heading: float, headings: Sequence[float]) -> bool:
    """Whether a heading counts as one of several."""
    return any(abs(remainder(heading - other, _FULL_TURN_RAD)) <= SAME_HEADING_RAD for other in headings)


def _closed(heading: float, turns: Turns, limit: int) -> List[float]:
    """A heading and what turns lead to from it, in the order in which they are come to; at most so many."""
    headings = [wrap_angle(heading)]
    for before, angle in _ways_round(turns.angles_rad, limit):
        headings.append(wrap_angle(headings[before] + angle))
    return headings


@lru_cache(maxsize=64)
def _ways_round(angles_rad: Tuple[float, ...], limit: int) -> Tuple[Tuple[int, float], ...]:
    """For each heading but the first that turns lead to, the number of the one it is come to from, and the turn."""
    headings, ways = [0.0], []
    for i, heading in enumerate(headings):
        for angle in angles_rad:
            new = wrap_angle(heading + angle)
            if len(headings) < limit and not among(new, headings):
                headings.append(new)
                ways.append((i, angle))
    return tuple(ways)


def shape_of(mask: Mask, layout: Layout, cache: ShapeCache) -> Shape:
    """Shape of a mask, kept."""
    return cache.get(("mask", mask.cells.tobytes(), layout), lambda: Shape.of_mask(mask, layout))


class RobotSpace:
    """Configuration space of one robot among things that do not move."""

    def __init__(
        self,
        mask: Mask,
        start: Pose,
        headings: Tuple[float, ...],
        turns: Turns,
        obstacles: CellSet,
        layout: Layout,
        resolution: FloatArray,
        cache: ShapeCache,
        wanted: Optional[int] = None,
        home_rad: Optional[float] = None,
        mask_at: Optional[Callable[[float], Mask]] = None,
    ) -> None:
        """Space of a robot whose mask holds at ``headings[0]``.

        Args:
            mask: present cells relative to the end effector's column.
            start: present pose.
            headings: see ``headings_from``.
            turns: allowed turns.
            obstacles: cells it must not overlap, the margin already added (see ``with_margin``).
            layout: the sets of columns' layout.
            resolution: size of a cell, m.
            cache: kept shapes.
            wanted: index of a heading that may be reached by any turn; None for none.
            home_rad: heading from which turns lead to those that may be reached by any turn less than the least allowed
                one, from headings to which they do not lead; None for none.
            mask_at: the mask at any heading, rad; None to turn the present one.
        """
        self.start = start
        self.headings = headings
        self.turns = turns
        self.obstacles = obstacles
        self.layout = layout
        self.wanted = wanted
        self._resolution = resolution
        self._cache = cache
        self._mask_at = mask_at
        self._key = (mask.cells.tobytes(), layout)
        self.shape0: Shape = shape_of(mask, layout, cache)
        self._shapes: Dict[int, Shape] = {0: self.shape0}
        self._blocked: Dict[int, ColumnSet] = {}
        self._turn_blocked: Dict[Tuple[int, int], ColumnSet] = {}
        self._turn_angles: Dict[Tuple[int, int], Optional[float]] = {}
        self._smears = Smears(obstacles)
        home = () if home_rad is None else headings_from(home_rad, turns, None)
        self._home = [among(heading, home) for heading in headings]

    @property
    def resolution(self) -> FloatArray:
        """Size of a cell, m."""
        return self._resolution

    def shape(self, h: int) -> Shape:
        """Shape at a heading."""
        if h not in self._shapes:
            self._shapes[h] = (
                self._turned(wrap_angle(self.headings[h] - self.headings[0]), 0.0)
                if self._mask_at is None
                else shape_of(self._mask_at(self.headings[h]), self.layout, self._cache)
            )
        return self._shapes[h]

    def turn_shape(self, h: int, k: int) -> Shape:
        """Union of the shapes while turning from one heading to another; a half turn may go either way round."""
        first = wrap_angle(self.headings[h] - self.headings[0])
        angle = wrap_angle(self.headings[k] - self.headings[h])
        angle = angle if abs(angle) < _HALF_TURN_RAD else 2.0 * math.pi
        return self._turned(first, angle) if self._mask_at is None else self._swept_turn(h, k, angle)

    def _swept_turn(self, h: int, k: int, angle: float) -> Shape:
        """What the robot covers on the way from one end of a turn to the other, whichever way it is made.

        The shapes at both ends cover the robot. So whatever it covers in between is covered by the first, turned on,
        and by the second, turned back.
        """
        start, end, angle = (k, h, -angle) if angle < 0.0 else (h, k, angle)
        before, after = self.shape(start), self.shape(end)
        return self._cache.get(
            ("turn", before, after, round(angle, 6)),
            lambda: (
                self._while_turning(start, 0.0, angle)
                .common(self._while_turning(end, -angle, angle))
                .together(before, after)
            ),
        )

    def _while_turning(self, h: int, first: float, angle: float) -> Shape:
        """What the shape at a heading covers from an angle off it, and turned by another from there, rad.

        By symmetry from the same turn in the first quarter, where the shape is just the same there.
        """
        quarters = math.floor(wrap_angle(self.headings[h]) / _RIGHT_ANGLE)
        heading = self.headings[h] - quarters * _RIGHT_ANGLE
        same = [r for r, yaw in enumerate(self.headings) if abs(wrap_angle(yaw - heading)) < _SAME_TURN_RAD]
        square = self._resolution[0] == self._resolution[1]
        if not (quarters and same and square and self._is_turned(same[0], quarters, h)):
            same, quarters = [h], 0
        whose = self.shape(same[0])
        key = ("turning", whose, round(first, 6), round(angle, 6))
        turning = self._cache.get(key, lambda: whose.turned(first, angle, self._resolution))
        return turning.turned_by_quarters(quarters % 4)

    def _is_turned(self, r: int, quarters: int, h: int) -> bool:
        """Whether the shape at one heading is that at another turned by right angles."""
        return self.shape(r).turned_by_quarters(quarters % 4).groups == self.shape(h).groups

    def _turned(self, first: float, angle: float) -> Shape:
        if angle < 0.0:
            first, angle = first + angle, -angle
        key = ("shape", self._key, round(first, 6), round(angle, 6))
        return self._cache.get(key, lambda: self.shape0.turned(first, angle, self._resolution))

    def turn_angle(self, h: int, k: int) -> Optional[float]:
        """Angle of the turn between two headings, rad; None when it is not an allowed one."""
        if (h, k) not in self._turn_angles:
            angle = wrap_angle(self.headings[k] - self.headings[h])
            free_choice = k == self.wanted and abs(angle) < _HALF_TURN_RAD
            back = self._home[k] and not self._home[h] and abs(angle) < self.turns.least_rad
            self._turn_angles[h, k] = angle if h != k and (self._allowed[h][k] or free_choice or back) else None
        return self._turn_angles[h, k]

    @cached_property
    def _allowed(self) -> List[List[bool]]:
        """Whether an allowed turn leads from a heading to another."""
        headings = np.array(self.headings)
        off = (headings - headings[:, None])[:, :, None] - np.array(self.turns.angles_rad)
        off -= _FULL_TURN_RAD * np.rint(off / _FULL_TURN_RAD)
        allowed: List[List[bool]] = (np.abs(off) <= SAME_HEADING_RAD).any(axis=2).tolist()
        return allowed

    def blocked(self, h: int) -> ColumnSet:
        """Columns where the robot cannot stand at a heading: something within the margin, or out of the volume."""
        if h not in self._blocked:
            shape = self.shape(h)
            self._blocked[h] = shape.blocked_among(self._smears) | ~self._inside(shape, h == 0) & self.layout.field
        return self._blocked[h]

    def turn_blocked(self, h: int, k: int) -> ColumnSet:
        """Columns where the robot cannot turn from one heading to another, or back."""
        h, k = min(h, k), max(h, k)
        if (h, k) not in self._turn_blocked:
            shape = self.turn_shape(h, k)
            blocked = shape.blocked_among(self._smears) | ~self._inside(shape, False) & self.layout.field
            self._turn_blocked[h, k] = blocked | self.blocked(h) | self.blocked(k)
        return self._turn_blocked[h, k]

    def _inside(self, shape: Shape, as_at_start: bool) -> ColumnSet:
        """Columns from which the shape lies in the volume, or no further outside than it does at the start."""
        gx, gy, _ = self.layout.shape
        x0, x1, y0, y1 = shape.bounds
        low_x, high_x, low_y, high_y = -x0, gx - 1 - x1, -y0, gy - 1 - y1
        if as_at_start:
            x, y, _ = self.start
            low_x, high_x = min(low_x, x), max(high_x, x)
            low_y, high_y = min(low_y, y), max(high_y, y)
        return self.layout.rectangle(max(low_x, 0), min(high_x, gx - 1), max(low_y, 0), min(high_y, gy - 1))

    @property
    def inside(self) -> ColumnSet:
        """Columns from which the robot at its present heading lies fully in the volume."""
        return self._inside(self.shape0, False)

    def swept(self, a: Pose, b: Pose) -> CellSet:
        """Cells swept by a move: the turn at the first pose, then the straight way at the second one's heading."""
        cells = self.shape(b[2]).swept(a[:2], b[:2])
        if a[2] != b[2]:
            cells = union(cells, self.turn_shape(a[2], b[2]).at(a[:2]))
        return cells

    def move_cost(self, a: Pose, b: Pose) -> float:
        """Cost of a move, cells: straight distance and the turn's angle."""
        cost = math.hypot(b[0] - a[0], b[1] - a[1])
        if a[2] != b[2]:
            cost += abs(wrap_angle(self.headings[b[2]] - self.headings[a[2]])) / self.turns.rad_per_cell
        return cost

    def pair_table(self, h: int, turn: Optional[int], other: RobotSpace, other_h: int) -> ColumnSet:
        """Where this robot cannot stand at a heading (or turn from it) with another one at the layout's corner pose.

        The other's end effector is at column (border, border); shift the set of columns to move it (see ``near``).
        """
        theirs = other.shape(other_h)
        border, stride = self.layout.border, self.layout.stride
        mine = self.shape(h) if turn is None else self.turn_shape(h, turn)

        def make() -> ColumnSet:
            return mine.blocked_by(tuple(shifted(layer, border * stride + border) for layer in theirs.inflated))

        return self._cache.get(("pair", mine, theirs), make)


class View:
    """One robot's space with other robots standing in it: what a search looks at."""

    def __init__(
        self, space: RobotSpace, others: Sequence[Tuple[RobotSpace, Pose]], near: Sequence[CellSet] = ()
    ) -> None:
        """The space of a robot.

        Args:
            space: among things that do not move.
            others: other robots and where they stand.
            near: further obstacles, the margin already added.
        """
        self.space = space
        self._border, self._stride = space.layout.border, space.layout.stride
        self._others = others
        self._near = [Smears(cell_set) for cell_set in near]
        self._blocked: Dict[int, ColumnSet] = {}
        self._turn_blocked: Dict[Tuple[int, int], ColumnSet] = {}

    def blocked(self, h: int) -> ColumnSet:
        """Columns where the robot cannot stand."""
        if h not in self._blocked:
            self._blocked[h] = self.space.blocked(h) | self._by_others(h, None)
        return self._blocked[h]

    def turn_blocked(self, h: int, k: int) -> ColumnSet:
        """Columns where the robot cannot turn from one heading to another, or back."""
        h, k = min(h, k), max(h, k)
        if (h, k) not in self._turn_blocked:
            self._turn_blocked[h, k] = self.space.turn_blocked(h, k) | self._by_others(h, k)
        return self._turn_blocked[h, k]

    def _by_others(self, h: int, turn: Optional[int]) -> ColumnSet:
        space, border = self.space, self.space.layout.border
        column_set = 0
        for other, (x, y, other_h) in self._others:
            table = space.pair_table(h, turn, other, other_h)
            column_set |= shifted(table, (x - border) * space.layout.stride + y - border)
        for smears in self._near:
            shape = space.shape(h) if turn is None else space.turn_shape(h, turn)
            column_set |= shape.blocked_among(smears)
        return column_set

    def stands(self, pose: Pose) -> bool:
        """Whether the robot can stand at a pose."""
        x, y, h = pose
        gx, gy, _ = self.space.layout.shape
        if not (0 <= x < gx and 0 <= y < gy):
            return False
        return not self.blocked(h) >> (x + self._border) * self._stride + y + self._border & 1

    def turns(self, x: int, y: int, h: int, k: int) -> bool:
        """Whether the robot can turn from one heading to another at a column."""
        if h == k:
            return True
        if self.space.turn_angle(h, k) is None:
            return False
        return not self.turn_blocked(h, k) >> (x + self._border) * self._stride + y + self._border & 1

    def known_blocked(self, x: int, y: int, h: int, k: int) -> bool:
        """Whether it is known without making a table that the robot cannot turn between two headings at a column."""
        blocked = self._turn_blocked.get((h, k) if h < k else (k, h), 0) or self._blocked.get(k, 0)
        return bool(blocked >> (x + self._border) * self._stride + y + self._border & 1)

    def line(self, ax: int, ay: int, bx: int, by: int, h: int) -> bool:
        """Whether the robot can go straight between two columns of the grid at a heading."""
        border, stride = self._border, self._stride
        low = ((ax if ax < bx else bx) + border) * stride + (ay if ay < by else by) + border
        blocked = self._blocked.get(h)
        if blocked is None:
            blocked = self.blocked(h)
        return not (blocked >> low) & band(bx - ax, by - ay, stride)

    def move(self, a: Pose, b: Pose) -> bool:
        """Whether a move is free: the turn at the first pose, then the straight way at the second one's heading."""
        return self.turns(a[0], a[1], a[2], b[2]) and self.line(a[0], a[1], b[0], b[1], b[2])


def with_margin(occupied: CellSet, present: CellSet, stride: int) -> CellSet:
    """Obstacles with a margin of one cell, for a robot whose present cells are given.

    Its own cells are no obstacle. What is within the margin already at the start keeps no margin, so that the robot is
    not locked in for ever; it is still an obstacle.
    """
    others = difference(occupied, present)
    inflated = dilated(others, stride)
    if not overlap(inflated, present):
        return inflated
    close = intersection(others, dilated(present, stride))
    return union(dilated(difference(others, close), stride), close)


def close_pair(one: RobotSpace, other: RobotSpace) -> bool:
    """Whether two robots stand within the margin of each other at their start poses."""
    return overlap(one.shape0.at(one.start[:2]), dilated(other.shape0.at(other.start[:2]), one.layout.stride))


def poses_touch(one: RobotSpace, a: Pose, other: RobotSpace, b: Pose) -> bool:
    """Whether two robots standing at two poses overlap or come within the margin of each other."""
    layout = one.layout
    table = one.pair_table(a[2], None, other, b[2])
    column_set = shifted(table, (b[0] - layout.border) * layout.stride + b[1] - layout.border)
    return bool(column_set >> layout.bit(a[0], a[1]) & 1)


def present_set(space: RobotSpace) -> CellSet:
    """Cells of a robot at its start."""
    return space.shape0.at(space.start[:2])


def margin_around(space: RobotSpace, other: RobotSpace) -> CellSet:
    """A robot that stands at its start as an obstacle for another one that may start within its margin."""
    return with_margin(present_set(other), present_set(space), space.layout.stride)
