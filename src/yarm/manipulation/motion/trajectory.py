"""Motions of the joints in time, within limits of speed, acceleration and, where asked for, jerk.

Jerk-limited moves are Ruckig's (L. Berscheid, T. Kroeger, RSS 2021), from state to state only: its waypoints would be
timed by a service outside. Waypoints are TOPP-RA's (H. Pham, Q.-C. Pham, IEEE Transactions on Robotics 34, 2018);
yarm.control.arm.motion, which times the HC10's moves by the same two, has the papers' titles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

import numpy as np
import numpy.typing as npt
import ruckig
import toppra
import toppra.algorithm as ta
from toppra import constraint

from yarm.geometry import FloatArray
from yarm.robots.youbot import ACCELERATION_RADPS2, JERK_RADPS3, N_JOINTS, SPEED_RADPS

Sampled = Tuple[FloatArray, FloatArray, FloatArray]
"""Positions, velocities and accelerations, (m, n) each."""
SAMPLE_S = 0.01
STILL_RAD = 1e-9
GRID_PER_POINT = 12
QUINTIC_SPEED, QUINTIC_ACCELERATION = 15.0 / 8.0, 10.0 / math.sqrt(3.0)
"""Greatest first and second derivative of 10 s^3 - 15 s^4 + 6 s^5 over a unit of time."""


class TrajectoryError(ValueError):
    """A motion cannot be made; the message names the joint or point, the number and the limit."""


@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Greatest speed (rad/s), acceleration (rad/s^2) and jerk (rad/s^3) of each joint, (n,) each."""

    speed: FloatArray
    acceleration: FloatArray
    jerk: FloatArray

    def __post_init__(self) -> None:
        for name in ("speed", "acceleration", "jerk"):
            values = getattr(self, name)
            if values.shape != self.speed.shape or not np.all(np.isfinite(values)) or np.any(values <= 0.0):
                raise TrajectoryError(
                    f"{name} limits must be {len(self.speed)} finite numbers above 0; they are {values.tolist()}"
                )


def arm_limits(share: float = 1.0) -> MotionLimits:
    """The arm's limits, or a share of them."""
    ones = np.ones(N_JOINTS)
    return MotionLimits(share * SPEED_RADPS * ones, share * ACCELERATION_RADPS2 * ones, share * JERK_RADPS3 * ones)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion from rest at time 0 (unless it was begun in motion) to rest at its end.

    Attributes:
        duration_s: how long it takes.
        method: what timed it.
        evaluate: times (m,), s, within it to positions, velocities and accelerations (m, n).
    """

    duration_s: float
    method: str
    evaluate: Callable[[FloatArray], Sampled]

    def at(self, time_s: float) -> FloatArray:
        """Joints (n,) at a time; before and after it holds its ends."""
        return np.asarray(self.evaluate(np.array([min(max(time_s, 0.0), self.duration_s)]))[0][0])

    def sampled(self, step_s: float = SAMPLE_S) -> Tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Times (m,), both ends among them, and positions, velocities, accelerations (m, n) there."""
        times = np.linspace(0.0, self.duration_s, max(math.ceil(self.duration_s / step_s), 1) + 1)
        return (times, *self.evaluate(times))


@dataclass(frozen=True)
class LimitCheck:
    """Greatest share of each limit that a sampled motion uses; above 1 it breaks it."""

    speed: float
    acceleration: float

    @property
    def kept(self) -> bool:
        """Whether no limit is exceeded."""
        return max(self.speed, self.acceleration) <= 1.0 + 1e-6


def check_limits(trajectory: Trajectory, limits: MotionLimits, step_s: float = 0.5 * SAMPLE_S) -> LimitCheck:
    """Speeds and accelerations of a motion against limits, on samples."""
    return _shares(trajectory, trajectory.sampled(step_s)[0], limits)


def _shares(trajectory: Trajectory, times: FloatArray, limits: MotionLimits) -> LimitCheck:
    _, velocity, acceleration = trajectory.evaluate(times)
    return LimitCheck(
        float(np.max(np.abs(velocity) / limits.speed)), float(np.max(np.abs(acceleration) / limits.acceleration))
    )


