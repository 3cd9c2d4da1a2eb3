"""Primitive bodies: what robots, furniture and debris are drawn from, and the points on their surfaces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import List, Sequence, Tuple

import numpy as np

from yarm.geometry.grid import FloatArray
from yarm.geometry.poses import transform_points


class Shape(str, Enum):
    """Shapes of primitives: equal to the words of URDF and scene files."""

    BOX = "box"
    CYLINDER = "cylinder"
    SPHERE = "sphere"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


@dataclass(frozen=True, eq=False)
class Solid:
    """A primitive with its pose in some frame.

    Attributes:
        shape: a cylinder's axis is z.
        size: box: x, y, z; cylinder: radius, length; sphere: radius; metres.
        pose: (4, 4) pose of its centre in that frame.
    """

    shape: Shape
    size: Tuple[float, ...]
    pose: FloatArray

    @property
    def half_extent(self) -> FloatArray:
        """Half the size (3,) of its bounding box in its own frame, metres.

        Raises:
            ValueError: a shape that is not known.
        """
        if self.shape == Shape.BOX:
            return 0.5 * np.asarray(self.size, dtype=float)
        if self.shape == Shape.CYLINDER:
            return np.array([self.size[0], self.size[0], 0.5 * self.size[1]])
        if self.shape == Shape.SPHERE:
            return np.full(3, float(self.size[0]))
        raise ValueError(f"solid {self.shape!r} must be one of {', '.join(Shape)}")

    def seen_from(self, transform: FloatArray) -> Solid:
        """The same primitive in another frame; ``transform`` (4, 4) takes points of its frame there."""
        return Solid(self.shape, self.size, transform @ self.pose)


def surface_points(solids: Sequence[Solid], spacing_m: float) -> FloatArray:
    """Points (n, 3) on the surfaces of solids, metres, in the frame of their poses.

    No point of a surface is farther from one of them than the spacing.

    Raises:
        ValueError: a shape that is not known.
    """
    parts = [transform_points(solid.pose, _surface(solid, spacing_m)) for solid in solids]
    return np.concatenate(parts) if parts else np.zeros((0, 3))


def _surface(solid: Solid, spacing_m: float) -> FloatArray:
    half = solid.half_extent
    if solid.shape == Shape.BOX:
        return _box_points(half, spacing_m)
    if solid.shape == Shape.CYLINDER:
        return _cylinder_points(solid.size[0], solid.size[1], spacing_m)
    return _sphere_points(solid.size[0], spacing_m)


def _box_points(half: FloatArray, spacing: float) -> FloatArray:
    axes = [np.linspace(-h, h, max(2, math.ceil(2 * h / spacing) + 1)) for h in half]
    faces: List[FloatArray] = []
    for axis in range(3):
        first, second = [i for i in range(3) if i != axis]
        u, v = np.meshgrid(axes[first], axes[second], indexing="ij")
        for side in (-half[axis], half[axis]):
            face = np.empty((u.size, 3))
            face[:, first], face[:, second], face[:, axis] = u.ravel(), v.ravel(), side
            faces.append(face)
    return np.unique(np.concatenate(faces), axis=0)


def _cylinder_points(radius: float, length: float, spacing: float) -> FloatArray:
    rings = []
    heights = np.linspace(-length / 2, length / 2, max(2, math.ceil(length / spacing) + 1))
    radii = [(radius, z) for z in heights]
    inner = np.linspace(0.0, radius, max(2, math.ceil(radius / spacing) + 1))[:-1]
    radii += [(r, z) for r in inner for z in (heights[0], heights[-1])]
    for r, z in radii:
        n = max(1, math.ceil(2 * math.pi * r / spacing))
        angles = 2 * math.pi * np.arange(n) / n
        rings.append(np.column_stack([r * np.cos(angles), r * np.sin(angles), np.full(n, z)]))
    return np.concatenate(rings)


def _sphere_points(radius: float, spacing: float) -> FloatArray:
    """Points on a spiral that goes round by the golden angle from pole to pole.

    R. Swinbank, R. J. Purser, "Fibonacci grids", Quarterly Journal of the Royal Meteorological Society 132, 2006.
    """
    n = max(8, math.ceil(4 * math.pi * (radius / spacing) ** 2))
    z = 1.0 - 2.0 * (np.arange(n) + 0.5) / n
    turn = math.pi * (1.0 + math.sqrt(5.0)) * np.arange(n)
    flat = np.sqrt(1.0 - z * z)
    points: FloatArray = radius * np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z])
    return points
