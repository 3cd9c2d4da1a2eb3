"""Particles: the columns a search may use as waypoints.

The even ones follow the additive sequence R2 (M. Roberts, "The unreasonable effectiveness of quasirandom sequences",
2018), shifted around the edges (R. Cranley, T. N. L. Patterson, SIAM Journal on Numerical Analysis 13, 1976). Narrow
places are found as in D. Hsu, T. Jiang, J. Reif, Z. Sun, "The bridge test for sampling narrow passages with
probabilistic roadmap planners", ICRA 2003, here along x and y only and in every column.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Tuple

import numpy as np

from yarm.geometry import IntArray
from yarm.planning.cspace.cell_sets import ColumnSet

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
    points = 0.5 + index * np.array([1.0 / _PLASTIC, 1.0 / _PLASTIC**2])
    cells = ((points - np.floor(points)) * (gx, gy)).astype(np.int64)
    flat = np.concatenate([cells[:, 0] * gy + cells[:, 1], np.arange(count)])
    first = np.empty(count, dtype=np.int64)
    first[flat[::-1]] = np.arange(len(flat))[::-1]
    ordered = flat[np.sort(first)]
    result: IntArray = np.stack([ordered // gy, ordered % gy], axis=-1)
    result.flags.writeable = False
    return result


def moved_order(order: IntArray, shape: Tuple[int, int], number: int) -> IntArray:
    """The same order moved by some columns around the edges, differently for each number; as even as before."""
    offset = np.floor(number * np.array([0.38196601, 0.70710678]) % 1.0 * shape).astype(np.int64)
    moved: IntArray = (order + offset) % np.asarray(shape)
    return moved


def narrow_columns(free: ColumnSet, stride: int, reach: int = 3) -> ColumnSet:
    """Free columns with something not free within ``reach`` on both sides along x, or along y (the bridge test)."""
    sides = []
    for step in (stride, 1):
        below = above = 0
        for k in range(1, reach + 1):
            below |= ~(free << k * step)
            above |= ~(free >> k * step)
        sides.append(below & above)
    return free & (sides[0] | sides[1])


def random_particles(n: int, shape: Tuple[int, int], rng: np.random.Generator) -> IntArray:
    """The original's draw: n independent random columns (n, 2), repeated ones left in."""
    return rng.integers(0, np.asarray(shape), size=(n, 2))


def threshold_particles(shape: Tuple[int, int, int], threshold: float = 5.0) -> int:
    """The original's number of particles from a threshold t: gx gy gz / (30 t), at least 1."""
    if not (math.isfinite(threshold) and threshold > 0.0):
        raise ValueError(f"threshold {threshold} must be a positive number")
    return max(1, int(np.prod(shape) / (30.0 * threshold)))
