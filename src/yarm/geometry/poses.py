"""Poses and rotations: ``T_a_b`` takes points of frame b to frame a; quaternions are (x, y, z, w).

See docs/conventions.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import FloatArray


@dataclass(frozen=True)
class Pose2:
    """A pose in the plane: x, y in metres, yaw in radians counter-clockwise from x."""

    x: float
    y: float
    yaw_rad: float = 0.0

    def compose(self, other: Pose2) -> Pose2:
        """Pose of frame c in a, from this pose of b in a and the other, of c in b."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            wrap_angle(self.yaw_rad + other.yaw_rad),
        )

    def inverse(self) -> Pose2:
        """Pose of frame a in b, from this pose of b in a."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.yaw_rad))

    def moved(self, points: FloatArray) -> FloatArray:
        """(n, 2) points of frame b in frame a, metres; this is the pose of b in a."""
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y = self.x + c * points[:, 0] - s * points[:, 1], self.y + s * points[:, 0] + c * points[:, 1]
        return pairs(x, y)

    def distance(self, other: Pose2) -> float:
        """Distance between the two origins, metres."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def towards(self, other: Pose2, share: float) -> Pose2:
        """The pose at a share of the way to another, 0 to 1; it turns the shorter way round."""
        turn = wrap_angle(other.yaw_rad - self.yaw_rad)
        return Pose2(
            self.x + share * (other.x - self.x),
            self.y + share * (other.y - self.y),
            wrap_angle(self.yaw_rad + share * turn),
        )


def pairs(x: FloatArray, y: FloatArray) -> FloatArray:
    """(n, 2) from two (n,): np.stack for two columns, at a third of its price."""
    both: FloatArray = np.empty((len(x), 2))
    both[:, 0], both[:, 1] = x, y
    return both


def wrap_angle(angle_rad: float) -> float:
    """The same direction in (-pi, pi]."""
    wrapped = math.remainder(angle_rad, 2.0 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def quaternion_from_rpy(roll_rad: float, pitch_rad: float, yaw_rad: float) -> FloatArray:
    """Quaternion (4,) x, y, z, w of fixed-axis roll, pitch, yaw (URDF order: R = Rz(yaw) Ry(pitch) Rx(roll))."""
    cr, sr = math.cos(roll_rad / 2), math.sin(roll_rad / 2)
    cp, sp = math.cos(pitch_rad / 2), math.sin(pitch_rad / 2)
    cy, sy = math.cos(yaw_rad / 2), math.sin(yaw_rad / 2)
    return np.array(
        [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ]
    )


def yaw_of_quaternion(quaternion: npt.ArrayLike) -> float:
    """Yaw about world z, rad, of a quaternion (4,) x, y, z, w."""
    x, y, z, w = (float(v) for v in np.asarray(quaternion, dtype=float))
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def rpy_of_quaternion(quaternion: npt.ArrayLike) -> FloatArray:
    """Fixed-axis roll, pitch, yaw (3,), rad, of a unit quaternion (4,) x, y, z, w; the inverse of quaternion_from_rpy.

    Pitch is in [-pi/2, pi/2]; at its ends roll and yaw are not unique, and any that fit are given.
    """
    x, y, z, w = (float(v) for v in np.asarray(quaternion, dtype=float))
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(min(1.0, max(-1.0, 2.0 * (w * y - z * x))))
    return np.array([roll, pitch, yaw_of_quaternion((x, y, z, w))])


def rotation_of_quaternion(quaternion: npt.ArrayLike) -> FloatArray:
    """Rotation matrix (3, 3) of a quaternion (4,) x, y, z, w of any length but zero.

    Raises:
        ValueError: not finite, or of length zero.
    """
    q = np.asarray(quaternion, dtype=float)
    norm = float(np.linalg.norm(q))
    if q.shape != (4,) or not math.isfinite(norm) or norm < 1e-9:
        raise ValueError(f"quaternion {quaternion!r} must be four finite numbers, not all 0")
    x, y, z, w = q / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def transform_matrix(translation: npt.ArrayLike, quaternion: npt.ArrayLike) -> FloatArray:
    """Homogeneous matrix (4, 4) from a translation (3,), metres, and a quaternion (4,) x, y, z, w."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_of_quaternion(quaternion)
    matrix[:3, 3] = np.asarray(translation, dtype=float)
    return matrix


def transform_points(matrix: FloatArray, points: npt.ArrayLike) -> FloatArray:
    """Points (..., 3), metres, taken through a homogeneous matrix (4, 4)."""
    result: FloatArray = np.asarray(points, dtype=float) @ matrix[:3, :3].T + matrix[:3, 3]
    return result


def quaternions_of(rotations: FloatArray) -> FloatArray:
    """Quaternions (n, 4) x, y, z, w of rotation matrices (n, 3, 3)."""
    m = rotations
    trace = m[:, 0, 0] + m[:, 1, 1] + m[:, 2, 2]
    # Each row of the symmetric 4 x 4 matrix is 4 q_i q; the one with the largest diagonal is the safest to take.
    k = np.empty((len(m), 4, 4))
    k[:, 0, 0] = 1 + 2 * m[:, 0, 0] - trace
    k[:, 1, 1] = 1 + 2 * m[:, 1, 1] - trace
    k[:, 2, 2] = 1 + 2 * m[:, 2, 2] - trace
    k[:, 3, 3] = 1 + trace
    k[:, 0, 1] = k[:, 1, 0] = m[:, 0, 1] + m[:, 1, 0]
    k[:, 0, 2] = k[:, 2, 0] = m[:, 0, 2] + m[:, 2, 0]
    k[:, 1, 2] = k[:, 2, 1] = m[:, 1, 2] + m[:, 2, 1]
    k[:, 0, 3] = k[:, 3, 0] = m[:, 2, 1] - m[:, 1, 2]
    k[:, 1, 3] = k[:, 3, 1] = m[:, 0, 2] - m[:, 2, 0]
    k[:, 2, 3] = k[:, 3, 2] = m[:, 1, 0] - m[:, 0, 1]
    best = np.argmax(np.diagonal(k, axis1=1, axis2=2), axis=1)
    rows = k[np.arange(len(m)), best]
    quaternions: FloatArray = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return quaternions
