"""Whether a disc can follow a path: swept discs against occupied squares; shares no code with the planner."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional, Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray
from yarm.navigation.grid_map import GridMap


@dataclass(frozen=True)
class PathVerdict:
    """What a check found.

    Attributes:
        clear: the disc keeps clear of every occupied cell.
        clearance_m: least distance between the path's line and an occupied square, metres; inf on an empty map.
        piece: index of the first piece (from point i to point i + 1) that is not clear; None when all are.
        reason: what is wrong where; empty when clear.
    """

    clear: bool
    clearance_m: float
    piece: Optional[int] = None
    reason: str = ""


def check_path(grid_map: GridMap, path: FloatArray, radius_m: float) -> PathVerdict:
    """Whether a disc of this radius keeps clear along a path (n, 2) of the map frame, metres.

    A first point that is itself too near to something may be left: along the first piece the distance must not get less
    than it is at the start, and the disc must be clear where that piece ends.

    Raises:
        ValueError: the path is not (n, 2) of finite numbers.
    """
    points = np.asarray(path, dtype=float)
    if points.ndim != 2 or points.shape[1] != 2 or not np.all(np.isfinite(points)):
        raise ValueError(f"a path must be (n, 2) finite numbers, not shape {points.shape}")
    if len(points) == 0:
        return PathVerdict(False, 0.0, 0, "the path is empty")
    boxes = _boxes(grid_map)
    if len(boxes) == 0:
        return PathVerdict(True, math.inf)
    local = _local(grid_map, points)
    least, allowed = math.inf, radius_m
    own = _gap(boxes, local[0], local[0])
    if own < radius_m:
        if len(points) < 2 or _gap(boxes, local[1], local[1]) < radius_m:
            return PathVerdict(False, own, 0, _what(own, radius_m, points[0]))
        allowed = own - 1e-6
    for i in range(max(len(points) - 1, 1)):
        gap = _gap(boxes, local[i], local[min(i + 1, len(points) - 1)])
        least = min(least, gap)
        if gap < (allowed if i == 0 else radius_m):
            return PathVerdict(False, gap, i, _what(gap, radius_m, points[i]))
    return PathVerdict(True, least)


def _what(gap: float, radius_m: float, point: FloatArray) -> str:
    return (
        f"{gap:.3f} m to an occupied cell on the piece that begins at ({point[0]:.2f}, {point[1]:.2f}); "
        f"the disc needs {radius_m:g} m"
    )


def _boxes(grid_map: GridMap) -> FloatArray:
    """(n, 4) least x, least y, greatest x, greatest y of the occupied squares in the map's own axes, metres."""
    rows, columns = np.nonzero(grid_map.occupied)
    low = np.stack([columns, rows], axis=1) * grid_map.resolution_m
    return np.concatenate([low, low + grid_map.resolution_m], axis=1)


def _local(grid_map: GridMap, points: FloatArray) -> FloatArray:
    c, s = math.cos(grid_map.origin.yaw_rad), math.sin(grid_map.origin.yaw_rad)
    moved = points - (grid_map.origin.x, grid_map.origin.y)
    turned: FloatArray = moved @ np.array([[c, -s], [s, c]])
    return turned


def _gap(boxes: FloatArray, a: FloatArray, b: FloatArray) -> float:
    """Least distance between the segment from a to b and the boxes; 0 where it passes through one."""
    near = boxes[_within(boxes, a, b)]
    if len(near) == 0:
        near = boxes
    if _crosses(near, a, b).any():
        return 0.0
    ends = np.minimum(_to_boxes(near, a), _to_boxes(near, b))
    corners = near[:, [0, 1, 2, 1, 0, 3, 2, 3]].reshape(-1, 2)
    return float(min(ends.min(), _to_segment(corners, a, b).min()))


def _within(boxes: FloatArray, a: FloatArray, b: FloatArray, margin_m: float = 0.5) -> BoolArray:
    low, high = np.minimum(a, b) - margin_m, np.maximum(a, b) + margin_m
    keep: BoolArray = np.all((boxes[:, 2:] >= low) & (boxes[:, :2] <= high), axis=1)
    return keep


def _to_boxes(boxes: FloatArray, point: FloatArray) -> FloatArray:
    away = np.maximum(np.maximum(boxes[:, :2] - point, point - boxes[:, 2:]), 0.0)
    distance: FloatArray = np.hypot(away[:, 0], away[:, 1])
    return distance


def _to_segment(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    along = b - a
    length2 = float(along @ along)
    share = np.clip((points - a) @ along / length2, 0.0, 1.0) if length2 > 0.0 else np.zeros(len(points))
    apart = points - (a + share[:, None] * along)
    distance: FloatArray = np.hypot(apart[:, 0], apart[:, 1])
    return distance


def _crosses(boxes: FloatArray, a: FloatArray, b: FloatArray) -> BoolArray:
    """(n,) which boxes the segment enters: the slab method."""
    enter, leave = np.zeros(len(boxes)), np.ones(len(boxes))
    for axis in range(2):
        rise = float(b[axis] - a[axis])
        low, high = boxes[:, axis] - a[axis], boxes[:, axis + 2] - a[axis]
        if abs(rise) < 1e-12:
            outside = (low > 0.0) | (high < 0.0)
            enter = np.where(outside, 2.0, enter)
            continue
        first, second = _ordered(low / rise, high / rise)
        enter, leave = np.maximum(enter, first), np.minimum(leave, second)
    crossed: BoolArray = enter <= leave
    return crossed


def _ordered(a: FloatArray, b: FloatArray) -> Tuple[FloatArray, FloatArray]:
    return np.minimum(a, b), np.maximum(a, b)
