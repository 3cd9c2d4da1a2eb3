"""Raster of passes over a surface, and how much of a surface a sander's path has covered."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
from scipy.spatial import cKDTree

from yarm.control.sander.surface import Surface
from yarm.geometry.grid import FloatArray

STEP_M = 0.01
COVERAGE_CELL_M = 0.005


@dataclass(frozen=True, eq=False)
class Stroke:
    """One straight piece of a raster.

    Attributes:
        points: (n, 3) on the surface, at most 1 cm apart, metres, world.
        normals: (n, 3) out of the surface.
        arc_m: (n,) way from the raster's start, metres.
    """

    points: FloatArray
    normals: FloatArray
    arc_m: FloatArray


@dataclass(frozen=True, eq=False)
class Raster:
    """Strokes from end to end."""

    strokes: Tuple[Stroke, ...]

    @property
    def length_m(self) -> float:
        """Whole way, metres."""
        return float(self.strokes[-1].arc_m[-1])

    @property
    def polyline(self) -> FloatArray:
        """All points (n, 3)."""
        return np.concatenate([stroke.points for stroke in self.strokes])


def lay_raster(surface: Surface, spacing_m: float, inset_m: float, standoff_m: float = 0.0) -> Raster:
    """Passes to and fro along the surface's longer side, evenly spaced by at most the spacing.

    Args:
        surface: what to sand.
        spacing_m: greatest distance between two passes.
        inset_m: distance of the outermost passes, and of the ends of all, from the edge.
        standoff_m: distance of the path from the surface, along its normals.
    """
    lower, upper = np.array(surface.lower) + inset_m, np.array(surface.upper) - inset_m
    along = 1 if upper[1] - lower[1] >= upper[0] - lower[0] else 0
    across = 1 - along
    count = max(math.ceil((upper[across] - lower[across]) / spacing_m - 1e-3), 1) + 1
    corners = []
    for index, offset in enumerate(np.linspace(lower[across], upper[across], count)):
        ends = (lower[along], upper[along]) if index % 2 == 0 else (upper[along], lower[along])
        for end in ends:
            corner = np.empty(2)
            corner[along], corner[across] = end, offset
            corners.append(corner)
    strokes, arc = [], 0.0
    for start, end in zip(corners[:-1], corners[1:]):
        stroke = _stroke(surface, start, end, arc, standoff_m)
        arc = float(stroke.arc_m[-1])
        strokes.append(stroke)
    return Raster(tuple(strokes))


def _stroke(surface: Surface, start: FloatArray, end: FloatArray, arc_m: float, standoff_m: float) -> Stroke:
    steps = max(math.ceil(float(np.linalg.norm(end - start)) / STEP_M), 1)
    xy = start + (end - start) * np.linspace(0.0, 1.0, steps + 1)[:, None]
    normals = surface.normals(xy)
    points = surface.points(xy) + standoff_m * normals
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return Stroke(points, normals, arc_m + np.concatenate([[0.0], np.cumsum(lengths)]))


def coverage(
    tips: FloatArray, lower: Tuple[float, float], upper: Tuple[float, float], height_m: float, radius_m: float
) -> float:
    """Share of a level rectangle over which a round tool has passed while it touched it.

    Args:
        tips: (n, 3) positions of the tool's face, metres, world; close together.
        lower: corner (x, y) of the rectangle.
        upper: the other corner.
        height_m: of the rectangle; the tool touches it within 5 mm.
        radius_m: of the tool.
    """
    touching = tips[np.abs(tips[:, 2] - height_m) <= 0.005]
    if len(touching) == 0:
        return 0.0
    xs = np.arange(lower[0] + 0.5 * COVERAGE_CELL_M, upper[0], COVERAGE_CELL_M)
    ys = np.arange(lower[1] + 0.5 * COVERAGE_CELL_M, upper[1], COVERAGE_CELL_M)
    cells = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=-1).reshape(-1, 2)
    distances, _ = cKDTree(touching[:, :2]).query(cells)
    return float(np.mean(distances <= radius_m))
