"""What the inspector hears, checked; whoever sends what cannot be used is named."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from typing import Deque, Optional, Set

from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import Image, LaserScan
from std_msgs.msg import Bool, String

from yarm.geometry.scans import Odometry, Scan
from yarm.inspection.senses import Picture, Senses
from yarm.msg import StepAck
from yarm.navigation.grid_map import GridMap
from yarm.ros.common import names
from yarm.ros.common.checks import present_s
from yarm.ros.common.readings import listen, read_odometry, read_scan
from yarm.ros.exploration.frames import Frames
from yarm.ros.inspection.images import take_camera_picture
from yarm.ros.inspection.navigation_link import NavigationLink
from yarm.ros.inspection.params import InspectorParams
from yarm.ros.navigation.maps import grid_fault, grid_of
from yarm.tags.picture_watch import PictureWatch

PICTURE_DELAY_S = 0.1
"""In lock-step a picture counts from so long after its stamp, so that it counts at the same pass in every run, s."""
MOST_PICTURES = 20


class InspectorInputs:
    """Subscribes to all of it. Thread-safe."""

    def __init__(self, params: InspectorParams, navigation: NavigationLink) -> None:
        """Listen from now on."""
        self._params, self._navigation = params, navigation
        self._changed = threading.Condition()
        self._frames = Frames()
        self._answered: Set[str] = set()
        self.map_count = 0
        """Grows with every map."""
        self.map: Optional[GridMap] = None
        self.forget()
        self._subscribers = [
            listen(names.SCAN, LaserScan, self._on_scan, 10),
            listen(names.ODOM, OdometryMessage, self._on_odometry, 10),
            listen(names.MAP, OccupancyGrid, self._on_map, 1),
            listen(names.AMCL_LOCALISED, Bool, self._on_localised, 10),
            listen(names.AMCL_REASON, String, self._on_reason, 10),
            listen(names.RGB_IMAGE, Image, self._on_image, 1),
        ]
        if params.waits_for:
            self._subscribers.append(listen(names.STEP_ACK, StepAck, self._on_ack, 100))

    def forget(self) -> None:
        """Time went backwards: of what moves nothing is known."""
        with self._changed:
            self._scan: Optional[Scan] = None
            self._odometry: Optional[Odometry] = None
            self._localised, self._place_fault = False, ""
            self._pictures: Deque[Image] = deque(maxlen=MOST_PICTURES)
            self._camera = PictureWatch()
        self._frames.forget()

    def together(self) -> bool:
        """Lock-step: everybody the first pass waits for is connected and has said so."""
        return set(self._params.waits_for) <= self._answered

    def observe(self, now_s: float) -> Senses:
        """Everything that is known at a pass; a picture is handed out once."""
        with self._changed:
            if self._params.sync:
                self._wait_for_all_of(now_s)
            link = self._frames.link(self._params.odom_frame)
            placed = link is not None and link.parent == self._params.map_frame
            return Senses(
                now_s,
                self._scan,
                self._odometry,
                link.pose if link is not None and placed else None,
                link.stamp_s if link is not None else -1.0,
                self._localised,
                self._place_fault,
                self._picture(now_s),
                self._camera.fault(now_s),
                self._navigation.outcome(now_s),
                self._navigation.gone(now_s),
                self.map is not None,
            )

    def _wait_for_all_of(self, now_s: float) -> None:
        """What was measured at this moment may still be on its way."""
        end = time.monotonic() + self._params.sync_wait
        while time.monotonic() < end:
            link = self._frames.link(self._params.odom_frame)
            stamps = [
                None if self._scan is None else self._scan.stamp_s,
                None if self._odometry is None else self._odometry.stamp_s,
            ]
            stamps += [None if link is None else link.stamp_s] if self._localised else []
            if all(stamp is not None and stamp >= now_s - 1e-6 for stamp in stamps):
                return
            self._changed.wait(0.005)

    def _picture(self, now_s: float) -> Optional[Picture]:
        """The newest that counts, if it can be used."""
        newest: Optional[Image] = None
        latest_s = now_s - PICTURE_DELAY_S + 1e-6 if self._params.sync else float("inf")
        while self._pictures and self._pictures[0].header.stamp.to_sec() <= latest_s:
            newest = self._pictures.popleft()
        if newest is None:
            return None
        grey, fault = take_camera_picture(newest)
        stamp_s = newest.header.stamp.to_sec()
        if fault:
            self._camera.refuse(fault, now_s)
            return None
        return None if self._camera.take(stamp_s, grey, now_s) else Picture(stamp_s, grey)

    def _on_scan(self, message: LaserScan) -> str:
        with self._changed:
            before_s = -math.inf if self._scan is None else self._scan.stamp_s
            scan, fault = read_scan(message, self._frames, self._params.base_frame, self._present_s(), before_s)
            self._scan = scan or self._scan
            self._changed.notify_all()
        return fault

    def _on_odometry(self, message: OdometryMessage) -> str:
        with self._changed:
            before_s = -math.inf if self._odometry is None else self._odometry.stamp_s
            odometry, fault = read_odometry(message, self._present_s(), before_s)
            self._odometry = odometry or self._odometry
            self._changed.notify_all()
        return fault

    def _present_s(self) -> float:
        return present_s(self._params.sync)

    def _on_localised(self, message: Bool) -> str:
        with self._changed:
            self._localised = bool(message.data)
        return ""

    def _on_reason(self, message: String) -> str:
        with self._changed:
            self._place_fault = str(message.data)
        return ""

    def _on_map(self, message: OccupancyGrid) -> str:
        fault = grid_fault(message)
        if not fault:
            grid = grid_of(message)
            with self._changed:
                self.map, self.map_count = grid, self.map_count + 1
        return fault

    def _on_ack(self, message: StepAck) -> str:
        self._answered.add(message.node)
        return ""

    def _on_image(self, message: Image) -> str:
        with self._changed:
            self._pictures.append(message)
        return ""
