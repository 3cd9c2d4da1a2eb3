"""What every node that drives a TurtleBot hears: kept in order, handed out once, waited for in lock-step, forgotten."""

from __future__ import annotations

import itertools
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage
from yarm.msg import BumperEvent as BumperMessage
from yarm.msg import StepAck

from yarm.robots.turtlebot import CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX, Bumper, BumperEvent
from yarm.ros.common.readings import read_pressed
from yarm.ros.common.robot_inputs import RobotInputs
from yarm.ros.exploration.inputs import ExplorerInputs
from yarm.ros.exploration.params import ExplorerParams
from yarm.ros.rooms.messages import bumper_cloud, camera_info, image_message

NOW_S = 10.0
LONG_S = 60.0


def params(**changes):
    plain = {
        "base_frame": "base_footprint",
        "odom_frame": "odom",
        "map_frame": "map",
        "sync": True,
        "sync_wait": LONG_S,
        "waits_for": (),
    }
    return SimpleNamespace(**{**plain, **changes})


@pytest.fixture
def quiet(monkeypatch):
    monkeypatch.setattr(rospy, "Subscriber", lambda *_, **__: None)
    monkeypatch.setattr(rospy, "get_time", lambda: NOW_S)


@pytest.fixture
def heard(quiet):
    return RobotInputs(params(), kept=3, bumper=True, low=True)


def link(parent, child, stamp_s):
    made = TransformStamped(child_frame_id=child)
    made.header.frame_id, made.header.stamp = parent, rospy.Time(stamp_s)
    made.transform.rotation.w = 1.0
    return made


def scan(stamp_s):
    message = LaserScan(angle_min=-0.5, angle_increment=0.5, range_min=0.45, range_max=10.0, ranges=[1.0, 2.0, 3.0])
    message.header.stamp, message.header.frame_id = rospy.Time(stamp_s), "base_footprint"
    return message


def odometry(stamp_s, x=0.0):
    message = OdometryMessage()
    message.header.stamp = rospy.Time(stamp_s)
    message.pose.pose.position.x, message.pose.pose.orientation.w = x, 1.0
    return message


def grid(frame="map"):
    message = OccupancyGrid(data=[0] * 6)
    message.header.frame_id, message.header.stamp = frame, rospy.Time(NOW_S)
    message.info.resolution, message.info.width, message.info.height = 0.05, 3, 2
    message.info.origin.orientation.w = 1.0
    return message


def empty_image():
    depth = np.full((CAMERA_HEIGHT_PX, CAMERA_WIDTH_PX), np.nan, np.float32)
    return image_message(depth, rospy.Time(NOW_S))


def test_so_much_is_kept_and_what_is_older_than_the_newest_is_refused(heard):
    for i in range(5):
        assert heard._on_odometry(odometry(1.0 + i, x=float(i))) == ""
    assert [entry.pose.x for entry in heard._past] == [2.0, 3.0, 4.0]
    assert "before 5.000 s" in heard._on_odometry(odometry(2.0))
    assert heard._odometry is heard._past[-1] and heard._odometry_s() == 5.0
    assert heard._scan is None and heard._scan_s() == -float("inf")


def test_bumps_and_low_obstacles_are_handed_out_once(heard):
    assert heard._on_bumper(BumperMessage(bumper=BumperMessage.LEFT, state=BumperMessage.PRESSED)) == ""
    assert heard._take_bumps() == (BumperEvent(Bumper.LEFT, True),) and heard._take_bumps() == ()
    assert heard._on_depth_image(empty_image()) == ""
    low = heard._take_low()
    assert low is not None and low[0] == NOW_S and low[1].shape == (0, 2) and heard._take_low() is None


def test_images_of_another_camera_are_left_out_said_why_and_taken_again_from_the_right_one(quiet):
    heard = ExplorerInputs(ExplorerParams(sync=True))
    other = camera_info(rospy.Time(NOW_S))
    other.K[0] = 525.0
    assert heard._on_depth_image(empty_image()) == "" and heard.complaints() == ()
    assert "525 px" in heard._on_depth_camera(other)
    assert heard._low is None, "the image before it was this camera's too"
    assert heard._on_depth_image(empty_image()) == "" and heard._low is None
    assert "depth image" not in heard._stamps(NOW_S), "no pass of the lock-step waits for what is left out"
    other.header.stamp = rospy.Time(NOW_S + 1.0)
    heard._on_depth_camera(other)
    (complaint,) = heard.complaints()
    assert complaint.text.startswith("depth camera: K[0] (fx) is 525 px, -29.3 from 554.3")
    assert "since 10.0 s; set the camera" in complaint.text and not complaint.stands
    assert heard._on_depth_camera(camera_info(rospy.Time(NOW_S + 2.0))) == "" and heard.complaints() == ()
    assert heard._on_depth_image(empty_image()) == "" and heard._take_low() is not None
    assert "depth image" in heard._stamps(NOW_S)


