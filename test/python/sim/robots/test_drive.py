"""Wheel speeds from drive command and caster angles."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.robots.ankurbot import CASTER_XY_M
from yarm.sim.robots.drive import turning_centre, wheel_speeds

FRONT, REAR = math.radians(82.5686), math.radians(84.0939)
ABOUT_EE = np.array([FRONT, -FRONT, REAR, -REAR])
ABOUT_CENTRE = np.radians([-45.0, 45.0, 45.0, -45.0])


def test_parallel_wheels_all_run_at_the_drive_speed() -> None:
    result = wheel_speeds(np.full(4, 0.7), 0.8, 0.0)
    assert result.speeds_mps.tolist() == [0.8] * 4
    assert np.isnan(turning_centre(np.full(4, 0.7))).all()


def test_a_yaw_rate_with_parallel_wheels_is_left_out_and_said() -> None:
    result = wheel_speeds(np.full(4, 0.7), 0.0, 1.0)
    assert not result.has_centre
    assert result.speeds_mps.tolist() == [0.0] * 4


def test_the_casters_of_the_paper_turn_about_the_end_effector() -> None:
    assert turning_centre(ABOUT_EE) == pytest.approx([1.30, 0.0], abs=1e-3)


def test_turning_about_the_body_centre() -> None:
    assert turning_centre(ABOUT_CENTRE) == pytest.approx([0.0, 0.0], abs=1e-9)
    speeds = wheel_speeds(ABOUT_CENTRE, 0.0, 1.0).speeds_mps
    assert np.abs(speeds) == pytest.approx(np.full(4, 0.15 * math.sqrt(2.0)))


@settings(max_examples=50, deadline=None)
@given(st.floats(-4.0, 4.0), st.floats(-4.0, 4.0), st.floats(-2.0, 2.0), st.integers(0, 15))
def test_every_wheel_moves_as_the_rigid_body_does(x: float, y: float, rate: float, flips: int) -> None:
    """Whichever way round a wheel stands, its speed along its heading is that of the turning body there."""
    arm = np.array(CASTER_XY_M) - (x, y)
    if np.min(np.linalg.norm(arm, axis=1)) < 0.05:
        return
    velocity = rate * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
    angles = np.arctan2(arm[:, 0], -arm[:, 1]) + math.pi * (np.right_shift(flips, np.arange(4)) & 1)
    speeds = wheel_speeds(angles, 0.0, rate).speeds_mps
    headings = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    assert speeds[:, None] * headings == pytest.approx(velocity, abs=1e-6)
