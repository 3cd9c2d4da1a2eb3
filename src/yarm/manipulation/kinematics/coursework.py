"""The formulas that the coursework printed, as it printed them, to be measured beside the right ones.

What is wrong with them is listed in docs/manipulation.md; nothing but the comparison and the demo uses them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import checked_joints, checked_pose, forward, forward_many, jacobian
from yarm.manipulation.kinematics.iterative import IterativeAnswer
from yarm.robots.youbot import (
    FOREARM_M,
    HAND_M,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    WRIST_ASIDE_M,
    Joints,
)

PRINTED_WRIST_ASIDE_M = -WRIST_ASIDE_M
"""The sign the other way round."""
ALPHA = 0.1
TOLERANCE = 1e-4
MOST_ITERATIONS = 20_000


@dataclass(frozen=True)
class Mended:
    """Which of the printed inverse kinematics' faults are taken away.

    Attributes:
        gamma: the arguments of the arc tangent in joint 2 exchanged.
        theta5: both arguments of the arc tangent in joint 5 negated.
    """

    gamma: bool = False
    theta5: bool = False


AS_PRINTED = Mended()


def printed_forward_many(q: FloatArray) -> FloatArray:
    """Poses (n, 4, 4) at joints (n, 5), rad: 4 mm beside the arm's everywhere."""
    poses = forward_many(q)
    tilt = q[:, 1] + q[:, 2] + q[:, 3]
    off = PRINTED_WRIST_ASIDE_M - WRIST_ASIDE_M
    poses[:, 0, 3] += off * np.cos(tilt) * np.cos(q[:, 0])
    poses[:, 1, 3] += off * np.cos(tilt) * np.sin(q[:, 0])
    poses[:, 2, 3] -= off * np.sin(tilt)
    return poses


def printed_inverse(pose: FloatArray, mended: Mended = AS_PRINTED) -> Optional[Joints]:
    """The one configuration that the printed formulas give; None where they are undefined.

    Args:
        pose: (4, 4), metres.
        mended: faults taken away.
    """
    r, p = pose[:3, :3], pose[:3, 3]
    x, y = p[0] - HAND_M * r[0, 2], p[1] - HAND_M * r[1, 2]
    q1 = math.atan2(y, x)
    if math.sin(q1) == 0.0 or abs(r[2, 2]) > 1.0:
        return None
    k = y / math.sin(q1)
    sine = math.sqrt(1.0 - r[2, 2] ** 2)
    u = k - PRINTED_WRIST_ASIDE_M * r[2, 2] - SHOULDER_AHEAD_M
    v = p[2] - HAND_M * r[2, 2] - SHOULDER_HEIGHT_M + PRINTED_WRIST_ASIDE_M * sine
    cosine = (u * u + v * v - UPPER_ARM_M**2 - FOREARM_M**2) / (2.0 * UPPER_ARM_M * FOREARM_M)
    if abs(cosine) > 1.0:
        return None
    q3 = math.acos(cosine)
    a, b = UPPER_ARM_M + FOREARM_M * math.cos(q3), FOREARM_M * math.sin(q3)
    gamma = math.atan2(b, a) if mended.gamma else math.atan2(a, b)
    length = math.hypot(a, b)
    q2 = math.atan2(u / length, v / length) - gamma
    q4 = math.acos(r[2, 2]) - q2 - q3
    q5 = math.atan2(-r[2, 1], -r[2, 0]) if mended.theta5 else math.atan2(r[2, 1], r[2, 0])
    return q1, q2, q3, q4, q5


def printed_jacobian(q: FloatArray) -> FloatArray:
    """Jacobian (6, 5) with the origin of frame 4 for the end effector: its linear rows are off by up to 0.185 m/rad."""
    matrix = jacobian(q)
    lever = HAND_M * forward(q)[:3, 2]
    matrix[:3] -= np.cross(matrix[3:].T, lever).T
    return matrix


def transposed_jacobian(
    pose: FloatArray, start: FloatArray, most_iterations: int = MOST_ITERATIONS, printed: bool = False
) -> IterativeAnswer:
    """The coursework's iteration: q += alpha J^T (difference of the poses), without limits.

    Args:
        pose: (4, 4), metres, arm's frame.
        start: (5,), rad.
        most_iterations: after which it is given up.
        printed: with the printed Jacobian instead of the right one.

    Raises:
        KinematicsError: not a pose, or not a configuration.
    """
    wanted, q = checked_pose(pose), checked_joints(start).copy()
    count = 0
    while True:
        reached = forward_many(q[None])[0]
        turn = wanted[:3, :3] @ reached[:3, :3].T
        angle = math.acos(min(1.0, max(-1.0, 0.5 * (float(np.trace(turn)) - 1.0))))
        scale = 0.5 if angle < 1e-9 else 0.5 * angle / max(math.sin(angle), 1e-9)
        error = np.empty(6)
        error[:3] = wanted[:3, 3] - reached[:3, 3]
        error[3:] = (
            scale * (turn[2, 1] - turn[1, 2]),
            scale * (turn[0, 2] - turn[2, 0]),
            scale * (turn[1, 0] - turn[0, 1]),
        )
        converged = float(np.linalg.norm(error)) < TOLERANCE
        if converged or count >= most_iterations:
            break
        count += 1
        q += ALPHA * (printed_jacobian(q) if printed else jacobian(q)).T @ error
    joints: Joints = tuple(float(v) for v in q)  # type: ignore[assignment]
    return IterativeAnswer(joints, converged, count, float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])))
