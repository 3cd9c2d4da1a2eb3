#!/usr/bin/env python3
"""Robots are sent at the table, at each other and at the HC10, past the Commander; ground truth must see no contact.

And a person stops everything while it moves.
"""

from __future__ import annotations

import math
import sys
import threading
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from sensor_msgs.msg import JointState, Joy
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage
from yarm.msg import Contacts, MoveRobotAction, MoveRobotGoal, SafetyStatus, SanderStatus

from yarm.control.sander.states import Button, SanderState
from yarm.ros.common import names
from yarm.ros.common.conversions import pose_message
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.goals import send_when_permitted
from support.participant import Participant

LIMIT_S = 30.0
WALL_LIMIT_S = 120.0
HEIGHT_M = 0.89
ARM, DRIVEN = "hc10_barc", "ankurbot_1"
REST_S, RESTS_FOR_S = 0.5, 1.5
"""Everything is at rest so long after a stop, and is then looked at for so long; simulated, s."""
REST_MPS, REST_RADPS = 0.03, 0.02


class SafetyTest(unittest.TestCase):
    """Each wrong command ends in a stop, with a reason, and the robot may leave afterwards."""

    @classmethod
    def setUpClass(cls):
        cls.heard = threading.Condition()
        cls.failures, cls.reasons, cls.held = [], [], True
        cls.safety, cls.sander = SafetyStatus(), SanderStatus()
        cls.tracks = {DRIVEN: [], ARM: []}
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, cls.on_safety, queue_size=100)
        rospy.Subscriber(names.sander_status(ARM), SanderStatus, cls.on_sander, queue_size=100)
        rospy.Subscriber(names.joint_states(ARM), JointState, cls.on_joints, queue_size=1000)
        rospy.Subscriber("/tf", TFMessage, cls.on_tf, queue_size=1000)
        cls.joy = rospy.Publisher(names.sander_joy(ARM), Joy, queue_size=10)
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
            cls.safety, cls.held = message, any(message.stopped)
            cls.reasons += [message.reason] if cls.held else []
            cls.heard.notify_all()

    @classmethod
    def on_sander(cls, message):
        with cls.heard:
            cls.sander = message
            cls.heard.notify_all()

    @classmethod
    def on_joints(cls, message):
        cls.note(ARM, message.header.stamp, message.position)

    @classmethod
    def on_tf(cls, message):
        for transform in message.transforms:
            if transform.child_frame_id.lstrip("/") == names.ee_frame(DRIVEN):
                at = transform.transform.translation
                cls.note(DRIVEN, transform.header.stamp, (at.x, at.y))

    @classmethod
    def note(cls, name, stamp, place):
        with cls.heard:
            cls.tracks[name].append((stamp.to_sec(), np.array(place)))
            cls.heard.notify_all()

    def fastest(self, name, since_s, until_s):
        """Greatest speed between neighbouring samples from one simulated time to another."""
        self.wait(lambda: self.tracks[name][-1][0] >= until_s, f"samples of {name}")
        with self.heard:
            found = [sample for sample in self.tracks[name] if since_s <= sample[0] <= until_s]
        steps = [np.abs(b - a).max() / (t - s) for (s, a), (t, b) in zip(found, found[1:]) if t > s]
        self.assertGreater(len(steps), 10, name)
        return max(steps)

    def moves(self, name, speed):
        track = self.tracks[name][-10:]
        return len(track) == 10 and np.abs(track[-1][1] - track[0][1]).max() > speed * (track[-1][0] - track[0][0]) > 0

    def press(self, button):
        """One press of the sander's joystick, and the sander's word that it has come."""
        before = self.sander.presses
        self.joy.publish(Joy(axes=[0.0] * 4, buttons=[int(button is b) for b in Button]))
        self.joy.publish(Joy(axes=[0.0] * 4, buttons=[0] * len(Button)))
        self.wait(lambda: self.sander.presses > before, f"answer to button {button.name}")

    def stop(self, on):
        answer = rospy.ServiceProxy(names.SAFETY_STOP, SetBool)(on)
        self.assertTrue(answer.success, answer.message)
        return answer.message

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

    def test_4_a_person_stops_everything_that_moves(self):
        self.wait(lambda: self.joy.get_num_connections() > 0, "sander")
        self.press(Button.ADVANCE)
        goal = MoveRobotGoal(target=pose_message(1.75, 0.05, HEIGHT_M, math.pi), action="False")
        self.clients[DRIVEN].send_goal(goal)
        self.wait(lambda: self.moves(DRIVEN, 0.3) and self.moves(ARM, 0.1), "motion of robot and arm")
        said = self.stop(True)
        self.assertIn(f"stopped by {rospy.get_name()} at", said)
        self.wait(lambda: self.safety.latched, "the monitor's word")
        since_s = self.safety.header.stamp.to_sec() + REST_S
        self.assertLess(self.fastest(DRIVEN, since_s, since_s + RESTS_FOR_S), REST_MPS)
        self.assertLess(self.fastest(ARM, since_s, since_s + RESTS_FOR_S), REST_RADPS)
        self.assertEqual((self.safety.reason, set(self.safety.stopped)), (said, {True}))
        self.assertEqual(self.sander.reason, f"stands: {said}")
        self.assertTrue(self.clients[DRIVEN].wait_for_result(rospy.Duration(LIMIT_S)))
        state = self.clients[DRIVEN].send_goal_and_wait(goal, rospy.Duration(LIMIT_S))
        self.assertEqual((state, self.clients[DRIVEN].get_goal_status_text()), (GoalStatus.REJECTED, f"stands: {said}"))
        self.assertEqual(self.stop(True), said)

    def test_5_and_releases_it_again(self):
        self.assertTrue(self.safety.latched)
        self.assertIn("released; it was stopped by", self.stop(False))
        self.wait(lambda: not self.safety.latched and self.moves(ARM, 0.1), "the arm going on by itself")
        self.assertEqual(self.stop(False), "nothing was stopped")
        self.press(Button.HOLD)
        self.press(Button.STORE)
        self.wait(lambda: self.sander.state == SanderState.STORAGE and not self.sander.moving, "the arm in storage")
        state, reason = self.send(DRIVEN, 0.75, 0.05, 180.0)
        self.assertEqual((state, reason), (GoalStatus.SUCCEEDED, ""))

    def test_6_a_turn_into_the_other_robot_is_stopped(self):
        state, _ = self.send("ankurbot_2", 0.75, 0.85, 180.0)
        self.assertIn(state, (GoalStatus.SUCCEEDED, GoalStatus.PREEMPTED))
        state, reason = self.send("ankurbot_2", 0.75, 0.05, 180.0)
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertIn("ankurbot_2 on its step", reason)
        self.assertIn("of ankurbot_1", reason)

    def test_7_an_arm_over_the_stand_into_the_hc10_is_stopped(self):
        state, reason = self.send("ankurbot_3", -1.1, 0.05, 270.0)
        self.assertEqual(state, GoalStatus.PREEMPTED)
        self.assertIn("ankurbot_3 on its step to (-1.10, 0.05", reason)
        self.assertIn("of hc10_barc", reason)


if __name__ == "__main__":
    init_node("safety_test")
    rostest.rosrun("yarm", "safety_test", SafetyTest, sys.argv)
