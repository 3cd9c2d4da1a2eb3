"""The closed form: every reachable pose, every branch, the singular ones, one at a time and in batches."""

from __future__ import annotations

import math
import re
from typing import List

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import KinematicsError, forward, forward_many
from yarm.manipulation.kinematics.inverse import IkStatus, inverse, within
from yarm.manipulation.kinematics.inverse_many import inverse_many, nearest_branch
from yarm.manipulation.kinematics.iterative import damped_least_squares
from yarm.robots.youbot import LOWER_RAD, UPPER_RAD, random_joints, within_limits

SEED = 88
LIMITED = st.tuples(*(st.floats(low, high) for low, high in zip(LOWER_RAD, UPPER_RAD)))


def drawn(n: int) -> FloatArray:
    """Configurations (n, 5) by the suite's seed."""
    return random_joints(np.random.default_rng(SEED), n)


def test_every_reachable_pose_is_solved_and_the_configuration_is_among_the_answers() -> None:
    q = drawn(10_000)
    for joints, pose in zip(q, forward_many(q)):
        answer = inverse(pose)
        assert answer.status is IkStatus.SOLVED
        assert answer.reason == ""
        assert min(np.max(np.abs(np.array(found) - joints)) for found in answer.solutions) < 1e-9
        reached = forward_many(np.array([*answer.solutions, *answer.beyond]))
        assert np.max(np.abs(reached - pose)) < 1e-12


@settings(deadline=None, max_examples=200)
@given(LIMITED)
@example((1.27587890625, LOWER_RAD[1], -1.1920928956465925e-07, 0.0, 0.0))
def test_any_configuration_is_found_again(joints: tuple) -> None:
    pose = forward(joints)
    answer = inverse(pose)
    assert answer.status is IkStatus.SOLVED
    assert inverse_many(pose[None]).solved[0]
    bent = [max(abs(found[2]), 1e-7) for found in answer.solutions]
    assert all(within(found, 1e-9 + 1e-14 / bend) for found, bend in zip(answer.solutions, bent))
    assert np.max(np.abs(forward_many(np.array(answer.solutions)) - pose)) < 1e-9


def test_the_branches_are_all_there_are() -> None:
    """A dense search from many starts finds no configuration that the closed form does not name."""
    rng = np.random.default_rng(SEED)
    for joints in random_joints(rng, 12):
        pose = forward(joints)
        named = np.array([*inverse(pose).solutions, *inverse(pose).beyond])
        for start in random_joints(rng, 25):
            found = damped_least_squares(pose, start)
            if found.position_m < 1e-9 and found.rotation_rad < 1e-9:
                away = np.remainder(named - np.array(found.q) + math.pi, 2.0 * math.pi) - math.pi
                assert np.min(np.max(np.abs(away), axis=1)) < 1e-4


def singular() -> List[FloatArray]:
    """Configurations (n, 5) within the limits: tool straight up, straight down, elbow straight, wrist on axis 1."""
    q = drawn(400)
    up, down, straight = q.copy(), q.copy(), q.copy()
    up[:, 3] = -up[:, 1] - up[:, 2]
    down[:, 3] = np.where(down[:, 1] + down[:, 2] > 0.0, math.pi, -math.pi) - down[:, 1] - down[:, 2]
    straight[:, 2] = 0.0
    over = q.copy()
    # The wrist point's distance from axis 1 is nought: solved for joint 2 after joint 3 and the tool's tilt are drawn.
    tilt = q[:, 3]
    ahead, across = 0.155 + 0.135 * np.cos(q[:, 2]), 0.135 * np.sin(q[:, 2])
    sine = (0.002 * np.cos(tilt) - 0.033) / np.hypot(ahead, across)
    over[:, 1] = np.arcsin(np.clip(sine, -1.0, 1.0)) - np.arctan2(across, ahead)
    over[:, 3] = tilt - over[:, 1] - over[:, 2]
    sets = [up, down, straight, over]
    return [part[within_limits(part)] for part in sets]


@pytest.mark.parametrize("kind", range(4), ids=["up", "down", "straight", "over axis 1"])
def test_singular_poses_are_solved(kind: int) -> None:
    part = singular()[kind]
    assert len(part) > 20
    for pose in forward_many(part):
        answer = inverse(pose)
        assert answer.status is IkStatus.SOLVED
        assert np.max(np.abs(forward_many(np.array(answer.solutions)) - pose)) < 1e-9


