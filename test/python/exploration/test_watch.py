"""Sick sensors: each is named, with its beginning and the remedy, the robot stands, and it goes on afterwards."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from yarm.exploration.model import LOOP_S, Command, Observation
from yarm.exploration.watch import AGE_S, BLIND_TURN_RAD, BLIND_WAY_M, FROZEN_HOLD_S, STUCK_BUMPER_S, SensorWatch
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import Bumper, BumperEvent

AHEAD = Command(0.2, 0.0)
MAP = GridMap(np.zeros((20, 20), np.int8), 0.05, Pose2(-0.5, -0.5))


class Drive:
    """A robot that drives ahead at what it is told, pass by pass, with noisy scans."""

    def __init__(self, seed=1):
        self.rng = np.random.default_rng(seed)
        self.watch = SensorWatch()
        self.now_s, self.x, self.told = 10.0, 0.0, AHEAD
        self.complaints = ()

    def seen(self):
        ranges = self.rng.normal(2.0, 0.01, 64).astype(np.float32)
        scan = Scan(self.now_s, ranges, -0.5, 1.0 / 63, 0.45, 10.0)
        odometry = Odometry(self.now_s, Pose2(self.x, 0.0), self.told.v_mps)
        return Observation(self.now_s, odometry, Pose2(0.0, 0.0), scan, map=MAP, map_count=1)

    def go(self, passes=1, **changes):
        """Passes with some of what is seen replaced; a function is called with what is seen."""
        for _ in range(passes):
            self.now_s += LOOP_S
            self.x += self.told.v_mps * LOOP_S
            seen = self.seen()
            values = {name: change(seen) if callable(change) else change for name, change in changes.items()}
            self.complaints = self.watch.step(replace(seen, **values), self.told)
            self.told = Command() if any(c.stands for c in self.complaints) else AHEAD
        return self.complaints


@pytest.fixture
def drive():
    robot = Drive()
    assert robot.go(10) == ()
    return robot


def only(complaints, sensor):
    assert [c.sensor for c in complaints] == [sensor], complaints
    return complaints[0]


@pytest.mark.parametrize("sensor", ["scan", "odometry"])
def test_what_stops_coming_stops_the_robot_within_half_a_second_and_says_since_when(drive, sensor):
    last = getattr(drive.seen(), sensor)
    last_s = drive.now_s
    while not drive.complaints:
        drive.go(**{sensor: last})
    complaint = only(drive.complaints, sensor)
    assert complaint.stands
    assert drive.now_s - last_s <= 0.5
    assert complaint.since_s == pytest.approx(last_s)
    assert f"since {last_s:.1f} s" in complaint.text
    assert "look at" in complaint.text
    drive.go(20, **{sensor: last})
    assert only(drive.complaints, sensor).since_s == pytest.approx(last_s)


def test_it_goes_on_when_the_scan_returns(drive):
    last = drive.seen().scan
    drive.go(20, scan=last)
    assert drive.complaints
    assert drive.go() == ()


@pytest.mark.parametrize("name", ["scan", "odometry", "map_from_odom", "map"])
def test_what_has_never_come_is_waited_for_without_moving(name):
    robot = Drive()
    robot.now_s = 0.0
    complaints = robot.go(**{name: None})
    assert complaints[0].stands
    assert "waits for it" in complaints[0].text
    robot.now_s = 30.0
    assert "look at" in robot.go(**{name: None})[0].text


def test_a_scan_without_beams(drive):
    empty = lambda seen: replace(seen.scan, ranges=np.zeros(0, np.float32))  # noqa: E731
    assert "no beams" in only(drive.go(scan=empty), "scan").text


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0, 0.0])
def test_a_scan_that_sees_nothing_is_no_fault_of_the_sensor(drive, value):
    blank = lambda seen: replace(seen.scan, ranges=np.full(64, value, np.float32))  # noqa: E731
    complaints = drive.go(2, scan=blank)
    assert complaints == ()


@pytest.mark.parametrize("value", [math.nan, math.inf, -1.0])
def test_a_scan_that_goes_on_seeing_nothing_while_the_robot_moves_is_blind(drive, value):
    blank = lambda seen: replace(seen.scan, ranges=np.full(64, value, np.float32))  # noqa: E731
    began_s, from_m = drive.now_s, drive.x
    while not drive.complaints:
        drive.go(scan=blank)
    complaint = only(drive.complaints, "scan")
    assert drive.x - from_m == pytest.approx(BLIND_WAY_M, abs=0.05)
    assert "no beam has a range" in complaint.text and complaint.since_s == pytest.approx(began_s)
    assert drive.go(20, scan=blank), "standing, it still sees nothing"
    assert drive.go() == ()


def test_turning_about_without_seeing_anything_is_blind_too(drive):
    blank = lambda seen: replace(seen.scan, ranges=np.full(64, math.nan, np.float32))  # noqa: E731
    turned = {
        yaw_deg: lambda seen, yaw_deg=yaw_deg: Odometry(seen.now_s, Pose2(drive.x, 0.0, math.radians(yaw_deg)))
        for yaw_deg in range(0, 200, 5)
    }
    found = [drive.go(scan=blank, odometry=odometry) != () for odometry in turned.values()]
    assert found.index(True) * 5 == pytest.approx(math.degrees(BLIND_TURN_RAD), abs=10.0)


def test_another_number_of_beams_is_no_fault(drive):
    fewer = lambda seen: replace(seen.scan, ranges=seen.scan.ranges[:32])  # noqa: E731
    assert drive.go(3, scan=fewer) == ()


def test_a_frozen_scan_is_noticed_because_the_robot_moves(drive):
    ranges = drive.seen().scan.ranges
    frozen = lambda seen: replace(seen.scan, ranges=ranges)  # noqa: E731
    assert drive.go(2, scan=frozen) == ()
    assert "does not change though the robot moves" in only(drive.go(3, scan=frozen), "scan").text
    assert drive.told == Command()
    assert drive.go(5, scan=frozen), "standing, it would have to be told again"
    assert drive.go() == ()


def test_a_scan_that_repeats_while_the_robot_stands_is_right(drive):
    drive.go()
    ranges, x = drive.seen().scan.ranges, drive.x
    still = {
        "scan": lambda seen: replace(seen.scan, ranges=ranges),
        "odometry": lambda seen: Odometry(seen.now_s, Pose2(x, 0.0)),
    }
    for _ in range(20):
        drive.told = Command()
        assert drive.go(**still) == ()


def test_frozen_odometry_is_noticed_within_half_a_second_and_tried_again(drive):
    pose, began_s = drive.seen().odometry.pose, drive.now_s
    frozen = lambda seen: Odometry(seen.now_s, pose)  # noqa: E731
    while not drive.complaints:
        drive.go(odometry=frozen)
    assert drive.now_s - began_s <= 0.5 + 1e-9
    assert "told to move" in only(drive.complaints, "odometry").text
    drive.go(int(FROZEN_HOLD_S / LOOP_S) + 1, odometry=frozen)
    assert drive.complaints == ()
    drive.go(5, odometry=frozen)
    assert only(drive.complaints, "odometry")
    drive.x = pose.x + 0.01
    assert drive.go() == ()


def test_odometry_that_jumps_stops_the_robot_for_a_moment(drive):
    drive.x += 0.5
    complaint = only(drive.go(), "odometry")
    assert "jumped by 0.5" in complaint.text
    assert complaint.stands
    assert drive.go(8) == ()


def test_a_pose_that_is_no_number(drive):
    bad = lambda seen: replace(seen.odometry, pose=Pose2(math.nan, 0.0))  # noqa: E731
    assert "no number" in only(drive.go(odometry=bad), "odometry").text


def test_a_mapping_that_is_gone_and_comes_back_elsewhere(drive):
    gone = only(drive.go(3, map_from_odom=None), "pose")
    assert "no transform map -> odom" in gone.text
    assert gone.since_s == pytest.approx(11.1)
    assert not drive.watch.take_jump()
    back = only(drive.go(map_from_odom=Pose2(0.4, 0.0)), "pose")
    assert "jumped by 0.40 m" in back.text
    assert drive.watch.take_jump()
    assert not drive.watch.take_jump()
    assert drive.go(8, map_from_odom=Pose2(0.4, 0.0)) == ()


def test_a_pose_that_turns_about_far_from_the_origin_has_jumped(drive):
    drive.go(map_from_odom=Pose2(0.0, 0.0, 0.5))
    assert drive.watch.take_jump()


def test_small_corrections_are_no_jump(drive):
    assert drive.go(map_from_odom=Pose2(0.15, 0.0, 0.02)) == ()


def test_a_stuck_bumper_is_not_counted_until_it_lets_go(drive):
    pressed, released = BumperEvent(Bumper.LEFT, True), BumperEvent(Bumper.LEFT, False)
    drive.go(bumps=(pressed,))
    assert drive.watch.bumps((pressed,)) == (pressed,)
    complaints = drive.go(int(STUCK_BUMPER_S / LOOP_S) + 2)
    complaint = only(complaints, "bumper")
    assert not complaint.stands
    assert "LEFT pressed though the robot drives since 11.1 s" in complaint.text
    assert drive.watch.bumps(()) == (released,), "the controller is told that it has let go"
    assert drive.watch.bumps((pressed,)) == ()
    right = BumperEvent(Bumper.RIGHT, True)
    assert drive.watch.bumps((right,)) == (right,)
    assert drive.go(bumps=(released,)) == ()
    assert drive.watch.bumps((released,)) == ()
    drive.go(bumps=(pressed,))
    assert drive.watch.bumps((pressed,)) == (pressed,)


def test_a_bumper_pressed_by_a_wall_for_long_is_not_stuck(drive):
    drive.go(bumps=(BumperEvent(Bumper.CENTER, True),))
    for _ in range(150):
        drive.told = Command()
        x = drive.x
        drive.go(odometry=lambda seen, x=x: Odometry(seen.now_s, Pose2(x, 0.0)))
        assert drive.complaints == ()


def test_the_age_allowed_leaves_time_to_stand_within_half_a_second():
    assert AGE_S + LOOP_S < 0.5
