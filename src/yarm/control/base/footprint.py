"""Extent of a robot in cells of the grid, from its solids: what a mobile robot answers to CALIBRATION."""

from __future__ import annotations

import math
from typing import Sequence, Tuple

from yarm.geometry.grid import FloatArray, GridSpec

Box = Tuple[FloatArray, FloatArray]


def extent_in_cells(boxes: Sequence[Box], spec: GridSpec) -> Tuple[int, int, int]:
    """Cells along x, y, z that the boxes (lower, upper corner (3,), metres, arm along x, z from the floor) take.

    A robot stands on the floor, below the grid's lower bound, so that its cells along z begin with the lowest.

    Raises:
        ValueError: no boxes.
    """
    if not boxes:
        raise ValueError("a robot's extent needs at least one solid")
    lower = [min(float(box[0][axis]) for box in boxes) for axis in range(3)]
    upper = [max(float(box[1][axis]) for box in boxes) for axis in range(3)]
    lower[2], upper[2] = spec.lower[2], min(upper[2], spec.upper[2])
    cells = [math.ceil((upper[i] - lower[i]) / float(spec.resolution[i]) - 1e-6) for i in range(3)]
    return cells[0], cells[1], cells[2]


def box_around(half_extent: FloatArray, pose: FloatArray) -> Box:
    """Axis-aligned box around a turned box: half extents (3,), metres, in its own frame and its pose (4, 4)."""
    half = abs(pose[:3, :3]) @ half_extent
    return pose[:3, 3] - half, pose[:3, 3] + half
