"""The closed form of ``inverse`` for many poses at once: less than a microsecond a pose in batches of thousands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray, IntArray
from yarm.manipulation.kinematics.forward import KinematicsError
from yarm.manipulation.kinematics.inverse import (
    AXIS_LENGTH_M,
    BEND_ERROR_RAD2,
    FREE_TOLERANCE,
    LIMIT_TOLERANCE_RAD,
    MOST_BEND_ERROR_RAD,
    PLANE_TOLERANCE,
    STRAIGHT_TOLERANCE_M,
    solve,
)
from yarm.robots.youbot import (
    FOREARM_M,
    HAND_M,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    WRIST_ASIDE_M,
    within_limits,
)

BRANCHES = 4
"""Two planes, two elbows each."""


@dataclass(frozen=True, eq=False)
class IkBatch:
    """Configurations of n poses; the slots of a pose are in no order that means anything.

    Attributes:
        q: (n, 4, 5), rad; NaN where there is none.
        within: (n, 4), which are there and keep the joints' limits.
    """

    q: FloatArray
    within: BoolArray

    @property
    def solved(self) -> BoolArray:
        """Poses (n,) with a configuration within the limits."""
        return np.asarray(self.within.any(axis=1))


def inverse_many(poses: FloatArray, plane_tolerance: float = PLANE_TOLERANCE) -> IkBatch:
    """Every configuration at which the end effector has each of the poses (n, 4, 4), metres, arm's frame.

    The rotations are taken to be rotations; ``inverse`` checks and explains a single one.

    Raises:
        KinematicsError: of another shape, or not finite.
    """
    if poses.ndim != 3 or poses.shape[1:] != (4, 4) or not np.all(np.isfinite(poses)):
        raise KinematicsError(f"poses must be finite and n x 4 x 4; they are {' x '.join(map(str, poses.shape))}")
    r13, r23, r33 = poses[:, 0, 2], poses[:, 1, 2], poses[:, 2, 2]
    x, y = poses[:, 0, 3] - HAND_M * r13, poses[:, 1, 3] - HAND_M * r23
    wrist, tool = np.hypot(x, y), AXIS_LENGTH_M * np.hypot(r13, r23)
    by_wrist = wrist >= tool
    first = np.arctan2(np.where(by_wrist, y, r23), np.where(by_wrist, x, r13))
    q = np.empty((len(poses), BRANCHES, 5))
    for side in range(2):
        q1 = first if side == 0 else np.where(first > 0.0, first - np.pi, first + np.pi)
        c1, s1 = np.cos(q1), np.sin(q1)
        in_plane = np.maximum(np.abs(c1 * y - s1 * x), np.abs(c1 * r23 - s1 * r13)) <= plane_tolerance
        st = r13 * c1 + r23 * s1
        u = x * c1 + y * s1 - WRIST_ASIDE_M * r33 - SHOULDER_AHEAD_M
        v = poses[:, 2, 3] - HAND_M * r33 + WRIST_ASIDE_M * st - SHOULDER_HEIGHT_M
        q5 = np.arctan2(s1 * poses[:, 0, 0] - c1 * poses[:, 1, 0], c1 * poses[:, 1, 1] - s1 * poses[:, 0, 1])
        bend = _bend(u, v)
        bend[~in_plane] = np.nan
        towards, tilt = np.arctan2(u, v), np.arctan2(st, r33)
        for elbow, q3 in enumerate((bend, -bend)):
            q2 = towards - np.arctan2(FOREARM_M * np.sin(q3), UPPER_ARM_M + FOREARM_M * np.cos(q3))
            slot = q[:, 2 * side + elbow]
            slot[:, 0], slot[:, 1], slot[:, 2], slot[:, 3], slot[:, 4] = q1, q2, q3, tilt - q2 - q3, q5
    q[:, :, 1:4:2] -= 2.0 * np.pi * np.ceil((q[:, :, 1:4:2] - np.pi) / (2.0 * np.pi))
    q[np.isnan(q[:, :, 2])] = np.nan
    _fill_free(q, poses, np.flatnonzero((wrist < FREE_TOLERANCE) & (tool < FREE_TOLERANCE)))
    least_bend = BEND_ERROR_RAD2 / MOST_BEND_ERROR_RAD
    tolerance = LIMIT_TOLERANCE_RAD + BEND_ERROR_RAD2 / np.maximum(np.abs(q[:, :, 2:3]), least_bend)
    return IkBatch(q, within_limits(q, tolerance))


def nearest_branch(batch: IkBatch, q: FloatArray) -> Tuple[FloatArray, BoolArray]:
    """Of each pose the configuration within limits whose joints are nearest to given ones.

    Args:
        batch: of n poses.
        q: (5,) or (n, 5), rad.

    Returns:
        (n, 5), NaN without any, and which (n,) have one.
    """
    far = np.max(np.abs(batch.q - np.asarray(q)[..., None, :]), axis=2)
    far[~batch.within] = np.inf
    chosen = np.argmin(far, axis=1)
    best = np.take_along_axis(batch.q, chosen[:, None, None], axis=1)[:, 0].copy()
    best[~batch.solved] = np.nan
    return best, batch.solved


def _bend(u: FloatArray, v: FloatArray) -> FloatArray:
    """Angle (n,) of joint 3 that brings the wrist point to (u, v) from joint 2; NaN out of reach."""
    square = u * u + v * v
    cosine = (square - UPPER_ARM_M**2 - FOREARM_M**2) / (2.0 * UPPER_ARM_M * FOREARM_M)
    distance = np.sqrt(square)
    over = np.maximum(distance - UPPER_ARM_M - FOREARM_M, UPPER_ARM_M - FOREARM_M - distance)
    bend: FloatArray = np.where(over > STRAIGHT_TOLERANCE_M, np.nan, np.arccos(np.clip(cosine, -1.0, 1.0)))
    return bend


def _fill_free(q: FloatArray, poses: FloatArray, rows: IntArray) -> None:
    """Where the plane is free up to four of the trial configurations, those within the limits first."""
    for row in rows:
        answer = solve(poses[row].tolist())
        found = [*answer.solutions, *answer.beyond][:BRANCHES]
        q[row] = np.nan
        for slot, joints in enumerate(found):
            q[row, slot] = joints
