#!/usr/bin/env python3
"""A simulated room as other nodes see it."""

from __future__ import annotations

import math
import subprocess
import sys
import threading
import unittest
from typing import Any, Callable, Dict, List, Set, Tuple

import numpy as np
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray
from yarm.msg import BumperEvent, Contacts, SimStatus, StepAck

from yarm.geometry import Pose2, yaw_of_quaternion
from yarm.resources import resource
from yarm.robots import turtlebot
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, load_arena

WALL_LIMIT_S = 60.0
ARENA: Arena = load_arena(resource("test", "ros", "room_arena.yaml"))


def pose_of(message: Odometry) -> Pose2:
    p, q = message.pose.pose.position, message.pose.pose.orientation
    return Pose2(p.x, p.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))


class RoomTest(unittest.TestCase):
    """One launch serves every check; they run in the order of their names, the restart last."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.changed = threading.Condition()
        cls.kept: Dict[str, List[Any]] = {}
        for topic, kind in (
            ("/clock", Clock), ("/rosout", Log), (names.ODOM, Odometry), (names.SIM_POSE, Odometry),
            (names.SCAN, LaserScan), (names.BUMPER, BumperEvent), (names.BUMPER_CLOUD, PointCloud2),
            (names.SIM_CONTACTS, Contacts), (names.SIM_STATUS, SimStatus), (names.SIM_ARENA, MarkerArray),
            (names.MUX_ACTIVE, String),
        ):  # fmt: skip
            cls.keep(topic, kind)
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        cls.sources = {
            source: rospy.Publisher(names.mux_input(source), Twist, queue_size=1)
            for source in ("safety_controller", "teleop", "navi")
        }

    @classmethod
    def keep(cls, topic: str, kind: Any) -> None:
        cls.kept[topic] = []

        def receive(message: Any) -> None:
            with cls.changed:
                cls.kept[topic].append(message)
                del cls.kept[topic][:-1000]
                cls.changed.notify_all()

        rospy.Subscriber(topic, kind, receive, queue_size=100, buff_size=1 << 24)

    def wait(self, condition: Callable[[], Any], what: str) -> Any:
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, timeout=WALL_LIMIT_S), f"never came: {what}")
            return condition()

    def now(self) -> float:
        self.wait(lambda: self.kept["/clock"], "/clock")
        return self.kept["/clock"][-1].clock.to_sec()

    def newest(self, topic: str, after_s: float = -1.0) -> Any:
        def fresh() -> Any:
            return next((m for m in reversed(self.kept[topic]) if m.header.stamp.to_sec() > after_s), None)

        return self.wait(fresh, f"a message on {topic} after {after_s:.3f} s")

    def at(self, topic: str, stamp: rospy.Time) -> Any:
        return self.wait(
            lambda: next((m for m in reversed(self.kept[topic]) if m.header.stamp == stamp), None),
            f"{topic} of {stamp.to_sec():.3f} s",
        )

    def nearest(self, topic: str, stamp: rospy.Time) -> Any:
        """The message nearest to a time, once one of that time or a later one has come."""
        self.newest(topic, stamp.to_sec() - 1e-6)
        with self.changed:
            return min(self.kept[topic], key=lambda m: abs((m.header.stamp - stamp).to_sec()))

    def truth(self) -> Tuple[Pose2, float, float]:
        message = self.newest(names.SIM_POSE)
        return pose_of(message), message.twist.twist.linear.x, message.twist.twist.angular.z

    def drive(self, source: str, v: float, w: float, until: Callable[[], Any], what: str) -> None:
        """Command ten times a simulated second until something holds; each wait has its limit."""
        limit_s = self.now() + 40.0
        command = Twist()
        command.linear.x, command.angular.z = v, w
        while not until():
            self.assertLess(self.now(), limit_s, f"never came: {what}")
            self.sent_s = self.now()
            self.sources[source].publish(command)
            next_s = self.now() + 0.1
            self.wait(lambda next_s=next_s: self.now() >= next_s, "time")

    def settle(self, source: str = "teleop") -> None:
        self.drive(source, 0.0, 0.0, lambda: abs(self.truth()[1]) < 0.002 and abs(self.truth()[2]) < 0.005, "standing")

    def touched(self) -> Set[str]:
        """Bodies that have touched what they may not."""
        contacts = [contact for message in self.kept[names.SIM_CONTACTS] for contact in message.contacts]
        return {body for c in contacts if c.kind == "failure" for body in (c.body_a, c.body_b)}

    def let_go(self) -> bool:
        """Whether the bumper's last word on each of its parts is that nothing presses it."""
        last = {event.bumper: event.state for event in list(self.kept[names.BUMPER])}
        return set(last.values()) == {BumperEvent.RELEASED}

    def refused(self) -> bool:
        return any("commands/velocity" in m.msg and "nan" in m.msg for m in self.kept["/rosout"])

    def test_a_rates_frames_and_stamps(self) -> None:
        for topic, period_s, frame in (
            (names.ODOM, 0.02, "odom"), (names.SCAN, 0.05, "camera_depth_frame"), (names.SIM_POSE, 0.02, "world")
        ):  # fmt: skip
            self.wait(lambda topic=topic: len(self.kept[topic]) > 40, f"40 messages on {topic}")
            stamps = np.array([message.header.stamp.to_nsec() for message in list(self.kept[topic])])
            period_ns = round(1e9 * period_s)
            self.assertEqual(set(np.diff(stamps) % period_ns), {0}, topic)  # a busy machine may lose some
            self.assertEqual(np.diff(stamps).min(), period_ns, topic)
            self.assertEqual({message.header.frame_id for message in list(self.kept[topic])}, {frame})
        clock = np.diff([message.clock.to_nsec() for message in list(self.kept["/clock"])])
        self.assertEqual(set(clock % 10_000_000), {0})
        self.assertLessEqual({10_000_000, 20_000_000}, set(clock))
        self.assertLess(np.median(clock), 20_000_001)
        stamp = self.newest(names.SCAN).header.stamp
        mount = self.tf.lookup_transform("base_footprint", "camera_depth_frame", stamp, rospy.Duration(5.0)).transform
        self.assertAlmostEqual(mount.translation.x, turtlebot.DEPTH_CAMERA.x)
        self.assertAlmostEqual(mount.translation.y, turtlebot.DEPTH_CAMERA.y)
        self.assertAlmostEqual(mount.translation.z, turtlebot.CAMERA_Z_M)
        moved = self.tf.lookup_transform("odom", "base_footprint", stamp, rospy.Duration(5.0)).transform
        odometry = pose_of(self.nearest(names.ODOM, stamp))
        self.assertAlmostEqual(moved.translation.x, odometry.x, delta=0.002)
        start = self.tf.lookup_transform("world", "map", rospy.Time(0), rospy.Duration(5.0)).transform
        self.assertAlmostEqual(start.translation.x, ARENA.start.x)
        self.assertAlmostEqual(start.rotation.z, math.sin(0.5 * ARENA.start.yaw_rad))

    def test_b_the_scan_sees_the_walls_that_are_there(self) -> None:
        scan = self.newest(names.SCAN)
        truth = pose_of(self.nearest(names.SIM_POSE, scan.header.stamp))
        self.assertEqual(len(scan.ranges), 640)
        self.assertAlmostEqual(math.degrees(scan.angle_max - scan.angle_min), 60.0, places=4)
        self.assertAlmostEqual(scan.angle_min + 639 * scan.angle_increment, scan.angle_max, places=5)
        self.assertEqual((round(scan.range_min, 3), scan.range_max), (0.45, 10.0))
        ranges = np.array(scan.ranges)
        tall = FlatBoxes([block for block in ARENA.blocks if block.kind != "low"])
        eye = truth.compose(turtlebot.DEPTH_CAMERA)
        bearings = scan.angle_min + scan.angle_increment * np.arange(640)
        true = tall.cast(eye.x, eye.y, bearings + eye.yaw_rad).ranges
        seen = np.isfinite(ranges)
        self.assertGreater(seen.mean(), 0.97)
        error = (ranges - true)[seen]
        self.assertLess(abs(np.median(error)), 0.04)
        self.assertLess(np.mean(np.abs(error) > 0.1), 0.03)
        # Right to left: the pillar is on the left of the start, and nearer than the wall behind it.
        self.assertLess(np.nanmin(ranges[400:]), np.nanmin(ranges[:200]))

    def test_c_depth_comes_when_somebody_listens(self) -> None:
        image = rospy.wait_for_message(names.DEPTH_IMAGE, Image, WALL_LIMIT_S)
        info = rospy.wait_for_message(names.DEPTH_INFO, CameraInfo, WALL_LIMIT_S)
        self.assertEqual((image.width, image.height, image.encoding, image.step), (640, 480, "32FC1", 2560))
        self.assertEqual(image.header.frame_id, "camera_depth_optical_frame")
        self.assertEqual((info.width, info.height, info.K[0], info.K[2]), (640, 480, turtlebot.CAMERA_FOCAL_PX, 319.5))
        depth = np.frombuffer(image.data, np.float32).reshape(480, 640)
        self.assertTrue(np.all(np.isnan(depth[turtlebot.HIDDEN_ROWS_FROM :])))
        self.assertGreater(np.isfinite(depth[240]).mean(), 0.97)

    def test_d_the_robot_goes_where_it_is_told_and_stops_when_nobody_speaks(self) -> None:
        before, before_s = self.truth()[0], self.now()
        self.drive("teleop", 0.2, 0.0, lambda: self.truth()[0].distance(before) > 0.3, "0.3 m ahead")
        self.wait(lambda: abs(self.truth()[1]) < 0.001, "the base's own stop")
        with self.changed:
            speeds = [(m.header.stamp.to_sec(), m.twist.twist.linear.x) for m in self.kept[names.SIM_POSE]]
        cruising = [(at_s, v) for at_s, v in speeds if at_s > before_s and v > 0.19]
        self.assertAlmostEqual(float(np.median([v for _, v in cruising])), 0.2, delta=0.01)
        # The last command came later than the clock told when it was sent: how much later, a busy machine decides.
        self.assertGreater(cruising[-1][0] - self.sent_s, turtlebot.COMMAND_TIMEOUT_S - 0.1)
        stood = self.newest(names.SIM_POSE)
        odometry, truth = pose_of(self.nearest(names.ODOM, stood.header.stamp)), pose_of(stood)
        believed = ARENA.start.compose(odometry)
        self.assertLess(believed.distance(truth), 0.06)
        self.assertGreater(truth.distance(before), 0.3)

    def test_e_the_mux_lets_the_higher_source_through(self) -> None:
        self.settle()
        self.drive("navi", 0.0, 0.5, lambda: self.truth()[2] > 0.45, "navi turning left")
        self.wait(lambda: "navi" in [m.data for m in self.kept[names.MUX_ACTIVE]], "navi's right")
        self.drive("safety_controller", 0.0, -0.5, lambda: self.truth()[2] < -0.45, "safety turning right")
        self.wait(lambda: self.kept[names.MUX_ACTIVE][-1].data == "idle", "idle")
        self.settle()

    def test_f_a_wall_presses_the_bumper_and_backing_off_lets_it_go(self) -> None:
        self.drive("teleop", 0.0, 0.6, lambda: abs(abs(self.truth()[0].yaw_rad) - math.pi) < 0.1, "facing west")
        self.settle()
        self.drive("teleop", 0.2, 0.0, lambda: self.kept[names.BUMPER], "a bump")
        bump = self.kept[names.BUMPER][0]
        self.assertEqual(bump.state, BumperEvent.PRESSED)
        self.assertAlmostEqual(self.truth()[0].x, -1.5 + turtlebot.RADIUS_M, delta=0.02)
        self.assertEqual(self.wait(self.touched, "a contact"), {"turtlebot", "west"})
        self.newest(names.BUMPER_CLOUD)
        cloud = self.kept[names.BUMPER_CLOUD][0]  # of the first touch; the base may have bounced since
        points = np.frombuffer(cloud.data, np.float32).reshape(3, 3)
        self.assertEqual(cloud.header.frame_id, "base_link")
        self.assertAlmostEqual(float(np.min(np.hypot(points[:, 0], points[:, 1]))), 0.24, places=4)
        self.drive("teleop", -0.1, 0.0, self.let_go, "the bumper let go")
        self.settle()
        self.wait(self.let_go, "no bumper pressed")

    def test_g_nonsense_is_refused_and_said_once(self) -> None:
        bad = Twist()
        bad.linear.x = math.nan
        self.sources["safety_controller"].publish(bad)
        self.wait(self.refused, "a refusal")
        self.assertLess(abs(self.truth()[1]), 0.01)

    def test_h_arena_and_status(self) -> None:
        markers = self.wait(lambda: self.kept[names.SIM_ARENA], "the arena")[-1].markers
        self.assertEqual([m.scale.z for m in markers], [block.size[2] for block in ARENA.blocks])
        status = self.newest(names.SIM_STATUS, self.now())
        self.assertGreater(status.real_time_factor, 0.0)
        self.assertTrue({"physics", "scan", "publish"} <= set(status.parts))

    def test_i_a_bad_arena_or_parameter_ends_the_node_and_says_why(self) -> None:
        for script, argument, words in (
            ("room_simulation", "_arena:=nowhere", ["nowhere.yaml: no such arena"]),
            ("room_simulation", "_seed:=-5", ["seed = -5", "-1 to 2.14748e+09"]),
            ("cmd_vel_mux", "_priorities:=[1, 1, 2]", ["priorities = [1, 1, 2]", "twice"]),
        ):
            command = [
                sys.executable,
                str(resource("scripts", script)),
                f"__name:=bad_{script}_{argument[1]}",
                argument,
            ]
            done = subprocess.run(command, capture_output=True, text=True, timeout=WALL_LIMIT_S, check=False)
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            for word in words:
                self.assertIn(word, done.stdout + done.stderr)

    def elsewhere(self) -> List[str]:
        """A command: another room in lock-step, in a namespace of its own."""
        topics = [f"{topic}:=/elsewhere{topic}" for topic in ("/clock", "/tf", "/tf_static")]
        settings = ["_sync:=true", "_participants:=[nobody]", "_wait_for_map:=false", "_sync_timeout:=1.0"]
        arena = f"_arena:={resource('test', 'ros', 'room_arena.yaml')}"
        return [
            sys.executable,
            str(resource("scripts", "room_simulation")),
            "__ns:=elsewhere",
            *topics,
            *settings,
            arena,
        ]

    def test_j_a_lock_step_without_its_participants_ends_and_names_them(self) -> None:
        done = subprocess.run(self.elsewhere(), capture_output=True, text=True, timeout=WALL_LIMIT_S, check=False)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn("lock-step cannot start: nobody has not acknowledged", done.stdout + done.stderr)

    def test_k_a_lock_step_does_not_begin_before_commands_would_arrive(self) -> None:
        """Somebody answers each moment, and is not connected to the base."""
        acks = rospy.Publisher(f"/elsewhere/{names.STEP_ACK}", StepAck, queue_size=10)

        def answer(message: Clock) -> None:
            ack = StepAck(node="nobody")
            ack.header.stamp = message.clock
            acks.publish(ack)

        clock = rospy.Subscriber("/elsewhere/clock", Clock, answer)
        with subprocess.Popen(self.elsewhere(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as child:
            said = child.communicate(timeout=WALL_LIMIT_S)[0]
        clock.unregister()
        self.assertEqual(child.returncode, 1, said)
        self.assertIn(f"lock-step cannot start: nobody is connected to {names.BASE_VELOCITY}", said)

    def test_z_started_again_it_begins_anew(self) -> None:
        before_s = self.now()
        self.assertGreater(self.truth()[0].distance(ARENA.start), 0.2)
        subprocess.run(["rosnode", "kill", "/room_simulation"], check=True, capture_output=True, timeout=WALL_LIMIT_S)
        self.wait(lambda: self.kept["/clock"][-1].clock.to_sec() < before_s - 1.0, "time going backwards")
        with self.changed:
            for topic in (names.ODOM, names.SIM_POSE):
                self.kept[topic].clear()  # its stamps come again
        self.wait(lambda: self.truth()[0].distance(ARENA.start) < 0.01, "the start")
        self.drive("teleop", 0.2, 0.0, lambda: self.truth()[1] > 0.19, "driving after the restart")
        moving = self.newest(names.SIM_POSE)
        odometry = pose_of(self.nearest(names.ODOM, moving.header.stamp))
        self.assertLess(ARENA.start.compose(odometry).distance(pose_of(moving)), 0.1)


if __name__ == "__main__":
    init_node("room_test")
    rostest.rosrun("yarm", "room", RoomTest)
