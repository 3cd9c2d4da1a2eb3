"""What the explorer hears, turned into an observation."""

from __future__ import annotations

import math
from collections import deque
from typing import Deque, Dict, Optional, Tuple

from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import OccupancyGrid

from yarm.exploration.model import LowView, Observation
from yarm.exploration.watch import Complaint
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.ros.common import names
from yarm.ros.common.readings import listen
from yarm.ros.common.robot_inputs import CAMERA_REMEDY, RobotInputs
from yarm.ros.exploration.params import ExplorerParams

MAP_DELAY_S = 0.5
"""In lock-step a map counts from so long after its stamp, so that it counts from the same pass in every run, s."""
MAP_STAMP = "map stamp, ns"
"""What ``slam_gmapping/state`` calls the stamp of the newest map; 0 before the first."""


class ExplorerInputs(RobotInputs):
    """Everything of the robot, and the map that grows. Thread-safe."""

    def __init__(self, params: ExplorerParams) -> None:
        """Listen from now on."""
        self._params = params
        self._waits_for_map = params.sync and params.wait_for_map
        self._told = False
        super().__init__(params, bumper=True, low=params.low_obstacles)
        if self._waits_for_map:
            self._subscribers.append(listen(names.SLAM_STATE, DiagnosticArray, self._on_state, 10))

    def forget(self) -> None:
        """Time went backwards: nothing has been heard yet, and no map is known."""
        super().forget()
        with self._changed:
            self._map = None
            self._map_count = 0
            self._maps: Deque[Tuple[float, GridMap]] = deque()
            self._newest_map_ns = 0
            self._state: Tuple[float, int] = (-math.inf, 0)

    def together(self) -> bool:
        """Lock-step: everybody whose word the first pass has to know of has been heard since the node began."""
        return (self._told or not self._waits_for_map) and super().together()

    def observe(self, now_s: float) -> Observation:
        """Everything that is known at a pass of the loop; bumps and low obstacles are handed out once."""
        with self._changed:
            self._wait_for_all_of(now_s)
            self._count_maps(now_s)
            low = self._take_low()
            return Observation(
                now_s,
                self._odometry,
                self._map_from_odom(now_s),
                self._scan,
                self._take_bumps(),
                self._map,
                self._map_count,
                None if low is None else LowView(*low),
            )

    def complaints(self) -> Tuple[Complaint, ...]:
        """What is left out though the run goes on without it."""
        with self._changed:
            if self._other_camera is None:
                return ()
            since_s, fault = self._other_camera
        return (Complaint("depth camera", since_s, f"{fault}, its images left out", CAMERA_REMEDY, stands=False),)

    def _stamps(self, now_s: float) -> Dict[str, float]:
        """Transform and depth image too, and the mapping's word on the scan, once the map that it names has come."""
        stamps = {**super()._stamps(now_s), "transform map -> odom": self._place_s()}
        if self._params.low_obstacles and self._other_camera is None:
            stamps["depth image"] = -math.inf if self._low is None else self._low[0]
        if self._waits_for_map:
            scan_s, map_ns = self._state
            stamps["word of slam_gmapping, or map,"] = scan_s if self._newest_map_ns >= map_ns else -math.inf
        return stamps

    def _take_map(self, message: OccupancyGrid, grid: GridMap) -> None:
        self._maps.append((message.header.stamp.to_sec(), grid))
        self._newest_map_ns = message.header.stamp.to_nsec()
        self._changed.notify_all()

    def _on_state(self, message: DiagnosticArray) -> str:
        stamps = [pair.value for status in message.status for pair in status.values if pair.key == MAP_STAMP]
        if len(stamps) != 1 or not stamps[0].isdecimal():
            return f"{MAP_STAMP!r} is {stamps}, one whole number is expected"
        with self._changed:
            self._state, self._told = (message.header.stamp.to_sec(), int(stamps[0])), True
            self._changed.notify_all()
        return ""

    def _count_maps(self, now_s: float) -> None:
        """The newest map that counts at this moment."""
        while self._maps and (not self._params.sync or self._maps[0][0] + MAP_DELAY_S <= now_s + 1e-6):
            self._map, self._map_count = self._maps.popleft()[1], self._map_count + 1

    def _map_from_odom(self, now_s: float) -> Optional[Pose2]:
        """The newest, unless it is too old or is not given in the map's frame."""
        link = self._frames.link(self._params.odom_frame)
        if link is None or link.parent != self._params.map_frame:
            return None
        return link.pose if now_s - link.stamp_s <= self._params.transform_tolerance else None
