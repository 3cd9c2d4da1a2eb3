"""Descent to a pose, singular configurations, and the coursework's own formulas with their faults."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.manipulation.kinematics.coursework import (
    Mended,
    printed_forward_many,
    printed_inverse,
    printed_jacobian,
    transposed_jacobian,
)
from yarm.manipulation.kinematics.forward import forward, forward_many, jacobian
from yarm.manipulation.kinematics.iterative import damped_least_squares
from yarm.manipulation.kinematics.singularity import MARGIN, SingularityKind, singularity
from yarm.robots.youbot import random_joints, within_limits

SEED = 17


def test_descent_with_restarts_finds_every_pose_within_the_limits() -> None:
    rng = np.random.default_rng(SEED)
    for q in random_joints(rng, 40):
        answer = damped_least_squares(forward(q), np.zeros(5), restarts=20, seed=SEED)
        assert answer.converged
        assert within_limits(answer.q)
        assert np.max(np.abs(forward(answer.q) - forward(q))) < 1e-5


def test_descent_that_does_not_arrive_says_what_is_left() -> None:
    pose = forward((0.0,) * 5)
    pose[2, 3] += 0.2
    answer = damped_least_squares(pose, np.full(5, 0.1), restarts=3)
    assert not answer.converged
    assert answer.position_m > 0.1
    assert within_limits(answer.q)


def test_the_two_singularities_are_told_apart() -> None:
    straight = singularity((0.3, 0.5, 0.0, 0.7, 0.1))
    assert straight.kind is SingularityKind.ELBOW
    assert straight.sigma_min < 1e-12
    # Wrist point on axis 1, tool upright: q3 = -1.6 leaves q2 to be solved.
    ahead, across = 0.155 + 0.135 * math.cos(1.6), 0.135 * math.sin(1.6)
    q2 = math.asin((0.002 - 0.033) / math.hypot(ahead, across)) - math.atan2(across, ahead)
    over = singularity((0.3, q2, 1.6, -q2 - 1.6, 0.1))
    assert over.kind is SingularityKind.WRIST_OVER_AXIS
    assert over.sigma_min < 1e-9
    assert over.wrist < 1e-9


def test_the_margin_decides_and_the_determinant_never_does() -> None:
    q = random_joints(np.random.default_rng(SEED), 300)
    found = [singularity(joints) for joints in q]
    for joints, report in zip(q, found):
        assert (report.kind is SingularityKind.NONE) == (report.sigma_min >= MARGIN)
        assert np.linalg.det(jacobian(joints).T @ jacobian(joints)) != 0.0
    assert 0 < sum(report.kind is not SingularityKind.NONE for report in found) < 100
    assert singularity((0.3, 0.5, math.radians(20.0), 0.7, 0.1)).kind is SingularityKind.NONE


def test_the_printed_forward_kinematics_are_four_millimetres_beside() -> None:
    q = random_joints(np.random.default_rng(SEED), 200)
    off = np.linalg.norm(printed_forward_many(q)[:, :3, 3] - forward_many(q)[:, :3, 3], axis=1)
    assert off == pytest.approx(np.full(200, 0.004), abs=1e-12)


def test_the_printed_inverse_is_never_right_and_mended_only_in_front() -> None:
    q = random_joints(np.random.default_rng(SEED), 1000)
    poses = printed_forward_many(q)
    shares = []
    for mended in (Mended(), Mended(gamma=True), Mended(gamma=True, theta5=True)):
        whole = position = 0
        for pose in poses:
            found = printed_inverse(pose, mended)
            if found is None:
                continue
            reached = printed_forward_many(np.array([found]))[0]
            near = np.max(np.abs(reached[:3, 3] - pose[:3, 3])) < 1e-6
            position += near
            whole += near and np.max(np.abs(reached - pose)) < 1e-6
        shares.append((position / len(poses), whole / len(poses)))
    assert shares[0] == (0.0, 0.0)
    assert 0.5 < shares[1][0] < 0.8
    assert shares[1][1] == 0.0
    assert shares[2] == (shares[1][0], shares[1][0])


def test_the_printed_jacobian_forgets_the_hand() -> None:
    for q in random_joints(np.random.default_rng(SEED), 50):
        off = jacobian(q) - printed_jacobian(q)
        assert np.max(np.abs(off[3:])) == 0.0
        assert np.max(np.linalg.norm(off[:3], axis=0)) == pytest.approx(0.185, abs=1e-9)


def test_the_transposed_jacobian_creeps() -> None:
    q = np.array([0.2, 0.3, 0.9, 0.2, 0.1])
    near = transposed_jacobian(forward(q), q + 0.05)
    assert near.converged
    assert near.iterations > 100
    assert np.max(np.abs(forward(near.q) - forward(q))) < 2e-4
    given_up = transposed_jacobian(forward(q), q + 0.05, most_iterations=10)
    assert not given_up.converged
    assert given_up.iterations == 10
