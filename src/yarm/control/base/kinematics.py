"""Steerable wheels of the omnidirectional base: caster angles for a direction or a centre of turning, and back.

Body frame: x ahead (along the arm), y left, origin at the body's centre; caster angles are headings of the wheels in
the body frame, rad, in [-pi, pi], in the order front left, front right, rear left, rear right. A drive command is
(drive speed along the wheels' heading, m/s; yaw rate about the centre that the caster angles define, rad/s).

Wheels that roll without slipping leave the body one motion: about the point in which their axes meet, or straight
where they are parallel (G. Campion, G. Bastin, B. d'Andrea-Novel, "Structural properties and classification of
kinematic and dynamic models of wheeled mobile robots", IEEE Transactions on Robotics and Automation 12, 1996).
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Optional, Sequence, Tuple

import numpy as np

from yarm.robots.ankurbot import CASTER_XY_M

Casters = Tuple[float, float, float, float]
Point = Tuple[float, float]

BODY_CENTRE: Point = (0.0, 0.0)
STEERING_ROOM_RAD = 0.3


def turning_casters(centre: Point) -> Casters:
    """Caster angles, within +-90 deg, at which the body can only turn about a centre (x, y), metres, body frame.

    Raises:
        ValueError: the centre is under a caster.
    """
    angles = []
    for x, y in CASTER_XY_M:
        dx, dy = x - centre[0], y - centre[1]
        if math.hypot(dx, dy) < 1e-6:
            raise ValueError(f"centre {centre} lies under the caster at ({x}, {y})")
        angles.append(half_turn(math.atan2(dx, -dy)))
    return (angles[0], angles[1], angles[2], angles[3])


def driving_casters(direction_rad: float, current: Sequence[float]) -> Tuple[Casters, float]:
    """All casters along a direction (body frame, rad) or against it, whichever is the shorter way from where they are.

    Angles near +-180 deg are avoided, where re-steering would run into the casters' stops.

    Returns:
        caster angles and the sign, +1 or -1, of the drive speed that then moves the body along the direction.
    """
    ahead = full_turn(direction_rad)
    back = full_turn(direction_rad + math.pi)
    forward = max(abs(ahead - angle) for angle in current) <= max(abs(back - angle) for angle in current) + 1e-9
    if max(abs(ahead), abs(back)) > math.pi - STEERING_ROOM_RAD:
        forward = abs(ahead) < abs(back)
    angle, sign = (ahead, 1.0) if forward else (back, -1.0)
    return (angle, angle, angle, angle), sign


def body_velocity(casters: Sequence[float], drive_mps: float, yaw_rate_radps: float) -> Tuple[float, float, float]:
    """Velocity of the body (vx, vy, m/s, body frame; yaw rate, rad/s) from caster angles and a drive command.

    Parallel casters define no centre of turning; then only the drive speed counts.
    """
    centre = turning_centre(casters)
    if centre is None:
        mean = math.atan2(sum(math.sin(a) for a in casters), sum(math.cos(a) for a in casters))
        return drive_mps * math.cos(mean), drive_mps * math.sin(mean), 0.0
    return yaw_rate_radps * centre[1], -yaw_rate_radps * centre[0], yaw_rate_radps


def turning_centre(casters: Sequence[float]) -> Optional[Point]:
    """Centre (x, y), metres, body frame, nearest to all wheels' axles; None when the wheels are parallel."""
    return _turning_centre(tuple(casters))


@lru_cache(maxsize=64)
def _turning_centre(casters: Tuple[float, ...]) -> Optional[Point]:
    """The same; while a base drives its wheels keep their angles."""
    normals = np.array([(math.cos(a), math.sin(a)) for a in casters])
    offsets = np.einsum("ij,ij->i", normals, np.array(CASTER_XY_M))
    _, singular, _ = np.linalg.svd(normals)
    if singular[1] < 1e-3 * singular[0]:
        return None
    centre = np.linalg.lstsq(normals, offsets, rcond=None)[0]
    return float(centre[0]), float(centre[1])


def full_turn(angle_rad: float) -> float:
    """The same direction in [-pi, pi]."""
    return math.remainder(angle_rad, 2.0 * math.pi)


def half_turn(angle_rad: float) -> float:
    """The same line, regardless of sense, in [-pi/2, pi/2]."""
    return math.remainder(angle_rad, math.pi)
