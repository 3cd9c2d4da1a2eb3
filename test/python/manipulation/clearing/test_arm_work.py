"""Motions of a pick: on the side that is up, slowly where it may touch; what cannot be is said."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.manipulation.clearing.arm_work import (
    DEEPER_M,
    FEEL_M,
    FEEL_MPS,
    ArmWork,
    WorkError,
    carry_joints,
    grip_point,
)
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.kinematics.forward import forward_many

CARRY = np.array(carry_joints(0.2))


def piece(roll: float, x: float = 0.44) -> FloatArray:
    return transform_matrix((x, 0.03, 0.02), quaternion_from_rpy(roll, 0.0, 0.5))


@pytest.mark.parametrize("roll", [0.0, math.pi])
def test_the_cup_feels_its_way_down_to_the_side_that_is_up(roll: float) -> None:
    there = piece(roll)
    plan = ArmWork(Pose2(0.0, 0.0), [], 1).pick(CARRY, there)
    top = grip_point(there)
    assert top[2] == pytest.approx(0.04)
    times, q, _, _ = plan.feel.sampled(0.01)
    cup = forward_many(q)[:, :3, 3] + T_BASE_ARM[:3, 3]
    assert cup[0] == pytest.approx(top + np.array((0.0, 0.0, FEEL_M)), abs=1e-6)
    assert cup[-1] == pytest.approx(top - np.array((0.0, 0.0, DEEPER_M)), abs=1e-6)
    speeds = np.linalg.norm(np.diff(cup, axis=0), axis=1) / np.diff(times)
    assert speeds.max() <= 1.02 * FEEL_MPS
    assert np.abs(forward_many(q)[:, 2, 2] + 1.0).max() < 1e-9


def test_what_cannot_be_picked_is_refused_with_the_reason() -> None:
    arm = ArmWork(Pose2(0.0, 0.0), [], 1)
    with pytest.raises(WorkError, match="lies on its side, 90 deg from flat"):
        arm.pick(CARRY, piece(0.5 * math.pi))
    with pytest.raises(WorkError, match="out of the arm's reach"):
        arm.pick(CARRY, piece(0.0, 0.9))
    with pytest.raises(WorkError, match=r"carries a piece over a rim of 0\.60 m"):
        carry_joints(0.6)
