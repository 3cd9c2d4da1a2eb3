"""What every node that drives a TurtleBot hears; checked, and whoever sends what cannot be used is named."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from typing import Deque, Dict, FrozenSet, List, Optional, Protocol, Set, Tuple

import numpy as np
import rospy
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2

from yarm.geometry import FloatArray
from yarm.geometry.scans import Odometry, Scan
from yarm.msg import BumperEvent as BumperMessage
from yarm.msg import StepAck
from yarm.navigation.grid_map import GridMap
from yarm.navigation.low_obstacles import low_obstacles
from yarm.robots.turtlebot import Bumper, BumperEvent
from yarm.ros.common import names
from yarm.ros.common.checks import present_s
from yarm.ros.common.frames import Frames
from yarm.ros.common.readings import (
    camera_fault,
    image_fault,
    listen,
    read_bumper,
    read_odometry,
    read_pressed,
    read_scan,
)
from yarm.ros.navigation.maps import grid_fault, grid_of

LOOK_AGAIN_S = 0.005
"""Wall time after which a pass that waits looks at the transforms again, s."""

CAMERA_REMEDY = "set the camera to the TurtleBot's resolution and calibration, or low_obstacles to false"
"""What to do about another depth camera."""


class InputParams(Protocol):
    """What the nodes' parameters have in common."""

    @property
    def base_frame(self) -> str:
        """The robot's frame."""

    @property
    def odom_frame(self) -> str:
        """Odometry's frame."""

    @property
    def map_frame(self) -> str:
        """The map's frame."""

    @property
    def sync(self) -> bool:
        """Lock-step."""

    @property
    def sync_wait(self) -> float:
        """Wall time a pass of the lock-step waits for what was measured at it, s."""

    @property
    def waits_for(self) -> Tuple[str, ...]:
        """Nodes that must have answered before the first pass of the lock-step."""


