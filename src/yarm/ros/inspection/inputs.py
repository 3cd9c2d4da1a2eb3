"""What the inspector hears, turned into what its session senses."""

from __future__ import annotations

import math
import time
from collections import deque
from typing import Deque, Dict, Optional, Sequence

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import Image

from yarm.inspection.boxes import Box, extent_of, outside
from yarm.inspection.place_word import PlaceWord
from yarm.inspection.senses import PLACE_AGE_S, Picture, Senses
from yarm.navigation.grid_map import GridMap
from yarm.ros.common import names
from yarm.ros.common.checks import pose_fault
from yarm.ros.common.readings import listen
from yarm.ros.common.robot_inputs import RobotInputs
from yarm.ros.inspection.images import take_camera_picture
from yarm.ros.inspection.navigation_link import NavigationLink
from yarm.ros.inspection.params import InspectorParams
from yarm.tags.picture_watch import SILENT_S, PictureWatch

PICTURE_DELAY_S = 0.1
"""In lock-step a picture counts from so long after its stamp, so that it counts at the same pass in every run, s."""
MOST_PICTURES = 20
CAMERA_WAIT_S = 10.0
"""Wall time that the first pass of the lock-step waits for a picture when all else has been heard, s."""


class InspectorInputs(RobotInputs):
    """Everything of the robot, its camera, the localisation's word, and how the goal stands. Thread-safe."""

    def __init__(self, params: InspectorParams, navigation: NavigationLink, boxes: Sequence[Box]) -> None:
        """Listen from now on.

        Args:
            params: of the node.
            navigation: says how the goal stands.
            boxes: must lie in the map.
        """
        self._params, self._navigation, self._boxes = params, navigation, boxes
        self._map_fault = "none has come"
        self._pictured, self._word = False, PlaceWord()
        self._heard_wall = math.inf
        super().__init__(params)
        self._subscribers += [
            listen(names.AMCL_STATE, DiagnosticArray, self._on_state, 10),
            listen(names.RGB_IMAGE, Image, self._on_image, 1),
        ]
        if not params.sync:
            self._subscribers.append(listen(names.AMCL_POSE, PoseWithCovarianceStamped, self._on_pose, 10))

    def forget(self) -> None:
        """Time went backwards: of what moves nothing is known."""
        super().forget()
        with self._changed:
            self._word.forget()
            self._state_s, self._placed, self._picture_s = -math.inf, False, -math.inf
            self._pictures: Deque[Image] = deque(maxlen=MOST_PICTURES)
            self._camera = PictureWatch()

    def together(self) -> bool:
        """Lock-step: everybody whose word the first pass has to know of has been heard since the node began.

        A camera that says nothing holds nobody up for ever.
        """
        if not (self._word.said and self._map is not None and self._navigation.heard() and super().together()):
            return False
        self._heard_wall = min(self._heard_wall, time.monotonic())
        return self._pictured or time.monotonic() - self._heard_wall > CAMERA_WAIT_S

    @property
    def map(self) -> Optional[GridMap]:
        """The newest."""
        return self._map

    @property
    def map_count(self) -> int:
        """Grows with every map."""
        return self._map_count

    def observe(self, now_s: float) -> Senses:
        """Everything that is known at a pass; a picture is handed out once."""
        with self._changed:
            self._wait_for_all_of(now_s)
            link = self._frames.link(self._params.odom_frame)
            placed = link is not None and link.parent == self._params.map_frame
            return Senses(
                now_s,
                self._scan,
                self._odometry,
                link.pose if link is not None and placed else None,
                self._place_s(),
                *self._word.at(now_s),
                self._picture(now_s),
                self._camera.fault(now_s),
                self._navigation.outcome(now_s),
                self._navigation.gone(now_s),
                self._map_fault,
            )

    def _stamps(self, now_s: float) -> Dict[str, float]:
        """The picture that counts now and the localisation's word on the scan too, unless they have fallen silent.

        The place is waited for when the localisation has given one.
        """
        stamps = super()._stamps(now_s)
        if now_s - self._picture_s <= SILENT_S:
            stamps["picture"] = self._picture_s + PICTURE_DELAY_S
        if now_s - self._state_s <= PLACE_AGE_S:
            stamps["word of the localisation"] = self._state_s
            if self._placed:
                stamps["transform map -> odom"] = self._place_s()
        return stamps

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

    def _take_map(self, message: OccupancyGrid, grid: GridMap) -> None:
        super()._take_map(message, grid)
        lost = [f"box {b.number} at ({b.pose.x:g}, {b.pose.y:g})" for b in outside(self._boxes, grid)]
        self._map_fault = f"{', '.join(lost)} outside of it, {extent_of(grid)}" if lost else ""

    def _on_state(self, message: DiagnosticArray) -> str:
        if len(message.status) != 1:
            return f"{len(message.status)} states, expected one"
        state = message.status[0]
        with self._changed:
            self._word.say(state.level == DiagnosticStatus.OK, str(state.message))
            self._state_s, self._placed = message.header.stamp.to_sec(), bool(message.header.frame_id)
            self._changed.notify_all()
        return ""

    def _on_pose(self, message: PoseWithCovarianceStamped) -> str:
        """All that the platform's own AMCL says; in lock-step, where each scan must be answered, it does not count."""
        frame = message.header.frame_id.lstrip("/")
        if frame != self._params.map_frame:
            return f"its frame is {frame!r}, expected {self._params.map_frame!r}"
        fault = pose_fault(message.pose.pose)
        if fault:
            return fault
        with self._changed:
            return self._word.pose(message.pose.covariance, rospy.get_time())

    def _on_image(self, message: Image) -> str:
        with self._changed:
            self._pictures.append(message)
            self._pictured, self._picture_s = True, message.header.stamp.to_sec()
            self._changed.notify_all()
        return ""
