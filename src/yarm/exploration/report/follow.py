"""Following the cells of a path as the report does: turn to a cell ahead, then drive and steer."""

from __future__ import annotations

import math
from typing import Optional

from yarm.exploration.model import Command
from yarm.exploration.report.params import ReportParams
from yarm.geometry import FloatArray, Pose2, wrap_angle


class CellFollower:
    """Follows (n, 2) points, metres, in the map."""

    def __init__(self, points: FloatArray, cell_m: float, params: ReportParams) -> None:
        """Begin at the first point."""
        self.points = points
        self._cell_m = cell_m
        self._params = params
        short = len(points) < params.follow_short
        self._to_go = len(points) - 1 if short else min(params.follow_to_go, len(points) - 1)
        self._tolerance = len(points) - 1 if short else min(params.follow_tolerance, len(points) - 1)
        self._turning = True

    def step(self, pose: Pose2) -> Optional[Command]:
        """What to drive from this pose of the base; None when the end is reached."""
        params = self._params
        if len(self.points) <= 1 or self._distance(pose, -1) <= params.follow_end:
            return None
        last = len(self.points) - 1
        if self._to_go < last and self._distance(pose, self._tolerance) <= params.follow_reach * self._cell_m:
            self._tolerance = min(self._tolerance + params.follow_advance, last)
            self._to_go = min(self._to_go + params.follow_advance, last)
        x, y = self.points[self._to_go]
        error = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.yaw_rad)
        if self._turning and abs(error) > params.follow_aligned:
            return Command(0.0, _clamped(params.follow_turn * error, params.angular_max))
        self._turning = False
        turn = _clamped(params.follow_gain * error, params.angular_max)
        return Command(params.follow_share * params.speed, turn)

    def _distance(self, pose: Pose2, index: int) -> float:
        x, y = self.points[index]
        return math.hypot(x - pose.x, y - pose.y)


def _clamped(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
