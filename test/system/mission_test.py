#!/usr/bin/env python3
"""One whole mission in lock-step, driven by the service as a user would; ground truth decides on contacts."""

from __future__ import annotations

import math
import sys
import threading
import time
import unittest

import rospy
import rostest
import tf2_ros
from rosgraph_msgs.msg import Log as LogMessage
from yarm.msg import CommanderStatus, Contacts, MapMetaData, ObjectRegistry, SafetyStatus, SanderStatus, SimStatus
from yarm.srv import StateChange

from yarm.control.sander.states import SanderState
from yarm.geometry import wrap_angle, yaw_of_quaternion
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.common.status_age import STALE_S, silence

ARM = "hc10_barc"
EXPECTED = {
    "1m1ma": ["debris_1"],
    "3m": ["target_1", "target_2", "target_3"],
    "1m1ma_bin": ["debris_1"],
    "2m1ma_bin": ["debris_1", "debris_2"],
    "3m6_bin": [f"debris_{i}" for i in range(1, 7)],
    "mission_disturbed": [f"debris_{i}" for i in range(1, 5)],
    "mission_unnamed": ["debris_auto_1", "debris_auto_2"],
    "mission_full_bin": ["debris_1"],
}
BODIES = {"debris_auto_1": "loose_1", "debris_auto_2": "loose_2"}
"""Names in the simulator of what only perception has named."""
SAID = {
    "mission_disturbed": [
        "a piece is moved while it is approached",
        "a piece slips off the cup",
        "ankurbot_1 has lost debris_1",
        "the vacuum fails over a piece",
        "PICK debris_2 failed, try 1",
        "a piece falls half over the table's edge",
        "a piece falls beside it, 1 cm apart",
        "the bin is moved while it is approached",
    ],
    "mission_full_bin": ["bin_1 is full: a piece in it lies 0.08 m high, at most 0.06"],
}
"""What must have been logged: that each disturbance has happened, and that it was noticed."""
LIES_IN = {"mission_full_bin": {"debris_1": "bin_2", "debris_8": "bin_1", "debris_9": "bin_1"}}
"""In which bin each piece must lie at the end."""
WALL_LIMIT_S = 1000.0
MOST_N = 30.0
"""Nothing is crushed: what a hand may push a piece with."""
HOME_M, HOME_RAD = 0.15, math.radians(5.0)
"""A robot is home when its end effector is this near to where it began: a cell of 0.10 m, and how far beside its middle
a step may end."""


class Heard:
    """Everything the test listens to; guarded by one condition."""

    def __init__(self):
        """Listen."""
        self.condition = threading.Condition()
        self.status = CommanderStatus()
        self.reached = []
        self.failures = []
        self.pushed_n = 0.0
        self.sander = []
        self.present = set()
        self.seen = set()
        self.holds = []
        self.bins = {}
        self.mapped = set()
        self.robots = set()
        self.said = []
        rospy.Subscriber("/rosout", LogMessage, self._on_log, queue_size=1000)
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, self._on_status, queue_size=100)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, self._on_contacts, queue_size=1000)
        rospy.Subscriber(names.sander_status(ARM), SanderStatus, self._on_sander, queue_size=1000)
        rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, self._on_registry, queue_size=10)
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, self._on_safety, queue_size=100)
        rospy.Subscriber(names.SIM_STATUS, SimStatus, self._on_sim, queue_size=100)
        rospy.Subscriber(names.PLANNING_METADATA, MapMetaData, self._on_map, queue_size=1)

    def fresh(self):
        """Whether the status is news of the Commander, and not what a dead one has left."""
        return not silence(self.status, rospy.get_time(), STALE_S)

    def _on_status(self, message):
        with self.condition:
            self.status = message
            for task in message.tasks:
                if task.status == "reached" and task.goal not in self.reached:
                    self.reached.append(task.goal)
            self.condition.notify_all()

    def _on_contacts(self, message):
        with self.condition:
            self.failures += [(message.header.stamp.to_sec(), c) for c in message.contacts if c.kind == "failure"]
            pushed = [c.force for c in message.contacts if "hand" in (c.link_a, c.link_b)]
            self.pushed_n = max([self.pushed_n, *pushed])

    def _on_sander(self, message):
        with self.condition:
            self.sander.append(message)
            self.condition.notify_all()

    def _on_registry(self, message):
        with self.condition:
            self.present = {entry.name for entry in message.entries}
            self.robots |= {entry.name for entry in message.entries if entry.object == "Mobile"}
            self.seen |= self.present
            self.condition.notify_all()

    def _on_sim(self, message):
        with self.condition:
            self.bins = dict(zip(message.debris, message.bins))
            self.condition.notify_all()

    def _on_map(self, message):
        with self.condition:
            self.mapped |= set(message.frames)
            self.condition.notify_all()

    def _on_log(self, message):
        with self.condition:
            self.said.append(message.msg)

    def _on_safety(self, message):
        with self.condition:
            if any(message.stopped):
                self.holds.append((message.header.stamp.to_sec(), message.reason))


