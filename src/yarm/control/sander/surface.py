"""The part's surface from its scan: the highest level surface of some size, fitted by a smooth height function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np
from scipy import ndimage

from yarm.control.arm.errors import ArmError
from yarm.geometry.grid import BoolArray, FloatArray

COLUMN_M = 0.01
LEVEL_M = 0.004
BAND_M = 0.012
OUTLIER_M = 0.006
TRIMS = 4


@dataclass(frozen=True, eq=False)
class Surface:
    """Heights z = c . (1, u, v, u^2, uv, v^2) over a rectangle; u, v from the rectangle's centre, metres.

    Attributes:
        coefficients: (6,).
        lower: corner (x, y) of the rectangle, metres, world.
        upper: the other corner.
        rms_m: root mean square of the points' distances from it.
    """

    coefficients: FloatArray
    lower: Tuple[float, float]
    upper: Tuple[float, float]
    rms_m: float = 0.0

    def points(self, xy: FloatArray) -> FloatArray:
        """Points (n, 3) of the surface over positions (n, 2), metres, world."""
        return np.column_stack([xy, _basis(self._local(xy)) @ self.coefficients])

    def normals(self, xy: FloatArray) -> FloatArray:
        """Normals (n, 3), upwards, of length 1, over positions (n, 2)."""
        u, v = self._local(xy).T
        c = self.coefficients
        normals = np.column_stack(
            [-(c[1] + 2.0 * c[3] * u + c[4] * v), -(c[2] + c[4] * u + 2.0 * c[5] * v), np.ones(len(u))]
        )
        result: FloatArray = normals / np.linalg.norm(normals, axis=1, keepdims=True)
        return result

    def _local(self, xy: FloatArray) -> FloatArray:
        centre = 0.5 * (np.array(self.lower) + np.array(self.upper))
        local: FloatArray = np.asarray(xy, dtype=float) - centre
        return local


def fit_surface(points: FloatArray, least_area_m2: float) -> Surface:
    """Fit the part's upper surface.

    The points are gathered in columns of 1 cm; the part is the highest level that enough columns share. What lies on
    it (debris) and below it (table) is left out, and its outline is that of the largest connected patch.

    Args:
        points: (n, 3), metres, world.
        least_area_m2: smaller surfaces are not the part.

    Raises:
        ArmError: no level surface of that size.
    """
    finite = points[np.all(np.isfinite(points), axis=1)]
    columns, heights = _columns(finite)
    level = _highest_level(heights, least_area_m2)
    near = np.abs(heights - level) < BAND_M
    patch = _largest_patch(columns, near)
    xy = (columns[patch] + 0.5) * COLUMN_M
    lower, upper = xy.min(axis=0) - 0.5 * COLUMN_M, xy.max(axis=0) + 0.5 * COLUMN_M
    local, z = xy - 0.5 * (lower + upper), heights[patch]
    keep = np.ones(len(z), dtype=bool)
    coefficients = np.zeros(6)
    for _ in range(TRIMS):
        coefficients = np.linalg.lstsq(_basis(local[keep]), z[keep], rcond=None)[0]
        residuals = z - _basis(local) @ coefficients
        keep = np.abs(residuals) < OUTLIER_M
    rms = float(np.sqrt(np.mean(residuals[keep] ** 2)))
    return Surface(coefficients, (float(lower[0]), float(lower[1])), (float(upper[0]), float(upper[1])), rms)


def _basis(local: FloatArray) -> FloatArray:
    u, v = local.T
    return np.column_stack([np.ones(len(u)), u, v, u * u, u * v, v * v])


def _columns(points: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Columns (m, 2), whole numbers, and the mean height of the points in each, (m,)."""
    if len(points) == 0:
        raise ArmError("the scan holds no points: does the wrist camera see the part?")
    cells = np.floor(points[:, :2] / COLUMN_M).astype(np.int64)
    columns, index = np.unique(cells, axis=0, return_inverse=True)
    counts = np.bincount(index.ravel(), minlength=len(columns))
    sums = np.bincount(index.ravel(), weights=points[:, 2], minlength=len(columns))
    return columns.astype(float), sums / counts


def _highest_level(heights: FloatArray, least_area_m2: float) -> float:
    edges = np.arange(heights.min() - LEVEL_M, heights.max() + 3.0 * LEVEL_M, LEVEL_M)
    counts, _ = np.histogram(heights, edges)
    smooth = np.convolve(counts, np.ones(3), mode="same")
    wanted = least_area_m2 / COLUMN_M**2
    enough = np.nonzero(smooth >= wanted)[0]
    if len(enough) == 0:
        raise ArmError(
            f"no level surface of {least_area_m2:g} m^2 in the scan: the largest has "
            f"{float(smooth.max()) * COLUMN_M**2:.3f} m^2"
        )
    top = enough[-1]
    while top > 0 and smooth[top - 1] > smooth[top]:
        top -= 1
    return float(0.5 * (edges[top] + edges[top + 1]))


def _largest_patch(columns: FloatArray, near: BoolArray) -> BoolArray:
    """Which columns belong to the largest connected patch of the near ones; holes of a column or two are bridged."""
    cells = (columns - columns.min(axis=0)).astype(np.int64)
    image = np.zeros(cells.max(axis=0) + 1, dtype=bool)
    image[cells[near, 0], cells[near, 1]] = True
    closed = ndimage.binary_closing(np.pad(image, 3), iterations=2)[3:-3, 3:-3] | image
    labels, count = ndimage.label(closed)
    sizes = ndimage.sum_labels(image, labels, index=range(1, count + 1))
    largest = labels == 1 + int(np.argmax(sizes))
    patch: BoolArray = near & largest[cells[:, 0], cells[:, 1]]
    return patch
