"""Boxes that carry a tag on one side: where they are, what of the floor they cover, how far a point is from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Sequence

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.pinhole import BoxSize, footprint
from yarm.navigation.grid_map import GridMap


@dataclass(frozen=True)
class Box:
    """A box on the floor.

    Attributes:
        number: from 1.
        pose: its centre on the floor, in the map; the tag is on the side that the yaw points to.
        size: its outer measures.
    """

    number: int
    pose: Pose2
    size: BoxSize = field(default_factory=BoxSize)

    @property
    def face(self) -> Pose2:
        """Middle of the tag's face on the floor, looking outwards."""
        return self.pose.compose(Pose2(0.5 * self.size.depth, 0.0))

    def corners(self) -> FloatArray:
        """(4, 2) corners on the floor, in the map, counter-clockwise from the front left."""
        return footprint(self.pose, self.size)

    def distance(self, x: float, y: float) -> float:
        """From a point of the map to the box, metres; 0 inside."""
        local = self.pose.inverse().compose(Pose2(x, y))
        beyond = max(abs(local.x) - 0.5 * self.size.depth, 0.0), max(abs(local.y) - 0.5 * self.size.width, 0.0)
        return math.hypot(*beyond)


def overlap(a: Box, b: Box) -> float:
    """Depth, metres, by which two boxes overlap; 0 when they only touch or are apart (separating axes)."""
    first, second = a.corners(), b.corners()
    least = math.inf
    for yaw in (a.pose.yaw_rad, a.pose.yaw_rad + math.pi / 2, b.pose.yaw_rad, b.pose.yaw_rad + math.pi / 2):
        axis = np.array([math.cos(yaw), math.sin(yaw)])
        along_a, along_b = first @ axis, second @ axis
        least = min(least, float(min(along_a.max(), along_b.max()) - max(along_a.min(), along_b.min())))
    return max(least, 0.0)


def outside(boxes: Sequence[Box], grid: GridMap) -> List[Box]:
    """The boxes whose centres do not lie in a map."""
    return [box for box in boxes if not grid.inside(*grid.cell_of(box.pose.x, box.pose.y))]


def extent_of(grid: GridMap) -> str:
    """How large a map is and where it begins, in words."""
    height_m, width_m = (cells * grid.resolution_m for cells in grid.cells.shape)
    return f"{width_m:g} x {height_m:g} m from ({grid.origin.x:g}, {grid.origin.y:g}) on"
