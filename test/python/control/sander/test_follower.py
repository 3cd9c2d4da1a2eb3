"""One motion at a time: what is sent, when the arm is there, how it is braked."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.follower import FOLLOW_GRACE_S, MotionFollower

STOP_S = 0.15


def line(duration_s: float = 2.0, length_rad: float = 1.0) -> ArmMotion:
    """All six joints together, evenly, the tip half a metre."""
    times = np.linspace(0.0, duration_s, 21)
    share = times / duration_s
    return ArmMotion(times, np.outer(share, np.full(6, length_rad)), 0.5 * share)


def follower(now_s: float = 10.0) -> MotionFollower:
    made = MotionFollower(STOP_S)
    made.send(line(), now_s)
    return made


def test_a_motion_is_sent_once_and_ends_where_it_ends() -> None:
    made = follower()
    (sent,) = made.take()
    assert sent.duration_s == 2.0
    assert made.take() == []
    assert made.active
    assert not made.arrived(np.full(6, 0.5), 11.0)
    assert not made.arrived(np.full(6, 1.0), 11.9)
    assert made.arrived(np.full(6, 0.995), 12.0)
    assert not made.active
    assert made.arrived(np.zeros(6), 13.0)


def test_a_motion_of_no_length_is_not_sent() -> None:
    made = MotionFollower(STOP_S)
    made.send(ArmMotion(np.zeros(1), np.zeros((1, 6)), np.zeros(1)), 1.0)
    assert made.take() == []
    assert made.active
    assert made.arrived(np.zeros(6), 1.0)


def test_an_arm_that_stays_behind_is_named_and_given_up() -> None:
    made = follower()
    q = np.array([1.0, 1.0, 0.6, 1.0, 1.0, 1.0])
    assert not made.arrived(q, 12.0 + FOLLOW_GRACE_S)
    with pytest.raises(ArmError, match=r"joint 3 is 0\.400 rad away 3 s after"):
        made.arrived(q, 12.01 + FOLLOW_GRACE_S)
    assert not made.active


def test_the_way_is_that_of_the_measured_joints_not_of_the_clock() -> None:
    made = follower()
    assert made.arc_m(np.full(6, 0.5), 11.0) == pytest.approx(0.25, abs=0.01)
    assert made.arc_m(np.full(6, 0.4), 11.0) == pytest.approx(0.20, abs=0.01)
    with pytest.raises(ArmError, match="no motion"):
        MotionFollower(STOP_S).arc_m(np.zeros(6), 0.0)


def test_braking_is_on_the_path_and_once() -> None:
    made = follower()
    made.take()
    made.brake(np.full(6, 0.5), 11.0)
    (sent,) = made.take()
    assert made.braking
    assert sent.duration_s == pytest.approx(STOP_S)
    assert sent.positions[0] == pytest.approx(np.full(6, 0.5), abs=0.02)
    assert sent.positions[-1] == pytest.approx(np.full(6, 0.5 + 0.5 * STOP_S / 2.0), abs=0.02)
    assert np.ptp(sent.positions, axis=1).max() < 1e-9
    made.brake(np.full(6, 0.5), 11.0)
    assert made.take() == []
    assert made.arrived(sent.positions[-1], 11.0 + STOP_S)
    made.send(line(), 12.0)
    assert not made.braking


def test_at_rest_there_is_nothing_to_brake() -> None:
    made = MotionFollower(STOP_S)
    made.brake(np.zeros(6), 1.0)
    assert made.take() == []
    assert not made.braking
