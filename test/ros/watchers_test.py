#!/usr/bin/env python3
"""The HC10 and a robot move only while maps, safety monitor and Commander are there; then they go on by themselves."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import sys
from pathlib import Path

import numpy as np
import psutil
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage
from yarm.msg import CommanderStatus, SafetyStatus, SanderStatus
from yarm.srv import SpawnObstaclesRequest

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.commander_driver import CommanderDriver

ROBOT, ARM = "ankurbot_1", "hc10_barc"
CONTROLS, SANDER = "multi_robot_controls_server", "hc10_state_machine"
STOP_S = 1.0
"""Braking of the arm, or of the robot at full speed: 0.3 s, and what a busy machine takes for the messages, s."""
REST_MPS, REST_RADPS, DRIVES_MPS = 0.03, 0.02, 0.3


def pace(before, now):
    """Speed between two places (x, y), each with its stamp, m/s."""
    return math.hypot(*(now[1] - before[1])) / (now[0] - before[0])


class WatchersTest(CommanderDriver):
    """The tests build on each other, in the order of their names."""

    LIMIT_S = 240.0

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.sander, cls.sander_said, cls.track, cls.joints = SanderStatus(), [], [], []
        cls.again, cls.safety = set(), SafetyStatus()
        rospy.Subscriber(names.SAFETY_STATUS, SafetyStatus, cls.on_safety, queue_size=100)
        rospy.Subscriber(names.DIAGNOSTICS, DiagnosticArray, cls.on_diagnostics, queue_size=100)
        rospy.Subscriber(names.sander_status(ARM), SanderStatus, cls.on_sander, queue_size=100)
        rospy.Subscriber(names.joint_states(ARM), JointState, cls.on_joints, queue_size=1000)
        rospy.Subscriber("/tf", TFMessage, cls.on_tf, queue_size=1000)

    def told(self):
        return f"{super().told()}; {self.sander}"

    @classmethod
    def on_sander(cls, message):
        with cls.condition:
            cls.sander = message
            cls.sander_said.append(message)
            cls.condition.notify_all()

    @classmethod
    def on_safety(cls, message):
        with cls.condition:
            cls.safety = message
            cls.condition.notify_all()

    @classmethod
    def on_diagnostics(cls, message):
        told = {s.name.split(":")[0] for s in message.status if any(v.key == "started again" for v in s.values)}
        with cls.condition:
            cls.again |= told
            cls.condition.notify_all()

    @classmethod
    def on_joints(cls, message):
        with cls.condition:
            cls.joints.append((message.header.stamp.to_sec(), np.array(message.position)))
            cls.condition.notify_all()

    @classmethod
    def on_tf(cls, message):
        for transform in message.transforms:
            if transform.child_frame_id.lstrip("/") == names.ee_frame(ROBOT):
                at = transform.transform.translation
                with cls.condition:
                    cls.track.append((transform.header.stamp.to_sec(), np.array((at.x, at.y))))
                    cls.condition.notify_all()

    def first(self, condition, what, after_s=0.0):
        """The sander's first word of a kind after a time; it may have said something else since."""

        def found():
            words = (word for word in self.sander_said if word.header.stamp.to_sec() > after_s and condition(word))
            return next(words, None)

        self.wait(found, what)
        with self.condition:
            return found()

    def speed(self, samples, since_s, until_s):
        """Greatest speed between neighbouring samples of (stamp, value) taken from one time to another."""
        self.wait(lambda: samples[-1][0] >= until_s, "samples")
        with self.condition:
            found = [sample for sample in samples if since_s <= sample[0] <= until_s]
        steps = [np.abs(b - a).max() / (t - s) for (s, a), (t, b) in zip(found, found[1:]) if t > s]
        self.assertGreater(len(steps), 10, "samples")
        return max(steps)

    def drive(self, name, at):
        """A new target, and the robot really on its way to it."""
        self.wait(lambda: not self.status.busy, "end of what went before")
        answer = self.spawn(SpawnObstaclesRequest(name=name, type="Target", x=at[0], y=at[1], z=0.89))
        self.assertTrue(answer.success, answer.message)
        self.begin_mission()
        self.wait(self.driving, "robot under way")

    def driving(self):
        before, now = self.track[-10], self.track[-1]
        return now[0] > before[0] and pace(before, now) > DRIVES_MPS

    def rests(self, since_s, seconds=2.0):
        """Robot and arm are at rest from a simulated time on, for some seconds."""
        self.assertLess(self.speed(self.track, since_s, since_s + seconds), REST_MPS)
        self.assertLess(self.speed(self.joints, since_s, since_s + seconds), REST_RADPS)

    def test_1_blind_the_arm_stops_before_the_robot_and_goes_on_when_cameras_see(self):
        self.enter(CommanderStatus.STARTED, current_state=True)
        self.enter(CommanderStatus.CALIBRATION, next_state=True)
        self.ended()
        self.enter(CommanderStatus.MENU, next_state=True)
        sanding = self.first(lambda word: word.moving and word.progress > 0.003, "sanding")
        stopped = self.first(
            lambda word: "forbids motion" in word.reason or "old" in word.reason,
            "the arm's word",
            sanding.header.stamp.to_sec(),
        )
        self.assertIn("commander", stopped.reason)
        self.rests(stopped.header.stamp.to_sec() + STOP_S, 8.0)
        self.wait(lambda: self.sander.reason == "" and self.sander.progress > stopped.progress + 0.002, "sanding again")

    def test_2_a_frozen_safety_monitor(self):
        self.frozen(names.SAFETY_NODE, "target_1", (-1.9, 1.65))

    def test_3_a_frozen_commander_is_named_by_the_command_line(self):
        self.drive("target_2", (0.65, 1.65))
        with self.stopped(names.COMMANDER_NODE):
            since_s = rospy.get_time()
            self.rests(since_s + 0.6 + STOP_S + 0.1, 3.0)
            self.wait(lambda: "nothing heard from commander" in self.sander.reason, "the arm's word")
            code, said = self.cli("status", timeout_s=20.0)
            self.assertEqual(code, 2, said)
            self.assertIn("nothing heard from commander for", said)
        self.ended()
        self.assertEqual(self.cli("status", timeout_s=self.LIMIT_S)[0], 0)

    def test_4_nodes_that_die_come_back_by_themselves_and_the_mission_goes_on(self):
        self.drive("target_3", (-1.9, 1.65))
        since_s = self.killed(CONTROLS, CONTROLS, stops=True)
        self.wait(lambda: self.drove_on(since_s), "robot under way again")
        self.killed("seed_tf_publisher", "seed_tf_publisher")
        self.ended()
        self.drive("target_4", (0.65, 1.65))
        since_s = self.killed(names.SAFETY_NODE, names.SAFETY_NODE, stops=True)
        self.wait(lambda: self.drove_on(since_s), "robot under way again")
        self.killed("perception", "cluster_assoc")
        self.ended()

    def test_5_a_commander_that_dies_in_a_step_is_followed_by_one_that_ends_the_mission(self):
        self.drive("target_5", (-1.9, 1.65))
        since_s = self.killed(names.COMMANDER_NODE, names.COMMANDER_NODE, stops=True)
        self.wait(lambda: self.drove_on(since_s), "robot under way again")
        self.ended()
        self.assertEqual([(task.goal, task.status) for task in self.status.tasks], [("target_5", "reached")])

    def test_6_a_sander_that_dies_leaves_the_arm_at_rest_and_the_next_one_goes_on(self):
        self.wait(lambda: self.sander.moving and not self.sander.lifted and self.sander.progress > 0.0, "sanding")
        progress, since_s = self.sander.progress, rospy.get_time()
        with self.condition:
            self.sander_said.clear()
        self.killed(SANDER, SANDER)
        self.wait(lambda: self.rested(since_s), "rest of the arm")
        self.wait(lambda: self.sander_said, "word of the next sander")
        self.assertGreaterEqual(self.sander_said[0].progress, progress - 0.002)
        self.wait(lambda: self.sander.progress > progress + 0.002, "sanding again")

    def test_7_a_controls_server_that_hangs_is_named_and_replaced(self):
        self.drive("target_7", (0.65, 1.65))
        pid, since_s = self.pid_of(CONTROLS), rospy.get_time()
        with self.condition:
            self.again.clear()
        os.kill(pid, signal.SIGSTOP)
        self.wait(lambda: any("the action server of" in reason for reason in self.reasons), "the Commander's word")
        self.wait(lambda: self.stood(since_s), "rest of the robot")
        self.wait(lambda: CONTROLS in self.again, "word of the next controls server")
        self.assertFalse(psutil.pid_exists(pid))
        self.ended()

    def test_8_a_persons_stop_outlives_the_safety_monitor(self):
        self.drive("target_8", (-1.9, 1.65))
        stop = rospy.ServiceProxy(names.SAFETY_STOP, SetBool)
        self.assertTrue(stop(True).success)
        self.wait(lambda: self.safety.latched, "the monitor's word")
        self.rests(self.safety.header.stamp.to_sec() + STOP_S)
        self.killed(names.SAFETY_NODE, names.SAFETY_NODE)
        with self.condition:
            type(self).safety = SafetyStatus()
        self.wait(lambda: self.safety.robots, "word of the new monitor")
        self.assertTrue(self.safety.latched, self.safety)
        self.assertIn(f"stopped by {rospy.get_name()} at", self.safety.reason)
        since_s = self.safety.header.stamp.to_sec()
        self.rests(since_s)
        self.wait(lambda: any("stopped by" in reason for reason in self.reasons), "word of the Commander")
        rospy.wait_for_service(names.SAFETY_STOP, timeout=self.LIMIT_S)
        released = stop(False)
        self.assertTrue(released.success, released.message)
        self.wait(lambda: self.drove_on(since_s), "robot under way again")
        self.ended()

    def rested(self, since_s):
        """Whether the arm has been at rest for a moment since a simulated time."""
        found = [(stamp_s, joints) for stamp_s, joints in self.joints if stamp_s > since_s]
        return any(np.abs(b - a).max() / (t - s) < REST_RADPS for (s, a), (t, b) in zip(found, found[5:]) if t > s)

    def killed(self, node, teller, stops=False):
        """A node is killed; another takes its place and says so. Gives back when it was killed, s of simulated time.

        With ``stops`` whoever starts it again is held until the robot stands: it may be back too soon for a stand.
        """
        pid, since_s = self.pid_of(node), rospy.get_time()
        with self.condition:
            self.again.clear()
        with self.held(psutil.Process(pid).parent()) if stops else contextlib.nullcontext():
            os.kill(pid, signal.SIGKILL)
            if stops:
                self.wait(lambda: self.stood(since_s), "rest of the robot")
        self.wait(lambda: teller in self.again, f"word of {teller} that it was started again")
        self.assertNotEqual(self.pid_of(node), pid)
        return since_s

    @contextlib.contextmanager
    def held(self, process):
        """A process stands still."""
        process.suspend()
        try:
            yield
        finally:
            process.resume()

    def stood(self, since_s):
        """Whether the robot has been at rest for a moment since a simulated time."""
        found = [(stamp_s, place) for stamp_s, place in self.track if stamp_s > since_s]
        pairs = [(a, b) for a, b in zip(found, found[5:]) if b[0] > a[0]]
        return any(np.abs(b - a).max() / (t - s) < REST_MPS for (s, a), (t, b) in pairs)

    def drove_on(self, since_s):
        """Whether the robot has stood since a simulated time and then driven; it may have arrived meanwhile."""
        found = [(stamp_s, place) for stamp_s, place in self.track if stamp_s > since_s]
        pairs = list(zip(found, found[5:]))
        rests = (i for i, (a, b) in enumerate(pairs) if b[0] > a[0] and pace(a, b) < REST_MPS)
        rest = next(rests, len(found))
        return any(b[0] > a[0] and pace(a, b) > DRIVES_MPS for a, b in zip(found[rest:], found[rest + 9 :]))

    def frozen(self, node, target, at):
        """A frozen node stops everything; thawed, all goes on."""
        self.drive(target, at)
        with self.stopped(node):
            since_s = rospy.get_time()
            self.rests(since_s + 0.25 + STOP_S, 3.0)
            self.wait(lambda: f"nothing heard from {node}" in self.sander.reason, "the arm's word")
        self.ended()


if __name__ == "__main__":
    init_node("watchers_test")
    rostest.rosrun("yarm", "watchers_test", WatchersTest, sys.argv)
