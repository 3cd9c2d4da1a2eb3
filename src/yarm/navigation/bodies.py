"""Bodies whose place is known, drawn into a map before anything has been seen of them."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from yarm.geometry import FloatArray
from yarm.navigation.grid_map import CellArray, GridMap

OCCUPIED = 100


def with_bodies(grid_map: GridMap, outlines: Sequence[FloatArray]) -> GridMap:
    """The map with bodies in it: every cell whose middle is in a body, or within half a cell of it, is occupied.

    So a body's sides lie within half a cell of the middles of its outermost cells. What is outside the map is left out.

    Args:
        grid_map: the map; it is not changed.
        outlines: of each body the corners (n, 2) of a convex outline, counter-clockwise, map frame, metres; n >= 3.

    Raises:
        ValueError: an outline is not (n, 2) finite numbers, or not convex and counter-clockwise.
    """
    cells: CellArray = grid_map.cells.copy()
    for number, outline in enumerate(outlines):
        corners = np.asarray(outline, dtype=float)
        fault = _outline_fault(corners)
        if fault:
            raise ValueError(f"outline {number} {fault}")
        _draw(grid_map, cells, corners)
    return GridMap(cells, grid_map.resolution_m, grid_map.origin)


def _outline_fault(corners: FloatArray) -> str:
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3 or not np.isfinite(corners).all():
        return f"must be (n, 2) finite numbers with n >= 3, not shape {corners.shape}"
    sides = np.roll(corners, -1, axis=0) - corners
    turns = np.roll(sides, -1, axis=0)
    if np.any(sides[:, 0] * turns[:, 1] - sides[:, 1] * turns[:, 0] <= 0.0):
        return "must be convex, its corners counter-clockwise"
    return ""


def _draw(grid_map: GridMap, cells: CellArray, corners: FloatArray) -> None:
    at = grid_map.cells_of(corners)
    low = np.clip(at.min(axis=0) - 1, 0, cells.shape)
    high = np.clip(at.max(axis=0) + 2, 0, cells.shape)
    if np.any(high <= low):
        return
    rows, columns = np.mgrid[low[0] : high[0], low[1] : high[1]]
    points = grid_map.centres_of(np.stack([rows.ravel(), columns.ravel()], axis=1))
    inside = distances(points, corners) <= 0.5 * grid_map.resolution_m
    cells[rows.ravel()[inside], columns.ravel()[inside]] = OCCUPIED


def distances(points: FloatArray, corners: FloatArray) -> FloatArray:
    """(m,) distance of points (m, 2) to a convex body with corners (n, 2), counter-clockwise; 0 inside, metres."""
    sides = np.roll(corners, -1, axis=0) - corners
    apart = points[:, None, :] - corners[None, :, :]
    left = sides[None, :, 0] * apart[:, :, 1] - sides[None, :, 1] * apart[:, :, 0]
    share = np.clip((apart * sides).sum(axis=2) / (sides**2).sum(axis=1), 0.0, 1.0)
    gaps = np.linalg.norm(apart - share[:, :, None] * sides, axis=2).min(axis=1)
    found: FloatArray = np.where((left >= 0.0).all(axis=1), 0.0, gaps)
    return found
