#!/usr/bin/env python3
"""The mobile robot in the simulated cell: straight, turning about the end effector, stopped on the way."""

from __future__ import annotations

import math
import sys
import threading
import unittest
from pathlib import Path
from typing import List, Sequence, Tuple

import numpy as np
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Pose, Quaternion, Twist
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from yarm.msg import Contacts, MoveRobotAction, MoveRobotGoal, TransformStampedVector

from yarm.control.base.model import path_deviation
from yarm.geometry.poses import Pose2, quaternion_from_rpy, rotation_of_quaternion, wrap_angle, yaw_of_quaternion
from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.participant import Participant

ROBOT = "ankurbot_1"
CAP_MPS = 1.0
CASTER_AT = ((0.15, 0.15), (0.15, -0.15), (-0.15, 0.15), (-0.15, -0.15))


class PhysicsTest(unittest.TestCase):
    """Motions in full physics; what the wheels and the casters did is recorded all along."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.condition = threading.Condition()
        cls.track: List[Tuple[float, Pose2]] = []
        cls.casters: List[Tuple[float, List[float]]] = []
        cls.twist: Tuple[float, float] = (0.0, 0.0)
        cls.moved_wheels: List[float] = []
        cls.wheel_heights: List[List[float]] = []
        cls.failures: List[str] = []
        cls.participant = Participant()
        rospy.Subscriber(names.SEED_TRANSFORMS, TransformStampedVector, cls.on_seeds, queue_size=1000)
        rospy.Subscriber(names.cmd_vel(ROBOT), Twist, cls.on_twist, queue_size=1000)
        rospy.Subscriber(names.joint_states(ROBOT), JointState, cls.on_joints, queue_size=1000)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber("/tf", TFMessage, cls.on_tf, queue_size=1000)
        cls.client = SimpleActionClient(names.move_robot(ROBOT), MoveRobotAction)
        cls.participant.wait_for_begin()
        assert cls.client.wait_for_server(rospy.Duration(60.0))

    @classmethod
    def on_seeds(cls, message: TransformStampedVector) -> None:
        """Keep the pose; the next camera set comes when the test has it."""
        if ROBOT in message.frame:
            transform = message.transforms[message.frame.index(ROBOT)]
            t, q = transform.transform.translation, transform.transform.rotation
            with cls.condition:
                pose = Pose2(t.x, t.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))
                cls.track.append((transform.header.stamp.to_sec(), pose))
                cls.condition.notify_all()
        cls.participant.took(message.header.stamp)

    @classmethod
    def on_twist(cls, message: Twist) -> None:
        cls.twist = (message.linear.x, message.angular.z)

    @classmethod
    def on_joints(cls, message: JointState) -> None:
        angles = dict(zip(message.name, message.position))
        speeds = dict(zip(message.name, message.velocity))
        with cls.condition:
            stamp_s = message.header.stamp.to_sec()
            casters = [angles[f"{c}_caster_joint"] for c in names.CASTERS]
            rolling = max(abs(speeds[f"{c}_wheel_joint"]) for c in names.CASTERS) * 0.05
            turning = max(abs(speeds[f"{c}_caster_joint"]) for c in names.CASTERS)
            cls.casters.append((stamp_s, casters))
            if turning > 3.0:
                cls.moved_wheels.append(rolling)

    @classmethod
    def on_contacts(cls, message: Contacts) -> None:
        for contact in message.contacts:
            if contact.kind == "failure":
                cls.failures.append(f"{contact.body_a} {contact.link_a} - {contact.body_b} {contact.link_b}")

    @classmethod
    def on_tf(cls, message: TFMessage) -> None:
        """Heights of the base above its four casters, from how it tilts."""
        for transform in message.transforms:
            if transform.child_frame_id == f"{ROBOT}/base_link":
                q = transform.transform.rotation
                up = rotation_of_quaternion((q.x, q.y, q.z, q.w))[2]
                height = transform.transform.translation.z
                cls.wheel_heights.append([height + up[0] * x + up[1] * y for x, y in CASTER_AT])

    def pose(self) -> Pose2:
        with self.condition:
            self.condition.wait_for(lambda: bool(self.track), timeout=30.0)
            return self.track[-1][1]

    def start(self, target: Pose2, action: str = "False", via: Sequence[Pose2] = ()) -> int:
        """Send a goal; index into the track from where it began."""
        goal = MoveRobotGoal(target=message_of(target), action=action, via=[message_of(pose) for pose in via])
        first = len(self.track)
        self.participant.ask(lambda: self.client.send_goal(goal))
        return first

    def drive(self, target: Pose2, action: str = "False") -> List[Tuple[float, Pose2]]:
        """Reach a pose; the track on the way."""
        first = self.start(target, action)
        self.assertTrue(self.client.wait_for_result(rospy.Duration(60.0)), "no result")
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED, self.client.get_result().message)
        pose = self.pose()
        self.assertLess(pose.distance(target), 0.03)
        self.assertLess(abs(math.degrees(wrap_angle(pose.yaw_rad - target.yaw_rad))), 1.0)
        with self.condition:
            return self.track[first:]

    def test_1_two_metres_straight(self) -> None:
        start = self.pose()
        target = Pose2(start.x + 0.2, start.y - 2.0, start.yaw_rad)
        track = self.drive(target)
        deviation = max(path_deviation(start, target, pose) for _, pose in track)
        beyond = max(start.distance(pose) for _, pose in track) - start.distance(target)
        seconds = track[-1][0] - track[0][0]
        rospy.loginfo("2 m: %.1f s, off the line by %.4f m, beyond by %.4f m", seconds, deviation, beyond)
        self.assertLess(deviation, 0.03)
        self.assertLess(beyond, 0.05)
        self.assertLess(max(speeds(track)), 1.05 * CAP_MPS)

    def test_2_quarter_turn_about_the_end_effector_keeps_it_in_place(self) -> None:
        start = self.pose()
        target = Pose2(start.x, start.y, start.yaw_rad + math.pi / 2)
        track = self.drive(target)
        drift = max(start.distance(pose) for _, pose in track)
        beyond = max(math.degrees(wrap_angle(pose.yaw_rad - target.yaw_rad)) for _, pose in track)
        body = [(stamp, pose.compose(Pose2(-1.65, 0.0))) for stamp, pose in track]
        seconds = track[-1][0] - track[0][0]
        rospy.loginfo("90 deg: %.1f s, point drifts by %.4f m, beyond by %.2f deg", seconds, drift, beyond)
        self.assertLess(drift, 0.03)
        self.assertLess(beyond, 1.0)
        self.assertLess(max(speeds(body)), 1.1 * CAP_MPS)

    def test_3_turn_about_the_body_and_back(self) -> None:
        start = self.pose()
        body = start.compose(Pose2(-1.30, 0.0))
        target = Pose2(body.x, body.y, start.yaw_rad - math.pi / 2).compose(Pose2(1.30, 0.0))
        track = self.drive(target, "True")
        drift = max(body.distance(pose.compose(Pose2(-1.30, 0.0))) for _, pose in track)
        self.assertLess(drift, 0.05)

    def test_4_cancel_stops_within_half_a_second(self) -> None:
        start = self.pose()
        self.start(Pose2(start.x - 1.0, start.y + 1.6, start.yaw_rad))
        with self.condition:
            moving = self.condition.wait_for(
                lambda: speeds(self.track[-4:]) and speeds(self.track[-4:])[-1] > 0.9, 60.0
            )
        self.assertTrue(moving, "never at full speed")
        cancelled_s, at = self.track[-1]
        self.participant.ask(self.client.cancel_goal)
        self.client.wait_for_result(rospy.Duration(10.0))
        self.assertEqual(self.client.get_state(), GoalStatus.PREEMPTED)
        with self.condition:
            stood = self.condition.wait_for(lambda: self.track[-1][0] > cancelled_s + 1.0, timeout=60.0)
            self.assertTrue(stood, "no poses after the cancel")
            after = [(stamp, pose) for stamp, pose in self.track if stamp >= cancelled_s]
        last_moving = max((b[0] for b, speed in zip(after[1:], speeds(after)) if speed > 0.02), default=cancelled_s)
        rospy.loginfo("stopped %.3f s and %.3f m after cancel", last_moving - cancelled_s, at.distance(after[-1][1]))
        self.assertLess(last_moving - cancelled_s, 0.5)

    def test_5_short_and_awkward_motions_are_reached(self) -> None:
        for dx, dy, turn in ((-0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.1, -0.1, 0.3), (0.0, 0.0, -0.3)):
            start = self.pose()
            self.drive(Pose2(start.x + dx, start.y + dy, start.yaw_rad + turn))

    def test_6_wheels_turned_before_the_base_drove_and_stayed_on_the_floor(self) -> None:
        rospy.loginfo("fastest rolling while casters turned: %.3f m/s", max(self.moved_wheels, default=0.0))
        self.assertEqual(self.failures, [])
        heights = np.array(self.wheel_heights)
        lift = heights - np.median(heights, axis=0)
        rospy.loginfo("wheels rise by up to %.2f mm", 1000.0 * lift.max())
        self.assertLess(max(self.moved_wheels, default=0.0), 0.05)
        self.assertLess(lift.max(), 0.001, "a wheel left the floor")

    def test_7_a_goal_that_leads_on_is_gone_on_to_round_the_corner(self) -> None:
        start = self.pose()
        corner = Pose2(start.x - 0.5, start.y + 0.8, start.yaw_rad)
        turned = math.atan2(0.8, -0.5) + math.radians(25.0)
        target = Pose2(corner.x + 0.6 * math.cos(turned), corner.y + 0.6 * math.sin(turned), start.yaw_rad)
        first = self.start(corner)
        with self.condition:
            self.assertTrue(self.condition.wait_for(lambda: start.distance(self.track[-1][1]) > 0.4, timeout=60.0))
        self.start(target, via=[corner])
        self.assertTrue(self.client.wait_for_result(rospy.Duration(60.0)), "no result")
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED, self.client.get_result().message)
        with self.condition:
            track = self.track[first:]
        off = max(min(line_distance(pose, start, corner), line_distance(pose, corner, target)) for _, pose in track)
        near = [k for k, (_, pose) in enumerate(track[1:]) if pose.distance(corner) < 0.25]
        slowest = min(speeds(track)[k] for k in near)
        rospy.loginfo(
            "round 25 deg: %.1f s, off the lines by %.4f m, slowest %.2f m/s", track[-1][0] - track[0][0], off, slowest
        )
        self.assertGreater(slowest, 0.4)
        self.assertLess(off, 0.05)
        self.assertLess(self.pose().distance(target), 0.03)


def message_of(pose: Pose2) -> Pose:
    """A pose at the end effector's height."""
    q = Quaternion(*quaternion_from_rpy(0.0, 0.0, pose.yaw_rad))
    return Pose(Point(pose.x, pose.y, 0.89), q)


def line_distance(pose: Pose2, start: Pose2, end: Pose2) -> float:
    """Distance from the straight way between two poses, metres."""
    ahead = (pose.x - start.x) * (end.x - start.x) + (pose.y - start.y) * (end.y - start.y)
    if ahead <= 0.0 or ahead >= start.distance(end) ** 2:
        return min(pose.distance(start), pose.distance(end))
    return path_deviation(start, end, pose)


def speeds(track: List[Tuple[float, Pose2]]) -> List[float]:
    """Speed between each two poses, m/s."""
    return [a[1].distance(b[1]) / max(b[0] - a[0], 1e-6) for a, b in zip(track[:-1], track[1:])]


if __name__ == "__main__":
    init_node("control_physics_test")
    rostest.rosrun("yarm", "control_physics", PhysicsTest)
