"""Poses and rotations: identities that must hold for every angle."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from yarm.geometry import (
    Pose2,
    quaternion_from_rpy,
    rotation_of_quaternion,
    rpy_of_quaternion,
    transform_matrix,
    transform_points,
    wrap_angle,
    yaw_of_quaternion,
)

angle = st.floats(-10, 10)
length = st.floats(-5, 5)


@given(angle)
def test_wrapped_angle_points_the_same_way(a):
    w = wrap_angle(a)
    assert -math.pi < w <= math.pi
    assert math.cos(w) == pytest.approx(math.cos(a), abs=1e-9)
    assert math.sin(w) == pytest.approx(math.sin(a), abs=1e-9)


@given(angle, angle, angle)
def test_quaternion_follows_scipy(roll, pitch, yaw):
    expected = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
    assert np.allclose(rotation_of_quaternion(quaternion_from_rpy(roll, pitch, yaw)), expected, atol=1e-9)


@given(st.floats(-math.pi + 1e-6, math.pi))
def test_yaw_round_trip(yaw):
    assert yaw_of_quaternion(quaternion_from_rpy(0, 0, yaw)) == pytest.approx(yaw, abs=1e-9)


@given(length, length, angle, length, length, angle)
def test_compose_with_inverse_is_identity(x, y, a, u, v, b):
    first, second = Pose2(x, y, a), Pose2(u, v, b)
    back = first.inverse().compose(first.compose(second))
    assert (back.x, back.y) == pytest.approx((u, v), abs=1e-9)
    assert math.cos(back.yaw_rad - b) == pytest.approx(1.0, abs=1e-9)


def test_points_of_a_frame_move_as_poses_do():
    pose, points = Pose2(1.0, -2.0, 0.7), np.array([[0.3, 0.4], [-1.0, 2.0]])
    for point, moved in zip(points, pose.moved(points)):
        expected = pose.compose(Pose2(*point))
        assert moved == pytest.approx([expected.x, expected.y])
    assert pose.inverse().moved(pose.moved(points)) == pytest.approx(points)


def test_points_go_through_a_matrix():
    matrix = transform_matrix((1, 2, 3), quaternion_from_rpy(0, 0, math.pi / 2))
    assert transform_points(matrix, [(1, 0, 0)]) == pytest.approx(np.array([[1, 3, 3]]))


@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (math.nan, 0, 0, 1), (1, 2, 3)])
def test_bad_quaternions_are_refused(bad):
    with pytest.raises(ValueError, match="four finite numbers"):
        rotation_of_quaternion(bad)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_roll_pitch_and_yaw_come_back(roll, pitch, yaw):
    assert rpy_of_quaternion(quaternion_from_rpy(roll, pitch, yaw)) == pytest.approx([roll, pitch, yaw], abs=1e-6)


def test_towards_goes_the_shorter_way_round() -> None:
    half = Pose2(0.0, 0.0, 3.0).towards(Pose2(2.0, 4.0, -3.0), 0.5)
    assert (half.x, half.y) == (1.0, 2.0) and abs(half.yaw_rad) == pytest.approx(math.pi)
    assert Pose2(1.0, 2.0, 0.3).towards(Pose2(5.0, 6.0, 0.4), 0.0) == Pose2(1.0, 2.0, 0.3)
