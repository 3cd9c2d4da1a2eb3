"""Poses that five joints cannot hold: what is kept is kept, and no neighbour is nearer."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.manipulation.kinematics.forward import KinematicsError, forward, forward_many, pose_error
from yarm.manipulation.kinematics.nearest import NearestRule, nearest
from yarm.robots.youbot import random_joints, within_limits

SEED = 31


def turned_poses(n: int) -> FloatArray:
    """Reachable positions with rotations at random (n, 4, 4)."""
    rng = np.random.default_rng(SEED)
    poses = forward_many(random_joints(rng, n))
    for pose in poses:
        pose[:3, :3] = transform_matrix((0.0, 0.0, 0.0), rng.normal(size=4))[:3, :3]
    return poses


@pytest.mark.parametrize("rule", list(NearestRule))
def test_the_position_is_kept_within_the_limits(rule: NearestRule) -> None:
    for pose in turned_poses(25):
        answer = nearest(pose, rule)
        assert within_limits(answer.q)
        assert answer.position_m < 1e-9
        assert np.linalg.norm(forward(answer.q)[:3, 3] - pose[:3, 3]) == pytest.approx(answer.position_m, abs=1e-12)
        assert not answer.exact
        assert "out of the plane" in answer.reason


def test_no_other_configuration_at_the_position_tilts_less() -> None:
    rng = np.random.default_rng(SEED)
    for pose in turned_poses(6):
        answer = nearest(pose, NearestRule.AXIS)
        others = 0
        for tilt in rng.uniform(-math.pi, math.pi, 400):
            heading = math.atan2(pose[1, 3], pose[0, 3]) + rng.integers(2) * math.pi
            other = transform_matrix(pose[:3, 3], quaternion_from_rpy(0.0, tilt, heading))
            found = nearest(other, NearestRule.AXIS)
            if found.tilt_rad < 1e-6:
                others += 1
                between = math.acos(np.clip(other[:3, 2] @ pose[:3, 2], -1.0, 1.0))
                assert between >= answer.tilt_rad - 1e-6
            if others > 20:
                break
        assert others > 5


def test_the_spin_is_kept_as_near_as_can_be() -> None:
    for pose in turned_poses(20):
        answer = nearest(pose, NearestRule.TILT)
        for turn in (-0.01, 0.01):
            q = np.array(answer.q)
            q[4] += turn
            if within_limits(q):
                assert np.linalg.norm(pose_error(forward(q), pose)[3:]) >= answer.rotation_rad - 1e-9


def test_a_pose_that_can_be_held_is_held() -> None:
    q = np.array([0.4, 0.3, 0.8, 0.4, -0.5])
    for rule in (NearestRule.TILT, NearestRule.AXIS):
        answer = nearest(forward(q), rule, near=q)
        assert answer.exact
        assert answer.reason == ""
        assert answer.q == pytest.approx(q, abs=1e-9)
    moved = nearest(forward(q), NearestRule.POSITION, near=q)
    assert moved.position_m < 1e-9


def test_the_position_alone_moves_the_joints_little() -> None:
    q = np.array([0.4, 0.3, 0.8, 0.4, -0.5])
    pose = forward(q + 0.01)
    alone, whole = (nearest(pose, rule, near=q) for rule in (NearestRule.POSITION, NearestRule.TILT))
    assert np.max(np.abs(np.array(alone.q) - q)) <= np.max(np.abs(np.array(whole.q) - q)) + 1e-9


def test_a_position_on_axis_one_is_served() -> None:
    pose = transform_matrix((0.0, 0.0, 0.55), quaternion_from_rpy(0.3, 0.4, 0.0))
    answer = nearest(pose, NearestRule.TILT)
    assert answer.position_m < 1e-9


def test_out_of_reach_ends_at_the_nearest_point_with_what_is_left() -> None:
    """Straight out at the shoulder's height the stretched arm ends 0.508 m from axis 1, less its 2 mm."""
    pose = transform_matrix((1.0, 0.0, 0.145), quaternion_from_rpy(0.0, math.pi / 2, 0.0))
    answer = nearest(pose, NearestRule.POSITION)
    reach = 0.033 + math.hypot(0.155 + 0.135 + 0.185, 0.002)
    assert answer.position_m == pytest.approx(1.0 - reach, abs=1e-4)
    assert "out of reach: 0.49" in answer.reason
    assert within_limits(answer.q)


def test_what_is_no_pose_is_refused() -> None:
    with pytest.raises(KinematicsError):
        nearest(np.full((4, 4), np.nan), NearestRule.TILT)
    with pytest.raises(KinematicsError):
        nearest(np.eye(4), NearestRule.TILT, near=(0.0,) * 4)
