#!/usr/bin/env python3
"""The simulated cell as other nodes see it."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
import time
import unittest
from typing import Any, Callable, Dict, List

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from yarm.msg import Clearance, Contacts, JointControllerState, ObjectRegistry, SimStatus
from yarm.srv import SpawnObstacles, SpawnObstaclesRequest

from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.start import init_node

WALL_LIMIT_S = 60.0
TICK_NS = 1e9 / 60.0
CLOUD = names.camera_points(1)


class SimulationTest(unittest.TestCase):
    """One launch serves every check; they run in the order of their names, the restart last."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.changed = threading.Condition()
        cls.kept: Dict[str, List[Any]] = {}
        cls.keep("/clock", Clock)
        cls.keep("/tf", TFMessage)
        cls.keep("/tf_static", TFMessage)
        cls.keep("/rosout", Log)
        cls.keep(names.OBJECT_REGISTRY, ObjectRegistry)
        cls.keep(names.SIM_STATUS, SimStatus)
        cls.keep(names.SIM_CONTACTS, Contacts)
        cls.keep(names.SIM_CLEARANCE, Clearance)
        cls.keep(CLOUD, PointCloud2)
        cls.keep(names.joint_states("hc10_barc"), JointState)
        cls.keep(names.caster_state("ankurbot_1", "fl"), JointControllerState)
        cls.spawn = rospy.ServiceProxy(names.SPAWN_OBSTACLES, SpawnObstacles)
        cls.delete = rospy.ServiceProxy(names.DELETE_OBSTACLES, SpawnObstacles)
        rospy.wait_for_service(names.SPAWN_OBSTACLES, timeout=WALL_LIMIT_S)

    @classmethod
    def keep(cls, topic: str, kind: Any) -> None:
        cls.kept[topic] = []

        def receive(message: Any) -> None:
            with cls.changed:
                cls.kept[topic].append(message)
                del cls.kept[topic][:-400]
                cls.changed.notify_all()

        rospy.Subscriber(topic, kind, receive, queue_size=100, buff_size=1 << 24)

    def wait(self, condition: Callable[[], Any], what: str) -> Any:
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, timeout=WALL_LIMIT_S), f"never came: {what}")
            return condition()

    def newest(self, topic: str, after_s: float = -1.0) -> Any:
        def found() -> Any:
            fresh = [m for m in self.kept[topic] if m.header.stamp.to_sec() > after_s]
            return fresh[-1] if fresh else None

        return self.wait(found, f"a message on {topic} after {after_s:.3f} s")

    def now(self) -> float:
        self.wait(lambda: self.kept["/clock"], "/clock")
        return self.kept["/clock"][-1].clock.to_sec()

    def pose(self, frame: str, after_s: float = -1.0) -> Any:
        def found() -> Any:
            for message in reversed(self.kept["/tf"]):
                for transform in message.transforms:
                    if transform.child_frame_id == frame and transform.header.stamp.to_sec() > after_s:
                        return transform
            return None

        return self.wait(found, f"frame {frame} after {after_s:.3f} s")

    def stamps(self, topic: str) -> List[int]:
        """Stamps of what has been heard on a topic, ns."""
        with self.changed:
            return [message.header.stamp.to_nsec() for message in self.kept[topic]]

    def neighbours(self, topic: str, period_s: float) -> bool:
        """Whether two messages have come that are one period apart; a busy machine may lose some."""
        return bool(np.any(np.diff(self.stamps(topic)) < 1.01e9 * period_s))

    def said(self, *words: str) -> bool:
        return any(all(word in log.msg for word in words) for log in self.kept["/rosout"])

    def publisher(self, topic: str, kind: Any) -> rospy.Publisher:
        publisher = rospy.Publisher(topic, kind, queue_size=10)
        limit = time.monotonic() + WALL_LIMIT_S
        while publisher.get_num_connections() == 0:
            self.assertLess(time.monotonic(), limit, f"nobody listens to {topic}")
            self.wait(lambda: True, "")
            rospy.rostime.wallsleep(0.02)
        return publisher

    def test_a_frames_and_clouds_come_at_their_rates_with_true_stamps(self) -> None:
        self.wait(lambda: len(self.kept["/tf"]) > 60, "60 messages on /tf")
        with self.changed:
            ticks = [m.transforms[0].header.stamp.to_nsec() for m in self.kept["/tf"]]
        steps = np.diff(ticks) / TICK_NS
        self.assertLess(float(np.abs(steps - np.rint(steps)).max()), 1e-6, "a tick is 4 steps of 1/240 s")
        self.assertEqual(round(float(steps.min())), 1)
        for message in self.kept["/tf"][-5:]:
            self.assertEqual(len({t.header.stamp for t in message.transforms}), 1)
            self.assertEqual({t.header.frame_id for t in message.transforms}, {"world"})
        self.wait(lambda: len(self.kept[CLOUD]) > 20, "20 clouds")
        self.wait(lambda: self.neighbours(CLOUD, 1.0 / 30.0), "two clouds in a row")
        steps = np.diff(self.stamps(CLOUD)) / (2.0 * TICK_NS)
        self.assertLess(float(np.abs(steps - np.rint(steps)).max()), 1e-6, "a camera set is every second tick")
        self.assertEqual(round(float(steps.min())), 1)

    def test_b_clouds_are_organised_in_the_optical_frame(self) -> None:
        cloud = self.newest(CLOUD)
        self.assertEqual(cloud.header.frame_id, "mapping_camera_1_depth_optical_frame")
        self.assertEqual((cloud.height, cloud.width, cloud.point_step, cloud.row_step), (320, 320, 16, 5120))
        self.assertEqual(
            [(f.name, f.offset, f.datatype) for f in cloud.fields],
            [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("rgb", 12, 7)],
        )
        self.assertEqual(len(cloud.data), 320 * 320 * 16)
        points = np.frombuffer(cloud.data, dtype=np.float32).reshape(320, 320, 4)
        z = points[..., 2]
        seen = np.isfinite(z)
        self.assertTrue(0.3 < seen.mean() < 0.7)
        self.assertTrue(z[seen].min() >= 0.5 and z[seen].max() <= 10.0)
        self.assertTrue(seen[-1].all() and not seen[0].any(), "y is down: the floor is below, the sky above")

    def test_c_the_registry_says_who_is_there(self) -> None:
        registry = self.newest(names.OBJECT_REGISTRY)
        kinds = {entry.name: (entry.object, entry.type, entry.seed_frame) for entry in registry.entries}
        self.assertEqual(kinds["ankurbot_2"], ("Mobile", "dynamic", "ankurbot_2/ee"))
        self.assertEqual(kinds["hc10_barc"], ("Manipulator", "dynamic", "hc10_barc/tool0"))
        self.assertEqual(kinds["table"][:2], ("Obstacle", "static"))
        for entry in registry.entries:
            self.assertEqual(len(entry.shapes), len(entry.shape_poses))
            self.assertEqual(len(entry.shapes), len(entry.shape_frames))
        self.pose("ankurbot_1/ee")
        self.pose("hc10_barc/tool0")
        static = {t.child_frame_id for m in self.kept["/tf_static"] for t in m.transforms}
        self.assertTrue({f"mapping_camera_{n}_depth_optical_frame" for n in (1, 2, 3, 4)} <= static)
        self.assertIn("hc10_barc/base_link", static)

    def test_d_a_robot_drives_on_its_wheels(self) -> None:
        start = self.pose("ankurbot_1/base_link").transform.translation
        for caster in names.CASTERS:
            self.publisher(names.caster_command("ankurbot_1", caster), Float64).publish(0.0)
        drive = self.publisher(names.cmd_vel("ankurbot_1"), Twist)
        command = Twist()
        command.linear.x = 0.5
        drive.publish(command)
        self.wait(lambda: start.x - self.pose("ankurbot_1/base_link").transform.translation.x > 0.1, "0.1 m along -x")
        # Whoever drove it is heard of no more: it stops by itself.
        self.wait(
            lambda: self.said("ankurbot_1/cmd_vel", "nothing for 0.5 s", "stopped"), "a warning about the silence"
        )
        stopping = self.now() + 0.3
        before = self.pose("ankurbot_1/base_link", stopping)
        later = self.pose("ankurbot_1/base_link", before.header.stamp.to_sec() + 0.5)
        self.assertAlmostEqual(later.transform.translation.x, before.transform.translation.x, delta=0.002)
        state = self.newest(names.caster_state("ankurbot_1", "fl"), self.now())
        self.assertAlmostEqual(state.process_value, 0.0, delta=0.02)

    def test_e_commands_with_nan_or_beyond_limits_are_said_once(self) -> None:
        bad = Twist()
        bad.linear.x = float("nan")
        drive = self.publisher(names.cmd_vel("ankurbot_2"), Twist)
        drive.publish(bad)
        self.wait(lambda: self.said("ankurbot_2/cmd_vel", "refused", "nan"), "a warning about NaN")
        bad.linear.x = 50.0
        drive.publish(bad)
        drive.publish(Twist())
        self.wait(lambda: self.said("ankurbot_2/cmd_vel", "50.000", "clamped"), "a warning about 50 m/s")
        caster = self.publisher(names.caster_command("ankurbot_2", "rr"), Float64)
        caster.publish(7.0)
        self.wait(lambda: self.said("rr_position_controller", "7.000", "clamped"), "a warning about 7 rad")
        caster.publish(0.0)
        count = sum("refused: drive speed nan" in log.msg for log in self.kept["/rosout"])
        drive.publish(Twist(linear=bad.linear.__class__(float("nan"), 0, 0)))
        drive.publish(Twist())
        later = self.now() + 0.5
        self.wait(lambda: self.kept["/clock"][-1].clock.to_sec() > later, "half a second")
        self.assertEqual(sum("refused: drive speed nan" in log.msg for log in self.kept["/rosout"]), count)

    def test_f_the_arm_follows_a_streamed_path(self) -> None:
        topic = names.joint_states("hc10_barc")
        joints = self.newest(topic)
        publisher = self.publisher(names.joint_path_command("hc10_barc"), JointTrajectory)
        goal = [position + 0.15 for position in joints.position]
        point = JointTrajectoryPoint(positions=goal, time_from_start=rospy.Duration(1.0))
        publisher.publish(JointTrajectory(joint_names=joints.name, points=[point]))
        self.wait(lambda: np.allclose(self.kept[topic][-1].position, goal, atol=0.003), "the path's end")
        publisher.publish(JointTrajectory(joint_names=["elbow"], points=[point]))
        self.wait(lambda: self.said("joint_path_command", "elbow", "joint_1_s"), "a warning about the joint's name")

    def test_g_objects_come_and_go(self) -> None:
        request = SpawnObstaclesRequest(name="debris_7", type="Debris", x=-0.2, y=0.0, z=0.755)
        self.assertTrue(self.spawn(request).success)
        self.wait(lambda: any(e.name == "debris_7" for e in self.kept[names.OBJECT_REGISTRY][-1].entries), "debris_7")
        self.pose("debris_7")
        self.assertTrue(self.delete(SpawnObstaclesRequest(name="debris_7")).success)
        self.wait(
            lambda: all(e.name != "debris_7" for e in self.kept[names.OBJECT_REGISTRY][-1].entries), "its leaving"
        )

    def test_h_bad_requests_are_refused_by_name(self) -> None:
        good: Dict[str, Any] = {"name": "thing", "type": "Obstacle", "x": 0.0, "y": -1.5, "z": 0.1}
        for change, words in (
            ({"name": "ankurbot_1"}, ["'ankurbot_1'", "taken"]),
            ({"x": 7.0}, ["x 7", "-2.5 to 2.5"]),
            ({"y": float("nan")}, ["y nan"]),
            ({"z": 3.0}, ["z 3", "0 to 1.3"]),
            ({"type": "Robot"}, ["'Robot'", "Debris, Target, Obstacle, Unregistered"]),
            ({"shape": [1.0, -1.0, 1.0]}, ["shape", "three sizes"]),
            ({"x": 1.95, "y": -1.9, "z": 0.3}, ["thing", "inside ankurbot_2"]),
            ({"name": "", "x": 9.0}, ["name ''", "x 9"]),
        ):
            answer = self.spawn(SpawnObstaclesRequest(**{**good, **change}))
            self.assertFalse(answer.success, change)
            for word in words:
                self.assertIn(word, answer.message)
        answer = self.delete(SpawnObstaclesRequest(name="nobody"))
        self.assertFalse(answer.success)
        self.assertIn("'nobody'", answer.message)

    def test_i_ground_truth_and_status(self) -> None:
        contacts = self.newest(names.SIM_CONTACTS, self.now())
        pairs = {(c.link_a, c.body_b) for c in contacts.contacts} | {(c.link_b, c.body_a) for c in contacts.contacts}
        self.assertIn(("fl_wheel", "floor"), pairs)
        self.assertTrue(all(c.allowed and c.kind == "allowed" for c in contacts.contacts))
        clearance = self.newest(names.SIM_CLEARANCE, self.now())
        self.assertEqual(sorted(clearance.robots), ["ankurbot_1", "ankurbot_2", "hc10_barc"])
        self.assertTrue(all(math.isinf(d) or d > 0.05 for d in clearance.distances))
        status = self.newest(names.SIM_STATUS, self.now())
        self.assertTrue({"physics", "cameras", "publish"} <= set(status.parts))
        self.wait(lambda: len(self.kept[names.SIM_STATUS]) > 2, "three times sim/status")
        factors = np.array([message.real_time_factor for message in list(self.kept[names.SIM_STATUS])])
        self.assertGreater(float(factors.min()), 0.0)
        self.assertLess(1.0 / float(np.mean(1.0 / factors)), 1.2, "what was held up is made up for, but no more")

    def test_j_a_bad_scene_or_parameter_ends_the_node_and_says_why(self) -> None:
        for argument, words in (
            ("_scene:=nowhere", ["nowhere.yaml: no such scene", "2m1ma"]),
            ("_seed:=-5", ["seed = -5", "-1 to 2.14748e+09"]),
        ):
            command = [sys.executable, str(resource("scripts", "simulation")), "__name:=simulation_bad", argument]
            done = subprocess.run(command, capture_output=True, text=True, timeout=WALL_LIMIT_S, check=False)
            self.assertEqual(done.returncode, 1)
            for word in words:
                self.assertIn(word, done.stdout + done.stderr)

    def test_k_the_wrist_camera_answers_when_somebody_listens(self) -> None:
        topic = names.wrist_points("hc10_barc")
        self.keep(topic, PointCloud2)
        cloud = self.newest(topic)
        self.assertEqual((cloud.height, cloud.width), (240, 320))
        self.assertEqual(cloud.header.frame_id, "hc10_barc/wrist_camera_optical_frame")
        self.wait(
            lambda: len(self.kept[topic]) > 4 and self.neighbours(topic, 1.0 / 15.0), "two of five clouds in a row"
        )
        self.assertAlmostEqual(float(np.diff(self.stamps(topic)).min()), 1e9 / 15.0, delta=1e6)

    def test_z_started_again_in_mid_run_it_begins_anew(self) -> None:
        before = self.now()
        self.assertGreater(before, 2.0)
        drive = self.publisher(names.cmd_vel("ankurbot_1"), Twist)
        subprocess.run(["rosnode", "kill", "/simulation"], check=True, capture_output=True, timeout=WALL_LIMIT_S)
        self.wait(lambda: self.now() < before - 1.0, "time going backwards")
        self.wait(lambda: abs(self.pose("ankurbot_1/base_link").transform.translation.x - 1.95) < 0.01, "the start")
        command = Twist()
        command.linear.x = 0.3
        limit = time.monotonic() + WALL_LIMIT_S
        while self.pose("ankurbot_1/base_link").transform.translation.x > 1.9:
            self.assertLess(time.monotonic(), limit, "no driving after the restart")
            drive.publish(command)  # the connection may still be that to the simulation that has ended
            rospy.rostime.wallsleep(0.05)


if __name__ == "__main__":
    init_node("simulation_test")
    rostest.rosrun("yarm", "simulated_cell", SimulationTest)