class RobotInputs:
    """Scan, odometry, map and transforms; bumper and low obstacles for who asks for them. Thread-safe.

    A node's own inputs extend it: they read under ``_changed`` what is kept here.
    """

    def __init__(self, params: InputParams, kept: int = 1, bumper: bool = False, low: bool = False) -> None:
        """Listen from now on.

        Args:
            params: of the node.
            kept: scans and odometry that are remembered.
            bumper: hear the bumper.
            low: look for low obstacles in the depth images.
        """
        self._shared, self._kept = params, kept
        self._changed = threading.Condition()
        self._frames = Frames()
        self._answered: Set[str] = set()
        self._map: Optional[GridMap] = None
        self._map_count = 0
        self._other_camera: Optional[Tuple[float, str]] = None
        self.forget()
        self._subscribers = [
            listen(names.SCAN, LaserScan, self._on_scan, 10),
            listen(names.ODOM, OdometryMessage, self._on_odometry, 10),
            listen(names.MAP, OccupancyGrid, self._on_map, 1),
        ]
        if bumper:
            self._subscribers.append(listen(names.BUMPER, BumperMessage, self._on_bumper, 10))
        if bumper and params.sync:
            self._subscribers.append(listen(names.BUMPER_CLOUD, PointCloud2, self._on_pressed, 10))
        if low:
            self._subscribers.append(listen(names.DEPTH_INFO, CameraInfo, self._on_depth_camera, 1))
            self._subscribers.append(listen(names.DEPTH_IMAGE, Image, self._on_depth_image, 1))
        if params.sync:
            self._subscribers.append(listen(names.STEP_ACK, StepAck, self._on_ack, 100))

    def forget(self) -> None:
        """Time went backwards: nothing has been measured yet. Map and camera stay: they may be told only once."""
        with self._changed:
            self._scans: Deque[Scan] = deque(maxlen=self._kept)
            self._past: Deque[Odometry] = deque(maxlen=self._kept)
            self._bumps: List[BumperEvent] = []
            self._pressed_s = -math.inf
            self._pressed: FrozenSet[Bumper] = frozenset()
            self._felt: Optional[FrozenSet[Bumper]] = None
            self._low: Optional[Tuple[float, FloatArray]] = None
            self._missed: List[str] = []
        self._frames.forget()

    def together(self) -> bool:
        """Lock-step: everybody the first pass waits for is connected and has said so."""
        return set(self._shared.waits_for) <= self._answered

    @property
    def _scan(self) -> Optional[Scan]:
        """The newest."""
        return self._scans[-1] if self._scans else None

    @property
    def _odometry(self) -> Optional[Odometry]:
        """The newest."""
        return self._past[-1] if self._past else None

    def _scan_s(self) -> float:
        """Stamp of the newest scan; -inf without one."""
        return self._scans[-1].stamp_s if self._scans else -math.inf

    def _odometry_s(self) -> float:
        """Stamp of the newest odometry; -inf without any."""
        return self._past[-1].stamp_s if self._past else -math.inf

    def _place_s(self) -> float:
        """Stamp of the newest transform of the odometry's frame; -inf without one."""
        link = self._frames.link(self._shared.odom_frame)
        return -math.inf if link is None else link.stamp_s

    def _take_bumps(self) -> Tuple[BumperEvent, ...]:
        """Changes of the bumper since the last call."""
        bumps, self._bumps = tuple(self._bumps), []
        return bumps

    def _take_low(self) -> Optional[Tuple[float, FloatArray]]:
        """Stamp, s, and (n, 2) low obstacles in the base frame, metres, of an image since the last call."""
        low, self._low = self._low, None
        return low

    def _stamps(self, now_s: float) -> Dict[str, float]:
        """Of everything that a pass of the lock-step waits for, by what it is."""
        stamps = {"scan": self._scan_s(), "odometry": self._odometry_s()}
        if self._felt is not None:
            stamps["bumper event"] = self._pressed_s if self._felt == self._pressed else -math.inf
        return stamps

    def _wait_for_all_of(self, now_s: float) -> None:
        """In lock-step: what was measured at this moment may still be on its way."""
        if not self._shared.sync:
            return
        end = time.monotonic() + self._shared.sync_wait
        late = self._late(now_s)
        while late and time.monotonic() < end:
            self._changed.wait(LOOK_AGAIN_S)
            late = self._late(now_s)
        if late and late != self._missed:
            rospy.logwarn(
                "lock-step at %.2f s: no %s of this moment within %g s of wall time; passes go on without, and this "
                "run may come out otherwise than another: is who says it alive? else raise sync_wait",
                now_s,
                " and no ".join(late),
                self._shared.sync_wait,
            )
        self._missed = late

    def _late(self, now_s: float) -> List[str]:
        """What has not come yet of all that a pass of the lock-step waits for."""
        return [what for what, stamp_s in self._stamps(now_s).items() if stamp_s < now_s - 1e-6]

    def _take_map(self, message: OccupancyGrid, grid: GridMap) -> None:
        """A map has come."""
        self._map, self._map_count = grid, self._map_count + 1

    def _on_scan(self, message: LaserScan) -> str:
        with self._changed:
            now_s = present_s(self._shared.sync)
            scan, fault = read_scan(message, self._frames, self._shared.base_frame, now_s, self._scan_s())
            if scan is not None:
                self._scans.append(scan)
                self._changed.notify_all()
        return fault

    def _on_odometry(self, message: OdometryMessage) -> str:
        with self._changed:
            odometry, fault = read_odometry(message, present_s(self._shared.sync), self._odometry_s())
            if odometry is not None:
                self._past.append(odometry)
                self._changed.notify_all()
        return fault

    def _on_bumper(self, message: BumperMessage) -> str:
        event, fault = read_bumper(message)
        if event is not None:
            with self._changed:
                self._bumps.append(event)
                if self._felt is not None:
                    self._felt = self._felt | {event.bumper} if event.pressed else self._felt - {event.bumper}
                    self._changed.notify_all()
        return fault

    def _on_pressed(self, message: PointCloud2) -> str:
        """Events bear no stamps: in lock-step the cloud tells whether all of them have come.

        What is pressed at first was never an event.
        """
        pressed, fault = read_pressed(message)
        if not fault:
            with self._changed:
                self._pressed, self._pressed_s = pressed, message.header.stamp.to_sec()
                self._felt = pressed if self._felt is None else self._felt
                self._changed.notify_all()
        return fault

    def _on_map(self, message: OccupancyGrid) -> str:
        fault = grid_fault(message, self._shared.map_frame)
        if not fault:
            grid = grid_of(message)
            with self._changed:
                self._take_map(message, grid)
        return fault

    def _on_ack(self, message: StepAck) -> str:
        self._answered.add(message.node)
        return ""

    def _on_depth_camera(self, message: CameraInfo) -> str:
        """The images of another camera are left out; one that says nothing of itself counts as the TurtleBot's."""
        fault = camera_fault(message)
        with self._changed:
            since_s = message.header.stamp.to_sec() if self._other_camera is None else self._other_camera[0]
            self._other_camera = (since_s, fault) if fault else None
            if fault:
                self._low = None
                self._changed.notify_all()
        return f"{fault}; its images are left out, {CAMERA_REMEDY}" if fault else ""

    def _on_depth_image(self, message: Image) -> str:
        fault = image_fault(message)
        if not fault:
            depth = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
            low = low_obstacles(depth)
            with self._changed:
                self._low = (message.header.stamp.to_sec(), low) if self._other_camera is None else None
                self._changed.notify_all()
        return fault