def test_a_map_of_another_frame_is_refused_and_time_going_back_keeps_the_map_alone(heard):
    assert "frame" in heard._on_map(grid("elsewhere")) and heard._map is None
    assert heard._on_map(grid()) == "" and heard._map is not None and heard._map_count == 1
    heard._on_odometry(odometry(1.0))
    heard._on_bumper(BumperMessage(bumper=BumperMessage.LEFT, state=BumperMessage.PRESSED))
    heard._frames._on_moving(TFMessage([link("map", "odom", NOW_S)]))
    heard.forget()
    assert heard._odometry is None and heard._take_bumps() == () and heard._place_s() == -float("inf")
    assert heard._map is not None and heard._map_count == 1


def test_a_pass_of_the_lock_step_waits_for_what_was_measured_at_it(heard):
    heard._on_odometry(odometry(NOW_S))

    def late():
        heard._on_scan(scan(NOW_S))

    sender = threading.Thread(target=late)
    with heard._changed:
        sender.start()
        began = time.monotonic()
        heard._wait_for_all_of(NOW_S)
        assert heard._scan_s() == NOW_S and time.monotonic() - began < LONG_S
    sender.join()


@pytest.mark.parametrize("changes", [{"sync": False}, {"sync_wait": 0.01}])
def test_without_lock_step_and_after_the_limit_nobody_waits(quiet, changes):
    heard = RobotInputs(params(**changes))
    with heard._changed:
        heard._wait_for_all_of(NOW_S)
    assert heard._scan is None


def cloud(stamp_s, *pressed):
    return bumper_cloud(frozenset(pressed), rospy.Time(stamp_s))


def test_every_set_of_pressed_sectors_is_read_from_its_cloud_and_a_broken_one_is_refused():
    for count in range(4):
        for sectors in itertools.combinations(Bumper, count):
            assert read_pressed(cloud(NOW_S, *sectors)) == (frozenset(sectors), "")
    short, other, few = cloud(NOW_S), cloud(NOW_S), cloud(NOW_S)
    short.data, other.fields[0].name, few.width = short.data[:20], "z", 2
    assert "20 bytes for 3 points of 12" in read_pressed(short)[1]
    assert "('z', 0, 7)" in read_pressed(other)[1] and "2 points" in read_pressed(few)[1]


def test_a_pass_of_the_lock_step_waits_for_bumper_events_that_bear_no_stamp(heard):
    heard._on_scan(scan(NOW_S))
    heard._on_odometry(odometry(NOW_S))
    assert heard._on_pressed(cloud(NOW_S, Bumper.RIGHT)) == ""
    assert heard._late(NOW_S) == [], "what was pressed from the start was never an event"
    heard._on_scan(scan(NOW_S + 0.1))
    heard._on_odometry(odometry(NOW_S + 0.1))
    assert heard._late(NOW_S + 0.1) == ["bumper event"]
    heard._on_pressed(cloud(NOW_S + 0.1, Bumper.RIGHT, Bumper.LEFT))
    assert heard._late(NOW_S + 0.1) == ["bumper event"], "of the left, on its way yet"
    heard._on_bumper(BumperMessage(bumper=BumperMessage.LEFT, state=BumperMessage.PRESSED))
    assert heard._late(NOW_S + 0.1) == []
    heard._on_bumper(BumperMessage(bumper=BumperMessage.RIGHT, state=BumperMessage.RELEASED))
    assert heard._late(NOW_S + 0.1) == ["bumper event"]
    heard.forget()
    assert "bumper event" not in heard._stamps(NOW_S), "nobody is waited for who has not spoken"


def test_what_a_pass_goes_on_without_is_said_once_and_again_after_it_has_come(quiet, monkeypatch):
    said = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *values: said.append(text % values))
    heard = RobotInputs(params(sync_wait=0.01))
    heard._on_scan(scan(NOW_S))
    with heard._changed:
        heard._wait_for_all_of(NOW_S)
        heard._wait_for_all_of(NOW_S)
        assert len(said) == 1 and "at 10.00 s: no odometry of this moment within 0.01 s" in said[0]
        heard._wait_for_all_of(NOW_S + 0.1)
        assert len(said) == 2 and "no scan and no odometry" in said[1]
    heard._on_odometry(odometry(NOW_S))
    with heard._changed:
        heard._wait_for_all_of(NOW_S)
        heard._wait_for_all_of(NOW_S + 0.1)
    assert len(said) == 3


def test_the_lock_step_begins_when_all_that_are_waited_for_have_answered(quiet):
    heard = RobotInputs(params(waits_for=("gate", "base")))
    assert not heard.together()
    heard._on_ack(StepAck(node="gate"))
    assert not heard.together()
    heard._on_ack(StepAck(node="base"))
    assert heard.together()
