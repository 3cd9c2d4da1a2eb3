"""Where frames are in each other, in the plane, from ``/tf`` and ``/tf_static``."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass
from typing import Dict, Optional

import rospy
from tf2_msgs.msg import TFMessage

from yarm.geometry import Pose2
from yarm.ros.common.checks import Doorkeeper, transform_fault
from yarm.ros.common.conversions import pose2_of_transform

MOST_STEPS = 20


@dataclass(frozen=True)
class Link:
    """The newest transform of a frame.

    Attributes:
        parent: the frame it is given in.
        pose: of the frame in its parent.
        stamp_s: when; infinite for one that never changes.
    """

    parent: str
    pose: Pose2
    stamp_s: float


class Frames:
    """The newest transform of every frame. Thread-safe."""

    def __init__(self) -> None:
        """Subscribe."""
        self._lock = threading.Lock()
        self._links: Dict[str, Link] = {}
        self._door = Doorkeeper("/tf")
        self._subscribers = [
            rospy.Subscriber("/tf", TFMessage, self._on_moving, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber("/tf_static", TFMessage, self._on_fixed, queue_size=100),
        ]

    def link(self, frame: str) -> Optional[Link]:
        """The newest transform of a frame to its parent."""
        with self._lock:
            return self._links.get(frame)

    def between(self, base: str, frame: str) -> Optional[Pose2]:
        """Pose of a frame in another that is above it; None when it is not."""
        pose, at = Pose2(0.0, 0.0), frame
        with self._lock:
            for _ in range(MOST_STEPS):
                if at == base:
                    return pose
                link = self._links.get(at)
                if link is None:
                    return None
                pose, at = link.pose.compose(pose), link.parent
        return None

    def forget(self) -> None:
        """Time went backwards: what moves is not known any more."""
        with self._lock:
            self._links = {frame: link for frame, link in self._links.items() if link.stamp_s == math.inf}

    def _on_moving(self, message: TFMessage) -> None:
        self._take(message, fixed=False)

    def _on_fixed(self, message: TFMessage) -> None:
        self._take(message, fixed=True)

    def _take(self, message: TFMessage, fixed: bool) -> None:
        for transform in message.transforms:
            fault = transform_fault(transform, 0.0)
            if self._door.refuses(message, fault):
                continue
            frame = transform.child_frame_id.lstrip("/")
            stamp_s = math.inf if fixed else transform.header.stamp.to_sec()
            parent = transform.header.frame_id.lstrip("/")
            with self._lock:
                self._links[frame] = Link(parent, pose2_of_transform(transform.transform), stamp_s)
