"""Motions in time: points that are joined by straight lines, as the arm's driver follows them.

Free moves are timed by Ruckig (L. Berscheid, T. Kroeger, "Jerk-limited real-time trajectory generation with arbitrary
target states", RSS 2021), paths of the tip by TOPP-RA (H. Pham, Q.-C. Pham, "A new approach to time-optimal path
parameterization based on reachability analysis", IEEE Transactions on Robotics 34, 2018).
"""

from __future__ import annotations

import sys
from contextlib import contextmanager
from dataclasses import dataclass
from types import ModuleType
from typing import Iterator

import numpy as np
import ruckig

from yarm.control.arm.errors import ArmError
from yarm.control.arm.model import JointLimits
from yarm.geometry.grid import FloatArray


@contextmanager
def _without(*names: str) -> Iterator[None]:
    """While something is imported, modules that are not there yet are empty ones."""
    absent = [name for name in names if name not in sys.modules]
    sys.modules.update({name: ModuleType(name) for name in absent})
    try:
        yield
    finally:
        for name in absent:
            del sys.modules[name]


with _without("matplotlib", "matplotlib.pyplot"):  # for pictures alone, and a quarter of a sander's time to start
    import toppra
    import toppra.algorithm as ta
    from toppra import constraint

SAMPLE_S = 0.05
REST_TOLERANCE_RAD = 0.01


@dataclass(frozen=True, eq=False)
class ArmMotion:
    """Joint positions over time, straight in between.

    Attributes:
        times_s: (m,), rising, from 0.
        positions: (m, 6), rad.
        arc_m: (m,) way of the tip along its path, metres; zeros where it does not matter.
    """

    times_s: FloatArray
    positions: FloatArray
    arc_m: FloatArray

    @property
    def duration_s(self) -> float:
        """Time from the first point to the last."""
        return float(self.times_s[-1])

    def at(self, time_s: float) -> FloatArray:
        """Joints (6,) at a time; before and after it holds its ends."""
        return np.array([np.interp(time_s, self.times_s, column) for column in self.positions.T])

    def arc_at(self, time_s: float) -> float:
        """Way of the tip at a time, metres."""
        return float(np.interp(time_s, self.times_s, self.arc_m))

    def nearest_time(self, q: FloatArray, early_s: float, late_s: float) -> float:
        """Time between two others at which the motion is nearest to measured joints (6,)."""
        times = np.linspace(max(early_s, 0.0), min(max(late_s, 0.0), self.duration_s), 25)
        sampled = np.stack([np.interp(times, self.times_s, column) for column in self.positions.T], axis=-1)
        return float(times[int(np.argmin(np.sum((sampled - q) ** 2, axis=1)))])

    def braked(self, from_s: float, stop_s: float) -> ArmMotion:
        """Stop on the same path: from full pace at a time, evenly slower, to rest after ``stop_s``."""
        left_s = self.duration_s - from_s
        taken = np.linspace(0.0, stop_s, max(int(np.ceil(stop_s / 0.02)), 2) + 1)
        path_times = from_s + np.minimum(taken - taken**2 / (2.0 * stop_s), max(left_s, 0.0))
        positions = np.array([self.at(time) for time in path_times])
        return ArmMotion(taken, positions, np.array([self.arc_at(time) for time in path_times]))


def through_corners(corners: FloatArray, limits: JointLimits, share: float, acceleration: float) -> ArmMotion:
    """Straight pieces of joint space between corners (n, 6), at rest in each; Ruckig times them.

    Args:
        corners: rad.
        limits: of the joints.
        share: of the joints' greatest speeds that is used, 0 to 1.
        acceleration: of each joint, rad/s^2; the jerk limit is ten times that per second.

    Raises:
        ArmError: Ruckig refuses, with its code.
    """
    times, positions = [np.zeros(1)], [np.asarray(corners[:1], dtype=float)]
    for start, goal in zip(corners[:-1], corners[1:]):
        way = goal - start
        if np.max(np.abs(way)) < 1e-6:
            continue
        trajectory = _straight(way, share * limits.speed, acceleration)
        samples = np.linspace(0.0, trajectory.duration, max(int(np.ceil(trajectory.duration / SAMPLE_S)), 1) + 1)[1:]
        shares = np.array([trajectory.at_time(float(t))[0][0] for t in samples])
        positions.append(start + shares[:, None] * way)
        times.append(times[-1][-1] + samples)
    all_times = np.concatenate(times)
    return ArmMotion(all_times, np.concatenate(positions), np.zeros(len(all_times)))


def along_path(
    joints: FloatArray, arc_m: FloatArray, speed_mps: float, tip_acceleration: float, limits: JointLimits
) -> ArmMotion:
    """A path of the tip, timed by TOPP-RA: tip and joint speeds within their limits, from rest to rest.

    The way of the tip is carried along as a seventh joint, so that its speed limit is one of the joints'.

    Args:
        joints: (n, 6), rad, close together.
        arc_m: (n,) way of the tip, rising strictly, metres.
        speed_mps: greatest speed of the tip.
        tip_acceleration: greatest acceleration of the tip, m/s^2.
        limits: of the joints; a tenth is kept back from their speeds.

    Raises:
        ArmError: fewer than two points, or no timing exists.
    """
    if len(joints) < 2:
        raise ArmError(f"a path of {len(joints)} point(s) cannot be timed")
    path = toppra.SplineInterpolator(arc_m - arc_m[0], np.column_stack([joints, arc_m - arc_m[0]]))
    speeds = np.append(0.9 * limits.speed, speed_mps)
    accelerations = np.append(np.full(6, 6.0), tip_acceleration)
    grid = np.linspace(0.0, arc_m[-1] - arc_m[0], max(2 * len(joints), 30))
    constraints = [
        constraint.JointVelocityConstraint(np.column_stack([-speeds, speeds])),
        constraint.JointAccelerationConstraint(np.column_stack([-accelerations, accelerations])),
    ]
    timed = ta.TOPPRA(constraints, path, gridpoints=grid).compute_trajectory(0.0, 0.0)
    if timed is None:
        raise ArmError(f"TOPP-RA found no timing for a path of {arc_m[-1] - arc_m[0]:.3f} m")
    times = np.linspace(0.0, timed.duration, max(int(np.ceil(timed.duration / SAMPLE_S)), 1) + 1)
    values = timed(times)
    return ArmMotion(times, values[:, :6], values[:, 6] + arc_m[0])


def _straight(way: FloatArray, speeds: FloatArray, acceleration: float) -> ruckig.Trajectory:
    """Share of a straight piece (6,) over time, 0 to 1; the joint that needs longest sets the pace."""
    longest = np.maximum(np.abs(way), 1e-9)
    wanted = ruckig.InputParameter(1)
    wanted.current_position, wanted.target_position = [0.0], [1.0]
    wanted.max_velocity = [float(np.min(speeds / longest))]
    wanted.max_acceleration = [float(np.min(acceleration / longest))]
    wanted.max_jerk = [float(np.min(10.0 * acceleration / longest))]
    trajectory = ruckig.Trajectory(1)
    code = ruckig.Ruckig(1).calculate(wanted, trajectory)
    if code not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise ArmError(f"Ruckig found no timing for a move by {way.round(3)} rad: {code}")
    return trajectory
