"""Where an ankurbot can go: its configuration space over end-effector columns and headings, with a safety margin.

A configuration is a column (x, y) of the end effector and one of HEADINGS headings. It is free when every cell of the
robot lies in the mapped volume and no obstacle is within one cell (all 26 neighbours) of it. A robot moves to one of
the 8 neighbouring columns at the same heading, or turns in place about its end effector by one heading.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Iterable, List, Tuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from yarm.geometry import (
    BoolArray,
    ColumnImage,
    FloatArray,
    GridSpec,
    IntArray,
    columns_from_cells,
    dilated,
    quaternion_from_rpy,
    shifted,
    transform_matrix,
    transform_points,
)
from yarm.geometry.solids import Shape
from yarm.sim.engine.bodies import FramedSolid

HEADINGS = 36
SAMPLE_M = 0.025
MARGIN_CELLS = 1


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
class RobotShape:
    """A robot's cells at each heading with its end effector in the middle of a column.

    Attributes:
        cells: HEADINGS arrays (n, 3): dx, dy from the end effector's column, absolute z.
    """

    cells: Tuple[IntArray, ...]

    @staticmethod
    def from_points(points_ee: FloatArray, spec: GridSpec) -> RobotShape:
        """From points (n, 3) that fill the robot: x, y from its end effector along its heading, z above the floor."""
        res_x, res_y, res_z = spec.resolution
        inside = points_ee[(points_ee[:, 2] >= spec.lower[2]) & (points_ee[:, 2] < spec.upper[2])]
        cells = []
        for heading in heading_angles():
            turned = transform_points(transform_matrix((0, 0, 0), quaternion_from_rpy(0, 0, heading)), inside)
            columns = np.floor(turned[:, :2] / (res_x, res_y) + 0.5)
            z = np.floor((turned[:, 2] - spec.lower[2]) / res_z)
            cells.append(np.unique(np.column_stack([columns, z]).astype(np.int64), axis=0))
        return RobotShape(tuple(cells))

    def image_at(self, heading: int, column: Tuple[int, int], spec: GridSpec) -> ColumnImage:
        """Column image of the robot at a configuration; cells outside the grid are left out."""
        cells = self.cells[heading] + np.array([column[0], column[1], 0])
        return columns_from_cells(cells[spec.contains(cells)], spec.shape[:2])


def heading_angles() -> FloatArray:
    """The headings, rad, (HEADINGS,)."""
    return np.arange(HEADINGS) * (2.0 * math.pi / HEADINGS)


def nearest_heading(yaw_rad: float) -> int:
    """Index of the heading nearest to a yaw."""
    return round(yaw_rad / (2.0 * math.pi / HEADINGS)) % HEADINGS


class ConfigurationSpace:
    """Free configurations (HEADINGS, gx, gy) of one robot shape among obstacles."""

    def __init__(self, shape: RobotShape, obstacle_points: FloatArray, spec: GridSpec) -> None:
        """From points (n, 3), metres, world, that fill the obstacles."""
        self.shape = shape
        self.spec = spec
        cells = spec.cells_inside(obstacle_points)
        obstacles = dilated(columns_from_cells(cells, spec.shape[:2]), spec.shape[2], MARGIN_CELLS)
        self.free: BoolArray = np.stack([_free(cells, obstacles, spec) for cells in shape.cells])

    def reachable(self, column: Tuple[int, int], heading: int) -> BoolArray:
        """Configurations (HEADINGS, gx, gy) that a robot at this configuration can get to; none when it is not free."""
        if not (self.spec.contains((*column, 0)) and self.free[heading][column]):
            return np.zeros_like(self.free)
        # Two copies side by side join the last heading to the first.
        twice = np.concatenate([self.free, self.free])
        labels, _ = ndimage.label(twice, structure=_NEIGHBOURS)
        reached: BoolArray = np.zeros_like(self.free)
        reached[heading][column] = True
        while True:
            doubled = np.concatenate([reached, reached])
            inflated = np.isin(labels, np.unique(labels[doubled])) & twice
            merged = inflated[:HEADINGS] | inflated[HEADINGS:]
            if np.array_equal(merged, reached):
                return reached
            reached = merged


def _neighbourhood() -> npt.NDArray[np.int64]:
    """Same heading: 8 neighbours; same column: the two next headings."""
    structure = np.zeros((3, 3, 3), dtype=np.int64)
    structure[1] = 1
    structure[:, 1, 1] = 1
    return structure


_NEIGHBOURS = _neighbourhood()


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


def compatible(
    shape: RobotShape, spec: GridSpec, one: List[Tuple[int, Tuple[int, int]]], other: List[Tuple[int, Tuple[int, int]]]
) -> bool:
    """Whether two robots can stand at one configuration of each list, with the margin between them."""
    images = [shape.image_at(heading, column, spec) for heading, column in other]
    for heading, column in one:
        inflated = dilated(shape.image_at(heading, column, spec), spec.shape[2], MARGIN_CELLS)
        if any(not np.any(inflated & image) for image in images):
            return True
    return False


def configurations_at(reached: BoolArray, column: Tuple[int, int]) -> List[Tuple[int, Tuple[int, int]]]:
    """Reached configurations of a column: (heading index, column)."""
    return [(int(heading), column) for heading in np.nonzero(reached[:, column[0], column[1]])[0]]


def pairs(names: Iterable[str]) -> Iterable[Tuple[str, str]]:
    """Every two different names."""
    return itertools.combinations(list(names), 2)
