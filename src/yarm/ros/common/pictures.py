"""Markers of any frame, and pictures made of them: what is no longer true is deleted."""

from __future__ import annotations

from typing import Dict, List, Set, Tuple

import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from yarm.geometry import FloatArray
from yarm.ros.common import names

Color = Tuple[float, float, float, float]
WHITE: Color = (1.0, 1.0, 1.0, 1.0)
QUEUE = 2


def marker(space: str, kind: int, color: Color, scale: Tuple[float, float, float]) -> Marker:
    """A marker at the world's origin; scale in metres."""
    made = Marker(type=kind, action=Marker.ADD, ns=space, color=ColorRGBA(*color))
    made.header.frame_id = names.WORLD_FRAME
    made.pose.orientation.w = 1.0
    made.scale.x, made.scale.y, made.scale.z = scale
    return made


def points(xyz: FloatArray) -> List[Point]:
    """Point messages of (n, 3) metres."""
    return [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in xyz]


def text(space: str, words: str, at: Tuple[float, float, float], size_m: float) -> Marker:
    """White text that faces the camera."""
    made = marker(space, Marker.TEXT_VIEW_FACING, WHITE, (0.0, 0.0, size_m))
    made.text = words
    made.pose.position.x, made.pose.position.y, made.pose.position.z = at
    return made


class Picture:
    """The markers last sent on a topic, so that those no longer true can be deleted."""

    def __init__(self, topic: str, frame: str = names.WORLD_FRAME) -> None:
        """Advertise, latched.

        Args:
            topic: a MarkerArray.
            frame: of every marker that names no other than the world.
        """
        self._frame = frame
        self.publisher = rospy.Publisher(topic, MarkerArray, queue_size=QUEUE, latch=True)
        self._shown: Set[Tuple[str, int]] = set()

    def send(self, markers: List[Marker], stamp_s: float) -> None:
        """Send a whole picture; markers of one namespace are numbered in order."""
        counts: Dict[str, int] = {}
        for made in markers:
            if made.header.frame_id == names.WORLD_FRAME:
                made.header.frame_id = self._frame
                made.header.stamp = rospy.Time.from_sec(max(0.0, stamp_s))
            made.id = counts.get(made.ns, 0)
            counts[made.ns] = made.id + 1
        now = {(made.ns, made.id) for made in markers}
        gone = [Marker(ns=space, id=number, action=Marker.DELETE) for space, number in sorted(self._shown - now)]
        for made in gone:
            made.header.frame_id = self._frame
        self._shown = now
        self.publisher.publish(MarkerArray(markers=[*gone, *markers]))
