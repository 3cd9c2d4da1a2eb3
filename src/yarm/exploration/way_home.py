"""Back to where the run began: how much time the way needs, and driving it."""

from __future__ import annotations

import math
from typing import Optional

from yarm.exploration.model import Command, Intent, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.follower import FollowSettings, PathFollower, room_ahead
from yarm.navigation.planner import Field
from yarm.robots.turtlebot import RADIUS_M

ESTIMATE_S = 5.0
"""Between two estimates of the way back."""
SPARE_S = 15.0
"""For turns, and for what comes between."""
HALF_WIDTH_M = RADIUS_M + 0.03
ARRIVED_M = 0.10


class WayHome:
    """Plans on every new map, drives at the speeds the parameters allow."""

    def __init__(self, params: ExploreParams) -> None:
        """Nothing planned."""
        self._params = params
        self._follower = PathFollower(FollowSettings(params.max_speed, params.near_speed, params.near_distance))
        self._estimated_s = -math.inf
        self._needed_s = 0.0
        self._planned: Optional[int] = None
        self._field: Optional[Field] = None

    def must_leave(self, seen: Observation, start: Optional[Pose2], left_s: float) -> bool:
        """Whether the time left is only just what the way back needs; looked at every ``ESTIMATE_S``."""
        if seen.map is None or seen.pose is None or start is None:
            return False
        if seen.now_s - self._estimated_s >= ESTIMATE_S:
            self._estimated_s = seen.now_s
            field = Field(seen.map, seen.pose)
            cell = seen.map.cell_of(start.x, start.y)
            if field.reachable(cell):
                self._needed_s = float(field.length[cell]) / self._params.near_speed + SPARE_S
        return left_s <= self._needed_s + ESTIMATE_S

    def step(self, seen: Observation, start: Pose2) -> Step:
        """One pass on the way back; done when there, or when there is no way, which the reason then says."""
        if seen.map is None or seen.pose is None:
            return Step(reason="no map or no pose")
        if seen.pose.distance(start) <= ARRIVED_M:
            return Step(behaviour="return", done=True)
        if self._planned != seen.map_count or seen.jumped or self._field is None or len(self._follower.path) == 0:
            reason = self._plan(seen, start)
            if reason:
                return Step(behaviour="return", done=True, reason=reason)
        assert self._field is not None
        drive = self._follower.step(seen.pose, _ahead_m(seen.scan), self._field.sees)
        intent = Intent(start, self._follower.path)
        return Step(Command(drive.v_mps, drive.w_radps), "return", done=drive.arrived, intent=intent)

    def _plan(self, seen: Observation, start: Pose2) -> str:
        assert seen.map is not None and seen.pose is not None
        self._planned = seen.map_count
        self._field = Field(seen.map, seen.pose)
        path = self._field.path_to(seen.map.cell_of(start.x, start.y))
        if len(path) == 0:
            return self._field.reason or f"no way back to the start ({start.x:.2f}, {start.y:.2f}) in the map"
        self._follower.follow(path)
        return ""


def _ahead_m(scan: Optional[Scan]) -> float:
    return 0.0 if scan is None else room_ahead(scan.points(), HALF_WIDTH_M)
