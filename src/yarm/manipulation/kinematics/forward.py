"""Where the youBot's hand is, and how it moves: forward kinematics and Jacobian, in closed form.

Poses are (4, 4), metres, of the end effector in the arm's frame (``yarm.robots.youbot``); the tool's axis is its z.
Joints are mechanical angles, rad. With t = q2 + q3 + q4 the rotation is Rz(q1) Ry(t) Rz(-q5), and all of joints 2 to
4 moves in the upright plane that axis 1 turns.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray
from yarm.robots.youbot import (
    FOREARM_M,
    HAND_M,
    N_JOINTS,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    WRIST_ASIDE_M,
)

UNIT_TOLERANCE = 1e-6
"""How far the rotation of a pose may be from orthonormal."""


class KinematicsError(ValueError):
    """Numbers that are no configuration or no pose; the message says which, the value and what is needed."""


def forward(q: npt.ArrayLike) -> FloatArray:
    """Pose (4, 4) of the end effector at joints (5,), rad.

    Raises:
        KinematicsError: not five finite numbers.
    """
    return np.asarray(forward_many(np.array([checked_joints(q)]))[0])


def forward_many(q: FloatArray) -> FloatArray:
    """Poses (n, 4, 4) at joints (n, 5), rad."""
    q1, q2, q3, q4, q5 = q.T
    q23 = q2 + q3
    t = q23 + q4
    c1, s1, ct, st, c5, s5 = np.cos(q1), np.sin(q1), np.cos(t), np.sin(t), np.cos(q5), np.sin(q5)
    out, up = _planar(q2, q23, t)
    poses = np.zeros((len(q), 4, 4))
    poses[:, 0, 0], poses[:, 1, 0], poses[:, 2, 0] = c1 * ct * c5 + s1 * s5, s1 * ct * c5 - c1 * s5, -st * c5
    poses[:, 0, 1], poses[:, 1, 1], poses[:, 2, 1] = c1 * ct * s5 - s1 * c5, s1 * ct * s5 + c1 * c5, -st * s5
    poses[:, 0, 2], poses[:, 1, 2], poses[:, 2, 2] = c1 * st, s1 * st, ct
    poses[:, 0, 3], poses[:, 1, 3], poses[:, 2, 3] = c1 * out, s1 * out, up
    poses[:, 3, 3] = 1.0
    return poses


def jacobian(q: npt.ArrayLike) -> FloatArray:
    """Jacobian (6, 5) of the end effector: joint speeds, rad/s, to velocity (m/s) and angular velocity (rad/s).

    Both are in the arm's frame, the velocity is the end effector's own.

    Raises:
        KinematicsError: not five finite numbers.
    """
    q1, q2, q3, q4, _ = checked_joints(q)
    q23, t = q2 + q3, q2 + q3 + q4
    c1, s1 = math.cos(q1), math.sin(q1)
    out, up = (float(v) for v in _planar(q2, q23, t))
    elbow_out = SHOULDER_AHEAD_M + UPPER_ARM_M * math.sin(q2)
    elbow_up = SHOULDER_HEIGHT_M + UPPER_ARM_M * math.cos(q2)
    wrist_out = elbow_out + FOREARM_M * math.sin(q23)
    wrist_up = elbow_up + FOREARM_M * math.cos(q23)
    matrix = np.zeros((6, N_JOINTS))
    matrix[:3, 0] = -s1 * out, c1 * out, 0.0
    matrix[5, 0] = 1.0
    joints = ((SHOULDER_AHEAD_M, SHOULDER_HEIGHT_M), (elbow_out, elbow_up), (wrist_out, wrist_up))
    for column, (joint_out, joint_up) in enumerate(joints, start=1):
        matrix[:3, column] = c1 * (up - joint_up), s1 * (up - joint_up), -(out - joint_out)
        matrix[3:, column] = -s1, c1, 0.0
    matrix[3:, 4] = -c1 * math.sin(t), -s1 * math.sin(t), -math.cos(t)
    return matrix


def pose_error(reached: FloatArray, wanted: FloatArray) -> FloatArray:
    """What leads from one pose (4, 4) to another: (6,) metres and rotation vector, rad, in the arm's frame."""
    turn = wanted[:3, :3] @ reached[:3, :3].T
    twice_sine = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    length = float(np.linalg.norm(twice_sine))
    angle = math.atan2(length, float(np.trace(turn)) - 1.0)
    if length > 1e-9:
        vector = twice_sine * (angle / length)
    elif angle < 1.0:
        vector = 0.5 * twice_sine
    else:
        # A half turn has no sine: its axis is the column of turn + 1 that is longest.
        columns = turn + np.eye(3)
        axis = columns[:, int(np.argmax(np.linalg.norm(columns, axis=0)))]
        vector = angle * axis / float(np.linalg.norm(axis))
    return np.concatenate([wanted[:3, 3] - reached[:3, 3], vector])


def checked_joints(q: npt.ArrayLike) -> FloatArray:
    """Joints (5,) as an array.

    Raises:
        KinematicsError: not five finite numbers.
    """
    values = np.asarray(q, dtype=float)
    if values.shape != (N_JOINTS,) or not np.all(np.isfinite(values)):
        raise KinematicsError(f"joints {q!r} must be {N_JOINTS} finite angles, rad")
    return values


def checked_pose(pose: npt.ArrayLike) -> FloatArray:
    """A pose (4, 4) as an array.

    Raises:
        KinematicsError: of another shape, not finite, or its rotation not orthonormal and right-handed.
    """
    matrix = np.asarray(pose, dtype=float)
    if matrix.shape != (4, 4) or not np.all(np.isfinite(matrix)):
        raise KinematicsError(f"a pose must be 4 x 4 finite numbers, not {pose!r}")
    rotation = matrix[:3, :3]
    off = float(np.max(np.abs(rotation @ rotation.T - np.eye(3))))
    if off > UNIT_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise KinematicsError(
            f"the rotation of a pose must be orthonormal and right-handed within {UNIT_TOLERANCE:g}; "
            f"it is off by {off:.3g}: normalise it first"
        )
    return matrix


def _planar(q2: npt.ArrayLike, q23: npt.ArrayLike, t: npt.ArrayLike) -> FloatArray:
    """Distance from axis 1 and height of the end effector, metres, (2, ...)."""
    st, ct = np.sin(t), np.cos(t)
    out = HAND_M * st + WRIST_ASIDE_M * ct + FOREARM_M * np.sin(q23) + UPPER_ARM_M * np.sin(q2) + SHOULDER_AHEAD_M
    up = HAND_M * ct - WRIST_ASIDE_M * st + FOREARM_M * np.cos(q23) + UPPER_ARM_M * np.cos(q2) + SHOULDER_HEIGHT_M
    return np.array([out, up])
