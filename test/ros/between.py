"""What stands between the simulated room's sensors and those who listen to them: silence, and somebody in the way."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from yarm.geometry import Pose2
from yarm.robots.turtlebot import DEPTH_CAMERA
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose

PERSON_RADIUS_M = 0.15
QUEUE = 100


class Between:
    """Passes messages of a topic on; rooms are launched with the first name, everybody else listens to the second.

    Attributes:
        silent: nothing is passed on.
    """

    def __init__(self, from_topic: str, to_topic: str, kind: type) -> None:
        """Pass everything on from now on."""
        self.silent = False
        self._out = rospy.Publisher(to_topic, kind, queue_size=QUEUE, tcp_nodelay=True)
        self._in = rospy.Subscriber(from_topic, kind, self._take, queue_size=QUEUE, tcp_nodelay=True)

    def changed(self, message: Any) -> Any:
        """What is passed on in place of a message."""
        return message

    def _take(self, message: Any) -> None:
        if not self.silent:
            self._out.publish(self.changed(message))


class ScanBetween(Between):
    """The scan, into which somebody may have stepped.

    Attributes:
        person: (x, y) in the world, metres, of somebody who stands there; None when nobody does.
    """

    def __init__(self, from_topic: str, to_topic: str) -> None:
        """Nobody there."""
        self.person: Optional[np.ndarray] = None
        self._truth: Optional[Pose2] = None
        self._pose = rospy.Subscriber(names.SIM_POSE, Odometry, self._on_truth, queue_size=QUEUE, tcp_nodelay=True)
        super().__init__(from_topic, to_topic, LaserScan)

    def changed(self, message: LaserScan) -> LaserScan:
        """The scan as it is with the person."""
        if self.person is None or self._truth is None:
            return message
        sensor = self._truth.compose(DEPTH_CAMERA)
        angles = sensor.yaw_rad + message.angle_min + message.angle_increment * np.arange(len(message.ranges))
        away = self.person - (sensor.x, sensor.y)
        along = away[0] * np.cos(angles) + away[1] * np.sin(angles)
        inside = PERSON_RADIUS_M**2 - (away @ away - along**2)
        met = np.where((inside > 0.0) & (along > 0.0), along - np.sqrt(np.maximum(inside, 0.0)), np.inf)
        ranges = np.fmin(np.asarray(message.ranges), met)
        ranges[ranges < message.range_min] = np.nan
        kept = {name: getattr(message, name) for name in message.__slots__}
        return LaserScan(**{**kept, "ranges": ranges.tolist()})

    def _on_truth(self, message: Odometry) -> None:
        self._truth = pose2_of_pose(message.pose.pose)