def quintic(start: npt.ArrayLike, goal: npt.ArrayLike, limits: MotionLimits) -> Trajectory:
    """Straight in joint space with zero speed and acceleration at both ends, as quick as the limits allow."""
    origin, way = _ends(start, goal, limits)
    slowest = max(
        float(np.max(QUINTIC_SPEED * np.abs(way) / limits.speed)),
        float(np.max(np.sqrt(QUINTIC_ACCELERATION * np.abs(way) / limits.acceleration))),
    )

    def evaluate(times: FloatArray) -> Sampled:
        s = times / slowest if slowest > 0.0 else np.zeros_like(times)
        pace, push = (1.0 / slowest, 1.0 / slowest**2) if slowest > 0.0 else (0.0, 0.0)
        share = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
        speed = 30.0 * pace * s**2 * (1.0 - 2.0 * s + s**2)
        acceleration = 60.0 * push * s * (1.0 - 3.0 * s + 2.0 * s**2)
        return origin + np.outer(share, way), np.outer(speed, way), np.outer(acceleration, way)

    return Trajectory(slowest, "quintic", evaluate)


def trapezoid(start: npt.ArrayLike, goal: npt.ArrayLike, limits: MotionLimits) -> Trajectory:
    """Straight in joint space: full acceleration, greatest speed, full deceleration."""
    origin, way = _ends(start, goal, limits)
    length = np.maximum(np.abs(way), 1e-300)
    pace, push = float(np.min(limits.speed / length)), float(np.min(limits.acceleration / length))
    if not np.any(np.abs(way) > STILL_RAD):
        duration = rise = 0.0
    else:
        pace = min(pace, math.sqrt(push))
        rise = pace / push
        duration = 1.0 / pace + rise

    def evaluate(times: FloatArray) -> Sampled:
        if duration == 0.0:
            zeros = np.zeros((len(times), len(origin)))
            return origin + zeros, zeros, zeros.copy()
        left = duration - times
        speed = np.minimum(pace, push * np.minimum(times, left))
        share = np.where(
            times < rise,
            0.5 * push * times**2,
            np.where(left < rise, 1.0 - 0.5 * push * left**2, pace * (times - 0.5 * rise)),
        )
        acceleration = push * ((times < rise).astype(float) - (left < rise))
        return origin + np.outer(share, way), np.outer(speed, way), np.outer(acceleration, way)

    return Trajectory(duration, "trapezoid", evaluate)


def jerk_limited(
    start: npt.ArrayLike, goal: npt.ArrayLike, limits: MotionLimits, velocity: Optional[npt.ArrayLike] = None
) -> Trajectory:
    """To rest at a goal, every joint within speed, acceleration and jerk, all arriving together (Ruckig).

    Args:
        start: (n,), rad.
        goal: (n,), rad.
        limits: of the joints.
        velocity: (n,), rad/s, with which it begins; None from rest.

    Raises:
        TrajectoryError: not finite, of different lengths, or Ruckig refuses, with its code.
    """
    origin, way = _ends(start, goal, limits)
    n = len(origin)
    wanted = ruckig.InputParameter(n)
    wanted.current_position, wanted.target_position = origin.tolist(), (origin + way).tolist()
    if velocity is not None:
        wanted.current_velocity = np.asarray(velocity, dtype=float).tolist()
    wanted.max_velocity = limits.speed.tolist()
    wanted.max_acceleration = limits.acceleration.tolist()
    wanted.max_jerk = limits.jerk.tolist()
    found = ruckig.Trajectory(n)
    code = ruckig.Ruckig(n).calculate(wanted, found)
    if code not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise TrajectoryError(f"Ruckig found no motion by {way.round(3).tolist()} rad: {code}")

    def evaluate(times: FloatArray) -> Sampled:
        rows = np.array([found.at_time(float(time)) for time in times])
        return rows[:, 0], rows[:, 1], rows[:, 2]

    return Trajectory(float(found.duration), "jerk-limited", evaluate)


