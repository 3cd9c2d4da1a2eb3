"""Motions that somebody else has timed: followed as given, or refused with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.manipulation.motion.commanded import commanded
from yarm.manipulation.motion.trajectory import TrajectoryError, arm_limits, quintic
from yarm.robots.youbot import JOINT_NAMES, UPPER_RAD, urdf_angles, urdf_rates

START, GOAL = np.zeros(5), np.array([0.4, 0.5, -0.6, 0.3, -0.2])
FAR = np.vstack([urdf_angles(START), urdf_angles(GOAL)])
TOP = np.array([0.0, UPPER_RAD[1], 0.0, 0.0, 0.0])
HIGH = np.vstack([urdf_angles(START), urdf_angles(TOP)])


def test_a_sampled_motion_comes_back_within_a_thousandth() -> None:
    made = quintic(START, GOAL, arm_limits())
    times, q, speed, _ = made.sampled(0.05)
    motion = commanded(JOINT_NAMES, times, urdf_angles(q), urdf_rates(speed), START)
    assert motion.duration_s == pytest.approx(made.duration_s)
    for time_s in np.linspace(0.0, made.duration_s, 37):
        assert np.max(np.abs(motion.at(time_s) - made.at(time_s))) < 1e-3


def test_joints_may_come_in_any_order_and_a_first_point_later_on_begins_where_the_arm_is() -> None:
    turned = commanded(JOINT_NAMES[::-1], [2.0], urdf_angles(GOAL)[None, ::-1], None, START)
    assert np.allclose(turned.at(0.0), START)
    assert np.allclose(turned.at(2.0), GOAL)
    middle = turned.at(1.0)
    assert np.all(np.abs(middle) <= np.abs(GOAL))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"names": ["a", *JOINT_NAMES[1:]]}, "arm_joint_1, .* each once"),
        ({"names": []}, "each once"),
        ({"times_s": [0.0, 0.0]}, "ascending"),
        ({"times_s": [-1.0, 2.0]}, "at least 0"),
        ({"times_s": [0.0, math.inf]}, "finite"),
        ({"times_s": [0.0, 0.1]}, r"rad/s fast, at most 1.57"),
        ({"times_s": [0.0, 601.0]}, "it takes 601 s, at most 600"),
        (
            {"rates": np.array([np.zeros(5), [0.0, -1.5, 0.0, 0.0, 0.0]]), "readings": HIGH},
            "between its points it leaves",
        ),
        ({"readings": FAR[:, :4]}, "5 finite numbers"),
        ({"readings": np.vstack([FAR[0], FAR[1] * math.nan])}, "positions must be 5 finite numbers"),
        ({"rates": np.zeros((1, 5))}, "velocities must be"),
        ({"readings": np.vstack([FAR[0], FAR[1] + 9.0])}, "point 2: .* outside the joints' limits"),
        ({"present": GOAL}, "0.600 rad from where the arm is, at most 0.05"),
        ({"times_s": [], "readings": np.zeros((0, 5))}, "at least one point"),
    ],
)
def test_what_cannot_be_followed_is_refused_with_the_number_and_the_limit(change: dict, reason: str) -> None:
    given = {"names": JOINT_NAMES, "times_s": [0.0, 4.0], "readings": FAR, "rates": None, "present": START}
    commanded(**given)
    with pytest.raises(TrajectoryError, match=reason):
        commanded(**{**given, **change})
