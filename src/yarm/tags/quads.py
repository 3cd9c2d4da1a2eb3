"""Measures of a tag's outline in an image: corners (4, 2), pixels, top left, top right, bottom right, bottom left."""

from __future__ import annotations

import math
from typing import Optional, Tuple

import cv2
import numpy as np

from yarm.geometry import FloatArray

OUTSIDE_WEIGHT = -0.5
"""What a pixel of the outline outside the image counts in the effective area; one inside counts 1."""
FARTHEST_PX = 16000.0
"""Corners are cut off here before they are drawn."""


def mapped_corners(homography: FloatArray, width: int, height: int) -> FloatArray:
    """Corners of a picture (width, height) as a homography (3, 3) maps them."""
    corners = np.array([[[0, 0], [width, 0], [width, height], [0, height]]], dtype=float)
    mapped: FloatArray = cv2.perspectiveTransform(corners, homography)[0]
    return mapped


def area(corners: FloatArray) -> float:
    """Area of the outline, square pixels."""
    return float(cv2.contourArea(np.asarray(corners, dtype=np.float32)))


def effective_area(corners: FloatArray, width: int, height: int) -> float:
    """Pixels of the outline inside an image of this size, less half of those outside."""
    mask = np.zeros((height, width), np.uint8)
    cut = np.clip(corners, -FARTHEST_PX, FARTHEST_PX)
    cv2.fillPoly(mask, [np.round(cut * 16).astype(np.int32)], 1, cv2.LINE_8, 4)
    inside = float(np.count_nonzero(mask))
    return inside + OUTSIDE_WEIGHT * max(0.0, area(corners) - inside)


def is_tangled(corners: FloatArray) -> bool:
    """Whether lines through opposite sides meet inside the corners' bounding box."""
    sides = (((0, 3), (1, 2)), ((0, 1), (3, 2)))
    low, high = corners.min(0), corners.max(0)
    for first, second in sides:
        meeting = _meeting(corners[first[0]], corners[first[1]], corners[second[0]], corners[second[1]])
        if meeting is not None and (meeting > low).all() and (meeting < high).all():
            return True
    return False


def angles_deg(corners: FloatArray) -> Tuple[float, float, float, float]:
    """Angle at each corner by the cosine rule, degrees; NaN where two corners fall together."""
    found = []
    for i in range(4):
        before, here, after = corners[i - 1], corners[i], corners[(i + 1) % 4]
        a, b, c = (math.dist(here, before), math.dist(here, after), math.dist(before, after))
        if a < 1e-9 or b < 1e-9:
            found.append(math.nan)
            continue
        found.append(math.degrees(math.acos(min(1.0, max(-1.0, (a * a + b * b - c * c) / (2.0 * a * b))))))
    return found[0], found[1], found[2], found[3]


def bottom_left(corners: FloatArray) -> int:
    """Number of the lower of the two corners on the left, whichever way the tag is turned."""
    left = np.argsort(corners[:, 0], kind="stable")[:2]
    return int(left[np.argmax(corners[left, 1])])


def bottom_left_angle_deg(corners: FloatArray) -> float:
    """Angle at the bottom left corner, degrees."""
    return angles_deg(corners)[bottom_left(corners)]


def _meeting(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> Optional[FloatArray]:
    """Where the line through a and b meets that through c and d; None when they are parallel."""
    matrix = np.column_stack([b - a, c - d])
    if abs(np.linalg.det(matrix)) < 1e-9:
        return None
    along = np.linalg.solve(matrix, c - a)[0]
    meeting: FloatArray = a + along * (b - a)
    return meeting
