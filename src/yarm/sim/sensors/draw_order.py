"""In which order upright boxes are drawn, so that a nearer one covers those behind it."""

from __future__ import annotations

from functools import lru_cache
from typing import List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray, Pose2
from yarm.geometry.pinhole import BoxSize, footprint

Boxes = Tuple[Tuple[Pose2, BoxSize], ...]


class _Lines(NamedTuple):
    """For each box (n) and each other one (n) a line along a side of one of them that divides them.

    Attributes:
        points: (n, n, 2) on the line.
        normals: (n, n, 2) away from whom the side belongs to.
        is_others: (n, n) the side belongs to the other one.
        divided: (n, n) whether there is such a line.
    """

    points: FloatArray
    normals: FloatArray
    is_others: BoolArray
    divided: BoolArray


def far_to_near(boxes: Sequence[Tuple[Pose2, BoxSize]], eye: Tuple[float, float]) -> List[int]:
    """Numbers of the boxes, those that may be covered by others first.

    Of two boxes a line along one side of one of them divides, the one on the eye's side of that line is in front.
    Where boxes overlap, or cover each other in a circle, the distance of their middles decides.

    Args:
        boxes: pose of the middle, and size.
        eye: x, y of the camera, metres.
    """
    lines = _dividing(tuple(boxes))
    eye_is_outside = np.sum((np.asarray(eye) - lines.points) * lines.normals, axis=2) > 0.0
    front = lines.divided & (eye_is_outside == lines.is_others)
    behind = [set(np.flatnonzero(row).tolist()) for row in front]
    distance = [float(np.hypot(pose.x - eye[0], pose.y - eye[1])) for pose, _ in boxes]
    order: List[int] = []
    left = set(range(len(boxes)))
    while left:
        free = [i for i in left if not behind[i] & left]
        chosen = max(free or left, key=lambda i: distance[i])
        order.append(chosen)
        left.remove(chosen)
    return order


@lru_cache(maxsize=8)
def _dividing(boxes: Boxes) -> _Lines:
    """The lines between boxes; they stand still while the eye moves."""
    outlines = [footprint(pose, size) for pose, size in boxes]
    n = len(outlines)
    lines = _Lines(np.zeros((n, n, 2)), np.zeros((n, n, 2)), np.zeros((n, n), np.bool_), np.zeros((n, n), np.bool_))
    for i, first in enumerate(outlines):
        for j, second in enumerate(outlines):
            own, others = _divides(first, second), _divides(second, first)
            found = own or others
            if i != j and found is not None:
                lines.points[i, j], lines.normals[i, j] = found
                lines.is_others[i, j], lines.divided[i, j] = own is None, True
    return lines


def _divides(owner: FloatArray, other: FloatArray) -> Optional[Tuple[FloatArray, FloatArray]]:
    """A point on a side of a convex outline that has all of another one beyond it, and that side's outer normal."""
    inside = owner.mean(0)
    for a, b in zip(owner, np.roll(owner, -1, axis=0)):
        normal = np.array([b[1] - a[1], a[0] - b[0]])
        normal = normal if (inside - a) @ normal < 0 else -normal
        if (((other - a) @ normal) >= 0).all():
            return a, normal
    return None
