"""Following a path on two wheels: turns in place at sharp bends, slows down near what is ahead."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2, wrap_angle

Sees = Callable[[FloatArray, FloatArray], bool]
"""Whether the robot can drive straight from one point (2,) to another, map frame."""


@dataclass(frozen=True)
class FollowSettings:
    """How a path is followed.

    Attributes:
        max_speed_mps: greatest speed.
        near_speed_mps: greatest speed when something is nearer than near_distance_m ahead.
        near_distance_m: see near_speed_mps.
        turn_radps: greatest rate of turning.
        gain_per_s: rate of turning per heading error.
        drive_below_rad: a standing robot turns in place until its heading error is below this.
        turn_above_rad: a driving robot stops and turns in place above this heading error.
        speed_up_mps2: how fast the speed may grow.
        slow_down_mps2: how fast the speed may shrink.
        turn_up_radps2: how fast the rate of turning may change.
        looks_m: how far ahead on the path it aims, the farthest first that it can drive to straight.
        arrive_m: a path's end is reached within this.
        arrive_rad: a final heading is reached within this.
        tick_s: time between two steps.
    """

    max_speed_mps: float = 0.3
    near_speed_mps: float = 0.15
    near_distance_m: float = 0.7
    turn_radps: float = 1.0
    gain_per_s: float = 2.5
    drive_below_rad: float = 0.20
    turn_above_rad: float = 0.60
    speed_up_mps2: float = 0.6
    slow_down_mps2: float = 1.5
    turn_up_radps2: float = 4.0
    looks_m: Tuple[float, ...] = (0.5, 0.3, 0.18, 0.1)
    arrive_m: float = 0.05
    arrive_rad: float = 0.06
    tick_s: float = 0.1


@dataclass(frozen=True)
class Drive:
    """What to do now.

    Attributes:
        v_mps: speed ahead.
        w_radps: turning, + = left.
        arrived: the path's end and the final heading are reached; both speeds are zero then.
        left_m: what is left of the path.
    """

    v_mps: float = 0.0
    w_radps: float = 0.0
    arrived: bool = False
    left_m: float = 0.0


class PathFollower:
    """Follows one path at a time; keeps the speeds it gave last, so that they change smoothly from path to path."""

    def __init__(self, settings: Optional[FollowSettings] = None) -> None:
        """A follower without a path."""
        self._settings = settings or FollowSettings()
        self._path: FloatArray = np.zeros((0, 2))
        self._along: FloatArray = np.zeros(0)
        self._yaw: Optional[float] = None
        self._done_m = 0.0
        self._turning = True
        self._ended = False
        self._v = 0.0
        self._w = 0.0

    @property
    def path(self) -> FloatArray:
        """(n, 2) the path that is followed, map frame, metres; (0, 2) without one."""
        return self._path

    @property
    def ahead(self) -> FloatArray:
        """(n, 2) the points of the path that are not passed yet; its end at least."""
        left = self._path[self._along > self._done_m]
        return left if len(left) else self._path[-1:]

    def follow(self, path: FloatArray, final_yaw_rad: Optional[float] = None) -> None:
        """Take a path (n, 2), map frame, metres, n >= 1, and the heading to turn to at its end, if any.

        Raises:
            ValueError: the path is empty.
        """
        if len(path) == 0:
            raise ValueError("an empty path cannot be followed")
        self._path = np.asarray(path, dtype=float)
        self._along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self._path, axis=0).T))])
        self._yaw, self._done_m, self._ended = final_yaw_rad, 0.0, False

    def stop(self) -> None:
        """Drop the path and forget the speeds: the robot stands."""
        self._path, self._along = np.zeros((0, 2)), np.zeros(0)
        self._v = self._w = 0.0
        self._turning = True

    def step(self, pose: Pose2, ahead_m: float, sees: Optional[Sees] = None, cap_mps: Optional[float] = None) -> Drive:
        """One tick.

        Args:
            pose: of the robot in the map.
            ahead_m: free way ahead of the robot along its heading.
            sees: whether a straight piece is free; without it the robot aims at most 0.1 m ahead.
            cap_mps: a limit of the speed for this tick.
        """
        if len(self._path) == 0:
            return self._give(0.0, 0.0, 0.0)
        here = np.array([pose.x, pose.y])
        self._done_m = self._project(here)
        left = float(self._along[-1]) - self._done_m
        to_end = float(np.hypot(*(self._path[-1] - here)))
        self._ended = self._ended or (left <= self._settings.arrive_m and to_end <= 2.0 * self._settings.arrive_m)
        if self._ended:
            return self._face(pose, left)
        aim = self._aim(here, sees)
        error = wrap_angle(math.atan2(aim[1] - here[1], aim[0] - here[0]) - pose.yaw_rad)
        return self._drive(error, left, ahead_m, cap_mps)

    def _face(self, pose: Pose2, left: float) -> Drive:
        error = 0.0 if self._yaw is None else wrap_angle(self._yaw - pose.yaw_rad)
        if abs(error) <= self._settings.arrive_rad:
            self.stop()
            return Drive(arrived=True, left_m=left)
        return self._give(0.0, self._rate(error), left)

    def _drive(self, error: float, left: float, ahead_m: float, cap_mps: Optional[float]) -> Drive:
        s = self._settings
        if abs(error) > s.turn_above_rad or (self._turning and abs(error) > s.drive_below_rad):
            self._turning = True
            return self._give(0.0, self._rate(error), left)
        self._turning = False
        speed = s.max_speed_mps if cap_mps is None else min(cap_mps, s.max_speed_mps)
        if ahead_m < s.near_distance_m + s.max_speed_mps * s.tick_s:
            speed = min(speed, s.near_speed_mps)
        speed *= max(1.0 - abs(error) / s.turn_above_rad, 0.1)
        speed = min(speed, max(1.5 * left, 0.04))
        return self._give(speed, self._rate(error), left)

    def _rate(self, error: float) -> float:
        """Rate of turning for a heading error: proportional, and never so fast that it could not stop in time."""
        s = self._settings
        most = min(s.turn_radps, math.sqrt(2.0 * 0.6 * s.turn_up_radps2 * abs(error)))
        rate = min(s.gain_per_s * abs(error), most)
        return math.copysign(max(rate, min(0.08, abs(error) / s.tick_s)), error)

    def _give(self, v: float, w: float, left: float) -> Drive:
        s = self._settings
        self._v = min(max(v, self._v - s.slow_down_mps2 * s.tick_s), self._v + s.speed_up_mps2 * s.tick_s)
        step = s.turn_up_radps2 * s.tick_s
        self._w = min(max(w, self._w - step), self._w + step)
        return Drive(self._v, self._w, False, left)

    def _project(self, here: FloatArray) -> float:
        """How far along the path the robot is: the nearest point not behind where it was, up to 0.6 m on."""
        if len(self._path) == 1:
            return 0.0
        a, b = self._path[:-1], self._path[1:]
        along = b - a
        length = np.maximum(np.diff(self._along), 1e-9)
        share = np.clip(np.einsum("ij,ij->i", here - a, along) / length**2, 0.0, 1.0)
        at = self._along[:-1] + share * length
        gap = np.hypot(*(a + share[:, None] * along - here).T)
        gap[(at < self._done_m - 0.05) | (at > self._done_m + 0.6)] += 10.0
        return max(float(at[int(np.argmin(gap))]), self._done_m)

    def _at(self, along_m: float) -> FloatArray:
        return np.array([np.interp(along_m, self._along, self._path[:, i]) for i in range(2)])

    def _aim(self, here: FloatArray, sees: Optional[Sees]) -> FloatArray:
        end = float(self._along[-1])
        nearest = self._settings.looks_m[-1]
        if sees is not None:
            for look in self._settings.looks_m[:-1]:
                aim = self._at(min(self._done_m + look, end))
                if sees(here, aim):
                    return aim
        aim = self._at(min(self._done_m + nearest, end))
        close: FloatArray = aim if np.hypot(*(aim - here)) > 1e-6 else self._path[-1]
        return close


def room_ahead(points: FloatArray, half_width_m: float, far_m: float = 10.0) -> float:
    """Distance ahead to the nearest of points (n, 2) of the base frame in the strip that the robot will sweep."""
    if len(points) == 0:
        return far_m
    ahead = points[(np.abs(points[:, 1]) <= half_width_m) & (points[:, 0] > 0.0), 0]
    return float(ahead.min()) if len(ahead) else far_m