def test_a_wrist_on_axis_one_under_an_upright_tool_leaves_joint_one_free() -> None:
    for spin in np.linspace(-3.0, 3.0, 13):
        pose = np.eye(4)
        pose[:2, :2] = [[math.cos(spin), -math.sin(spin)], [math.sin(spin), math.cos(spin)]]
        pose[2, 3] = 0.52
        answer = inverse(pose)
        assert answer.free
        assert answer.status is IkStatus.SOLVED
        assert np.max(np.abs(forward_many(np.array(answer.solutions)) - pose)) < 1e-9
        batch = inverse_many(np.array([pose]))
        assert batch.solved[0]
        assert np.max(np.abs(forward_many(batch.q[0][batch.within[0]]) - pose)) < 1e-9


def test_a_batch_gives_what_one_at_a_time_gives() -> None:
    q = drawn(500)
    poses = forward_many(q)
    poses[::7, 2, 3] += 1.0
    poses[::11, :3, :3] = poses[::11, :3, :3][:, :, [1, 2, 0]]
    batch = inverse_many(poses)
    for pose, row, inside in zip(poses, batch.q, batch.within):
        answer = inverse(pose)
        for found, wanted in ((row[inside], answer.solutions), (row[~inside], answer.beyond)):
            there = found[~np.isnan(found[:, 0])]
            assert len(there) == len(wanted)
            if len(wanted):
                assert np.max(np.abs(np.sort(there, axis=0) - np.sort(np.array(wanted), axis=0))) < 1e-9


def test_the_nearest_branch_is_the_configuration_itself() -> None:
    q = drawn(200)
    poses = forward_many(q)
    poses[0, 2, 3] += 2.0
    best, there = nearest_branch(inverse_many(poses), q)
    assert not there[0]
    assert np.all(np.isnan(best[0]))
    assert np.max(np.abs(best[1:] - q[1:])) < 1e-9


def test_a_pose_out_of_reach_says_by_how_much() -> None:
    pose = forward((0.0,) * 5)
    pose[2, 3] += 0.1
    answer = inverse(pose)
    assert answer.status is IkStatus.OUT_OF_REACH
    assert answer.reach_error_m == pytest.approx(0.1, abs=1e-3)
    assert "m beyond what joints 2 and 3 reach (0.020 to 0.290 m)" in answer.reason


def test_a_pose_out_of_the_plane_says_by_how_much_and_noise_is_forgiven() -> None:
    pose = forward((0.3, 0.4, -0.7, 0.2, 0.1))
    aside = pose.copy()
    aside[:2, 3] += 0.01 * np.array([-math.sin(0.3), math.cos(0.3)])
    answer = inverse(aside)
    assert answer.status is IkStatus.OUT_OF_PLANE
    assert answer.plane_error > 1e-3
    assert "out of the plane" in answer.reason
    noisy = pose.copy()
    noisy[:3, 3] += 1e-7
    assert inverse(noisy).status is IkStatus.SOLVED
    strict = inverse(noisy, plane_tolerance=1e-9)
    assert strict.status is IkStatus.OUT_OF_PLANE
    assert "out of the plane of axis 1, 1e-09 is allowed" in strict.reason


def test_beyond_the_limits_is_told_from_out_of_reach() -> None:
    beyond = (math.radians(175.0), 1.2, 0.3, 0.4, 0.0)
    answer = inverse(forward(beyond))
    assert answer.status in (IkStatus.BEYOND_LIMITS, IkStatus.SOLVED)
    assert min(np.max(np.abs(np.array(q) - beyond)) for q in answer.beyond) < 1e-9
    folded = inverse(forward((0.0, math.radians(100.0), math.radians(150.0), 0.0, 0.0)))
    assert folded.status is IkStatus.BEYOND_LIMITS
    assert "leave the joints' limits" in folded.reason
    assert re.search(r"has joint \d at -?\d+\.\d deg, \d+\.\d beyond -?\d+\.\d to \d+\.\d deg", folded.reason)


def test_what_is_no_pose_is_refused() -> None:
    skew, unknown = np.eye(4), np.eye(4)
    skew[0, 0] = 1.001
    unknown[0, 3] = math.nan
    for wrong in (skew, unknown, np.eye(3), -np.eye(4)):
        with pytest.raises(KinematicsError):
            inverse(wrong)
    with pytest.raises(KinematicsError, match="n x 4 x 4"):
        inverse_many(np.eye(4))
