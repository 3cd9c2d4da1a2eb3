"""Forward kinematics and Jacobian against the URDF, KDL and differences."""

from __future__ import annotations

import math

import numpy as np
import PyKDL
import pytest

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import (
    KinematicsError,
    checked_pose,
    forward,
    forward_many,
    jacobian,
    pose_error,
)
from yarm.robots.youbot import random_joints

SEED = 8


def kdl_poses(q: FloatArray) -> FloatArray:
    """The same poses (n, 4, 4) by KDL, from the Denavit-Hartenberg table of the arm."""
    table = (
        (-0.033, math.pi / 2, 0.145, math.pi),
        (0.155, 0.0, 0.0, math.pi / 2),
        (0.135, 0.0, 0.0, 0.0),
        (0.002, math.pi / 2, 0.0, -math.pi / 2),
        (0.0, math.pi, -0.185, math.pi),
    )
    chain = PyKDL.Chain()
    for a, alpha, d, theta in table:
        chain.addSegment(PyKDL.Segment(PyKDL.Joint(PyKDL.Joint.RotZ), PyKDL.Frame.DH(a, alpha, d, theta)))
    solver = PyKDL.ChainFkSolverPos_recursive(chain)
    poses = np.zeros((len(q), 4, 4))
    for pose, joints in zip(poses, q):
        angles, frame = PyKDL.JntArray(5), PyKDL.Frame()
        for index, angle in enumerate(joints):
            angles[index] = float(angle)
        assert solver.JntToCart(angles, frame) >= 0
        pose[:] = [[frame[row, column] for column in range(4)] for row in range(3)] + [[0.0, 0.0, 0.0, 1.0]]
    return poses


def test_it_is_the_published_table() -> None:
    q = random_joints(np.random.default_rng(SEED), 300)
    assert np.max(np.abs(forward_many(q) - kdl_poses(q))) < 1e-12


def test_the_candle_stands_upright() -> None:
    pose = forward((0.0,) * 5)
    assert pose[:3, 3] == pytest.approx([0.031, 0.0, 0.620], abs=1e-12)
    assert np.allclose(pose[:3, :3], np.eye(3))


def test_the_jacobian_is_what_a_small_step_does() -> None:
    step = 1e-6
    for q in random_joints(np.random.default_rng(SEED), 30):
        numeric = [pose_error(forward(q - step * axis), forward(q + step * axis)) / (2.0 * step) for axis in np.eye(5)]
        assert np.max(np.abs(jacobian(q) - np.array(numeric).T)) < 1e-8


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 1.0, 3.0, math.pi - 1e-9, math.pi])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0.6, 0, -0.8), (-0.48, 0.6, 0.64)])
def test_a_turn_is_found_whatever_its_angle(angle: float, axis: tuple) -> None:
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    pose = np.eye(4)
    pose[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    found = pose_error(np.eye(4), pose)[3:]
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-7)
    assert abs(found @ np.array(axis)) == pytest.approx(angle, abs=1e-7)


@pytest.mark.parametrize("joints", [(0.0,) * 4, (0.0, 0.0, math.nan, 0.0, 0.0), (math.inf,) * 5])
def test_what_is_no_configuration_is_refused(joints: tuple) -> None:
    for function in (forward, jacobian):
        with pytest.raises(KinematicsError, match="must be 5 finite angles"):
            function(joints)


def test_what_is_no_pose_is_refused_with_the_number() -> None:
    scaled, mirrored, unknown = np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0]), np.full((4, 4), math.nan)
    scaled[:3, :3] *= 1.01
    with pytest.raises(KinematicsError, match=r"off by 0\.0201"):
        checked_pose(scaled)
    with pytest.raises(KinematicsError, match="right-handed"):
        checked_pose(mirrored)
    for wrong in (unknown, np.eye(3)):
        with pytest.raises(KinematicsError, match="4 x 4 finite"):
            checked_pose(wrong)
