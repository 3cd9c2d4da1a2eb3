"""Measurements from messages: what can be used becomes a value, whatever else is left out with the reason."""

from __future__ import annotations

import math

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import Image, LaserScan
from tf2_msgs.msg import TFMessage
from yarm.msg import BumperEvent as BumperMessage

from yarm.geometry import Pose2
from yarm.robots.turtlebot import CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX, Bumper, BumperEvent
from yarm.ros.common.frames import Frames
from yarm.ros.common.readings import camera_fault, image_fault, read_bumper, read_odometry, read_scan
from yarm.ros.navigation.maps import grid_fault
from yarm.ros.rooms.messages import camera_info

BASE, CAMERA = "base_footprint", "camera_depth_frame"
NOW_S = 10.0


@pytest.fixture
def frames(monkeypatch):
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    known = Frames()
    placed = TransformStamped(child_frame_id=CAMERA)
    placed.header.frame_id = BASE
    placed.transform.translation.x, placed.transform.rotation.w = -0.087, 1.0
    known._on_fixed(TFMessage([placed]))
    return known


def scan(ranges=(1.0, 2.0, 3.0), stamp_s=NOW_S, frame=CAMERA, **changes):
    message = LaserScan(angle_min=-0.5, angle_increment=0.5, range_min=0.45, range_max=10.0, ranges=list(ranges))
    message.header.stamp, message.header.frame_id = rospy.Time(stamp_s), frame
    for name, value in changes.items():
        setattr(message, name, value)
    return message


def taken(frames, message, before_s=-math.inf):
    return read_scan(message, frames, BASE, NOW_S, before_s)


def test_a_scan_is_placed_on_the_robot(frames):
    read, fault = taken(frames, scan())
    assert fault == "" and read.stamp_s == NOW_S and read.sensor == Pose2(-0.087, 0.0)
    np.testing.assert_allclose(read.angles(), (-0.5, 0.0, 0.5))


def test_beams_from_left_to_right_are_turned_round(frames):
    straight, _ = taken(frames, scan((1.0, 2.0, 3.0)))
    other, fault = taken(frames, scan((3.0, 2.0, 1.0), angle_min=0.5, angle_increment=-0.5))
    assert fault == ""
    np.testing.assert_allclose(other.points(), straight.points(), atol=1e-6)
    np.testing.assert_array_equal(other.ranges, straight.ranges)
    assert other.angle_increment_rad > 0.0


@pytest.mark.parametrize("ranges", [(), (1.0,), (math.nan,) * 640, (math.inf,) * 3, (-1.0,) * 7])
def test_any_number_of_beams_and_any_ranges_are_a_scan(frames, ranges):
    for turn in (0.1, -0.1):
        read, fault = taken(frames, scan(ranges, angle_increment=turn))
        assert fault == "" and len(read.ranges) == len(ranges)
        assert len(read.points()) == (1 if ranges == (1.0,) else 0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"frame": "laser"}, "frame 'laser' is not known in base_footprint; who publishes its transform?"),
        ({"stamp_s": 9.0}, "its stamp 9.000 s is before 9.500 s, the newest"),
        ({"stamp_s": 20.0}, "its stamp 20.000 s is in the future; it is 10.000 s"),
        ({"angle_min": math.nan}, "its angles or limits are no numbers"),
        ({"angle_increment": math.inf}, "its angles or limits are no numbers"),
        ({"angle_increment": 0.0}, "its beams turn by 0 rad"),
        ({"range_max": math.nan}, "its greatest range is nan m"),
    ],
)
def test_a_scan_that_cannot_be_used_is_left_out_and_says_why(frames, changes, said):
    read, fault = taken(frames, scan(**changes), before_s=9.5)
    assert read is None and said in fault


def odometry(x=1.0, stamp_s=NOW_S, w=1.0):
    message = OdometryMessage()
    message.header.stamp = rospy.Time(stamp_s)
    message.pose.pose.position.x, message.pose.pose.orientation.w = x, w
    message.twist.twist.linear.x = 0.2
    return message


