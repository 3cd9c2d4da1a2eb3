"""Signed distance of points to primitive solids, and the direction that leads away from them."""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.motion.checkpoints import Obstacle


def signed_distance(solid: Solid, points: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Distance (n,) of points (n, 3) to a solid, metres, negative inside, and directions (n, 3) away from it."""
    local = transform_points(np.linalg.inv(solid.pose), points)
    if solid.shape == Shape.SPHERE:
        length = np.linalg.norm(local, axis=1)
        away = local / np.maximum(length, 1e-12)[:, None]
        return length - solid.size[0], away @ solid.pose[:3, :3].T
    if solid.shape == Shape.CYLINDER:
        radius = np.hypot(local[:, 0], local[:, 1])
        out = local[:, :2] / np.maximum(radius, 1e-12)[:, None]
        over = np.column_stack([radius - solid.size[0], np.abs(local[:, 2]) - 0.5 * solid.size[1]])
        axes = np.stack([np.column_stack([out, np.zeros(len(out))]), _upright(local)], axis=1)
    else:
        over = np.abs(local) - solid.half_extent
        axes = np.where(local >= 0.0, 1.0, -1.0)[:, :, None] * np.eye(3)[None]
    distance, away = _of_product(over, axes)
    return distance, away @ solid.pose[:3, :3].T


def nearest_obstacle(obstacles: Sequence[Obstacle], points: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """The same to the nearest of several obstacles; inf and zeros without any."""
    distance, away = np.full(len(points), np.inf), np.zeros((len(points), 3))
    for obstacle in obstacles:
        found, direction = signed_distance(obstacle.solid, points)
        closer = found < distance
        distance[closer], away[closer] = found[closer], direction[closer]
    return distance, away


def _upright(local: FloatArray) -> FloatArray:
    return np.column_stack([np.zeros((len(local), 2)), np.where(local[:, 2] >= 0.0, 1.0, -1.0)])


def _of_product(over: FloatArray, axes: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Distance and direction for a product of intervals: ``over`` (n, k) is how far beyond each, along ``axes``."""
    beyond = np.maximum(over, 0.0)
    outside = np.linalg.norm(beyond, axis=1)
    deepest = np.argmax(over, axis=1)
    inside = outside == 0.0
    weights = beyond / np.maximum(outside, 1e-12)[:, None]
    weights[inside] = np.eye(over.shape[1])[deepest[inside]]
    away: FloatArray = np.einsum("nk,nkd->nd", weights, axes)
    return np.where(inside, over.max(axis=1), outside), away
