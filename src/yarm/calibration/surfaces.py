"""Distances of points to known solids and the floor, and which way their surfaces face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.geometry.solids import Shape, Solid

NOWHERE_M = 1e3


@dataclass(frozen=True)
class Nearest:
    """Of each point: distance (n,) to the nearest surface, metres, negative inside, and its outward normal (n, 3)."""

    distance: FloatArray
    normal: FloatArray


def nearest_surface(points: FloatArray, solids: Sequence[Solid], floor: bool = True) -> Nearest:
    """The nearest surface of solids and, if asked, of the floor z = 0.

    Args:
        points: (n, 3), metres, world.
        solids: with their poses in the world.
        floor: whether there is one.
    """
    distance = points[:, 2].copy() if floor else np.full(len(points), NOWHERE_M)
    normal = np.tile(np.array([0.0, 0.0, 1.0]), (len(points), 1))
    for solid in solids:
        reach = float(np.linalg.norm(solid.half_extent)) + np.abs(distance)
        near = np.flatnonzero(np.linalg.norm(points - solid.pose[:3, 3], axis=1) < reach)
        own, facing = _of_solid(points[near], solid)
        closer = np.abs(own) < np.abs(distance[near])
        distance[near[closer]], normal[near[closer]] = own[closer], facing[closer]
    return Nearest(distance, normal)


def _of_solid(points: FloatArray, solid: Solid) -> Tuple[FloatArray, FloatArray]:
    rotation = solid.pose[:3, :3]
    local = (points - solid.pose[:3, 3]) @ rotation
    if solid.shape == Shape.BOX:
        distance, facing = _box(local, solid.half_extent)
    elif solid.shape == Shape.CYLINDER:
        distance, facing = _cylinder(local, solid.size[0], 0.5 * solid.size[1])
    else:
        length = np.linalg.norm(local, axis=1)
        distance, facing = length - solid.size[0], local / np.maximum(length, 1e-9)[:, None]
    return distance, facing @ rotation.T


def _box(local: FloatArray, half: FloatArray) -> Tuple[FloatArray, FloatArray]:
    beyond = np.abs(local) - half
    outside = np.maximum(beyond, 0.0)
    far = np.linalg.norm(outside, axis=1)
    axis = np.argmax(beyond, axis=1)
    facing = np.zeros_like(local)
    rows = np.arange(len(local))
    facing[rows, axis] = np.sign(local[rows, axis])
    out = far > 0.0
    facing[out] = np.sign(local[out]) * outside[out] / far[out, None]
    return np.where(out, far, beyond[rows, axis]), facing


def _cylinder(local: FloatArray, radius: float, half: float) -> Tuple[FloatArray, FloatArray]:
    across = np.linalg.norm(local[:, :2], axis=1)
    flat = np.column_stack([across, local[:, 2]])
    distance, facing = _box(flat, np.array([radius, half]))
    radial = local[:, :2] / np.maximum(across, 1e-9)[:, None]
    return distance, np.column_stack([facing[:, :1] * radial, facing[:, 1]])
