"""Inverse kinematics of the youBot's arm in closed form, every branch.

Five joints turn an upright plane (joint 1), move in it (2 to 4) and spin the tool (5): a pose can be reached only if
the wrist point and the tool's axis lie in one upright plane through axis 1. Where they do there are up to four answers:
the plane faces the hand or turns its back on it, and the elbow bends either way. docs/manipulation.md derives it.

One pose is solved in plain floats, which is an order of magnitude quicker than through arrays.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import List, Tuple

import numpy as np
import numpy.typing as npt

from yarm.manipulation.kinematics.forward import UNIT_TOLERANCE, checked_pose
from yarm.robots.youbot import (
    FOREARM_M,
    HAND_M,
    LOWER_RAD,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    UPPER_RAD,
    WRIST_ASIDE_M,
    Joints,
)

PLANE_TOLERANCE = 1e-6
"""How far wrist point (m) and tool axis (its component) may be out of one plane through axis 1."""
FREE_TOLERANCE = 1e-9
"""Both nearer to axis 1 than this: the plane is free, only joint 1 minus or plus joint 5 counts."""
TRIAL_PLANES = tuple(math.radians(angle) for angle in (0.0, 60.0, -60.0, 120.0, -120.0))
LIMIT_TOLERANCE_RAD = 1e-9
BEND_ERROR_RAD2, MOST_BEND_ERROR_RAD = 1e-14, 1e-7
"""Joint 3 comes from its cosine: an elbow bent by b is known to 1e-14 / b only, a straight one to 1e-7 rad. So much
more a joint may be beyond its limit, or a pose held with a straight elbow at a limit would have no answer."""
STRAIGHT_TOLERANCE_M = 1e-9
"""A wrist point farther out than the straight arm by less counts as reached by it."""
AXIS_LENGTH_M = 0.3
"""What turns the tool axis' horizontal part into a length beside the wrist point's distance from axis 1."""
_SUM_OF_SQUARES = UPPER_ARM_M**2 + FOREARM_M**2
_TWICE_PRODUCT = 2.0 * UPPER_ARM_M * FOREARM_M


class IkStatus(Enum):
    """How a pose was answered."""

    SOLVED = "solved"
    BEYOND_LIMITS = "beyond the joints' limits"
    OUT_OF_PLANE = "out of every plane through axis 1"
    OUT_OF_REACH = "out of reach"


@dataclass(frozen=True)
class IkAnswer:
    """Every configuration that reaches a pose.

    Attributes:
        status: whether there is one within the limits, and why not.
        solutions: those within the limits.
        beyond: those that leave them.
        plane_error: how far wrist point (m) or tool axis (its component) is out of the plane of joint 1, the greater.
        reach_error_m: how much farther, or nearer, than joints 2 and 3 reach the wrist point is; 0 within.
        free: joint 1 may stand anywhere; five trial angles were tried.
        plane_tolerance: how much of ``plane_error`` was allowed.
    """

    status: IkStatus
    solutions: Tuple[Joints, ...]
    beyond: Tuple[Joints, ...]
    plane_error: float
    reach_error_m: float
    free: bool = False
    plane_tolerance: float = PLANE_TOLERANCE

    @property
    def reason(self) -> str:
        """Why there is no solution, with the number and the limit; empty when there is one."""
        if self.status is IkStatus.OUT_OF_PLANE:
            return (
                f"wrist or tool axis is {self.plane_error:.3g} out of the plane of axis 1, "
                f"{self.plane_tolerance:.3g} is allowed; five joints cannot follow"
            )
        if self.status is IkStatus.OUT_OF_REACH:
            low, high = abs(UPPER_ARM_M - FOREARM_M), UPPER_ARM_M + FOREARM_M
            return (
                f"wrist point is {self.reach_error_m:.4f} m beyond what joints 2 and 3 reach "
                f"({low:.3f} to {high:.3f} m)"
            )
        if self.status is IkStatus.BEYOND_LIMITS:
            nearest = min(self.beyond, key=lambda q: max(_overruns(q)))
            joint, over = max(enumerate(_overruns(nearest)), key=lambda item: item[1])
            return (
                f"all {len(self.beyond)} configurations leave the joints' limits; the nearest has joint {joint + 1} at "
                f"{math.degrees(nearest[joint]):.1f} deg, {math.degrees(over):.1f} beyond "
                f"{math.degrees(LOWER_RAD[joint]):.1f} to {math.degrees(UPPER_RAD[joint]):.1f} deg"
            )
        return ""


def inverse(pose: npt.ArrayLike, plane_tolerance: float = PLANE_TOLERANCE) -> IkAnswer:
    """Every configuration at which the end effector has a pose (4, 4), metres, arm's frame.

    Args:
        pose: of the end effector.
        plane_tolerance: see ``PLANE_TOLERANCE``; noise of 1e-7 m in a pose needs as much.

    Raises:
        KinematicsError: not a pose.
    """
    rows = pose.tolist() if isinstance(pose, np.ndarray) and pose.shape == (4, 4) else checked_pose(pose).tolist()
    if not _is_pose(rows):
        checked_pose(pose)
    return solve(rows, plane_tolerance)


def solve(rows: List[List[float]], plane_tolerance: float = PLANE_TOLERANCE) -> IkAnswer:
    """The same for a pose that is known to be one, as nested lists."""
    (r11, r12, r13, px), (r21, r22, r23, py), (_, _, r33, pz), _ = rows
    x, y = px - HAND_M * r13, py - HAND_M * r23
    wrist, tool = math.hypot(x, y), AXIS_LENGTH_M * math.hypot(r13, r23)
    free = wrist < FREE_TOLERANCE and tool < FREE_TOLERANCE
    if free:
        planes: Tuple[float, ...] = TRIAL_PLANES
    else:
        first = math.atan2(y, x) if wrist >= tool else math.atan2(r23, r13)
        planes = (first, first - math.pi if first > 0.0 else first + math.pi)
    plane_error, reach_error = 0.0, math.inf
    solutions: List[Joints] = []
    beyond: List[Joints] = []
    for q1 in planes:
        c1, s1 = math.cos(q1), math.sin(q1)
        plane_error = max(abs(c1 * y - s1 * x), abs(c1 * r23 - s1 * r13))
        if plane_error > plane_tolerance:
            continue
        st = r13 * c1 + r23 * s1
        q5 = math.atan2(s1 * r11 - c1 * r21, c1 * r22 - s1 * r12)
        u = x * c1 + y * s1 - WRIST_ASIDE_M * r33 - SHOULDER_AHEAD_M
        v = pz - HAND_M * r33 + WRIST_ASIDE_M * st - SHOULDER_HEIGHT_M
        reach_error = min(reach_error, _elbows(q1, q5, u, v, math.atan2(st, r33), solutions, beyond))
    return IkAnswer(
        _status(solutions, beyond, plane_error > plane_tolerance),
        tuple(solutions),
        tuple(beyond),
        plane_error,
        0.0 if solutions or beyond or math.isinf(reach_error) else reach_error,
        free,
        plane_tolerance,
    )


def _elbows(q1: float, q5: float, u: float, v: float, t: float, solutions: List[Joints], beyond: List[Joints]) -> float:
    """Add the configurations of one plane; how far the wrist point (u, v), from joint 2, is out of reach, metres."""
    cosine = (u * u + v * v - _SUM_OF_SQUARES) / _TWICE_PRODUCT
    if cosine > 1.0 or cosine < -1.0:
        distance = math.hypot(u, v)
        over = max(distance - UPPER_ARM_M - FOREARM_M, UPPER_ARM_M - FOREARM_M - distance)
        if over > STRAIGHT_TOLERANCE_M:
            return over
        cosine = math.copysign(1.0, cosine)
    bend = math.acos(cosine)
    towards = math.atan2(u, v)
    tolerance = LIMIT_TOLERANCE_RAD + BEND_ERROR_RAD2 / max(bend, BEND_ERROR_RAD2 / MOST_BEND_ERROR_RAD)
    for q3 in (bend, -bend) if bend > 0.0 else (0.0,):
        q2 = _wrapped(towards - math.atan2(FOREARM_M * math.sin(q3), UPPER_ARM_M + FOREARM_M * cosine))
        q: Joints = (q1, q2, q3, _wrapped(t - q2 - q3), q5)
        (solutions if within(q, tolerance) else beyond).append(q)
    return 0.0


def _overruns(q: Joints) -> List[float]:
    """How far each joint is beyond its limits, rad; below 0 within."""
    return [max(low - angle, angle - high) for angle, low, high in zip(q, LOWER_RAD, UPPER_RAD)]


def within(q: Joints, tolerance_rad: float = LIMIT_TOLERANCE_RAD) -> bool:
    """Whether one configuration keeps every limit (``youbot.within_limits`` for one, in plain floats)."""
    return all(
        low - tolerance_rad <= angle <= high + tolerance_rad for angle, low, high in zip(q, LOWER_RAD, UPPER_RAD)
    )


def _is_pose(rows: List[List[float]]) -> bool:
    """What ``checked_pose`` asks for, in plain floats; NaN fails every comparison."""
    (a, b, c, x), (d, e, f, y), (g, h, i, z), _ = rows
    off = max(
        abs(a * a + b * b + c * c - 1.0),
        abs(d * d + e * e + f * f - 1.0),
        abs(a * d + b * e + c * f),
        abs(b * f - c * e - g),
        abs(c * d - a * f - h),
        abs(a * e - b * d - i),
    )
    return off <= 0.5 * UNIT_TOLERANCE and math.isfinite(a + b + c + d + e + f + g + h + i + x + y + z)


def _wrapped(angle: float) -> float:
    if angle > math.pi:
        return angle - 2.0 * math.pi if angle <= 3.0 * math.pi else math.remainder(angle, 2.0 * math.pi)
    if angle <= -math.pi:
        return angle + 2.0 * math.pi if angle > -3.0 * math.pi else math.remainder(angle, 2.0 * math.pi)
    return angle


def _status(solutions: List[Joints], beyond: List[Joints], out_of_plane: bool) -> IkStatus:
    if solutions:
        return IkStatus.SOLVED
    if beyond:
        return IkStatus.BEYOND_LIMITS
    return IkStatus.OUT_OF_PLANE if out_of_plane else IkStatus.OUT_OF_REACH
