"""Feeds a node that reads scans one moment of a recorded tour at a time, and hears what it says."""

from __future__ import annotations

import math
import threading
import time
from typing import Callable, Dict, List, Tuple

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from support import slam_log
from support.links import wait_until_heard

MOUNT: slam_log.Pose = (-0.087, 0.0125, 0.0)
LIMIT_S = 60.0
UNKNOWN: Tuple[int, slam_log.Pose] = (0, (0.0, 0.0, 0.0))


def transform(parent: str, child: str, pose: slam_log.Pose, stamp: rospy.Time, z: float = 0.0) -> TransformStamped:
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
    message.transform.translation.x, message.transform.translation.y, message.transform.translation.z = *pose[:2], z
    message.transform.rotation.z = math.sin(pose[2] / 2.0)
    message.transform.rotation.w = math.cos(pose[2] / 2.0)
    return message


def scan_of(moment: slam_log.Moment) -> LaserScan:
    message = LaserScan()
    message.header.frame_id = "camera_depth_frame"
    message.header.stamp = rospy.Time(0, moment.stamp_ns)
    message.angle_min, message.angle_max = slam_log.ANGLE_MIN, slam_log.ANGLE_MAX
    message.angle_increment = (slam_log.ANGLE_MAX - slam_log.ANGLE_MIN) / (len(moment.ranges) - 1)
    message.range_min, message.range_max = 0.45, 10.0
    message.ranges = moment.ranges.tolist()
    return message


class ScanPlayer:
    """Clock, scan and tf of a robot; what the node answers on /tf and /diagnostics."""

    def __init__(self, health: str) -> None:
        """``health``: name of the node's status on /diagnostics."""
        self.changed = threading.Condition()
        self.T_map_odom = UNKNOWN
        self.health: Dict[str, str] = {}
        self._health_name = health
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.scan = rospy.Publisher("scan", LaserScan, queue_size=10)
        self.tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100)
        rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics)

    def hear(self, topic: str, kind: type) -> List:
        """The messages of a topic, in the order in which they come."""
        where: List = []
        rospy.Subscriber(topic, kind, self._keep, where)
        return where

    def _keep(self, message: object, where: List[object]) -> None:
        with self.changed:
            where.append(message)
            self.changed.notify_all()

    def _on_tf(self, message: TFMessage) -> None:
        with self.changed:
            for found in message.transforms:
                if (found.header.frame_id, found.child_frame_id) == ("map", "odom"):
                    t, r = found.transform.translation, found.transform.rotation
                    self.T_map_odom = (found.header.stamp.to_nsec(), (t.x, t.y, 2.0 * math.atan2(r.z, r.w)))
            self.changed.notify_all()

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        with self.changed:
            for status in message.status:
                self.health[status.name] = status.message
            self.changed.notify_all()

    def wait(self, what: str, condition: Callable[[], bool]) -> None:
        """Until a condition holds, at most LIMIT_S."""
        end = time.monotonic() + LIMIT_S
        with self.changed:
            while not condition():
                left = end - time.monotonic()
                if left <= 0.0:
                    raise AssertionError(f"waited {LIMIT_S:.0f} s for {what}; health: {self.health}")
                self.changed.wait(left)

    def forget_health(self) -> None:
        with self.changed:
            self.health.clear()

    def wait_for_health(self, *parts: str) -> None:
        self.wait(f"health with {parts}", lambda: all(part in self.health.get(self._health_name, "") for part in parts))

    def connect(self) -> None:
        """Wait until the node hears everything."""
        for publisher in (self.clock, self.scan, self.tf, self.static):
            wait_until_heard(publisher.resolved_name.strip("/"), self._health_name.split(":")[0])

    def tick(self, stamp_ns: int) -> None:
        self.clock.publish(Clock(rospy.Time(0, stamp_ns)))

    def send(self, moment: slam_log.Moment) -> None:
        self.tick(moment.stamp_ns)
        stamp = rospy.Time(0, moment.stamp_ns)
        self.tf.publish(TFMessage([transform("odom", "base_footprint", moment.odometry, stamp)]))
        self.scan.publish(scan_of(moment))

    def step(self, moment: slam_log.Moment) -> slam_log.Pose:
        """Send one moment and wait for its answer: where the node believes the robot to be, in the map."""
        self.send(moment)
        self.wait("map -> odom at the scan's time", lambda: self.T_map_odom[0] == moment.stamp_ns)
        return slam_log.compose(self.T_map_odom[1], moment.odometry)
