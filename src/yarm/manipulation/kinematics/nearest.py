"""The reachable pose nearest to one that five joints cannot hold, under a named rule, with what is left over."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import List, Optional, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import checked_joints, checked_pose, forward, pose_error
from yarm.manipulation.kinematics.inverse import IkStatus, inverse
from yarm.manipulation.kinematics.inverse_many import inverse_many, nearest_branch
from yarm.manipulation.kinematics.iterative import damped_least_squares
from yarm.robots.youbot import LOWER_RAD, UPPER_RAD, Joints

TILTS = 720
"""Directions of the tool that are tried in a plane: one every half degree, the best then refined."""
REFINEMENTS = 30
STARTS = 12
ON_AXIS_M = 1e-9


class NearestRule(Enum):
    """What is kept of a pose that cannot be held whole.

    ``TILT``: the position; the tool's axis tilts as little as can be, and the spin about it is as near as can be.
    ``AXIS``: position and axis in the same way; joint 5 stays where it is.
    ``POSITION``: the position alone; the joints move as little as can be.
    """

    TILT = "tilt"
    AXIS = "axis"
    POSITION = "position"


@dataclass(frozen=True)
class NearestAnswer:
    """The nearest reachable pose.

    Attributes:
        q: joints, rad, within the limits.
        exact: the pose itself is reached.
        position_m: distance left over; above 1e-6 only when the position itself is out of reach.
        tilt_rad: angle between the tool's axes.
        rotation_rad: angle between the rotations.
        reason: why the pose itself is not reached; empty when it is.
    """

    q: Joints
    exact: bool
    position_m: float
    tilt_rad: float
    rotation_rad: float
    reason: str


def nearest(pose: npt.ArrayLike, rule: NearestRule, near: npt.ArrayLike = (0.0,) * 5) -> NearestAnswer:
    """The configuration whose pose is nearest to a wanted one.

    Args:
        pose: (4, 4), metres, arm's frame.
        rule: what is kept.
        near: (5,), rad: of equally good ones the one whose joints are nearest to these is taken.

    Raises:
        KinematicsError: not a pose, or not a configuration.
    """
    wanted, here = checked_pose(pose), checked_joints(near)
    whole = inverse(wanted)
    if whole.status is IkStatus.SOLVED and rule is not NearestRule.POSITION:
        q = min(whole.solutions, key=lambda found: float(np.max(np.abs(np.array(found) - here))))
        return _answer(np.array(q), wanted, "")
    found = _position_kept(wanted, rule, here)
    if found is None:
        return _position_lost(wanted, here)
    return _answer(found, wanted, whole.reason)


def _position_kept(wanted: FloatArray, rule: NearestRule, here: FloatArray) -> Optional[FloatArray]:
    """Joints (5,) at the wanted position, or None where no direction of the tool reaches it."""
    best: Optional[FloatArray] = None
    least = math.inf
    for heading in _headings(wanted):
        tilts = np.arange(TILTS) * (2.0 * math.pi / TILTS)
        step = 2.0 * math.pi / TILTS
        for _ in range(REFINEMENTS):
            q, cost = _tried(wanted, heading, tilts, rule, here)
            index = int(np.argmin(cost))
            if cost[index] < least:
                best, least = q[index], float(cost[index])
            if not math.isfinite(cost[index]) or step < 1e-9:
                break
            tilts, step = tilts[index] + np.linspace(-step, step, 9), step / 4.0
    return best


def _headings(wanted: FloatArray) -> List[float]:
    """Angles of joint 1 whose plane holds the position; on axis 1, where every plane does, the tool's own."""
    x, y = float(wanted[0, 3]), float(wanted[1, 3])
    if math.hypot(x, y) < ON_AXIS_M:
        x, y = float(wanted[0, 2]), float(wanted[1, 2])
    first = math.atan2(y, x)
    return [first, first - math.copysign(math.pi, first)]


def _tried(
    wanted: FloatArray, heading: float, tilts: FloatArray, rule: NearestRule, here: FloatArray
) -> Tuple[FloatArray, FloatArray]:
    """Joints (n, 5) for each tilt of the tool in a plane, and what each costs (n,); inf where there are none."""
    ct, st, c1, s1 = np.cos(tilts), np.sin(tilts), math.cos(heading), math.sin(heading)
    poses = np.zeros((len(tilts), 4, 4))
    poses[:, :3, 0] = np.stack([c1 * ct, s1 * ct, -st], axis=1)
    poses[:, :3, 1] = (-s1, c1, 0.0)
    poses[:, :3, 2] = np.stack([c1 * st, s1 * st, ct], axis=1)
    poses[:, :3, 3], poses[:, 3, 3] = wanted[:3, 3], 1.0
    batch = inverse_many(poses)
    # The spin is chosen apart: joint 5 turns about the tool's axis and touches nothing else.
    in_plane = batch.q[:, :, 0] - heading
    same = np.abs(np.remainder(in_plane + math.pi, 2.0 * math.pi) - math.pi) < 1e-6
    spin = _spin(wanted, poses) if rule is NearestRule.TILT else np.full(len(tilts), here[4])
    batch.q[:, :, 4] = np.clip(spin, LOWER_RAD[4], UPPER_RAD[4])[:, None]
    inside = (batch.q[:, :, :4] >= np.array(LOWER_RAD[:4])) & (batch.q[:, :, :4] <= np.array(UPPER_RAD[:4]))
    batch.within[:] = inside.all(axis=2) & same
    q, there = nearest_branch(batch, here)
    moved = np.max(np.abs(q - here), axis=1)
    tilt = np.arccos(np.clip(poses[:, :3, 2] @ wanted[:3, 2], -1.0, 1.0))
    cost = moved if rule is NearestRule.POSITION else tilt + 1e-9 * moved
    return q, np.where(there, cost, math.inf)


def _spin(wanted: FloatArray, poses: FloatArray) -> FloatArray:
    """Joint 5 (n,), rad, that brings each rotation (n, 4, 4) without spin nearest to the wanted one."""
    # trace(W^T R Rz(-q5)) is greatest at the angle of the planar part of M = W^T R.
    m = np.einsum("ji,njk->nik", wanted[:3, :3], poses[:, :3, :3])
    spin: FloatArray = np.arctan2(m[:, 0, 1] - m[:, 1, 0], m[:, 0, 0] + m[:, 1, 1])
    return -spin


def _position_lost(wanted: FloatArray, here: FloatArray) -> NearestAnswer:
    """The configuration whose end effector comes nearest to a position that is out of reach."""
    found = damped_least_squares(wanted, here, restarts=STARTS, rotation_weight=0.0)
    return _answer(
        np.array(found.q), wanted, f"the position is out of reach: {found.position_m:.4f} m are left at the nearest"
    )


def _answer(q: FloatArray, wanted: FloatArray, reason: str) -> NearestAnswer:
    reached = forward(q)
    error = pose_error(reached, wanted)
    tilt = math.atan2(
        float(np.linalg.norm(np.cross(reached[:3, 2], wanted[:3, 2]))), float(reached[:3, 2] @ wanted[:3, 2])
    )
    joints: Joints = tuple(float(v) for v in q)  # type: ignore[assignment]
    position, rotation = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
    exact = position < 1e-6 and rotation < 1e-6
    return NearestAnswer(joints, exact, position, tilt, rotation, "" if exact else reason)
