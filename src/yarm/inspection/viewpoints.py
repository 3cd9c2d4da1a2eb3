"""Where the report looks at a box from: distances and angles in order, the first that can be reached."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Iterator, Optional, Sequence, Tuple

from yarm.geometry import Pose2, wrap_angle
from yarm.inspection.boxes import Box

DISTANCES_M = (0.5, 0.6, 0.7, 0.8, 0.4, 0.3, 0.2)
ANGLES_DEG = (0, 30, -30, 60, -60)
NEIGHBOUR_M = 0.6
"""A body nearer than this to the frontal viewpoint is a neighbour."""
NEIGHBOUR_RAD = math.radians(60.0)
"""It counts for a side when it lies within this of it."""
NARROW_M = 0.6
"""Less than this free behind the frontal viewpoint is a narrow space."""

Reachable = Callable[[Pose2], bool]
"""Whether the robot can get to a pose."""
Gap = Callable[[float, float], float]
"""Distance from a point of the map to the nearest body, metres."""


@dataclass(frozen=True)
class Viewpoint:
    """A pose that looks at a box.

    Attributes:
        box: number of the box.
        pose: of the robot, in the map.
        distance_m: from the box's centre.
        angle_deg: from straight ahead of the tag, + counter-clockwise.
    """

    box: int
    pose: Pose2
    distance_m: float
    angle_deg: float


def viewpoint(box: Box, distance_m: float, angle_deg: float) -> Viewpoint:
    """The pose at this distance and angle, facing the box's centre."""
    bearing = box.pose.yaw_rad + math.radians(angle_deg)
    x, y = box.pose.x + distance_m * math.cos(bearing), box.pose.y + distance_m * math.sin(bearing)
    return Viewpoint(box.number, Pose2(x, y, wrap_angle(bearing + math.pi)), distance_m, angle_deg)


def candidates(box: Box, angles_deg: Sequence[int] = ANGLES_DEG) -> Iterator[Viewpoint]:
    """Every viewpoint of a box, in the order in which they are tried."""
    for distance in DISTANCES_M:
        for angle in angles_deg:
            yield viewpoint(box, distance, angle)


def angles_beside(box: Box, others: Sequence[Box], gap: Gap) -> Tuple[int, ...]:
    """The angles to try at a box, in order, as its neighbours and the room in front ask for.

    A neighbour at the left, as the box faces, sends the right-hand angles ahead; at the right the left-hand ones; in
    front, or with too little room there, no frontal point is tried.
    """
    frontal = viewpoint(box, DISTANCES_M[0], 0).pose
    sides = {_side(box, frontal, other) for other in others if other.distance(frontal.x, frontal.y) < NEIGHBOUR_M}
    behind = (
        frontal.x + NARROW_M * math.cos(box.pose.yaw_rad) / 2,
        frontal.y + NARROW_M * math.sin(box.pose.yaw_rad) / 2,
    )
    narrow = gap(*behind) < NARROW_M / 2
    order = list(ANGLES_DEG)
    if "left" in sides and "right" not in sides:
        order = [0, -30, -60, 30, 60]
    elif "right" in sides and "left" not in sides:
        order = [0, 30, 60, -30, -60]
    if "front" in sides or narrow:
        order.remove(0)
    return tuple(order)


def _side(box: Box, frontal: Pose2, other: Box) -> str:
    """Where a neighbour is, seen from the frontal viewpoint in the direction that the box faces; "" behind."""
    bearing = wrap_angle(math.atan2(other.pose.y - frontal.y, other.pose.x - frontal.x) - box.pose.yaw_rad)
    for name, middle in (("front", 0.0), ("left", math.pi / 2), ("right", -math.pi / 2)):
        if abs(wrap_angle(bearing - middle)) <= (NEIGHBOUR_RAD if name != "front" else math.radians(30.0)):
            return name
    return ""


def first_reachable(box: Box, reachable: Reachable, angles_deg: Sequence[int] = ANGLES_DEG) -> Optional[Viewpoint]:
    """The first candidate that can be reached; None when none can."""
    return next((view for view in candidates(box, angles_deg) if reachable(view.pose)), None)
