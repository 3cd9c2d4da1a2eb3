"""Odometry: exact without noise, as wrong as it says with it, the same again with the same seed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry.scans import Odometry
from yarm.sim.kinematic.wheel_odometry import EXACT, TYPICAL, OdometryNoise, WheelOdometry

STEP_S = 0.02


def rolled(seed: int, noise: OdometryNoise, way_m: float, turn_rad: float, steps: int = 100) -> Odometry:
    odometry = WheelOdometry(np.random.default_rng(seed), noise)
    for i in range(steps):
        odometry.roll(way_m / steps / STEP_S, turn_rad / steps / STEP_S, STEP_S, (i + 1) * STEP_S)
    return odometry.now


def test_without_errors_it_is_an_arc() -> None:
    now = rolled(1, EXACT, math.pi, 0.5 * math.pi)
    assert (now.pose.x, now.pose.y) == pytest.approx((2.0, 2.0), abs=1e-3)
    assert now.pose.yaw_rad == pytest.approx(0.5 * math.pi)
    assert (now.stamp_s, now.v_mps, now.w_radps) == pytest.approx((2.0, 0.5 * math.pi, 0.25 * math.pi))


def test_it_is_as_wrong_as_its_noise_says() -> None:
    ways = [rolled(seed, TYPICAL, 4.0, 0.0).pose for seed in range(300)]
    turns = [rolled(seed, TYPICAL, 0.0, 2.0).pose.yaw_rad for seed in range(300)]
    lengths = [math.hypot(pose.x, pose.y) for pose in ways]
    # Scales are drawn evenly from a band: its deviation is the half width over root 3.
    for values, true, walk in ((lengths, 4.0, TYPICAL.random_m), (turns, 2.0, TYPICAL.random_rad)):
        expected = math.hypot(true * TYPICAL.scale / math.sqrt(3.0), walk * math.sqrt(true))
        assert np.std(values) == pytest.approx(expected, rel=0.15)
        assert np.mean(values) == pytest.approx(true, abs=4.0 * expected / math.sqrt(300))
    drift = TYPICAL.drift_rad_per_m * 4.0 / math.sqrt(3.0)
    assert np.std([pose.yaw_rad for pose in ways]) == pytest.approx(drift, rel=0.15)


def test_speeds_have_no_random_errors() -> None:
    speeds = [rolled(4, TYPICAL, 0.2, 0.1, steps).v_mps * steps for steps in (10, 20, 40)]
    assert speeds == pytest.approx([speeds[0]] * 3)
    assert speeds[0] * STEP_S == pytest.approx(0.2, rel=TYPICAL.scale)


def test_standing_still_adds_nothing() -> None:
    assert rolled(3, TYPICAL, 0.0, 0.0).pose == rolled(3, EXACT, 0.0, 0.0).pose


def test_a_slip_moves_the_pose_and_nothing_else() -> None:
    slips = []
    for seed in range(300):
        odometry = WheelOdometry(np.random.default_rng(seed), TYPICAL)
        odometry.roll(0.0, 0.0, STEP_S, STEP_S)
        odometry.slip()
        assert (odometry.now.stamp_s, odometry.now.v_mps) == (STEP_S, 0.0)
        slips.append((odometry.now.pose.x, odometry.now.pose.y, odometry.now.pose.yaw_rad))
    assert np.std(slips, axis=0) == pytest.approx([TYPICAL.slip_m, TYPICAL.slip_m, TYPICAL.slip_rad], rel=0.15)


def test_a_seed_repeats_and_another_differs() -> None:
    first, again, other = (rolled(seed, TYPICAL, 1.0, 1.0).pose for seed in (7, 7, 8))
    assert first == again
    assert first != other
