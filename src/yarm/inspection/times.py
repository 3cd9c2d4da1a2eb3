"""How long a drive takes: a model by length and turns, corrected by what drives have really taken."""

from __future__ import annotations

import math
import statistics
from typing import List

from yarm.geometry import Pose2, wrap_angle

SPEED_MPS, TURN_RADPS, START_S = 0.3, 0.8, 1.0
"""Of an undisturbed drive: along the way, turning in place, and from order to motion."""
PRIOR_RATIO, PRIOR_DRIVES = 1.5, 4
"""Before anything was driven a drive may take this many times as long; it counts as so many drives."""
TYPICAL_RATIO = 1.1
"""What a drive takes usually, before anything was driven."""
SHARE = 0.95
RECENT = 60
"""Drives that are remembered."""


class DriveTimes:
    """Predicts drives; learns from each how much longer than undisturbed they take."""

    def __init__(self) -> None:
        """Nothing driven yet."""
        self._ratios: List[float] = []

    @staticmethod
    def undisturbed_s(length_m: float, start: Pose2, goal: Pose2) -> float:
        """Time of a way of this length between two poses, turning towards it and at its end; inf without a way."""
        if not math.isfinite(length_m):
            return math.inf
        bearing = math.atan2(goal.y - start.y, goal.x - start.x)
        turns = abs(wrap_angle(bearing - start.yaw_rad)) + abs(wrap_angle(goal.yaw_rad - bearing))
        if length_m < 0.05:
            turns = abs(wrap_angle(goal.yaw_rad - start.yaw_rad))
        return START_S + length_m / SPEED_MPS + turns / TURN_RADPS

    def add(self, undisturbed_s: float, taken_s: float) -> None:
        """Note a drive that arrived."""
        if undisturbed_s > 0.0 and math.isfinite(undisturbed_s):
            self._ratios.append(taken_s / undisturbed_s)
            del self._ratios[:-RECENT]

    @property
    def ratio(self) -> float:
        """The 95th percentile of how much longer a drive takes; the prior counts as the first drives."""
        ratios = self._with_prior(PRIOR_RATIO)
        return ratios[min(math.ceil(SHARE * len(ratios)), len(ratios)) - 1]

    @property
    def typical(self) -> float:
        """The same for a drive among many: the median."""
        return statistics.median(self._with_prior(TYPICAL_RATIO))

    def _with_prior(self, prior: float) -> List[float]:
        return sorted([*self._ratios, *[prior] * max(PRIOR_DRIVES - len(self._ratios), 0)])

    def late_s(self, undisturbed_s: float) -> float:
        """What a drive hardly ever exceeds."""
        return undisturbed_s * self.ratio