def test_odometry_is_a_pose_with_speeds():
    read, fault = read_odometry(odometry(), NOW_S, 9.9)
    assert fault == "" and (read.stamp_s, read.pose, read.v_mps) == (NOW_S, Pose2(1.0, 0.0), 0.2)


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (odometry(x=math.nan), "must be finite"),
        (odometry(w=0.0), "must have length 1"),
        (odometry(stamp_s=9.0), "its stamp 9.000 s is before 9.900 s, the newest"),
        (odometry(stamp_s=20.0), "in the future"),
    ],
)
def test_odometry_that_cannot_be_used_is_left_out_and_says_why(message, said):
    read, fault = read_odometry(message, NOW_S, 9.9)
    assert read is None and said in fault


def test_a_bumper_has_three_sectors_and_two_states():
    assert read_bumper(BumperMessage(bumper=2, state=1)) == (BumperEvent(Bumper.RIGHT, True), "")
    for bumper, state in ((3, 1), (0, 2)):
        read, fault = read_bumper(BumperMessage(bumper=bumper, state=state))
        assert read is None and fault == f"bumper {bumper}, state {state} mean nothing"


def image(**changes):
    message = Image(width=CAMERA_WIDTH_PX, height=CAMERA_HEIGHT_PX, encoding="32FC1")
    message.data = bytes(4 * CAMERA_WIDTH_PX * CAMERA_HEIGHT_PX)
    for name, value in changes.items():
        setattr(message, name, value)
    return message


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, ""),
        ({"width": 320}, "320 x 480 pixels, expected 640 x 480"),
        ({"encoding": "16UC1"}, "encoding '16UC1', expected 32FC1"),
        ({"is_bigendian": 1}, "little-endian"),
        ({"data": b"1234"}, "4 bytes for 640 x 480 pixels of 4 bytes"),
    ],
)
def test_a_depth_image_has_one_form(changes, said):
    fault = image_fault(image(**changes))
    assert said in fault and bool(fault) == bool(said)


def test_the_rooms_own_depth_camera_and_one_calibrated_a_little_otherwise_are_taken():
    assert camera_fault(camera_info(rospy.Time(0))) == ""
    other = camera_info(rospy.Time(0))
    other.K[0], other.K[4], other.K[2], other.K[5] = 560.0, 550.0, 321.0, 238.0
    assert camera_fault(other) == ""


@pytest.mark.parametrize(
    ("index", "value", "said"),
    [
        (0, 525.0, "K[0] (fx) is 525 px, -29.3 from 554.3, allowed 11.1 either way"),
        (4, 600.0, "K[4] (fy) is 600 px, +45.7 from 554.3"),
        (2, 330.0, "K[2] (cx) is 330 px, +10.5 from 319.5, allowed 3.0 either way"),
        (5, 200.0, "K[5] (cy) is 200 px, -39.5 from 239.5"),
        (0, 0.0, "K[0] (fx) is 0 px, expected 554.3"),
        (4, math.nan, "K[4] (fy) is nan px, expected 554.3"),
        (5, math.inf, "K[5] (cy) is inf px"),
    ],
)
def test_another_depth_camera_is_told_by_the_number_that_differs(index, value, said):
    message = camera_info(rospy.Time(0))
    message.K[index] = value
    assert said in camera_fault(message)


def test_a_depth_camera_of_another_size_is_refused():
    message = camera_info(rospy.Time(0))
    message.width = 320
    assert camera_fault(message) == "320 x 480 pixels, expected 640 x 480"


def grid(frame="map", resolution=0.05, data=(0, 100, -1, 50), **origin):
    message = OccupancyGrid(data=list(data))
    message.header.frame_id = frame
    message.info.resolution, message.info.width, message.info.height = resolution, 2, 2
    message.info.origin.position.x, message.info.origin.orientation.w = origin.get("x", 0.0), origin.get("w", 1.0)
    return message


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (grid(), ""),
        (grid(frame="/map"), ""),
        (grid(frame="world"), "its frame is 'world', expected map"),
        (grid(data=(0, 0, 0)), "3 cells for 2 x 2, expected as many"),
        (grid(data=(0, 0, 0, 101)), "values 0 to 101, expected -1 to 100"),
        (grid(resolution=0.0), "cells of 0 m, expected 0.001 to 100 m"),
        (grid(x=math.inf), "must be finite"),
        (grid(w=0.0), "must have length 1"),
    ],
)
def test_a_map_that_contradicts_itself_is_left_out_and_says_why(message, said):
    fault = grid_fault(message, "map")
    assert said in fault and bool(fault) == bool(said)
