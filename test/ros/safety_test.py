#!/usr/bin/env python3
"""Robots are sent at the table, at each other and at the HC10, past the Commander; ground truth must see no contact."""

from __future__ import annotations

import math
import sys
import threading
import unittest
from pathlib import Path

import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from yarm.msg import Contacts, MoveRobotAction, MoveRobotGoal, SafetyStatus

from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.goals import send_when_permitted
from support.participant import Participant

LIMIT_S = 30.0
WALL_LIMIT_S = 120.0
HEIGHT_M = 0.89


class SafetyTest(unittest.TestCase):
    """Each wrong command ends in a stop, with a reason, and the robot may leave afterwards."""

    @classmethod
    def setUpClass(cls):
        cls.heard = threading.Condition()
        cls.failures, cls.reasons, cls.held = [], [], True
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, cls.on_safety, queue_size=100)
        cls.clients = {}
        for robot in ("ankurbot_1", "ankurbot_2", "ankurbot_3"):
            cls.clients[robot] = SimpleActionClient(names.move_robot(robot), MoveRobotAction)
        Participant.wait_for_begin()
        for robot, client in cls.clients.items():
            assert client.wait_for_server(rospy.Duration(60.0)), robot

    @classmethod
    def on_contacts(cls, message):
        with cls.heard:
            cls.failures += [f"{c.body_a} {c.link_a} / {c.body_b}" for c in message.contacts if c.kind == "failure"]

    @classmethod
    def on_safety(cls, message):
        with cls.heard:
            cls.held = any(message.stopped)
            cls.reasons += [message.reason] if cls.held else []
            cls.heard.notify_all()

    def wait(self, condition, what):
        with self.heard:
            self.assertTrue(self.heard.wait_for(condition, WALL_LIMIT_S), f"never came: {what}")

    def send(self, robot, x, y, yaw_deg):
        self.wait(lambda: not self.held, "the end of the last stop")
        with self.heard:
            self.reasons.clear()
        goal = MoveRobotGoal(target=pose_message(x, y, HEIGHT_M, math.radians(yaw_deg)), action="False")
        state = send_when_permitted(self.clients[robot], goal, LIMIT_S)
        if state == GoalStatus.PREEMPTED:
            self.wait(lambda: self.reasons, "the safety monitor's reason")
        with self.heard:
            reason = self.reasons[-1] if self.reasons else ""
            self.assertEqual(self.failures, [])
        return state, reason

    def test_1_a_good_command_is_left_alone(self):
        state, reason = self.send("ankurbot_1", 0.75, 0.05, 180.0)
        self.assertEqual((state, reason), (GoalStatus.SUCCEEDED, ""))

    def test_2_body_into_the_table_is_stopped(self):
        state, reason = self.send("ankurbot_1", -0.90, 0.05, 180.0)
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertIn("ankurbot_1 on its step to (-0.90, 0.05", reason)
        self.assertIn("of table", reason)

    def test_3_and_it_may_go_back(self):
        state, reason = self.send("ankurbot_1", 0.75, 0.05, 180.0)
        self.assertEqual((state, reason), (GoalStatus.SUCCEEDED, ""))

    def test_4_a_turn_into_the_other_robot_is_stopped(self):
        state, _ = self.send("ankurbot_2", 0.75, 0.85, 180.0)
        self.assertIn(state, (GoalStatus.SUCCEEDED, GoalStatus.PREEMPTED))
        state, reason = self.send("ankurbot_2", 0.75, 0.05, 180.0)
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertIn("ankurbot_2 on its step", reason)
        self.assertIn("of ankurbot_1", reason)

    def test_5_an_arm_over_the_stand_into_the_hc10_is_stopped(self):
        state, reason = self.send("ankurbot_3", -1.1, 0.05, 270.0)
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertIn("ankurbot_3 on its step to (-1.10, 0.05", reason)
        self.assertIn("of hc10_barc", reason)


if __name__ == "__main__":
    init_node("safety_test")
    rostest.rosrun("yarm", "safety_test", SafetyTest, sys.argv)
