#!/usr/bin/env python3
"""Main path, refusals, stop, command line, and every fault that leaves the cell itself running."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
import unittest
import xmlrpc.client

import rosnode
import rospy
import rostest
from yarm.msg import CommanderStatus, Contacts, MapMetaData, ObjectRegistry
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest, StateChange, StateChangeRequest

from yarm.ros import names

LIMIT_S = 90.0
FAR = (-1.9, 1.65)


class CommanderTest(unittest.TestCase):
    """The tests build on each other, in the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.condition = threading.Condition()
        cls.status, cls.failures = CommanderStatus(), []
        cls.reasons, cls.in_map, cls.registry = set(), [], ObjectRegistry()
        rospy.Subscriber(names.COMMANDER_STATUS, CommanderStatus, cls.on_status, queue_size=100)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber(names.PLANNING_METADATA, MapMetaData, cls.on_map, queue_size=1, buff_size=1 << 22)
        rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, cls.on_registry, queue_size=10)
        for service in (names.COMMANDER_STATE, names.SPAWN_OBSTACLES, names.DELETE_OBSTACLES):
            rospy.wait_for_service(service, timeout=60.0)
        cls.change = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)
        cls.spawn = rospy.ServiceProxy(names.SPAWN_OBSTACLES, SpawnObstacles)
        cls.delete = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)

    @classmethod
    def on_status(cls, message):
        with cls.condition:
            cls.status = message
            cls.reasons |= {message.reason} | {task.reason for task in message.tasks}
            cls.condition.notify_all()

    @classmethod
    def on_contacts(cls, message):
        with cls.condition:
            cls.failures += [f"{c.body_a} / {c.body_b}" for c in message.contacts if c.kind == "failure"]

    @classmethod
    def on_map(cls, message):
        with cls.condition:
            cls.in_map = list(message.frames)

    @classmethod
    def on_registry(cls, message):
        with cls.condition:
            cls.registry = message

    def tearDown(self):
        with self.condition:
            self.assertEqual(self.failures, [])

    def wait(self, ready, what, limit_s=LIMIT_S):
        deadline = time.monotonic() + limit_s
        with self.condition:
            while not ready():
                left = deadline - time.monotonic()
                self.assertGreater(left, 0.0, f"no {what} within {limit_s} s: {self.status}; reasons: {self.reasons}")
                self.condition.wait(min(left, 0.5))

    def ask(self, **fields):
        with self.condition:
            self.reasons.clear()
        return self.change(StateChangeRequest(**fields))

    def enter(self, state, **fields):
        answer = self.ask(**fields)
        self.assertTrue(answer.success, answer.message)
        self.wait(lambda: self.status.state == state, f"state {state}")

    def ended(self, outcome="succeeded"):
        self.wait(lambda: not self.status.busy and self.status.outcome != "", "end of the work")
        self.assertEqual(self.status.outcome, outcome, self.status)

    def put(self, name, kind, x, y, z=0.89, shape=()):
        answer = self.spawn(SpawnObstaclesRequest(name=name, type=kind, x=x, y=y, z=z, shape=list(shape)))
        self.assertTrue(answer.success, answer.message)

    def take_away(self, name):
        answer = self.delete(SpawnObstaclesRequest(name=name))
        self.assertTrue(answer.success, answer.message)

    def unreachable(self):
        """Reason by goal of the goals nobody can reach."""
        return {task.goal: task.reason for task in self.status.tasks if task.status == "unreachable"}

    def moving(self):
        return any(task.status == "moving" for task in self.status.tasks)

    def said(self, words):
        return lambda: any(words in reason for reason in self.reasons)

    def go(self, name, at):
        """A new target, and the robot on its way to it."""
        self.wait(lambda: not self.status.busy, "end of what went before")
        self.put(name, "Target", *at)
        fields = {"current_state": True} if self.status.state == 5 else {"jump_state": 5}
        self.enter(CommanderStatus.BOUNDLESS, **fields)
        self.wait(self.moving, "robot on its way")

    def test_1_refusals_name_the_state_and_what_it_accepts(self):
        for fields in ({}, {"next_state": True, "jump_state": 4}):
            answer = self.ask(**fields)
            self.assertFalse(answer.success)
            self.assertIn("exactly one field", answer.message)
            self.assertIn("IDLE accepts", answer.message)

    def test_2_main_path(self):
        self.enter(CommanderStatus.STARTED, current_state=True)
        answer = self.ask(jump_state=5)
        self.assertFalse(answer.success)
        self.assertIn("STARTED accepts: current_state (-> STARTED), next_state (-> CALIBRATION)", answer.message)
        self.enter(CommanderStatus.CALIBRATION, next_state=True)
        self.assertFalse(self.ask(next_state=True).success)
        self.ended()
        self.enter(CommanderStatus.MENU, next_state=True)
        self.go("target_1", FAR)
        self.assertIn("busy", self.ask(next_state=True).message)
        self.ended()

    def test_3_previous_stops_at_the_waypoint_and_the_command_line_runs_again(self):
        self.go("target_2", (0.65, 1.65))
        self.enter(CommanderStatus.MENU, previous_state=True)
        self.wait(lambda: not self.status.busy, "stop")
        self.assertEqual(self.status.outcome, "stopped")
        self.assertIn("reached", self.cli("run", "--mode", "boundless"))
        self.assertIn("BOUNDLESS", self.cli("status"))

    def test_4_a_thing_dropped_on_the_path_is_driven_round_or_waited_for(self):
        self.go("target_3", FAR)
        self.put("box_1", "Unregistered", -0.95, 1.65, 0.9, (0.1, 0.3, 0.3))
        self.wait(lambda: self.said("way")() or self.said("cannot")() or not self.status.busy, "word on the box")
        self.assertNotIn("box_1", [entry.name for entry in self.registry.entries])
        self.assertTrue(any(name.startswith("unknown") for name in self.in_map), self.in_map)
        self.take_away("box_1")
        self.ended()

    def test_5_a_goal_that_becomes_unreachable_is_named_and_served_when_it_is_free(self):
        self.go("target_4", (0.65, 1.65))
        self.put("box_2", "Obstacle", 0.65, 1.65, 1.0, (0.5, 0.5, 0.2))
        self.wait(lambda: "target_4" in self.unreachable(), "target_4 unreachable")
        with self.condition:
            self.assertIn("box_2", self.unreachable()["target_4"])
        self.take_away("box_2")
        self.ended()

    def test_6_a_robot_that_does_not_move(self):
        self.go("target_5", FAR)
        self.freeze("multi_robot_controls_server", "has not moved for 10 s")

    def test_7_silent_perception(self):
        self.go("target_6", (0.65, 1.65))
        self.freeze("perception", "no new planning_metadata for more than 1 s")

    def test_8_a_lost_action_server_and_back(self):
        self.go("target_7", FAR)
        rosnode.kill_nodes(["/multi_robot_controls_server"])
        self.wait(self.said("the action server of ankurbot_1 is lost"), "fault", 30.0)
        again = subprocess.Popen(
            [sys.executable, os.path.join(os.environ["YARM_ROOT"], "scripts", "multi_robot_controls_server")]
        )
        try:
            self.ended()
            self.enter(CommanderStatus.CLEANUP, next_state=True)
            self.ended()
        finally:
            again.terminate()
            again.wait(20.0)
        self.enter(CommanderStatus.IDLE, next_state=True)

    def cli(self, *arguments):
        """What commander_cli prints; its exit code must be 0."""
        script = os.path.join(os.environ["YARM_ROOT"], "scripts", "commander_cli")
        command = [sys.executable, script, *arguments, "--timeout", str(LIMIT_S)]
        done = subprocess.run(command, timeout=LIMIT_S + 30.0, check=False, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def freeze(self, node, words):
        """Hold a node until the Commander says so in these words; then the mission must go on to its end."""
        pid = self.pid_of(node)
        os.kill(pid, signal.SIGSTOP)
        try:
            self.wait(self.said(words), "fault", 60.0)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.ended()

    def pid_of(self, node):
        uri = rospy.get_master().lookupNode("/" + node)[2]
        return xmlrpc.client.ServerProxy(uri).getPid("/commander_test")[2]


if __name__ == "__main__":
    rospy.init_node("commander_test")
    rostest.rosrun("yarm", "commander_test", CommanderTest, sys.argv)
