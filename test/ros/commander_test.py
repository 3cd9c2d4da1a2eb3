#!/usr/bin/env python3
"""Main path, refusals, stop, command line, and every fault that leaves the cell itself running."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rosnode
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from rosgraph_msgs.msg import Log
from tf2_msgs.msg import TFMessage
from yarm.msg import (
    CommanderStatus,
    MapMetaData,
    ObjectRegistry,
    RegisteredObject,
    SafetyStatus,
    TransformStampedVector,
)
from yarm.srv import SpawnObstaclesRequest, WhatIf, Why

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.commander_driver import CommanderDriver

FAR = (-1.9, 1.65)
WHAT_IF_S = 600.0
"""Wall time that forks may take: at the least priority, s."""


class CommanderTest(CommanderDriver):
    """The tests build on each other, in the order of their names."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.in_map, cls.registry = [], ObjectRegistry()
        rospy.Subscriber(names.PLANNING_METADATA, MapMetaData, cls.on_map, queue_size=1, buff_size=1 << 22)
        rospy.Subscriber(names.OBJECT_REGISTRY, ObjectRegistry, cls.on_registry, queue_size=10)

    @classmethod
    def on_map(cls, message):
        with cls.condition:
            cls.in_map = list(message.frames)

    @classmethod
    def on_registry(cls, message):
        with cls.condition:
            cls.registry = message

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
        self.begin_mission()
        self.wait(self.moving, "robot on its way")

    def test_1_refusals_name_the_state_and_what_it_accepts(self):
        answer = self.ask(next_state=True, jump_state=4)
        self.assertFalse(answer.success)
        self.assertIn("exactly one field", answer.message)
        self.assertIn("IDLE accepts", answer.message)

    def test_2_main_path(self):
        self.enter(CommanderStatus.STARTED)
        self.assertIn("exactly one field must be set, but set were: none", self.ask().message)
        answer = self.ask(jump_state=5)
        self.assertFalse(answer.success)
        self.assertIn("STARTED accepts: current_state (-> STARTED), next_state (-> CALIBRATION)", answer.message)
        self.enter(CommanderStatus.CALIBRATION, next_state=True)
        self.assertFalse(self.ask(next_state=True).success)
        self.ended()
        self.enter(CommanderStatus.MENU, next_state=True)
        self.put("target_1", "Target", *FAR)
        self.wait(lambda: "target_1" in self.in_map, "target_1 in the map")
        self.what_if()
        self.begin_mission()
        self.wait(self.moving, "robot on its way")
        self.assertIn("busy", self.ask(next_state=True).message)
        self.ended()

    def what_if(self):
        """The cell as it is, forked by service and by command; a faulty question is refused."""
        service = rospy.ServiceProxy(names.COMMANDER_WHAT_IF, WhatIf)
        wrong = service(alternatives=["planner=nobody"], runs=1)
        self.assertFalse(wrong.success)
        self.assertIn("planner = 'nobody': must be one of", wrong.message)
        right = service(alternatives=["", "particles=100"], runs=1, seed=3)
        self.assertTrue(right.success, right.message)
        told = [(one.name, one.runs, one.cleared) for one in right.answers]
        self.assertEqual(told, [("as it is", 1, 1), ("particles=100", 1, 1)], right.message)
        self.assertGreater(Path(right.plot).stat().st_size, 5000)
        with tempfile.TemporaryDirectory() as folder:
            command = ["rosrun", "yarm", "what_if", "--set", "particles=100", "--runs", "1", "--results", folder]
            done = subprocess.run(command, capture_output=True, text=True, timeout=WHAT_IF_S, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            said = done.stdout
            self.assertRegex(said, r"the live cell at [0-9.]+ s: 2 alternatives, 1 runs each")
            self.assertRegex(said, r"2 runs in [0-9.]+ s:[^:]*as it is +1 of 1[^:]*particles=100 +1 of 1")
            self.assertGreater((Path(folder) / "what_if" / "answer.png").stat().st_size, 5000)

    def test_3_previous_stops_at_the_waypoint_and_the_command_line_runs_again(self):
        self.go("target_2", (0.65, 1.65))
        self.enter(CommanderStatus.MENU, previous_state=True)
        self.wait(lambda: not self.status.busy, "stop")
        self.assertEqual(self.status.outcome, "stopped")
        self.assertIn("reached", self.done("run", "--mode", "boundless"))
        self.assertIn("BOUNDLESS", self.done("status"))

    def test_4_a_thing_dropped_on_the_path_is_driven_round_or_waited_for(self):
        self.go("target_3", FAR)
        self.put("box_1", "Unregistered", -0.95, 1.65, 0.9, (0.1, 0.3, 0.3))
        self.wait(lambda: self.said("way")() or self.said("cannot")() or not self.status.busy, "word on the box")
        self.assertNotIn("box_1", [entry.name for entry in self.registry.entries])
        self.wait(lambda: any(name.startswith("unknown") for name in self.in_map), "box_1 as unknown in the map")
        self.take_away("box_1")
        self.ended()

    def test_5_a_goal_that_becomes_unreachable_is_named_and_served_when_it_is_free(self):
        self.go("target_4", (0.65, 1.65))
        self.put("box_2", "Obstacle", 0.65, 1.65, 1.0, (0.5, 0.5, 0.2))
        self.wait(lambda: "box_2" in self.unreachable().get("target_4", ""), "target_4 unreachable for box_2")
        answer = rospy.ServiceProxy(names.COMMANDER_WHY, Why)("target_4")
        self.assertTrue(answer.success, answer.text)
        changes = [(change.kind, change.thing) for change in answer.causes[0].changes]
        self.assertIn(changes, ([("move", "box_2")], [("remove", "box_2")]), answer.text)
        nobody = rospy.ServiceProxy(names.COMMANDER_WHY, Why)("nobody")
        self.assertFalse(nobody.success)
        self.assertIn("nobody is neither a goal nor a robot; there is ", nobody.text)
        command = ["rosrun", "yarm", "why", "target_4"]
        said = subprocess.run(command, capture_output=True, text=True, timeout=self.LIMIT_S, check=True)
        self.assertIn("cannot reach target_4", said.stdout)
        self.take_away("box_2")
        self.ended()

    def test_5_messages_of_a_stranger_are_refused_by_name_and_the_mission_goes_on(self):
        wrong = faulty_messages()
        strangers = [(rospy.Publisher(topic, type(m), queue_size=10), topic, m) for topic, m in wrong]
        self.go("target_8", (-0.65, 1.65))
        refused = set()
        rospy.Subscriber("/rosout", Log, lambda m: refused.update({(m.name, m.msg.split(" refused: ")[0])}))
        me = rospy.get_name().strip("/")
        expected = {
            (f"/{node}", f"{topic} of {me}")
            for node, topics in {
                "commander": (names.PLANNING_METADATA, names.OBJECT_REGISTRY, names.SAFETY_STATUS),
                "safety_monitor": ("/tf", names.PLANNING_METADATA),
                "multi_robot_controls_server": (names.SEED_TRANSFORMS,),
            }.items()
            for topic in topics
        }
        deadline = time.monotonic() + self.LIMIT_S
        while not expected <= refused and time.monotonic() < deadline:
            for publisher, topic, message in strangers:
                now = rospy.Time.now()
                if topic == "/tf":
                    message.transforms[0].header.stamp = now
                elif topic == names.SEED_TRANSFORMS:
                    message.header.stamp = message.transforms[0].header.stamp = now
                elif message.header.stamp != rospy.Time():
                    message.header.stamp = now + rospy.Duration(3600.0)
                publisher.publish(message)
            time.sleep(0.05)
        self.assertEqual(expected - refused, set())
        for publisher, _, _ in strangers:
            publisher.unregister()
        self.ended()

    def test_6_a_frozen_controls_server(self):
        self.go("target_5", FAR)
        self.freeze("multi_robot_controls_server", "the action server of ankurbot_1 is lost")

    def test_7_silent_perception(self):
        self.go("target_6", (0.65, 1.65))
        self.freeze("perception", "no new planning_metadata for more than 1 s")

    def test_8_a_lost_action_server_and_back(self):
        self.go("target_7", FAR)
        rosnode.kill_nodes(["/multi_robot_controls_server"])
        self.wait(self.said("the action server of ankurbot_1 is lost"), "fault")
        again = subprocess.Popen(
            [sys.executable, os.path.join(os.environ["YARM_ROOT"], "scripts", "multi_robot_controls_server")]
        )
        try:
            self.ended()
            self.enter(CommanderStatus.CLEANUP, next_state=True)
            self.ended()
        finally:
            again.terminate()
            again.wait(60.0)
        self.enter(CommanderStatus.IDLE)

    def done(self, *arguments):
        """What commander_cli prints; its exit code must be 0."""
        code, said = self.cli(*arguments, timeout_s=self.LIMIT_S)
        self.assertEqual(code, 0, said)
        return said

    def freeze(self, node, words):
        """Hold a node until the Commander says so in these words; then the mission must go on to its end."""
        with self.stopped(node):
            self.wait(self.said(words), "fault")
        self.ended()


def faulty_messages():
    """Messages nobody should act on, by topic; those with a stamp are sent with one of the future."""
    small = MapMetaData(gx=50, gy=50, gz=20, grid=[0] * 10)
    small.xmin, small.xmax, small.ymin, small.ymax, small.zmin, small.zmax = -2.5, 2.5, -2.5, 2.5, 0.01, 1.3
    future = MapMetaData(gx=50, gy=50, gz=20, grid=[0] * 50000)
    future.xmin, future.xmax, future.ymin, future.ymax, future.zmin, future.zmax = -2.5, 2.5, -2.5, 2.5, 0.01, 1.3
    future.header.stamp = rospy.Time(1)
    zero = TransformStamped(child_frame_id=names.ee_frame("ankurbot_1"))
    zero.header.frame_id = names.WORLD_FRAME
    status = SafetyStatus()
    status.header.stamp = rospy.Time(1)
    seeds = TransformStampedVector(transforms=[zero], type=["dynamic"], frame=["ankurbot_1"], object=["Mobile"])
    return [
        (names.PLANNING_METADATA, small),
        (names.PLANNING_METADATA, future),
        (names.OBJECT_REGISTRY, ObjectRegistry(entries=[RegisteredObject(name="x", object="Alien")])),
        (names.SAFETY_STATUS, status),
        (names.SEED_TRANSFORMS, seeds),
        ("/tf", TFMessage(transforms=[zero])),
    ]


if __name__ == "__main__":
    init_node("commander_test")
    rostest.rosrun("yarm", "commander_test", CommanderTest, sys.argv)
