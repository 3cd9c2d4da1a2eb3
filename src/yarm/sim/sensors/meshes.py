"""Triangles of the primitives, for ray casting."""

from __future__ import annotations

import math
from typing import List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, transform_points
from yarm.geometry.solids import Shape, Solid

CYLINDER_SIDES = 96
"""A cylinder's side is at most r (1 - cos(pi / 96)) = 0.0005 r inside the true one."""
SPHERE_RINGS = 16

Triangles = npt.NDArray[np.float32]
"""(n, 3, 3): three corners of each triangle, metres."""


def solid_triangles(solid: Solid, pose: FloatArray) -> FloatArray:
    """Triangles (n, 3, 3) of a solid whose centre is at ``pose`` (4, 4)."""
    if solid.shape == Shape.BOX:
        local = box_triangles(solid.size)
    elif solid.shape == Shape.CYLINDER:
        local = cylinder_triangles(solid.size[0], solid.size[1])
    else:
        local = sphere_triangles(solid.size[0])
    return transform_points(pose, local)


def box_triangles(size: Sequence[float]) -> FloatArray:
    """The 12 triangles of a box of full size x, y, z, metres, about its centre."""
    corners = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * np.asarray(size)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    index = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    triangles: FloatArray = corners[np.array(index)]
    return triangles


def cylinder_triangles(radius: float, length: float) -> FloatArray:
    """Triangles of a cylinder about its centre, axis z, metres."""
    angles = np.linspace(0.0, 2.0 * math.pi, CYLINDER_SIDES + 1)
    rim = np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=-1)
    triangles: List[Tuple[Sequence[float], ...]] = []
    for (ax, ay), (bx, by) in zip(rim[:-1], rim[1:]):
        low_a, low_b = (ax, ay, -0.5 * length), (bx, by, -0.5 * length)
        top_a, top_b = (ax, ay, 0.5 * length), (bx, by, 0.5 * length)
        triangles += [(low_a, low_b, top_b), (low_a, top_b, top_a)]
        triangles += [((0.0, 0.0, 0.5 * length), top_a, top_b), ((0.0, 0.0, -0.5 * length), low_b, low_a)]
    return np.array(triangles)


def sphere_triangles(radius: float) -> FloatArray:
    """Triangles of a sphere about its centre, metres."""
    polar = np.linspace(0.0, math.pi, SPHERE_RINGS + 1)
    around = np.linspace(0.0, 2.0 * math.pi, 2 * SPHERE_RINGS + 1)
    p, a = np.meshgrid(polar, around, indexing="ij")
    points = radius * np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=-1)
    first = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:]], axis=-2)
    second = np.stack([points[:-1, :-1], points[1:, 1:], points[:-1, 1:]], axis=-2)
    return np.concatenate([first.reshape(-1, 3, 3), second.reshape(-1, 3, 3)])
