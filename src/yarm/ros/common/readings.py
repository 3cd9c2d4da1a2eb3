"""What a TurtleBot measures, from messages: checked, and as the values the rest of the package works with."""

from __future__ import annotations

import math
from typing import Any, Callable, FrozenSet, Optional, Tuple

import numpy as np
import rospy
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField

from yarm.geometry.scans import Odometry, Scan
from yarm.msg import BumperEvent as BumperMessage
from yarm.robots.turtlebot import CAMERA_FOCAL_PX, CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX, Bumper, BumperEvent
from yarm.ros.common.checks import Doorkeeper, pose_fault, stamp_fault
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.frames import Frames

IMAGE_BYTES = 2**21
PRESSED_M = 1.0
"""Points of the bumper's cloud nearer than this are pressed sectors; the others are put far away."""
XY_FIELDS = [("x", 0, PointField.FLOAT32), ("y", 4, PointField.FLOAT32)]
FOCAL_SHARE = 0.02
"""Of the focal length: a camera that differs by more is another one; it would lift the floor by more than 6 mm."""
CENTRE_PX = 3.0
"""A centre farther than this from the image's is another camera's; at 2.5 m it would lift the floor by 14 mm."""
LEAST_TURN_RAD = 1e-6
"""Beams that turn by less look all the same way."""


def listen(topic: str, kind: type, take: Callable[[Any], str], queue: int) -> rospy.Subscriber:
    """Subscribe; whoever sends what ``take`` finds fault with is named."""
    door = Doorkeeper(topic)

    def on_message(message: object) -> None:
        door.refuses(message, take(message))

    return rospy.Subscriber(
        topic, kind, on_message, queue_size=queue, buff_size=max(65536, 2 * IMAGE_BYTES), tcp_nodelay=True
    )


def read_scan(
    message: LaserScan, frames: Frames, base_frame: str, now_s: float, before_s: float
) -> Tuple[Optional[Scan], str]:
    """The scan, its beams from right to left whichever way they came, or what is wrong with it.

    Args:
        message: as it came.
        frames: to find the sensor on the robot.
        base_frame: the robot's frame.
        now_s: the present; 0 when it is not known.
        before_s: stamp of the newest one taken.
    """
    stamp_s = message.header.stamp.to_sec()
    frame = message.header.frame_id.lstrip("/")
    sensor = frames.between(base_frame, frame)
    if sensor is None:
        return None, f"frame {frame!r} is not known in {base_frame}; who publishes its transform?"
    if not all(math.isfinite(v) for v in (message.angle_min, message.angle_increment, message.range_min)):
        return None, "its angles or limits are no numbers"
    if math.isnan(message.range_max) or abs(message.angle_increment) < LEAST_TURN_RAD:
        return (
            None,
            f"its greatest range is {message.range_max:g} m, and its beams turn by {message.angle_increment:g} rad",
        )
    fault = stamp_fault(stamp_s, now_s) or _older(stamp_s, before_s)
    if fault:
        return None, fault
    ranges = np.array(message.ranges, dtype=np.float32)
    first_rad, turn_rad = message.angle_min, message.angle_increment
    if turn_rad < 0.0:
        first_rad, turn_rad, ranges = first_rad + turn_rad * (len(ranges) - 1), -turn_rad, ranges[::-1]
    return Scan(stamp_s, ranges, first_rad, turn_rad, message.range_min, message.range_max, sensor), ""


def read_odometry(message: OdometryMessage, now_s: float, before_s: float) -> Tuple[Optional[Odometry], str]:
    """The odometry, or what is wrong with it; times as of :func:`read_scan`."""
    stamp_s = message.header.stamp.to_sec()
    fault = pose_fault(message.pose.pose) or stamp_fault(stamp_s, now_s) or _older(stamp_s, before_s)
    if fault:
        return None, fault
    twist = message.twist.twist
    return Odometry(stamp_s, pose2_of_pose(message.pose.pose), twist.linear.x, twist.angular.z), ""