class MissionTest(unittest.TestCase):
    """From IDLE through the mission to IDLE."""

    def setUp(self):
        self.scene = rospy.get_param("~scene")
        self.deadline = time.monotonic() + WALL_LIMIT_S
        self.heard = Heard()
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        rospy.wait_for_service(names.COMMANDER_STATE, timeout=120.0)
        self.service = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)

    def wait(self, condition, what):
        with self.heard.condition:
            while not condition():
                left = self.deadline - time.monotonic()
                self.assertGreater(left, 0.0, f"waited for {what}; status: {self.heard.status}")
                self.assertFalse(rospy.is_shutdown(), f"shut down while waiting for {what}")
                self.heard.condition.wait(min(left, 1.0))

    def ask(self, state, **fields):
        answer = self.service(
            **{"next_state": False, "current_state": False, "previous_state": False, "jump_state": 0, **fields}
        )
        self.assertTrue(answer.success, answer.message)
        self.wait(lambda: self.heard.fresh() and self.heard.status.state == state, f"state {state}")

    def idle(self, what):
        self.wait(lambda: self.heard.fresh() and not self.heard.status.busy and self.heard.status.outcome, what)
        self.assertEqual(self.heard.status.outcome, "succeeded", self.heard.status)

    def places(self):
        """Where the simulation says that the end effectors are: x, y, m, and yaw, rad, by robot."""
        found = {}
        for robot in sorted(self.heard.robots):
            frame, latest = names.ee_frame(robot), rospy.Time(0)
            pose = self.tf.lookup_transform(names.WORLD_FRAME, frame, latest, rospy.Duration(30.0)).transform
            q = pose.rotation
            found[robot] = (pose.translation.x, pose.translation.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))
        return found

    def check_home(self, began):
        """By the truth: every robot is back where it began."""
        self.assertTrue(began, "no mobile robot is registered")
        for robot, (x, y, yaw) in self.places().items():
            from_x, from_y, from_yaw = began[robot]
            self.assertLess(math.hypot(x - from_x, y - from_y), HOME_M, f"{robot} from its home, m")
            self.assertLess(abs(wrap_angle(yaw - from_yaw)), HOME_RAD, f"{robot} from its heading at home, rad")

    def test_mission(self):
        rospy.wait_for_message(names.SIM_STATUS, SimStatus, timeout=120.0)  # the lock-step has begun
        self.wait(lambda: self.heard.present, "object_registry")
        began = self.places()
        expected = EXPECTED[self.scene]
        debris = [goal for goal in expected if goal.startswith("debris")]
        self.ask(CommanderStatus.STARTED, current_state=True)
        self.ask(CommanderStatus.CALIBRATION, next_state=True)
        self.idle("the calibration")
        self.ask(CommanderStatus.MENU, next_state=True)
        if debris:
            self.wait(lambda: set(debris) & (self.heard.seen | self.heard.mapped), "debris on the part")
        self.ask(CommanderStatus.BOUNDLESS, jump_state=5)
        self.wait(lambda: set(expected) <= set(self.heard.reached), f"{expected} reached")
        if rospy.get_param("~bins", False):
            bodies = [BODIES.get(name, name) for name in debris]
            self.wait(lambda: all(self.heard.bins.get(body) for body in bodies), f"{bodies} in a bin by ground truth")
        else:
            self.wait(lambda: not set(expected) & self.heard.present, "what was reached to be deleted")
        self.idle("the mission")
        if debris and self.heard.sander:
            self.check_pause_cycle()
        self.ask(CommanderStatus.CLEANUP, next_state=True)
        self.idle("the way home")
        self.check_home(began)
        self.ask(CommanderStatus.IDLE, next_state=True)
        self.ask(CommanderStatus.STARTED, current_state=True)
        with self.heard.condition:
            failures = [f"{t:.2f} s: {c.body_a} {c.link_a} / {c.body_b} {c.link_b}" for t, c in self.heard.failures]
            self.assertEqual(failures, [], "contacts by ground truth")
            if rospy.get_param("~bins", False):
                self.assertEqual([body for body, found in self.heard.bins.items() if not found], [], "pieces in no bin")
                self.assertEqual(LIES_IN.get(self.scene, self.heard.bins), self.heard.bins)
                self.assertGreater(self.heard.pushed_n, 0.0, "no hand has touched anything")
            self.assertLessEqual(self.heard.pushed_n, MOST_N, "a hand's force on a piece, N")
            unsaid = [words for words in SAID.get(self.scene, []) if not any(words in said for said in self.heard.said)]
            self.assertEqual(unsaid, [], f"not said; said: {self.heard.said}")

    def check_pause_cycle(self):
        """Sanding, pause, lift, and sanding again from where it stopped."""
        self.wait(self.resumed, "the HC10 to resume sanding")
        with self.heard.condition:
            at_work = [m for m in self.heard.sander if m.state == SanderState.SCAN_TO_PATH]
        sanding = next(i for i, m in enumerate(at_work) if m.enabled and m.progress > 0.0)
        paused = next(i for i, m in enumerate(at_work) if i > sanding and not m.enabled)
        lifted = next(i for i, m in enumerate(at_work) if i > paused and m.lifted)
        resumed = next(i for i, m in enumerate(at_work) if i > lifted and m.enabled)
        stopped_at = at_work[paused].progress
        self.assertLess(abs(at_work[resumed].progress - stopped_at), 0.02)
        self.assertGreater(at_work[-1].progress, stopped_at)

    def resumed(self):
        at_work = [m for m in self.heard.sander if m.state == SanderState.SCAN_TO_PATH]
        pauses = [i for i, m in enumerate(at_work) if i and at_work[i - 1].enabled and not m.enabled]
        if not pauses:
            return False
        stopped_at = at_work[pauses[-1]].progress
        return at_work[-1].enabled and at_work[-1].progress > stopped_at + 0.01


if __name__ == "__main__":
    init_node("mission_test")
    rostest.rosrun("yarm", "mission_test", MissionTest, sys.argv)
