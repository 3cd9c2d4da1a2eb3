"""Where an ankurbot can go: its configuration space over end-effector columns and headings, with a safety margin.

A configuration is a heading, rad, and a column (x, y) of the end effector. It is free when every cell of the robot lies
in the mapped volume and no obstacle is within one cell (all 26 neighbours) of it. A robot moves to one of the 4
neighbouring columns at the same heading, or makes one of the turns it is allowed in place about its end effector, where
it is free at every heading on the way. So it drives only at headings that turns lead to from the one it starts with.
(Nothing is lost by four neighbours: what a longer move sweeps, a diagonal one on both sides, holds a chain of such.)
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Callable, Dict, Iterable, List, Sequence, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import (
    BoolArray,
    ColumnImage,
    FloatArray,
    GridSpec,
    IntArray,
    Mask,
    columns_from_cells,
    dilated,
    shifted,
    transform_points,
    wrap_angle,
)
from yarm.geometry.solids import Shape
from yarm.sim.scenes.bodies import FramedSolid

MOST_HEADINGS = 72
LOOK_RAD = math.radians(5.0)
"""How far apart the headings are that are looked at in the midst of a turn, at most."""
SAME_HEADING_RAD = math.radians(0.1)
SAMPLE_M = 0.025
MARGIN_CELLS = 1

Column = Tuple[int, int]
Configuration = Tuple[float, Column]
"""Heading, rad, world, and column of the end effector."""


def solid_points(items: Iterable[Tuple[FramedSolid, FloatArray]]) -> FloatArray:
    """Points (n, 3), metres, world, not more than SAMPLE_M apart, filling solids given with T_world_solid (4, 4)."""
    clouds = [np.zeros((0, 3))]
    for item, pose in items:
        half = item.solid.half_extent
        axes = [np.linspace(-h, h, 1 + math.ceil(2.0 * h / SAMPLE_M)) for h in half]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        if item.solid.shape != Shape.BOX:
            reach = np.linalg.norm(points if item.solid.shape == Shape.SPHERE else points[:, :2], axis=1)
            points = points[reach <= half[0] + 1e-9]
        clouds.append(transform_points(pose, points))
    return np.concatenate(clouds)


@dataclass(frozen=True, eq=False)
class Reached:
    """What a robot can get to.

    Attributes:
        headings_rad: where turns lead, the start's first.
        columns: (headings, gx, gy) where its end effector can be at each of them.
    """

    headings_rad: Tuple[float, ...]
    columns: BoolArray

    def at(self, column: Column) -> List[Configuration]:
        """Configurations of a column of the grid, in the order of the headings."""
        return [(self.headings_rad[i], column) for i in np.nonzero(self.columns[:, column[0], column[1]])[0]]


class ConfigurationSpace:
    """Where a robot may be among obstacles, the margin between them."""

    def __init__(self, mask_at: Callable[[float], Mask], obstacle_points: FloatArray, spec: GridSpec) -> None:
        """From points (n, 3), metres, world, that fill the obstacles.

        Args:
            mask_at: the robot's cells at any heading, rad.
            obstacle_points: points (n, 3), metres, world, that fill the obstacles.
            spec: the grid.
        """
        self.spec = spec
        self._mask_at = mask_at
        cells = spec.cells_inside(obstacle_points)
        self._obstacles = dilated(columns_from_cells(cells, spec.shape[:2]), spec.shape[2], MARGIN_CELLS)
        self._free: Dict[int, BoolArray] = {}
        self._images: Dict[Configuration, ColumnImage] = {}

    def free_at(self, yaw_rad: float) -> BoolArray:
        """Columns (gx, gy) where the robot may be at a heading."""
        key = round(wrap_angle(yaw_rad) / SAME_HEADING_RAD)
        if key not in self._free:
            self._free[key] = _free(self._mask_at(yaw_rad).cells, self._obstacles, self.spec)
        return self._free[key]

    def reachable(self, column: Column, yaw_rad: float, turns_deg: Sequence[float]) -> Reached:
        """What a robot that makes these turns can get to from a configuration; nothing when that is not free."""
        headings = _headings(yaw_rad, turns_deg)
        reached = np.zeros((len(headings), *self.spec.shape[:2]), dtype=bool)
        if not (self.spec.contains((*column, 0)) and self.free_at(yaw_rad)[column]):
            return Reached(headings, reached)
        fields = [ndimage.label(self.free_at(heading))[0] for heading in headings]
        turns = self._turns(headings, turns_deg)
        reached[0][column] = True
        while True:
            there = [np.isin(field, np.unique(field[at])) & (field > 0) for field, at in zip(fields, reached)]
            turned = np.stack(there)
            for i, j, free in turns:
                turned[j] |= there[i] & free
            if np.array_equal(turned, reached):
                return Reached(headings, reached)
            reached = turned

    def _turns(self, headings: Sequence[float], turns_deg: Sequence[float]) -> List[Tuple[int, int, BoolArray]]:
        """Turns from a heading to another, by index, and the columns (gx, gy) where nothing is in the way of one."""
        turns = []
        for i, heading in enumerate(headings):
            for turn in (math.radians(angle) for angle in turns_deg if angle):
                end = wrap_angle(heading + turn)
                j = next((j for j, other in enumerate(headings) if _same(other, end)), i)
                between = np.linspace(0.0, turn, math.ceil(abs(turn) / LOOK_RAD - 1e-9) + 1)
                free: BoolArray = np.all([self.free_at(heading + angle) for angle in between.tolist()], axis=0)
                turns.append((i, j, free))
        return turns

    def compatible(self, one: Sequence[Configuration], other: Sequence[Configuration]) -> bool:
        """Whether two robots can be at one configuration of each list, the margin between them."""
        images = [self._image(configuration) for configuration in other]
        for configuration in one:
            inflated = dilated(self._image(configuration), self.spec.shape[2], MARGIN_CELLS)
            if any(not np.any(inflated & image) for image in images):
                return True
        return False

    def _image(self, configuration: Configuration) -> ColumnImage:
        """Column image of the robot; cells outside the grid are left out."""
        if configuration not in self._images:
            yaw_rad, column = configuration
            cells = self._mask_at(yaw_rad).cells + np.array([column[0], column[1], 0])
            image = columns_from_cells(cells[self.spec.contains(cells)], self.spec.shape[:2])
            self._images[configuration] = image
        return self._images[configuration]


def _same(one_rad: float, other_rad: float) -> bool:
    return abs(wrap_angle(one_rad - other_rad)) < SAME_HEADING_RAD


def _headings(yaw_rad: float, turns_deg: Sequence[float]) -> Tuple[float, ...]:
    """Every heading that repeated turns lead to, the present one first."""
    found = [yaw_rad]
    for heading in found:
        for turn in turns_deg:
            new = wrap_angle(heading + math.radians(turn))
            if len(found) < MOST_HEADINGS and not any(_same(new, known) for known in found):
                found.append(new)
    return tuple(found)


def _free(cells: IntArray, obstacles: ColumnImage, spec: GridSpec) -> BoolArray:
    """Columns (gx, gy) where the robot with these cells neither meets an obstacle nor leaves the volume."""
    inside = np.ones(spec.shape[:2], dtype=np.int64)
    blocked = np.zeros(spec.shape[:2], dtype=bool)
    columns, index = np.unique(cells[:, :2], axis=0, return_inverse=True)
    bits = np.zeros(len(columns), dtype=np.int64)
    np.bitwise_or.at(bits, index, np.left_shift(np.int64(1), cells[:, 2]))
    for (dx, dy), mask in zip(columns, bits):
        blocked |= (shifted(obstacles, -int(dx), -int(dy)) & mask) != 0
        blocked |= shifted(inside, -int(dx), -int(dy)) == 0
    return ~blocked


def pairs(names: Iterable[str]) -> Iterable[Tuple[str, str]]:
    """Every two different names."""
    return itertools.combinations(list(names), 2)
