"""What a TurtleBot measures, and the room it is in, as messages."""

from __future__ import annotations

import math
import struct
from typing import AbstractSet, List, Sequence, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2, PointField
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from yarm.geometry import Pose2
from yarm.geometry.pinhole import Pinhole
from yarm.geometry.scans import Odometry, Scan
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.sim.engine.room import COLOURS
from yarm.sim.scenes.arena import Block
from yarm.sim.sensors.noise import FloatImage
from yarm.sim.sensors.rgb_camera import RgbFrame

XY_VARIANCE, YAW_VARIANCE, UNKNOWN_VARIANCE = 0.1, 0.05, 1e6
"""What the platform's own driver says of its odometry, m^2 and rad^2."""
CLOUD_RADIUS_M, CLOUD_Z_M, CLOUD_SIDE_RAD = 0.24, 0.04, math.radians(70.0)
"""Where the points of pressed sectors are drawn, as the platform does: a little ahead of the body."""
CLOUD_FAR_M = 100.0
"""Points of sectors that are not pressed are this far away."""


def transform(parent: str, child: str, pose: Pose2, stamp: rospy.Time) -> TransformStamped:
    """A transform parent <- child in the plane."""
    made = TransformStamped(child_frame_id=child)
    made.header.stamp, made.header.frame_id = stamp, parent
    moved = pose_message(pose.x, pose.y, 0.0, pose.yaw_rad)
    made.transform.translation, made.transform.rotation = moved.position, moved.orientation
    return made


def odometry_message(odometry: Odometry, frame: str, stamp: rospy.Time) -> OdometryMessage:
    """Where the base is in a frame, and its speeds in its own."""
    made = OdometryMessage(child_frame_id=names.BASE_FOOTPRINT)
    made.header.stamp, made.header.frame_id = stamp, frame
    made.pose.pose = pose_message(odometry.pose.x, odometry.pose.y, 0.0, odometry.pose.yaw_rad)
    made.twist.twist.linear.x, made.twist.twist.angular.z = odometry.v_mps, odometry.w_radps
    known = [XY_VARIANCE, XY_VARIANCE, UNKNOWN_VARIANCE, UNKNOWN_VARIANCE, UNKNOWN_VARIANCE, YAW_VARIANCE]
    made.pose.covariance = made.twist.covariance = np.diag(known).ravel().tolist()
    return made


def scan_message(scan: Scan, stamp: rospy.Time) -> LaserScan:
    """A laser scan in the depth camera's frame."""
    made = LaserScan(
        angle_min=scan.angle_min_rad,
        angle_max=-scan.angle_min_rad,
        angle_increment=scan.angle_increment_rad,
        scan_time=1.0 / turtlebot.SCAN_RATE_HZ,
        range_min=scan.range_min_m,
        range_max=scan.range_max_m,
        ranges=scan.ranges.tolist(),
    )
    made.header.stamp, made.header.frame_id = stamp, names.SCAN_FRAME
    return made


def image_message(depth: FloatImage, stamp: rospy.Time) -> Image:
    """A depth image, metres."""
    height, width = depth.shape
    made = Image(height=height, width=width, encoding="32FC1", is_bigendian=0, step=4 * width, data=depth.tobytes())
    made.header.stamp, made.header.frame_id = stamp, names.DEPTH_FRAME
    return made


def camera_info(stamp: rospy.Time) -> CameraInfo:
    """The depth camera: a pinhole without distortion."""
    width, height = turtlebot.CAMERA_WIDTH_PX, turtlebot.CAMERA_HEIGHT_PX
    # Centres of pixels have whole coordinates in images, so the middle of the image lies between two.
    middle = 0.5 * (width - 1), 0.5 * (height - 1)
    return pinhole_info(Pinhole(width, height, turtlebot.CAMERA_FOCAL_PX, *middle), names.DEPTH_FRAME, stamp)


def pinhole_info(camera: Pinhole, frame: str, stamp: rospy.Time) -> CameraInfo:
    """A pinhole without distortion, in its optical frame."""
    f, cx, cy = camera.focal_px, camera.centre_x, camera.centre_y
    made = CameraInfo(height=camera.height, width=camera.width, distortion_model="plumb_bob", D=[0.0] * 5)
    made.K = [f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0]
    made.R = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    made.P = [f, 0.0, cx, 0.0, 0.0, f, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
    made.header.stamp, made.header.frame_id = stamp, frame
    return made


def rgb_message(frame: RgbFrame, stamp: rospy.Time) -> Image:
    """A frame of the RGB camera."""
    height, width = frame.grey.shape
    data = frame.rgb().tobytes()
    made = Image(height=height, width=width, encoding="rgb8", is_bigendian=0, step=3 * width, data=data)
    made.header.stamp, made.header.frame_id = stamp, names.RGB_FRAME
    return made


def bumper_cloud(pressed: AbstractSet[Bumper], stamp: rospy.Time) -> PointCloud2:
    """Three points in base_link, one a sector: at the body where it is pressed, far away where it is not."""
    points: List[Tuple[float, float, float]] = []
    for sector, bearing in ((Bumper.LEFT, CLOUD_SIDE_RAD), (Bumper.CENTER, 0.0), (Bumper.RIGHT, -CLOUD_SIDE_RAD)):
        radius = CLOUD_RADIUS_M if sector in pressed else CLOUD_FAR_M
        points.append((radius * math.cos(bearing), radius * math.sin(bearing), CLOUD_Z_M))
    made = PointCloud2(height=1, width=len(points), point_step=12, row_step=12 * len(points), is_dense=True)
    made.fields = [PointField(axis, 4 * i, PointField.FLOAT32, 1) for i, axis in enumerate("xyz")]
    made.data = struct.pack(f"<{3 * len(points)}f", *(value for point in points for value in point))
    made.header.stamp, made.header.frame_id = stamp, names.BASE_LINK
    return made


def arena_markers(blocks: Sequence[Block]) -> List[Marker]:
    """Each block as a box in the world, numbered, one namespace a kind."""
    made = []
    for number, block in enumerate(blocks):
        marker = Marker(ns=str(block.kind), id=number, type=Marker.CUBE, action=Marker.ADD)
        marker.header.frame_id = names.WORLD_FRAME
        marker.pose = pose_message(block.pose.x, block.pose.y, 0.5 * block.size[2], block.pose.yaw_rad)
        marker.scale.x, marker.scale.y, marker.scale.z = block.size
        marker.color = ColorRGBA(*COLOURS[block.kind], 1.0)
        made.append(marker)
    return made
