"""In which order upright boxes are drawn, so that a nearer one covers those behind it."""

from __future__ import annotations

from typing import Dict, List, Sequence, Set, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.pinhole import BoxSize, footprint


def far_to_near(boxes: Sequence[Tuple[Pose2, BoxSize]], eye: Tuple[float, float]) -> List[int]:
    """Numbers of the boxes, those that may be covered by others first.

    Of two boxes a line along one side of one of them divides, the one on the eye's side of that line is in front.
    Where boxes overlap, or cover each other in a circle, the distance of their middles decides.

    Args:
        boxes: pose of the middle, and size.
        eye: x, y of the camera, metres.
    """
    outlines = [footprint(pose, size) for pose, size in boxes]
    behind: Dict[int, Set[int]] = {
        i: {j for j in range(len(boxes)) if j != i and _is_front(outlines[i], outlines[j], np.array(eye))}
        for i in range(len(boxes))
    }
    distance = [float(np.hypot(pose.x - eye[0], pose.y - eye[1])) for pose, _ in boxes]
    order: List[int] = []
    left = set(range(len(boxes)))
    while left:
        free = [i for i in left if not behind[i] & left]
        chosen = max(free or left, key=lambda i: distance[i])
        order.append(chosen)
        left.remove(chosen)
    return order


def _is_front(first: FloatArray, second: FloatArray, eye: FloatArray) -> bool:
    """Whether the first convex outline may cover a part of the second, as seen from the eye."""
    for owner, other, eye_is_with_other in ((first, second, False), (second, first, True)):
        inside = owner.mean(0)
        for a, b in zip(owner, np.roll(owner, -1, axis=0)):
            normal = np.array([b[1] - a[1], a[0] - b[0]])
            normal = normal if (inside - a) @ normal < 0 else -normal
            if (((other - a) @ normal) >= 0).all():
                eye_outside = bool((eye - a) @ normal > 0)
                return eye_outside == eye_is_with_other
    return False
