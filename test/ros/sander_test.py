#!/usr/bin/env python3
"""The HC10 in the simulated cell, driven through its action as the Commander drives it."""

from __future__ import annotations

import math
import sys
import threading
import unittest
from pathlib import Path
from typing import Callable, List, Tuple

import numpy as np
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point
from sensor_msgs.msg import JointState, Joy
from std_msgs.msg import Float32, Int8
from yarm.msg import Contacts, KeepOff, MoveRobotAction, MoveRobotGoal, SanderStatus

from yarm.control.arm.model import ArmKinematics, load_arm
from yarm.control.sander.raster import coverage
from yarm.control.sander.states import SanderState
from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.participant import Participant

ARM = "hc10_barc"
PART = ((-0.45, -0.30), (-0.05, 0.30))
PART_TOP_M, TOOL_RADIUS_M = 0.73, 0.06
WAIT_S = 120.0
NOTHING, KEPT_M = KeepOff(), 0.35


class SanderTest(unittest.TestCase):
    """Storage, scan, part, raster with pauses, teleoperation and storage again, in the order of the names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.arm = load_arm()
        cls.kinematics = ArmKinematics(cls.arm)
        cls.condition = threading.Condition()
        cls.samples: List[Tuple[float, np.ndarray]] = []
        cls.tips: List[np.ndarray] = []
        cls.tilts: List[float] = []
        cls.contacts: List[str] = []
        cls.states: List[int] = []
        cls.status = SanderStatus()
        cls.progress = 0.0
        cls.switched_s = 0.0
        cls.participant = Participant()
        rospy.Subscriber(names.joint_states(ARM), JointState, cls.on_joints, queue_size=1000)
        rospy.Subscriber(names.sander_status(ARM), SanderStatus, cls.on_status)
        rospy.Subscriber(names.sander_state(ARM), Int8, cls.on_state)
        rospy.Subscriber(names.sander_progress(ARM), Float32, cls.on_progress)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        cls.joy = rospy.Publisher(names.sander_joy(ARM), Joy, queue_size=10)
        cls.client = SimpleActionClient(names.move_robot(ARM), MoveRobotAction)
        cls.participant.wait_for_begin()
        assert cls.client.wait_for_server(rospy.Duration(60.0))

    @classmethod
    def on_joints(cls, message: JointState) -> None:
        """Keep the reading; the next camera set comes when the test has it."""
        angles = dict(zip(message.name, message.position))
        q = np.array([angles[joint.name] for joint in cls.arm.model.moving_joints])
        with cls.condition:
            pose = cls.kinematics.tip(q)
            cls.samples.append((message.header.stamp.to_sec(), q))
            if cls.status.state == SanderState.SCAN_TO_PATH:
                cls.tips.append(pose[:3, 3])
                cls.tilts.append(math.degrees(math.acos(min(max(-pose[2, 2], -1.0), 1.0))))
            cls.condition.notify_all()
        cls.participant.took(message.header.stamp)

    @classmethod
    def on_status(cls, message: SanderStatus) -> None:
        with cls.condition:
            if cls.status.enabled and not message.enabled:
                cls.switched_s = message.header.stamp.to_sec()
            cls.status = message

    @classmethod
    def on_state(cls, message: Int8) -> None:
        with cls.condition:
            cls.states.append(message.data)

    @classmethod
    def on_progress(cls, message: Float32) -> None:
        with cls.condition:
            cls.progress = message.data

    @classmethod
    def on_contacts(cls, message: Contacts) -> None:
        for contact in message.contacts:
            if not contact.allowed and ARM in (contact.body_a, contact.body_b):
                cls.contacts.append(f"{contact.body_a} {contact.link_a} - {contact.body_b} {contact.link_b}")

    def act(self, action: str, state: int = GoalStatus.SUCCEEDED, keep_off: KeepOff = NOTHING) -> str:
        self.participant.ask(lambda: self.client.send_goal(MoveRobotGoal(action=action, keep_off=keep_off)))
        self.assertTrue(self.client.wait_for_result(rospy.Duration(WAIT_S)), f"{action}: no result")
        message = self.client.get_result().message
        self.assertEqual(self.client.get_state(), state, f"{action}: {message}")
        return message

    def wait(self, condition: Callable[[], bool], what: str) -> None:
        with self.condition:
            end = rospy.get_time() + WAIT_S
            while not condition():
                self.condition.wait(timeout=5.0)
                self.assertNotIn("stays where it is", self.status.reason)
                self.assertLess(rospy.get_time(), end, f"never came: {what}; the sander says: {self.status}")

    def press(self, button: int) -> None:
        for pressed in (1, 0):
            self.joy.publish(Joy(axes=[0.0] * 4, buttons=[pressed * int(i == button) for i in range(4)]))

    def now(self) -> Tuple[float, np.ndarray]:
        with self.condition:
            return self.samples[-1]

    def rest_time(self, since_s: float) -> float:
        """Time from a moment until the tip stands still over the part (it may lift already), s."""
        with self.condition:
            samples = [(stamp, self.kinematics.tip(q)[:2, 3]) for stamp, q in self.samples if stamp >= since_s]
        pairs = zip(samples[:-1], samples[1:])
        speeds = [(b[0], float(np.linalg.norm(b[1] - a[1])) / (b[0] - a[0])) for a, b in pairs]
        return next((stamp for stamp, speed in speeds if speed < 0.01), math.inf) - since_s

    def tip(self) -> np.ndarray:
        return self.kinematics.tip(self.now()[1])[:3, 3]

    def refusal_of_on(self) -> str:
        """Why ON is refused, by an action server that has heard of the sander's state, as this test has."""
        end = rospy.get_time() + WAIT_S
        while rospy.get_time() < end:
            message = self.act("ON", GoalStatus.REJECTED)
            if "has not reported its state" not in message:
                return message
        raise AssertionError("the action server never heard of the sander's state")

    def hovers(self) -> bool:
        """Whether it stands lifted off the part, by its status and by its joints."""
        return self.status.lifted and self.kinematics.tip(self.samples[-1][1])[2, 3] >= 1.15

    def test_1_wrong_actions_are_refused_by_name(self) -> None:
        self.wait(lambda: self.status.state_name == "storage", "the sander's status")
        self.assertIn("'DANCE'", self.act("DANCE", GoalStatus.REJECTED))
        self.assertIn("state 0 (storage)", self.refusal_of_on())

    def test_2_calibration_ends_in_state_4_stopped_above_the_part(self) -> None:
        self.assertEqual(self.act("CALIBRATION"), "SPACE=SWITCH/AREA=11,29,17,32,0,10")
        # The result, the states, the status and the joints come on four topics, in any order.
        self.wait(lambda: SanderState.SCAN_TO_PATH in self.states, "state 4")
        self.assertEqual([s for s in self.states if s], [1, 2, 3, 4])
        self.wait(self.hovers, "the hover")
        self.assertEqual(self.status.progress, 0.0)

    def test_3_pause_stops_and_lifts_then_resumes_where_it_stopped(self) -> None:
        self.act("ON")
        self.wait(lambda: self.progress > 0.12, "12 % of the raster")
        sent_s = self.now()[0]
        self.act("OFF")
        self.wait(self.hovers, "the hover")
        rospy.loginfo(
            "at rest %.3f s after the switch came, %.3f s after the goal was sent",
            self.rest_time(self.switched_s),
            self.rest_time(sent_s),
        )
        self.assertLess(self.rest_time(self.switched_s), 0.3)
        stopped = self.status.progress
        tips_before = len(self.tips)
        self.act("ON")
        self.wait(lambda: self.status.progress > stopped + 0.01, "more of the raster")
        resumed = np.array(self.tips[tips_before:])
        first = resumed[resumed[:, 2] < PART_TOP_M + 0.004][0]
        earlier = np.array(self.tips[:tips_before])
        last = earlier[earlier[:, 2] < PART_TOP_M + 0.004][-1]
        self.assertLess(float(np.linalg.norm(first - last)), 0.02)

    def test_4_told_what_to_keep_off_it_sands_elsewhere_then_the_whole_part(self) -> None:
        tips_before = len(self.tips)
        self.act("ON", keep_off=KeepOff([Point(*PART[0], 0.0)], KEPT_M))
        self.wait(lambda: "too near" in self.status.reason and self.status.lifted, "all that may be sanded now")
        tips = np.array(self.tips[tips_before:])
        low = tips[tips[:, 2] < PART_TOP_M + 0.004]
        low = low[np.linalg.norm(low - low[0], axis=1) > 0.05]  # it was sanding there when it was told
        self.assertGreater(len(low), 100)
        self.assertGreater(float(np.linalg.norm(low[:, :2] - PART[0], axis=1).min()), KEPT_M - 0.01)
        self.assertLess(self.status.progress, 0.9)
        self.act("ON")
        self.wait(lambda: self.status.progress >= 1.0 and self.status.lifted, "the raster's end")
        tilts = np.array(self.tilts)  # kept after each tip, so there are at least as many tips
        tips = np.array(self.tips[: len(tilts)])
        share = coverage(tips, PART[0], PART[1], PART_TOP_M, TOOL_RADIUS_M)
        low = tips[:, 2] < PART_TOP_M + 0.004
        rospy.loginfo(
            "coverage %.4f; tilt up to %.2f deg; lowest tip %.4f m", share, tilts[low].max(), tips[:, 2].min()
        )
        self.assertGreaterEqual(share, 0.95)
        self.assertLess(float(tilts[low].max()), 5.0)
        self.assertGreater(float(tips[:, 2].min()), PART_TOP_M - 0.005)

    def test_5_cleanup_goes_home_and_teleoperation_moves_the_tip(self) -> None:
        self.act("CLEANUP")
        self.wait(lambda: self.status.state == SanderState.STORAGE, "storage")
        self.wait(lambda: np.max(np.abs(self.samples[-1][1] - self.arm.storage)) < 0.02, "the storage pose")
        self.press(2)
        self.wait(lambda: self.status.state == SanderState.TELEOPERATION, "teleoperation")
        before = self.tip()
        end = rospy.get_time() + 1.5
        while rospy.get_time() < end:
            self.joy.publish(Joy(axes=[0.0, 1.0, 0.0, 0.0], buttons=[0] * 4))
            self.now_changes()
        moved = self.tip() - before
        self.assertGreater(moved[1], 0.08)
        self.assertLess(abs(moved[0]) + abs(moved[2]), 0.02)
        self.press(1)
        self.wait(lambda: self.status.state == SanderState.STORAGE, "storage")

    def test_6_limits_were_never_exceeded_and_nothing_was_touched(self) -> None:
        stamps = np.array([s for s, _ in self.samples])
        q = np.array([q for _, q in self.samples])
        self.assertTrue(np.all(np.diff(stamps) > 0.0))
        self.assertTrue(self.arm.limits.contain(q))
        share = np.abs(np.diff(q, axis=0)) / np.diff(stamps)[:, None] / self.arm.limits.speed
        rospy.loginfo("greatest share of each joint's speed: %s", share.max(axis=0).round(3))
        self.assertLess(float(share.max()), 1.0)
        self.assertEqual(self.contacts, [])

    def now_changes(self) -> None:
        with self.condition:
            self.condition.wait(timeout=1.0)


if __name__ == "__main__":
    init_node("sander_test")
    rostest.rosrun("yarm", "sander", SanderTest)
