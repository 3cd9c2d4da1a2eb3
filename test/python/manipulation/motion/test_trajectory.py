"""Every timing starts and ends where it should, at rest, and exceeds no limit on a dense sample."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
import pytest

from yarm.manipulation.motion.trajectory import (
    MotionLimits,
    Trajectory,
    TrajectoryError,
    arm_limits,
    check_limits,
    jerk_limited,
    quintic,
    through_waypoints,
    trapezoid,
)
from yarm.robots.youbot import random_joints

SEED = 4
LIMITS = arm_limits()
Timing = Callable[..., Trajectory]
MOVES = [quintic, trapezoid, jerk_limited]


@pytest.mark.parametrize("timing", MOVES)
def test_a_move_keeps_every_limit_from_rest_to_rest(timing: Timing) -> None:
    rng = np.random.default_rng(SEED)
    for start, goal in zip(random_joints(rng, 25), random_joints(rng, 25)):
        motion = timing(start, goal, LIMITS)
        times, q, speed, _ = motion.sampled()
        assert q[0] == pytest.approx(start, abs=1e-9)
        assert q[-1] == pytest.approx(goal, abs=1e-9)
        assert np.max(np.abs(speed[[0, -1]])) < 1e-9
        check = check_limits(motion, LIMITS, 0.002)
        assert check.kept
        assert max(check.speed, check.acceleration) > 0.9
        assert times[-1] == pytest.approx(motion.duration_s)


@pytest.mark.parametrize("timing", [*MOVES, through_waypoints])
def test_velocity_and_acceleration_are_the_derivatives(timing: Timing) -> None:
    rng = np.random.default_rng(SEED)
    start, goal = random_joints(rng, 2)
    motion = (
        timing(np.array([start, 0.5 * (start + goal) + 0.1, goal]), LIMITS)
        if timing is through_waypoints
        else (timing(start, goal, LIMITS))
    )
    h = 1e-5
    times = np.linspace(0.1, 0.9, 17) * motion.duration_s
    _, speed, acceleration = motion.evaluate(times)
    ahead, behind = motion.evaluate(times + h), motion.evaluate(times - h)
    assert np.max(np.abs((ahead[0] - behind[0]) / (2 * h) - speed)) < 1e-4
    middle = np.abs((ahead[1] - behind[1]) / (2 * h) - acceleration)
    assert np.median(middle) < 1e-3


def test_the_quintic_has_no_acceleration_at_its_ends() -> None:
    motion = quintic(np.zeros(5), np.ones(5), LIMITS)
    _, _, acceleration = motion.evaluate(np.array([0.0, motion.duration_s]))
    assert np.max(np.abs(acceleration)) < 1e-9


def test_the_jerk_is_limited() -> None:
    motion = jerk_limited(np.zeros(5), np.array([1.0, -0.5, 0.3, 0.0, 2.0]), LIMITS)
    times, _, _, acceleration = motion.sampled(0.001)
    jerk = np.abs(np.diff(acceleration, axis=0)) / np.diff(times)[:, None]
    assert np.max(jerk) <= LIMITS.jerk[0] * (1.0 + 1e-6)


def test_a_move_may_begin_in_motion() -> None:
    motion = jerk_limited(np.zeros(5), np.ones(5), LIMITS, velocity=np.full(5, 0.5))
    assert motion.evaluate(np.zeros(1))[1][0] == pytest.approx(np.full(5, 0.5))
    assert motion.at(motion.duration_s + 1.0) == pytest.approx(np.ones(5))


@pytest.mark.parametrize("timing", MOVES)
def test_no_way_takes_no_time(timing: Timing) -> None:
    motion = timing(np.ones(5), np.ones(5), LIMITS)
    assert motion.duration_s == pytest.approx(0.0, abs=1e-9)
    assert motion.at(0.0) == pytest.approx(np.ones(5))


def test_waypoints_are_passed_within_the_limits() -> None:
    rng = np.random.default_rng(SEED)
    for count in (2, 3, 6, 20):
        points = random_joints(rng, count)
        motion = through_waypoints(points, LIMITS)
        _, q, speed, _ = motion.sampled(0.002)
        assert check_limits(motion, LIMITS, 0.0007).kept
        assert np.max(np.abs(speed[[0, -1]])) < 1e-6
        for point in points:
            assert np.min(np.max(np.abs(q - point), axis=1)) < 0.01


@pytest.mark.parametrize("seed", range(40))
def test_limits_are_kept_between_any_samples(seed: int) -> None:
    rng = np.random.default_rng(seed)
    size_rad = rng.choice([0.02, 0.1, 0.5])
    points = np.cumsum(rng.normal(0.0, size_rad, (int(rng.integers(2, 25)), 5)), axis=0)
    timed = through_waypoints(points, arm_limits())
    check = check_limits(timed, arm_limits(), 3e-4)
    assert check.kept, f"seed {seed}: {check}"
    assert max(check.speed, check.acceleration) > 0.99, f"seed {seed}: slower than it needs to be: {check}"


def test_a_check_sees_a_limit_that_is_broken() -> None:
    motion = quintic(np.zeros(5), np.ones(5), LIMITS)
    assert not check_limits(motion, arm_limits(0.9)).kept


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: quintic(np.zeros(4), np.ones(5), LIMITS), "must be 5 finite angles"),
        (lambda: trapezoid(np.zeros(5), np.full(5, math.nan), LIMITS), "goal"),
        (lambda: through_waypoints(np.zeros((1, 5)), LIMITS), "needs two waypoints, not 1"),
        (lambda: through_waypoints(np.zeros((3, 5)), LIMITS), "waypoints 0 and 1 are the same"),
        (lambda: through_waypoints(np.zeros((3, 4)), LIMITS), "m x 5"),
        (
            lambda: MotionLimits(np.ones(5), -np.ones(5), np.ones(5)),
            "acceleration limits must be 5 finite numbers above",
        ),
    ],
)
def test_bad_input_is_named(call: Callable[[], object], says: str) -> None:
    with pytest.raises(TrajectoryError, match=says):
        call()
