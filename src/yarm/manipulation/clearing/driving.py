"""The youBot's base along a way and exactly to its end: speeds from where it is, so that slip is made up for."""

from __future__ import annotations

import math
from typing import List, Sequence

import numpy as np

from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.manipulation.clearing.floor_space import TURN_M_PER_RAD

FASTEST_MPS, FASTEST_RADPS = 0.35, 0.7
GAIN_PER_S = 2.5
AHEAD_M = 0.08
"""The base is drawn to the point so far ahead of it on its way."""
STEP_M = 0.02
ARRIVED_M, ARRIVED_RAD = 0.004, math.radians(0.5)
SETTLED_S = 0.15
STUCK_S, STUCK_M = 8.0, 0.01


class Follower:
    """Drives one way. ``step`` once for every new pose."""

    def __init__(self, way: Sequence[Pose2]) -> None:
        """Begin.

        Args:
            way: poses from one to the next of which the base may go straight; the first is where it is.
        """
        self._points = _dense(way)
        self._at = 0
        self._arrived_s = math.nan
        self._best, self._best_s = math.inf, math.nan
        self.reason = ""

    def step(self, pose: Pose2, now_s: float) -> FloatArray:
        """Velocity (3,): m/s ahead and to the left, rad/s."""
        while self._at < len(self._points) - 1 and _far(pose, self._points[self._at]) < AHEAD_M:
            self._at += 1
        goal = self._points[self._at]
        turn = wrap_angle(goal.yaw_rad - pose.yaw_rad)
        local = pose.inverse().compose(goal)
        velocity = GAIN_PER_S * np.array((local.x, local.y, turn))
        speed = math.hypot(velocity[0], velocity[1])
        share = min(1.0, FASTEST_MPS / max(speed, 1e-9), FASTEST_RADPS / max(abs(velocity[2]), 1e-9))
        self._note(pose, now_s)
        return np.asarray(share * velocity)

    def done(self, now_s: float) -> bool:
        """Whether the base stands at the end of its way."""
        return now_s - self._arrived_s >= SETTLED_S

    def _note(self, pose: Pose2, now_s: float) -> None:
        end = self._points[-1]
        there = pose.distance(end) < ARRIVED_M and abs(wrap_angle(end.yaw_rad - pose.yaw_rad)) < ARRIVED_RAD
        if not (there and self._at == len(self._points) - 1):
            self._arrived_s = math.nan
        elif math.isnan(self._arrived_s):
            self._arrived_s = now_s
        left = len(self._points) - 1 - self._at + _far(pose, self._points[self._at])
        if left < self._best - STUCK_M:
            self._best, self._best_s = left, now_s
        elif not there and now_s - self._best_s > STUCK_S:
            self.reason = f"the base has not come on for {STUCK_S:g} s, {pose.distance(end):.2f} m from its stand"


def _far(a: Pose2, b: Pose2) -> float:
    return a.distance(b) + TURN_M_PER_RAD * abs(wrap_angle(a.yaw_rad - b.yaw_rad))


def _dense(way: Sequence[Pose2]) -> List[Pose2]:
    points = [way[0]]
    for a, b in zip(way[:-1], way[1:]):
        steps = max(1, math.ceil(_far(a, b) / STEP_M))
        points += [a.towards(b, step / steps) for step in range(1, steps + 1)]
    return points
