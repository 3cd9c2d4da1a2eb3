"""Particles: the columns a search may use as waypoints."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Tuple

import numpy as np
from scipy.spatial import cKDTree

from yarm.geometry import BoolArray, IntArray

_PLASTIC = 1.32471795724474602596
"""The plastic number: its powers give the most even additive sequence in the plane (R2)."""


@lru_cache(maxsize=8)
def cell_order(shape: Tuple[int, int]) -> IntArray:
    """Every column of a grid once, so that each beginning of the list covers the grid evenly.

    The R2 sequence visits the cells; a cell visited before is left out, and those the sequence has not met after many
    rounds follow in row order.

    Args:
        shape: columns along x and y.

    Returns:
        (gx * gy, 2) columns; not to be written to.
    """
    gx, gy = shape
    count = gx * gy
    index = np.arange(1, 4 * count + 1)[:, None]
    points = (0.5 + index * np.array([1.0 / _PLASTIC, 1.0 / _PLASTIC**2])) % 1.0
    cells = (points * (gx, gy)).astype(np.int64)
    flat = np.concatenate([cells[:, 0] * gy + cells[:, 1], np.arange(count)])
    _, first = np.unique(flat, return_index=True)
    ordered = flat[np.sort(first)]
    result: IntArray = np.stack([ordered // gy, ordered % gy], axis=-1)
    result.flags.writeable = False
    return result


def moved_order(order: IntArray, shape: Tuple[int, int], number: int) -> IntArray:
    """The same order moved by some columns around the edges, differently for each number; as even as before."""
    offset = np.floor(number * np.array([0.38196601, 0.70710678]) % 1.0 * shape).astype(np.int64)
    moved: IntArray = (order + offset) % np.asarray(shape)
    return moved


def narrow_particles(order: IntArray, n: int, narrow: BoolArray, factor: float) -> IntArray:
    """Further columns of an order behind its first n, so many that narrow places hold ``factor`` times more.

    Args:
        order: (m, 2) columns, see ``cell_order``.
        n: number of columns used everywhere.
        narrow: (gx, gy) columns where free space is narrow.
        factor: density there over the density elsewhere, at least 1.

    Returns:
        (k, 2) columns, all of them narrow.
    """
    more = order[n : math.ceil(n * factor)]
    chosen: IntArray = more[narrow[more[:, 0], more[:, 1]]]
    return chosen


def narrow_columns(free: BoolArray, reach: int = 3) -> BoolArray:
    """Free columns with something blocked within ``reach`` on both sides along x, or along y (the bridge test)."""
    gx, gy = free.shape
    padded = np.zeros((gx + 2 * reach, gy + 2 * reach), dtype=np.bool_)
    padded[reach : reach + gx, reach : reach + gy] = free
    sides = []
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        hit = np.zeros_like(free)
        for k in range(1, reach + 1):
            hit |= ~padded[reach + k * dx : reach + k * dx + gx, reach + k * dy : reach + k * dy + gy]
        sides.append(hit)
    narrow: BoolArray = free & ((sides[0] & sides[1]) | (sides[2] & sides[3]))
    return narrow


def random_particles(n: int, shape: Tuple[int, int], rng: np.random.Generator) -> IntArray:
    """The original's draw: n independent random columns (n, 2), repeated ones left in."""
    return rng.integers(0, np.asarray(shape), size=(n, 2))


def threshold_particles(shape: Tuple[int, int, int], threshold: float = 5.0) -> int:
    """The original's number of particles from a threshold t: gx gy gz / (30 t), at least 1."""
    if not (math.isfinite(threshold) and threshold > 0.0):
        raise ValueError(f"threshold {threshold} must be a positive number")
    return max(1, int(np.prod(shape) / (30.0 * threshold)))


def largest_pocket(particles: IntArray, shape: Tuple[int, int]) -> float:
    """Radius, cells, of the largest circle around a column that holds no particle: a measure of evenness."""
    grid = np.argwhere(np.ones(shape, dtype=np.bool_))
    distances, _ = cKDTree(particles).query(grid)
    return float(distances.max())
