"""Backs off along the way a robot came: there was room, although nothing sees what is behind it."""

from __future__ import annotations

import math
from collections import deque
from typing import Deque, Optional

import numpy as np

from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.navigation.follower import Drive

STEP_M, KEPT_M = 0.05, 1.5
"""Between two remembered places, and how much of the way is remembered."""
JUMP_M = 0.30
"""A place farther than this from the one before was not driven to: what was remembered before counts no more."""
RETREAT_M = 0.40
"""So far back, along the way."""
REACHED_M = 0.04
BACK_MPS = 0.10
TURN_PER_S, MOST_RADPS = 1.5, 0.6
"""Rate of turning for each radian that the next place lies aside, 1/s, and at most."""
ASIDE_RAD = 0.4
"""A place farther aside is turned to first."""
RETREAT_S = 15.0
"""A retreat that takes longer has ended."""


class Trail:
    """Where the robot has been lately, map frame."""

    def __init__(self) -> None:
        """Nowhere yet."""
        self._points: Deque[FloatArray] = deque(maxlen=round(KEPT_M / STEP_M))

    def note(self, pose: Pose2) -> None:
        """The robot is here now."""
        here = np.array([pose.x, pose.y])
        gap_m = math.inf if not self._points else float(np.hypot(*(here - self._points[-1])))
        if gap_m >= JUMP_M:
            self._points.clear()
        if gap_m >= STEP_M:
            self._points.append(here)

    def back(self) -> FloatArray:
        """(n, 2) the way it came, the newest place first, metres; up to ``RETREAT_M`` of it, (0, 2) of none."""
        points = np.array(list(self._points)[::-1]).reshape(-1, 2)
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])[: len(points)]
        found: FloatArray = points[along <= RETREAT_M]
        return found

    def cut(self, count: int) -> None:
        """The newest so many places have been driven back over."""
        for _ in range(min(count, len(self._points))):
            self._points.pop()


class Retreat:
    """Drives over places in turn, backwards where they lie behind.

    Attributes:
        way: (n, 2) what is left, map frame, metres.
    """

    def __init__(self, way: FloatArray, now_s: float) -> None:
        """Begin at a moment."""
        self.way = way
        self._began_s = now_s

    def step(self, pose: Pose2, now_s: float) -> Optional[Drive]:
        """What to drive; None when the end is reached, or it has taken too long."""
        while len(self.way) and self._passed(pose):
            self.way = self.way[1:]
        if not len(self.way) or now_s - self._began_s > RETREAT_S:
            return None
        bearing = math.atan2(self.way[0, 1] - pose.y, self.way[0, 0] - pose.x)
        aside = wrap_angle(bearing - pose.yaw_rad)
        behind = abs(aside) > 0.5 * math.pi
        aside = wrap_angle(aside + math.pi) if behind else aside
        turn = max(-MOST_RADPS, min(MOST_RADPS, TURN_PER_S * aside))
        speed = 0.0 if abs(aside) > ASIDE_RAD else BACK_MPS
        return Drive(-speed if behind else speed, turn)

    def _passed(self, pose: Pose2) -> bool:
        """The next place is reached, or the one after it is nearer."""
        gaps = np.hypot(self.way[:2, 0] - pose.x, self.way[:2, 1] - pose.y)
        return bool(gaps[0] < REACHED_M or (len(gaps) > 1 and gaps[1] < gaps[0]))