def through_waypoints(points: npt.ArrayLike, limits: MotionLimits) -> Trajectory:
    """A spline through points (m, n), rad, from rest to rest, timed by TOPP-RA.

    The joints leave the straight lines between the points; points close together keep them near.

    Raises:
        TrajectoryError: fewer than two points, the same point twice in a row, not finite, or no timing exists.
    """
    corners = np.asarray(points, dtype=float)
    if corners.ndim != 2 or corners.shape[1] != len(limits.speed) or not np.all(np.isfinite(corners)):
        raise TrajectoryError(f"waypoints must be finite and m x {len(limits.speed)}, not {corners.shape}")
    if len(corners) < 2:
        raise TrajectoryError(f"a path needs two waypoints, not {len(corners)}")
    gaps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    if np.any(gaps < STILL_RAD):
        first = int(np.argmin(gaps))
        apart = f"{gaps[first]:.1g} rad apart, {STILL_RAD:g} rad or more is due"
        raise TrajectoryError(f"waypoints {first} and {first + 1} are the same: {apart}")
    ways = np.concatenate([[0.0], np.cumsum(gaps)])
    path = toppra.SplineInterpolator(ways, corners)
    bounds = [
        constraint.JointVelocityConstraint(np.column_stack([-limits.speed, limits.speed])),
        constraint.JointAccelerationConstraint(np.column_stack([-limits.acceleration, limits.acceleration])),
    ]
    # Grid points on the waypoints: between them the spline's curvature is smooth.
    grid = np.interp(np.linspace(0, len(ways) - 1, GRID_PER_POINT * (len(ways) - 1) + 1), np.arange(len(ways)), ways)
    timed = ta.TOPPRA(bounds, path, gridpoints=grid).compute_trajectory(0.0, 0.0)
    if timed is None:
        raise TrajectoryError(f"TOPP-RA found no timing for {len(corners)} waypoints over {ways[-1]:.3f} rad")

    def evaluate(times: FloatArray) -> Sampled:
        inside = np.clip(times, 0.0, timed.duration)
        return timed(inside), timed(inside, 1), timed(inside, 2)

    trajectory = Trajectory(float(timed.duration), "TOPP-RA", evaluate)
    return _slowed(trajectory, np.asarray(timed.ss_waypoints, dtype=float), limits)


def _slowed(trajectory: Trajectory, knots: FloatArray, limits: MotionLimits) -> Trajectory:
    """The same motion stretched in time until every limit is kept: TOPP-RA holds them at its grid points only.

    Args:
        trajectory: of cubic pieces.
        knots: times (m,) between which they lie, s: an acceleration is greatest at one of them, a speed there or where
            the acceleration is 0.
        limits: to keep.
    """
    _, _, push = trajectory.evaluate(knots)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = push[:-1] / (push[:-1] - push[1:])
    turns = (knots[:-1, None] + np.diff(knots)[:, None] * share)[(share > 0.0) & (share < 1.0)]
    check = _shares(trajectory, np.concatenate([knots, turns]), limits)
    return stretched(trajectory, max(1.0, check.speed, math.sqrt(check.acceleration)))


def stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    """The same way in a time that is longer by a factor above 0.

    Raises:
        TrajectoryError: another factor.
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise TrajectoryError(f"a motion is stretched by a finite factor above 0, not {factor}")

    def evaluate(times: FloatArray) -> Sampled:
        q, speed, acceleration = trajectory.evaluate(times / factor)
        return q, speed / factor, acceleration / factor**2

    return Trajectory(trajectory.duration_s * factor, trajectory.method, evaluate)


def _ends(start: npt.ArrayLike, goal: npt.ArrayLike, limits: MotionLimits) -> Tuple[FloatArray, FloatArray]:
    origin, target = np.asarray(start, dtype=float), np.asarray(goal, dtype=float)
    for name, values in (("start", origin), ("goal", target)):
        if values.shape != limits.speed.shape or not np.all(np.isfinite(values)):
            raise TrajectoryError(f"{name} {values.tolist()} must be {len(limits.speed)} finite angles, rad")
    return origin, target - origin
