#!/usr/bin/env python3
"""Everything goes on from the scene's start when the cell is started again: map, seeds, control, Commander."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
import unittest
from collections import Counter
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional

import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Pose
from yarm.msg import (
    CommanderStatus,
    Contacts,
    MapMetaData,
    MoveRobotAction,
    MoveRobotGoal,
    ObjectRegistry,
    SanderStatus,
    TransformStampedVector,
)
from yarm.srv import StateChange

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.goals import send_when_permitted

WALL_LIMIT_S = 240.0
ROBOTS = ("ankurbot_1", "ankurbot_2")
GOALS = {"target_1", "target_2"}


class RestartTest(unittest.TestCase):
    """One run through: before, the restart, after."""

    def setUp(self) -> None:
        self.changed = threading.Condition()
        self.newest: Dict[str, Any] = {}
        self.counts: Counter = Counter()
        self.states: List[int] = []
        self.failures: List[str] = []
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, self.on_contacts, queue_size=1000)
        for topic, kind in (
            (names.PLANNING_METADATA, MapMetaData),
            (names.SEED_TRANSFORMS, TransformStampedVector),
            (names.OBJECT_REGISTRY, ObjectRegistry),
            (names.COMMANDER_STATUS, CommanderStatus),
            (names.sander_status("hc10_barc"), SanderStatus),
        ):
            rospy.Subscriber(topic, kind, self.receive, callback_args=topic, queue_size=10, buff_size=1 << 22)

    def receive(self, message: Any, topic: str) -> None:
        with self.changed:
            self.newest[topic] = message
            self.counts[topic] += 1
            if topic == names.COMMANDER_STATUS and self.states[-1:] != [message.state]:
                self.states.append(message.state)
            self.changed.notify_all()

    def on_contacts(self, message: Contacts) -> None:
        with self.changed:
            self.failures += [f"{c.body_a} / {c.body_b}" for c in message.contacts if c.kind == "failure"]

    def wait(self, condition: Callable[[], Any], what: str) -> None:
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, timeout=WALL_LIMIT_S), f"never came: {what}")

    def stamp(self, topic: str) -> float:
        message = self.newest.get(topic)
        return -1.0 if message is None else message.header.stamp.to_sec()

    def cells(self) -> Optional[List[int]]:
        message = self.newest.get(names.PLANNING_METADATA)
        if message is None or not set(ROBOTS) <= set(message.frames):
            return None
        return [len(message.grid_indices[message.frames.index(name)].indices) for name in ROBOTS]

    def drive(self, robot: str, y: float) -> None:
        """Move a robot's end effector along y, heading kept."""
        client = SimpleActionClient(names.move_robot(robot), MoveRobotAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(60.0)), f"{robot} has no action server")
        seeds = self.newest[names.SEED_TRANSFORMS]
        transform = seeds.transforms[seeds.frame.index(robot)].transform
        target = Pose(position=transform.translation, orientation=transform.rotation)
        target.position.y += y
        state = send_when_permitted(client, MoveRobotGoal(target=target, action="False"), 90.0)
        self.assertEqual(state, GoalStatus.SUCCEEDED, client.get_goal_status_text())

    def status(self) -> CommanderStatus:
        return self.newest.get(names.COMMANDER_STATUS, CommanderStatus())

    def await_calibration(self) -> None:
        def done() -> bool:
            status = self.status()
            return status.state == CommanderStatus.CALIBRATION and not status.busy and bool(status.outcome)

        self.wait(done, "the calibration")
        self.assertEqual(self.status().outcome, "succeeded", self.status().reason)

    def ask(self, **fields: bool) -> None:
        rospy.wait_for_service(names.COMMANDER_STATE, timeout=WALL_LIMIT_S)
        service = rospy.ServiceProxy(names.COMMANDER_STATE, StateChange)
        nothing = {"next_state": False, "current_state": False, "previous_state": False, "jump_state": 0}
        answer = service(**{**nothing, **fields})
        self.assertTrue(answer.success, answer.message)

    def await_mission(self, what: str) -> None:
        """BOUNDLESS with robots on their way."""

        def under_way() -> bool:
            status = self.status()
            moving = any(task.status == "moving" for task in status.tasks)
            return status.state == CommanderStatus.BOUNDLESS and moving

        self.wait(under_way, what)

    def test_everybody_goes_on(self) -> None:
        self.wait(self.cells, "a map of all robots")
        self.ask(current_state=True)
        self.wait(lambda: self.status().state == CommanderStatus.STARTED, "Commander STARTED")
        self.ask(next_state=True)
        self.await_calibration()
        self.drive("ankurbot_1", -0.3)
        self.ask(jump_state=CommanderStatus.BOUNDLESS)
        self.await_mission("the mission under way")
        before, known = self.stamp(names.PLANNING_METADATA), self.counts[names.OBJECT_REGISTRY]
        states_before = len(self.states)
        subprocess.run(["rosnode", "kill", "/simulation"], check=True, capture_output=True, timeout=WALL_LIMIT_S)
        for topic in (names.SEED_TRANSFORMS, names.PLANNING_METADATA):
            self.wait(lambda topic=topic: 0.0 <= self.stamp(topic) < before - 1.0, f"{topic} of the new run")
        self.wait(lambda: self.counts[names.OBJECT_REGISTRY] > known, "the registry of the new run")
        self.wait(lambda: self.cells() and min(self.cells()) > 20, "all robots in the map")
        seeds = self.newest[names.SEED_TRANSFORMS]
        position = seeds.transforms[seeds.frame.index("ankurbot_1")].transform.translation
        self.assertLess(math.hypot(position.x - 0.65, position.y - 1.9), 0.02, "back at the scene's start")
        # The Commander calibrates again by itself, what it knew of the cell is gone, and takes up its mission.
        self.wait(lambda: CommanderStatus.CALIBRATION in self.states[states_before:], "the second calibration")
        self.await_mission("the mission taken up again")
        self.wait(lambda: not self.status().busy and bool(self.status().outcome), "the end of the mission")
        self.assertEqual(self.status().outcome, "succeeded", self.status().reason)
        self.assertEqual({task.goal for task in self.status().tasks if task.status == "reached"}, GOALS)
        self.assertEqual(self.failures, [])


if __name__ == "__main__":
    init_node("simulation_restart_test")
    rostest.rosrun("yarm", "simulation_restart", RestartTest)
