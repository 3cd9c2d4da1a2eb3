"""What wheels and gyro say of a motion: scale errors of the run, random errors, slips."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from yarm.geometry import Pose2, wrap_angle
from yarm.geometry.scans import Odometry


@dataclass(frozen=True)
class OdometryNoise:
    """Sizes of the errors.

    Attributes:
        scale: greatest error of distances and turns as a share; one draw of each a run.
        drift_rad_per_m: greatest drift of the heading; one draw a run.
        random_m: standard deviation of a metre's length; grows with the square root of the way.
        random_rad: standard deviation of a turn of one radian; grows with the square root of the turn.
        slip_m: standard deviation along x and y of a slip at a bump.
        slip_rad: standard deviation of its turn.
    """

    scale: float = 0.02
    drift_rad_per_m: float = 0.01
    random_m: float = 0.03
    random_rad: float = 0.02
    slip_m: float = 0.02
    slip_rad: float = math.radians(1.1)


TYPICAL = OdometryNoise()
EXACT = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class WheelOdometry:
    """Adds up what the wheels do; it knows nothing of walls, so it goes on where the robot does not."""

    def __init__(self, generator: np.random.Generator, noise: OdometryNoise) -> None:
        """Draw the errors of this run; the odometry frame is where the robot stands now."""
        self._generator = generator
        self._noise = noise
        self._scale_v, self._scale_w = 1.0 + generator.uniform(-noise.scale, noise.scale, 2)
        self._drift = float(generator.uniform(-noise.drift_rad_per_m, noise.drift_rad_per_m))
        self.now = Odometry(0.0, Pose2(0.0, 0.0))

    def roll(self, v_mps: float, w_radps: float, dt_s: float, stamp_s: float) -> None:
        """The wheels turned at these speeds for a time that ends at the stamp.

        What is said of the speeds has their scale's error only: the random errors belong to the way.
        """
        way, turn = v_mps * dt_s, w_radps * dt_s
        draw = self._generator.standard_normal(2)
        measured_way = way * self._scale_v + self._noise.random_m * math.sqrt(abs(way)) * draw[0]
        measured_turn = (
            turn * self._scale_w + self._drift * abs(way) + self._noise.random_rad * math.sqrt(abs(turn)) * draw[1]
        )
        middle = self.now.pose.yaw_rad + 0.5 * measured_turn
        pose = Pose2(
            float(self.now.pose.x + measured_way * math.cos(middle)),
            float(self.now.pose.y + measured_way * math.sin(middle)),
            wrap_angle(float(self.now.pose.yaw_rad + measured_turn)),
        )
        self.now = Odometry(stamp_s, pose, float(v_mps * self._scale_v), float(w_radps * self._scale_w))

    def slip(self) -> None:
        """The robot was pushed aside and the wheels did not notice."""
        dx, dy, turn = self._generator.standard_normal(3) * (
            self._noise.slip_m,
            self._noise.slip_m,
            self._noise.slip_rad,
        )
        pose = self.now.pose.compose(Pose2(float(dx), float(dy), float(turn)))
        self.now = Odometry(self.now.stamp_s, pose, self.now.v_mps, self.now.w_radps)
