"""What the explorer hears, checked and turned into an observation; whoever sends what cannot be used is named."""

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

from yarm.exploration.model import LowView, Observation
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.msg import BumperEvent as BumperMessage
from yarm.msg import StepAck
from yarm.navigation.grid_map import GridMap
from yarm.navigation.low_obstacles import low_obstacles
from yarm.robots.turtlebot import BumperEvent
from yarm.ros.common import names
from yarm.ros.common.checks import present_s
from yarm.ros.common.readings import image_fault, listen, read_bumper, read_odometry, read_scan
from yarm.ros.exploration.frames import Frames
from yarm.ros.exploration.params import ExplorerParams
from yarm.ros.navigation.maps import grid_fault, grid_of

MAP_DELAY_S = 0.5
"""In lock-step a map counts from so long after its stamp, so that it counts from the same pass in every run, s."""


class ExplorerInputs:
    """Subscribes to all of it. Thread-safe."""

    def __init__(self, params: ExplorerParams) -> None:
        """Listen from now on."""
        self._params = params
        self._changed = threading.Condition()
        self._frames = Frames()
        self.forget()
        self._subscribers = [
            listen(names.SCAN, LaserScan, self._on_scan, 10),
            listen(names.ODOM, OdometryMessage, self._on_odometry, 10),
            listen(names.BUMPER, BumperMessage, self._on_bumper, 10),
            listen(names.MAP, OccupancyGrid, self._on_map, 1),
        ]
        self._answered: Set[str] = set()
        if params.sync:
            self._subscribers.append(listen(names.STEP_ACK, StepAck, self._on_ack, 100))
        if params.low_obstacles:
            self._subscribers.append(listen(names.DEPTH_IMAGE, Image, self._on_image, 1))

    def forget(self) -> None:
        """Time went backwards: nothing has been heard yet."""
        with self._changed:
            self._scan: Optional[Scan] = None
            self._odometry: Optional[Odometry] = None
            self._bumps: List[BumperEvent] = []
            self._map: Optional[GridMap] = None
            self._map_count = 0
            self._maps: Deque[Tuple[float, GridMap]] = deque()
            self._low: Optional[LowView] = None
        self._frames.forget()

    def together(self) -> bool:
        """Lock-step: everybody the first pass waits for is connected and has said so."""
        return set(self._params.waits_for) <= self._answered

    def observe(self, now_s: float) -> Observation:
        """Everything that is known at a pass of the loop; bumps and low obstacles are handed out once."""
        with self._changed:
            if self._params.sync:
                self._wait_for_all_of(now_s)
            self._take_maps(now_s)
            bumps, self._bumps = tuple(self._bumps), []
            low, self._low = self._low, None
            return Observation(
                now_s,
                self._odometry,
                self._map_from_odom(now_s),
                self._scan,
                bumps,
                self._map,
                self._map_count,
                low,
            )

    def _wait_for_all_of(self, now_s: float) -> None:
        """What was measured at this moment may still be on its way."""
        end = time.monotonic() + self._params.sync_wait
        while time.monotonic() < end:
            link = self._frames.link(self._params.odom_frame)
            measured = [self._scan, self._odometry, link, *([self._low] if self._params.low_obstacles else [])]
            if all(reading is not None and reading.stamp_s >= now_s - 1e-6 for reading in measured):
                return
            self._changed.wait(0.005)

    def _take_maps(self, now_s: float) -> None:
        """The newest map that counts at this moment."""
        while self._maps and (not self._params.sync or self._maps[0][0] + MAP_DELAY_S <= now_s + 1e-6):
            self._map, self._map_count = self._maps.popleft()[1], self._map_count + 1

    def _map_from_odom(self, now_s: float) -> Optional[Pose2]:
        """The newest, unless it is too old or is not given in the map's frame."""
        link = self._frames.link(self._params.odom_frame)
        if link is None or link.parent != self._params.map_frame:
            return None
        return link.pose if now_s - link.stamp_s <= self._params.transform_tolerance else None

    def _on_scan(self, message: LaserScan) -> str:
        with self._changed:
            before_s = -math.inf if self._scan is None else self._scan.stamp_s
            now_s = present_s(self._params.sync)
            reading, fault = read_scan(message, self._frames, self._params.base_frame, now_s, before_s)
            if reading is not None:
                self._scan = reading
                self._changed.notify_all()
        return fault

    def _on_odometry(self, message: OdometryMessage) -> str:
        with self._changed:
            before_s = -math.inf if self._odometry is None else self._odometry.stamp_s
            reading, fault = read_odometry(message, present_s(self._params.sync), before_s)
            if reading is not None:
                self._odometry = reading
                self._changed.notify_all()
        return fault

    def _on_bumper(self, message: BumperMessage) -> str:
        event, fault = read_bumper(message)
        if event is not None:
            with self._changed:
                self._bumps.append(event)
        return fault

    def _on_ack(self, message: StepAck) -> str:
        self._answered.add(message.node)
        return ""

    def _on_map(self, message: OccupancyGrid) -> str:
        fault = grid_fault(message, self._params.map_frame)
        if not fault:
            grid = grid_of(message)
            with self._changed:
                self._maps.append((message.header.stamp.to_sec(), grid))
        return fault

    def _on_image(self, message: Image) -> str:
        fault = image_fault(message)
        if not fault:
            depth = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
            view = LowView(message.header.stamp.to_sec(), low_obstacles(depth))
            with self._changed:
                self._low = view
                self._changed.notify_all()
        return fault
