"""Corners that a base drives round without stopping: on an arc inside the corner that passes it within a distance.

The casters turn at one rate, so the arc's radius R is the speed over that rate. It touches both lines: with the way's
direction changed by an angle, it begins R tan(angle / 2) before the corner and passes it at R (1 / cos(angle / 2) - 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Sequence

from yarm.control.base.kinematics import STEERING_ROOM_RAD, full_turn
from yarm.control.base.params import BaseParams
from yarm.control.base.speed_profile import passing_speed
from yarm.geometry.poses import Pose2

STRAIGHT_RAD = math.radians(0.5)
"""A lesser change of direction is none."""
SHARPEST_RAD = math.radians(60.0)
"""At a sharper corner the base stops."""


@dataclass(frozen=True)
class Corner:
    """How a corner is passed.

    Attributes:
        left_m: way to it along the lines.
        before_m: where the arc begins at that speed, before it, metres; later at a lower one, in proportion.
        speed_mps: on the arc; 0 for one where the base stops.
    """

    left_m: float
    before_m: float
    speed_mps: float


def corners_ahead(left_m: float, caster_rad: float, points: Sequence[Pose2], params: BaseParams) -> List[Corner]:
    """The corners of a way up to the first one at which the base stops; the end of the way is such a one.

    Args:
        left_m: way left to the first corner.
        caster_rad: angle of the casters on the line that leads there, body frame.
        points: where the line began, and the corners, the last of them the end; at least two.
        params: of the base.
    """
    found: List[Corner] = []
    for k in range(1, len(points) - 1):
        before, at, after = points[k - 1 : k + 2]
        turn = full_turn(_direction(at, after) - _direction(before, at))
        caster_rad += turn
        if abs(turn) > SHARPEST_RAD or abs(caster_rad) > math.pi - STEERING_ROOM_RAD:
            break
        found.append(_corner(left_m, abs(turn), min(before.distance(at), at.distance(after)) / 2.0, params))
        left_m += at.distance(after)
    return [*found, Corner(left_m, 0.0, 0.0)]


def speed_for(corners: Sequence[Corner], params: BaseParams) -> float:
    """Largest speed from which every corner can be passed at its speed, m/s."""
    return min(
        passing_speed(corner.left_m - corner.before_m, corner.speed_mps, params.deceleration_mps2, params.delay_s)
        for corner in corners
    )


def _corner(left_m: float, turn_rad: float, room_m: float, params: BaseParams) -> Corner:
    if turn_rad < STRAIGHT_RAD:
        return Corner(left_m, 0.0, params.cap_mps)
    half = turn_rad / 2.0
    widest = min(params.corner_m / (1.0 / math.cos(half) - 1.0), room_m / math.tan(half))
    speed = min(params.cap_mps, params.corner_rate_radps * widest)
    return Corner(left_m, speed / params.corner_rate_radps * math.tan(half), speed)


def _direction(start: Pose2, end: Pose2) -> float:
    return math.atan2(end.y - start.y, end.x - start.x)
