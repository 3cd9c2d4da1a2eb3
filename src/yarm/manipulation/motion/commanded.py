"""A motion that somebody else has timed, as its controller is commanded it, checked before the arm follows it."""

from __future__ import annotations

from typing import List, Optional, Sequence

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from yarm.geometry import FloatArray
from yarm.manipulation.motion.trajectory import Sampled, Trajectory, TrajectoryError
from yarm.robots.youbot import (
    JOINT_NAMES,
    N_JOINTS,
    SPEED_RADPS,
    mechanical_angles,
    urdf_rates,
    within_limits,
)

AT_RAD = 0.05
"""A motion that begins at once begins within this of where each joint is, rad."""
ROUNDED_RAD = 1e-3
"""Readings may be outside a joint's limits by so much, rad: they are rounded on the way."""
LONGEST_S = 600.0
"""A motion takes no longer."""
SPEED_SHARE = 1.02
"""Greatest share of a joint's speed limit, between two points interpolated from samples of a motion that keeps it."""


def commanded(
    names: Sequence[str],
    times_s: npt.ArrayLike,
    readings: npt.ArrayLike,
    rates: Optional[npt.ArrayLike],
    present: npt.ArrayLike,
) -> Trajectory:
    """The motion through timed points: cubic where speeds are given, else monotone from point to point.

    Args:
        names: of the joints, in the order of the points' numbers.
        times_s: (m,), s, from the motion's beginning.
        readings: (m, 5) the driver's angles, rad.
        rates: (m, 5) their speeds, rad/s; None when none are given.
        present: (5,) mechanical angles where the arm is, rad.

    Raises:
        TrajectoryError: names, numbers, times, limits or the beginning are wrong: which, and what is allowed.
    """
    if sorted(names) != sorted(JOINT_NAMES):
        raise TrajectoryError(f"joints {list(names)} must be {', '.join(JOINT_NAMES)}, each once")
    order = [list(names).index(name) for name in JOINT_NAMES]
    times = np.asarray(times_s, dtype=float)
    q = mechanical_angles(_checked("positions", readings, times)[:, order])
    speed = None if rates is None else urdf_rates(_checked("velocities", rates, times)[:, order])
    if not np.all(np.isfinite(times)) or times[0] < 0.0 or np.any(np.diff(times) <= 0.0):
        raise TrajectoryError(f"times {_some(times)} s must be finite, at least 0 and ascending")
    if times[-1] > LONGEST_S:
        raise TrajectoryError(f"it takes {times[-1]:.0f} s, at most {LONGEST_S:g}")
    for k in np.flatnonzero(~within_limits(q, ROUNDED_RAD)):
        raise TrajectoryError(f"point {k + 1}: angles {q[k].round(3).tolist()} rad are outside the joints' limits")
    now = np.asarray(present, dtype=float)
    if times[0] > 0.0:
        times, q = np.concatenate([[0.0], times]), np.vstack([now, q])
        speed = None if speed is None else np.vstack([np.zeros(N_JOINTS), speed])
    off = float(np.max(np.abs(q[0] - now)))
    if off > AT_RAD:
        raise TrajectoryError(
            f"it begins at time 0 {off:.3f} rad from where the arm is, at most {AT_RAD:g}; give its first point time"
        )
    motion = _through(times, q, speed)
    _, between, rates_between, _ = motion.sampled()
    if not np.all(within_limits(between, ROUNDED_RAD)):
        raise TrajectoryError("between its points it leaves the joints' limits; give it smaller speeds at them")
    fastest = float(np.max(np.abs(rates_between)))
    if fastest > SPEED_SHARE * SPEED_RADPS:
        raise TrajectoryError(f"it is {fastest:.2f} rad/s fast, at most {SPEED_RADPS:g}; give it more time")
    return motion


def _checked(what: str, rows: npt.ArrayLike, times: FloatArray) -> FloatArray:
    values = np.asarray(rows, dtype=float)
    if not len(times) or values.shape != (len(times), N_JOINTS) or not np.all(np.isfinite(values)):
        raise TrajectoryError(f"{what} must be {N_JOINTS} finite numbers for each of at least one point")
    return values


def _through(times: FloatArray, q: FloatArray, speed: Optional[FloatArray]) -> Trajectory:
    if len(times) == 1:
        times, q, speed = np.array([0.0, 1e-3]), np.vstack([q, q]), None
    curve = PchipInterpolator(times, q) if speed is None else CubicHermiteSpline(times, q, speed)

    def evaluate(at: FloatArray) -> Sampled:
        return curve(at), curve(at, 1), curve(at, 2)

    return Trajectory(float(times[-1]), "commanded", evaluate)


def _some(times: FloatArray) -> List[float]:
    return [round(float(t), 3) for t in times[:6]]