def read_bumper(message: BumperMessage) -> Tuple[Optional[BumperEvent], str]:
    """The change of the bumper, or what is wrong with it."""
    if message.bumper not in tuple(Bumper) or message.state not in (BumperMessage.RELEASED, BumperMessage.PRESSED):
        return None, f"bumper {message.bumper}, state {message.state} mean nothing"
    return BumperEvent(Bumper(message.bumper), message.state == BumperMessage.PRESSED), ""


def read_pressed(message: PointCloud2) -> Tuple[FrozenSet[Bumper], str]:
    """Which sectors a cloud of the bumper says are pressed, or what is wrong with it."""
    fields = [(field.name, field.offset, field.datatype) for field in message.fields[:2]]
    count = message.width * message.height
    if fields != XY_FIELDS or message.is_bigendian or count != len(Bumper):
        return frozenset(), f"{count} points with the fields {fields}, {len(Bumper)} with {XY_FIELDS} are expected"
    if message.point_step < 8 or len(message.data) < count * message.point_step:
        return frozenset(), f"{len(message.data)} bytes for {count} points of {message.point_step}"
    raw = np.frombuffer(message.data, np.uint8, count * message.point_step).reshape(count, message.point_step)
    points = np.ascontiguousarray(raw[:, :8]).view("<f4")
    near = points[np.hypot(points[:, 0], points[:, 1]) < PRESSED_M]
    sides = np.sign(np.where(np.abs(near[:, 1]) < 0.5 * np.abs(near[:, 0]), 0.0, near[:, 1]))
    return frozenset({1: Bumper.LEFT, 0: Bumper.CENTER, -1: Bumper.RIGHT}[int(side)] for side in sides), ""


def image_fault(message: Image) -> str:
    """What is wrong with a depth image; empty when it can be used."""
    if (message.width, message.height) != (CAMERA_WIDTH_PX, CAMERA_HEIGHT_PX):
        return f"{message.width} x {message.height} pixels, expected {CAMERA_WIDTH_PX} x {CAMERA_HEIGHT_PX}"
    if message.encoding != "32FC1" or message.is_bigendian:
        return f"encoding {message.encoding!r}, expected 32FC1, little-endian, metres"
    if len(message.data) != 4 * message.width * message.height:
        return f"{len(message.data)} bytes for {message.width} x {message.height} pixels of 4 bytes"
    return ""


def camera_fault(message: CameraInfo) -> str:
    """Why low obstacles cannot be found in the images of this depth camera; empty when they can.

    They are looked for with the focal length and the middle of the TurtleBot's camera (``turtlebot.CAMERA_FOCAL_PX``).
    """
    if (message.width, message.height) != (CAMERA_WIDTH_PX, CAMERA_HEIGHT_PX):
        return f"{message.width} x {message.height} pixels, expected {CAMERA_WIDTH_PX} x {CAMERA_HEIGHT_PX}"
    middle = 0.5 * (CAMERA_WIDTH_PX - 1), 0.5 * (CAMERA_HEIGHT_PX - 1)
    focal_px = FOCAL_SHARE * CAMERA_FOCAL_PX
    for index, name, expected, allowed in (
        (0, "fx", CAMERA_FOCAL_PX, focal_px),
        (4, "fy", CAMERA_FOCAL_PX, focal_px),
        (2, "cx", middle[0], CENTRE_PX),
        (5, "cy", middle[1], CENTRE_PX),
    ):
        value = message.K[index]
        if not math.isfinite(value) or value <= 0.0:
            return f"K[{index}] ({name}) is {value:g} px, expected {expected:g}"
        if abs(value - expected) > allowed:
            return (
                f"K[{index}] ({name}) is {value:g} px, {value - expected:+.1f} from {expected:g}, "
                f"allowed {allowed:.1f} either way"
            )
    return ""


def _older(stamp_s: float, before_s: float) -> str:
    """A stamp before the newest one taken."""
    return f"its stamp {stamp_s:.3f} s is before {before_s:.3f} s, the newest" if stamp_s < before_s else ""
