"""Kinematics of the HC10."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from python.control.arm_samples import arm
from yarm.control.arm.model import ArmKinematics, tool_pose

KINEMATICS = ArmKinematics(arm())
LIMITS = arm().limits


def joints(draw_seed: int) -> np.ndarray:
    return np.random.default_rng(draw_seed).uniform(0.95 * LIMITS.lower, 0.95 * LIMITS.upper)


def dh(q: np.ndarray) -> np.ndarray:
    """Tip of the sander by the published DH table: tool0, turned over, and 0.12 m of tool."""
    rows = [
        (q[0], 0.275, 0.0, -90.0),
        (q[1] - math.pi / 2, 0.0, 0.700, 180.0),
        (q[2] + math.pi / 2, 0.0, 0.0, 90.0),
        (q[3], -0.500, 0.0, -90.0),
        (q[4], -0.162, 0.0, 90.0),
        (q[5] + math.pi, -0.130, 0.0, 180.0),
    ]
    pose = np.eye(4)
    for theta, d, a, alpha_deg in rows:
        ct, st_, ca, sa = math.cos(theta), math.sin(theta), np.cos(np.radians(alpha_deg)), np.sin(np.radians(alpha_deg))
        pose = pose @ np.array(
            [
                [ct, -st_ * ca, st_ * sa, a * ct],
                [st_, ct * ca, -ct * sa, a * st_],
                [0.0, sa, ca, d],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    tool = np.eye(4)
    tool[2, 3] = 0.12
    base = np.eye(4)
    base[:3, 3] = arm().base_xyz
    return base @ pose @ tool


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6))
def test_forward_kinematics_agree_with_the_published_dh_table(seed):
    q = joints(seed)
    assert KINEMATICS.tip(q)[:3] == pytest.approx(dh(q)[:3], abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10**6))
def test_jacobian_is_the_tips_velocity(seed):
    q, dq, h = joints(seed), np.random.default_rng(seed + 1).normal(size=6), 1e-6
    moved = (KINEMATICS.tip(q + h * dq)[:3, 3] - KINEMATICS.tip(q - h * dq)[:3, 3]) / (2.0 * h)
    assert (KINEMATICS.jacobian(q) @ dq)[:3] == pytest.approx(moved, abs=1e-5)


@settings(max_examples=50, deadline=None, derandomize=True)
@given(
    st.floats(-0.43, -0.07),
    st.floats(-0.28, 0.28),
    st.floats(0.73, 1.18),
    st.floats(-0.05, 0.05),
    st.floats(-0.05, 0.05),
)
def test_poses_over_the_part_are_solved_within_limits(x, y, z, tilt_x, tilt_y):
    normal = np.array([tilt_x, tilt_y, 1.0])
    pose = tool_pose(np.array([x, y, z]), normal / np.linalg.norm(normal), 0.0)
    q = KINEMATICS.solve(pose, np.array([-0.19, 0.92, 1.51, 0.0, -0.58, 0.19]))
    assert q is not None
    assert LIMITS.contain(q)
    assert KINEMATICS.tip(q) == pytest.approx(pose, abs=1e-4)


def test_out_of_reach_gives_none():
    pose = tool_pose(np.array([1.0, 0.0, 0.8]), np.array([0.0, 0.0, 1.0]), 0.0)
    assert KINEMATICS.solve(pose, np.zeros(6)) is None


def test_a_solution_beyond_a_limit_is_not_given():
    q = np.array([0.0, 0.5, -0.05, 0.0, -0.5, 0.0])
    bent = q + np.array([0.0, 0.0, -0.3, 0.0, 0.0, 0.0])
    found = KINEMATICS.solve(KINEMATICS.tip(bent), q)
    assert found is None or LIMITS.contain(found)


def test_tool_pose_is_a_rotation_against_the_normal():
    normal = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    pose = tool_pose(np.zeros(3), normal, 0.4)
    assert pose[:3, :3] @ pose[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    assert pose[:3, 2] == pytest.approx(-normal)


def test_limits_are_those_of_the_maker():
    assert np.degrees(LIMITS.lower) == pytest.approx([-180, -180, -5, -180, -180, -180])
    assert np.degrees(LIMITS.upper) == pytest.approx([180, 180, 355, 180, 180, 180])
    assert np.degrees(LIMITS.speed) == pytest.approx([130, 130, 180, 180, 250, 250])
