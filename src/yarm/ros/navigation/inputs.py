"""What move_base hears, turned into an observation."""

from __future__ import annotations

from typing import Dict, Optional, Tuple

from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.move_base import Observation
from yarm.ros.common.robot_inputs import RobotInputs
from yarm.ros.navigation.params import MoveBaseNodeParams

KEPT = 100
"""Odometry that is remembered, to place a scan where the robot was when it was taken."""


class MoveBaseInputs(RobotInputs):
    """Everything of the robot, each scan placed in the map. Thread-safe."""

    def __init__(self, params: MoveBaseNodeParams) -> None:
        """Listen from now on."""
        self._params = params
        super().__init__(params, KEPT, bumper=True, low=params.low_obstacles)

    def observe(self, now_s: float) -> Observation:
        """Everything that is known now; bumps and low obstacles are handed out once."""
        with self._changed:
            self._wait_for_all_of(now_s)
            bumps, low = self._take_bumps(), self._take_low()
            placed, fault = self._place(now_s)
            scan = self._scan_with_odometry()
            scan_pose = None
            if placed is not None and scan is not None:
                scan_pose = placed.compose(self._odometry_at(scan.stamp_s))
            odometry = None if placed is None else self._past[-1].pose
            pose = None if placed is None or odometry is None else placed.compose(odometry)
            points = None if low is None else low[1]
            return Observation(now_s, pose, fault, scan, scan_pose, self._map, self._map_count, points, bumps, odometry)

    def in_map(self, frame: str) -> Optional[Pose2]:
        """Pose of a frame in the map; None when no transforms lead there."""
        frame = frame.lstrip("/")
        found = self._frames.between(self._params.map_frame, frame)
        if found is None:
            above = self._frames.between(frame, self._params.map_frame)
            found = None if above is None else above.inverse()
        return found

    def _place(self, now_s: float) -> Tuple[Optional[Pose2], str]:
        """Odometry's frame in the map, or why the robot's place is not known."""
        p = self._params
        link = self._frames.link(p.odom_frame)
        if link is None or link.parent != p.map_frame:
            return None, f"no transform {p.map_frame} -> {p.odom_frame}; is the localisation running?"
        if not self._past:
            return None, "no odometry has come; is the base running?"
        for what, stamp_s in (
            (f"transform {p.map_frame} -> {p.odom_frame}", link.stamp_s),
            ("odometry", self._odometry_s()),
        ):
            if now_s - stamp_s > p.transform_tolerance:
                return None, f"the newest {what} is {now_s - stamp_s:.2f} s old, at most {p.transform_tolerance:g} s"
        return link.pose, ""

    def _scan_with_odometry(self) -> Optional[Scan]:
        """The newest scan that is not newer than the odometry."""
        known = [scan for scan in self._scans if scan.stamp_s <= self._odometry_s() + 1e-6]
        return known[-1] if known else None

    def _odometry_at(self, stamp_s: float) -> Pose2:
        """Odometry's pose at a moment, between the two messages around it."""
        after = self._past[-1]
        for before in reversed(self._past):
            if before.stamp_s <= stamp_s:
                span_s = after.stamp_s - before.stamp_s
                return before.pose.towards(after.pose, (stamp_s - before.stamp_s) / span_s if span_s > 0.0 else 0.0)
            after = before
        return after.pose

    def _stamps(self, now_s: float) -> Dict[str, float]:
        """A place too, while the localisation gives one."""
        place_s = self._place_s()
        fresh = now_s - place_s <= self._params.transform_tolerance
        return {**super()._stamps(now_s), **({"transform map -> odom": place_s} if fresh else {})}
