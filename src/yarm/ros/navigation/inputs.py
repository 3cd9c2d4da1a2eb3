"""What move_base hears, checked and turned into an observation; whoever sends what cannot be used is named."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from typing import Deque, List, Optional, Set, Tuple

import numpy as np
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import Image, LaserScan

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.msg import BumperEvent as BumperMessage
from yarm.msg import StepAck
from yarm.navigation.grid_map import GridMap
from yarm.navigation.low_obstacles import low_obstacles
from yarm.navigation.move_base import Observation
from yarm.robots.turtlebot import BumperEvent
from yarm.ros.common import names
from yarm.ros.common.checks import present_s
from yarm.ros.common.readings import image_fault, listen, read_bumper, read_odometry, read_scan
from yarm.ros.exploration.frames import Frames
from yarm.ros.navigation.maps import grid_fault, grid_of
from yarm.ros.navigation.params import MoveBaseNodeParams

KEPT = 100
"""Odometry that is remembered, to place a scan where the robot was when it was taken."""


class MoveBaseInputs:
    """Subscribes to all of it. Thread-safe."""

    def __init__(self, params: MoveBaseNodeParams) -> None:
        """Listen from now on."""
        self._params = params
        self._changed = threading.Condition()
        self._frames = Frames()
        self._answered: Set[str] = set()
        self._map: Optional[GridMap] = None
        self._map_count = 0
        self.forget()
        self._subscribers = [
            listen(names.SCAN, LaserScan, self._on_scan, 10),
            listen(names.ODOM, OdometryMessage, self._on_odometry, 10),
            listen(names.BUMPER, BumperMessage, self._on_bumper, 10),
            listen(names.MAP, OccupancyGrid, self._on_map, 1),
        ]
        if params.sync:
            self._subscribers.append(listen(names.STEP_ACK, StepAck, self._on_ack, 100))
        if params.low_obstacles:
            self._subscribers.append(listen(names.DEPTH_IMAGE, Image, self._on_image, 1))

    def forget(self) -> None:
        """Time went backwards: nothing has been measured yet. The map stays: who serves it says it once."""
        with self._changed:
            self._scans: Deque[Scan] = deque(maxlen=5)
            self._past: Deque[Odometry] = deque(maxlen=KEPT)
            self._bumps: List[BumperEvent] = []
            self._low: Optional[FloatArray] = None
        self._frames.forget()

    def together(self) -> bool:
        """Lock-step: everybody the first pass waits for is connected and has said so."""
        return set(self._params.waits_for) <= self._answered

    def observe(self, now_s: float) -> Observation:
        """Everything that is known now; bumps and low obstacles are handed out once."""
        with self._changed:
            if self._params.sync:
                self._wait_for_all_of(now_s)
            bumps, self._bumps = tuple(self._bumps), []
            low, self._low = self._low, None
            placed, fault = self._place(now_s)
            scan = self._scan_with_odometry()
            scan_pose = None
            if placed is not None and scan is not None:
                scan_pose = placed.compose(self._odometry_at(scan.stamp_s))
            odometry = None if placed is None else self._past[-1].pose
            pose = None if placed is None or odometry is None else placed.compose(odometry)
            return Observation(now_s, pose, fault, scan, scan_pose, self._map, self._map_count, low, bumps, odometry)

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
            ("odometry", self._stamp()),
        ):
            if now_s - stamp_s > p.transform_tolerance:
                return None, f"the newest {what} is {now_s - stamp_s:.2f} s old, at most {p.transform_tolerance:g} s"
        return link.pose, ""

    def _stamp(self) -> float:
        return self._past[-1].stamp_s if self._past else -math.inf

    def _scan_with_odometry(self) -> Optional[Scan]:
        """The newest scan that is not newer than the odometry."""
        known = [scan for scan in self._scans if scan.stamp_s <= self._stamp() + 1e-6]
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

    def _wait_for_all_of(self, now_s: float) -> None:
        """What was measured at this moment may still be on its way; a place too, while the localisation gives one."""
        end = time.monotonic() + self._params.sync_wait
        while time.monotonic() < end:
            link = self._frames.link(self._params.odom_frame)
            scan_s = self._scans[-1].stamp_s if self._scans else -math.inf
            stamps = [scan_s, self._stamp()]
            if link is not None and now_s - link.stamp_s <= self._params.transform_tolerance:
                stamps.append(link.stamp_s)
            if all(stamp_s >= now_s - 1e-6 for stamp_s in stamps):
                return
            self._changed.wait(0.005)

    def _on_scan(self, message: LaserScan) -> str:
        with self._changed:
            before_s = self._scans[-1].stamp_s if self._scans else -math.inf
            now_s = present_s(self._params.sync)
            scan, fault = read_scan(message, self._frames, self._params.base_frame, now_s, before_s)
            if scan is not None:
                self._scans.append(scan)
                self._changed.notify_all()
        return fault

    def _on_odometry(self, message: OdometryMessage) -> str:
        with self._changed:
            odometry, fault = read_odometry(message, present_s(self._params.sync), self._stamp())
            if odometry is not None:
                self._past.append(odometry)
                self._changed.notify_all()
        return fault

    def _on_bumper(self, message: BumperMessage) -> str:
        event, fault = read_bumper(message)
        if event is not None:
            with self._changed:
                self._bumps.append(event)
        return fault

    def _on_map(self, message: OccupancyGrid) -> str:
        fault = grid_fault(message, self._params.map_frame)
        if not fault:
            grid = grid_of(message)
            with self._changed:
                self._map, self._map_count = grid, self._map_count + 1
        return fault

    def _on_ack(self, message: StepAck) -> str:
        self._answered.add(message.node)
        return ""

    def _on_image(self, message: Image) -> str:
        fault = image_fault(message)
        if not fault:
            depth = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
            low = low_obstacles(depth)
            with self._changed:
                self._low = low
        return fault
