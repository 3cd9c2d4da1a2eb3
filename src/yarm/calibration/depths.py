"""The depth that a camera at some pose would read of known solids: which surface each of its rays meets first."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray
from yarm.geometry.solids import Shape, Solid


def first_met(origin: FloatArray, rays: FloatArray, solids: Sequence[Solid], floor: bool = True) -> FloatArray:
    """How far each ray goes until it meets a solid, (n,), in lengths of the ray; inf for one that meets nothing.

    Args:
        origin: (3,) where all rays begin, metres, world; outside all solids.
        rays: (n, 3), of any length, world.
        solids: with their poses in the world.
        floor: whether z = 0 is met as well.
    """
    far = np.full(len(rays), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        if floor:
            _nearer(far, -origin[2] / rays[:, 2])
        for solid in solids:
            rotation = solid.pose[:3, :3]
            start, way = (origin - solid.pose[:3, 3]) @ rotation, rays @ rotation
            if solid.shape == Shape.BOX:
                enter, leave = _slabs(start, way, solid.half_extent)
            elif solid.shape == Shape.CYLINDER:
                around = _sphere(start[:2], way[:, :2], solid.size[0])
                between = _slabs(start[2:], way[:, 2:], solid.half_extent[2:])
                enter, leave = np.maximum(around[0], between[0]), np.minimum(around[1], between[1])
            else:
                enter, leave = _sphere(start, way, solid.size[0])
            _nearer(far, np.where(enter < leave, enter, np.inf))
    return far


def _nearer(far: FloatArray, met: FloatArray) -> None:
    closer = (met > 0.0) & (met < far)
    far[closer] = met[closer]


def _slabs(start: FloatArray, way: FloatArray, half: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Where rays enter and leave the space between pairs of planes at +-half of each axis."""
    one, other = (-half - start) / way, (half - start) / way
    return np.fmin(one, other).max(axis=1), np.fmax(one, other).min(axis=1)


def _sphere(start: FloatArray, way: FloatArray, radius: float) -> Tuple[FloatArray, FloatArray]:
    """Where rays enter and leave a sphere (in the plane: a circle); NaN for those that miss it."""
    square, along = np.sum(way * way, axis=1), way @ start
    root = np.sqrt(along**2 - square * (start @ start - radius**2))
    return (-along - root) / square, (-along + root) / square
