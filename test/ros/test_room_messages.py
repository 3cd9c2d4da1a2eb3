"""What a TurtleBot measures, as messages."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rospy

from support.rooms import block, room
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.rooms import messages
from yarm.sim.engine.room import COLOURS
from yarm.sim.scenes.arena import BlockKind
from yarm.sim.sensors.room_eye import CAMERA

STAMP = rospy.Time(12, 340_000_000)


def test_odometry_and_its_transform_agree():
    pose = Pose2(1.5, -0.5, 2.0)
    message = messages.odometry_message(Odometry(12.34, pose, 0.2, -0.4), "odom", STAMP)
    moved = messages.transform("odom", "base_footprint", pose, STAMP).transform
    found = pose2_of_pose(message.pose.pose)
    assert (found.x, found.y, found.yaw_rad) == pytest.approx((1.5, -0.5, 2.0))
    assert (moved.translation.x, moved.translation.y, moved.rotation.z) == pytest.approx((1.5, -0.5, math.sin(1.0)))
    assert (message.twist.twist.linear.x, message.twist.twist.angular.z) == (0.2, -0.4)
    assert (message.header.frame_id, message.child_frame_id, message.header.stamp) == ("odom", "base_footprint", STAMP)
    assert len(message.pose.covariance) == 36


def test_a_scan_keeps_its_order_and_its_gaps():
    ranges = np.array([1.0, math.nan, 3.0], np.float32)
    message = messages.scan_message(Scan(12.34, ranges, -0.5, 0.5, 0.45, 10.0), STAMP)
    assert (message.ranges[0], message.ranges[2]) == (1.0, 3.0)
    assert math.isnan(message.ranges[1])
    assert message.angle_min + 2 * message.angle_increment == pytest.approx(message.angle_max)


def test_a_depth_image_reads_back_and_its_camera_is_the_one_that_took_it():
    depth = np.arange(12, dtype=np.float32).reshape(3, 4)
    message = messages.image_message(depth, STAMP)
    back = np.frombuffer(message.data, np.float32).reshape(message.height, message.width)
    assert np.array_equal(back, depth)
    info = messages.camera_info(STAMP)
    assert info.K[0] == pytest.approx(CAMERA.focal_px)
    # A pixel's own ray by the message's numbers, and by the camera's.
    u, v = 100, 40
    ray = CAMERA.directions()[v, u]
    assert ((u - info.K[2]) / info.K[0], (v - info.K[5]) / info.K[4]) == pytest.approx((ray[0], ray[1]), abs=1e-6)


@pytest.mark.parametrize("pressed", [set(), {Bumper.LEFT}, {Bumper.CENTER, Bumper.RIGHT}, set(Bumper)])
def test_the_bumpers_cloud_has_a_point_near_for_each_pressed_sector(pressed):
    cloud = messages.bumper_cloud(frozenset(pressed), STAMP)
    points = np.frombuffer(cloud.data, np.float32).reshape(-1, 3)
    near = {turtlebot.bumper_at(math.atan2(y, x)) for x, y, _ in points if math.hypot(x, y) < 0.5}
    assert near == pressed
    assert len(points) == 3


def test_every_kind_of_block_has_a_colour_and_stands_on_the_floor():
    assert set(COLOURS) == set(BlockKind)
    arena = room(block("brick", 1.0, 0.5, (0.2, 0.1, 0.1), "low"))
    markers = messages.arena_markers(arena.blocks)
    assert len({marker.id for marker in markers}) == len(arena.blocks)
    brick = markers[-1]
    assert (brick.ns, brick.pose.position.z, brick.scale.z) == ("low", 0.05, 0.1)
