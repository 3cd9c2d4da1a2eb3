"""What a robot measures of its surroundings and of itself, in the plane: laser scans and odometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import BoolArray, FloatArray
from yarm.geometry.poses import Pose2, pairs

RangeArray = npt.NDArray[np.float32]
AT_BASE = Pose2(0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Scan:
    """One laser scan.

    Attributes:
        stamp_s: when, s.
        ranges: (n,) metres, beam 0 first; NaN, or out of [range_min_m, range_max_m], where nothing valid was seen.
        angle_min_rad: of beam 0 in the sensor's frame.
        angle_increment_rad: from one beam to the next; + = to the left.
        range_min_m: least range that means anything.
        range_max_m: greatest range that means anything.
        sensor: pose of the sensor on the robot's base.
    """

    stamp_s: float
    ranges: RangeArray
    angle_min_rad: float
    angle_increment_rad: float
    range_min_m: float
    range_max_m: float
    sensor: Pose2 = AT_BASE

    def angles(self) -> FloatArray:
        """(n,) bearing of each beam in the sensor's frame, rad."""
        return self.angle_min_rad + self.angle_increment_rad * np.arange(len(self.ranges), dtype=float)

    def valid(self) -> BoolArray:
        """(n,) which beams saw something within the sensor's limits."""
        with np.errstate(invalid="ignore"):
            inside: BoolArray = (self.ranges >= self.range_min_m) & (self.ranges <= self.range_max_m)
        return inside

    def points(self) -> FloatArray:
        """(m, 2) what the valid beams hit, in the robot's base frame, metres."""
        valid = self.valid()
        bearing = self.angles()[valid] + self.sensor.yaw_rad
        ranges = self.ranges[valid].astype(float)
        return pairs(self.sensor.x + ranges * np.cos(bearing), self.sensor.y + ranges * np.sin(bearing))


@dataclass(frozen=True)
class Odometry:
    """Where a robot believes to be by its wheels and gyro.

    Attributes:
        stamp_s: when, s.
        pose: base in the odometry frame.
        v_mps: speed ahead.
        w_radps: turning, + = left.
    """

    stamp_s: float
    pose: Pose2
    v_mps: float = 0.0
    w_radps: float = 0.0
