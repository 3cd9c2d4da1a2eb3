"""The map with what the scan cannot see: low obstacles from depth images, and what the robot has bumped into."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace
from typing import Deque, Optional, Set, Tuple

from yarm.exploration.model import LowView, Observation
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry
from yarm.navigation.grid_map import GridMap
from yarm.navigation.overlay import Overlay
from yarm.robots.turtlebot import Bumper, BumperEvent

PASSES_KEPT = 20
CALM_S = 1.0
"""A depth image counts from so long after the bumper was let go: who pushes tilts, and takes floor for bricks, s."""
MOST_LOW = 150
"""An image with more low places than this shows a floor that is tilted against the camera."""
SAME_MOMENT_S = 0.03
"""A scan this near in time to a depth image shows the same."""


class Surroundings:
    """Lays marks over every map; pure, one pass of the loop after the other."""

    def __init__(self) -> None:
        """No marks."""
        self._past: Deque[Odometry] = deque(maxlen=PASSES_KEPT)
        self._merged: Optional[GridMap] = None
        self._counts: Tuple[int, int] = (-1, -1)
        self._version = 0
        self._pressed: Set[Bumper] = set()
        self._touched_s = -math.inf
        self.forget()

    def forget(self) -> None:
        """The map frame is another one: every mark is void."""
        self._overlay = Overlay()
        self._counts = (-1, -1)

    def update(self, seen: Observation, bumps: Tuple[BumperEvent, ...]) -> Observation:
        """The observation with its marks in the map, and a count that grows whenever either changes.

        Args:
            seen: all that is known, the map as the mapping gives it.
            bumps: changes of the bumper that can be believed.
        """
        if seen.odometry is not None and (not self._past or seen.odometry.stamp_s > self._past[-1].stamp_s):
            self._past.append(seen.odometry)
        if seen.map is None or seen.pose is None:
            return seen
        self._mark(seen, bumps)
        counts = (seen.map_count, self._overlay.count)
        if counts != self._counts:
            self._counts, self._version = counts, self._version + 1
            self._merged = self._overlay.over(seen.map)
        return replace(seen, map=self._merged, map_count=self._version)

    def _mark(self, seen: Observation, bumps: Tuple[BumperEvent, ...]) -> None:
        assert seen.pose is not None and seen.map_from_odom is not None
        self._feel(seen.now_s, bumps)
        if seen.low is not None and self._level(seen.low):
            scan = seen.scan
            if scan is not None and abs(scan.stamp_s - seen.low.stamp_s) > SAME_MOMENT_S:
                scan = None
            odometry = self._odometry_at(seen.low.stamp_s)
            self._overlay.see(seen.map_from_odom.compose(odometry), seen.low.points, scan)
        for event in bumps:
            if event.pressed:
                self._overlay.bump(seen.pose, event.bumper, seen.map)

    def _feel(self, now_s: float, bumps: Tuple[BumperEvent, ...]) -> None:
        """When the bumper was pressed last."""
        for event in bumps:
            (self._pressed.add if event.pressed else self._pressed.discard)(event.bumper)
        if self._pressed or bumps:
            self._touched_s = now_s

    def _level(self, low: LowView) -> bool:
        """Whether the camera looks level, as far as one can tell."""
        return low.stamp_s - self._touched_s >= CALM_S and len(low.points) <= MOST_LOW

    def _odometry_at(self, stamp_s: float) -> Pose2:
        """Odometry's pose at a moment, between those of two passes."""
        after = self._past[-1]
        for before in reversed(self._past):
            if before.stamp_s <= stamp_s:
                return _between(before, after, stamp_s)
            after = before
        return after.pose


def _between(before: Odometry, after: Odometry, stamp_s: float) -> Pose2:
    span_s = after.stamp_s - before.stamp_s
    if span_s <= 0.0 or stamp_s >= after.stamp_s:
        return after.pose
    return before.pose.towards(after.pose, (stamp_s - before.stamp_s) / span_s)
