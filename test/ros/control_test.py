#!/usr/bin/env python3
"""The controls server against the kinematic stand-in: goals, refusals, preemption, old poses, robots that go."""

from __future__ import annotations

import math
import threading
import unittest
from typing import List, Tuple

import rosnode
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Pose
from std_msgs.msg import String
from yarm.msg import MoveRobotAction, MoveRobotFeedback, MoveRobotGoal, TransformStampedVector

from yarm.geometry.poses import Pose2, quaternion_from_rpy, yaw_of_quaternion
from yarm.ros.common import names
from yarm.ros.common.start import init_node

LIMIT = rospy.Duration(60.0)
SERVER_LIMIT = rospy.Duration(240.0)
"""For a node to be started, s of simulated time, which is up to twice as fast as real time."""


class ControlTest(unittest.TestCase):
    """One launch serves every check; each leaves the stand-in well-behaved."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.events = rospy.Publisher("standin/event", String, queue_size=10)
        cls.lock = threading.Condition()
        cls.poses = {}
        cls.track: List[Tuple[float, Pose2]] = []
        rospy.Subscriber(names.SEED_TRANSFORMS, TransformStampedVector, cls.on_seeds)
        cls.clients = {
            n: SimpleActionClient(names.move_robot(n), MoveRobotAction) for n in ("ankurbot_1", "ankurbot_2")
        }
        for name, client in cls.clients.items():
            assert client.wait_for_server(SERVER_LIMIT), name

    @classmethod
    def on_seeds(cls, message: TransformStampedVector) -> None:
        with cls.lock:
            for transform, name in zip(message.transforms, message.frame):
                t, q = transform.transform.translation, transform.transform.rotation
                pose = Pose2(t.x, t.y, yaw_of_quaternion((q.x, q.y, q.z, q.w)))
                cls.poses[name] = (pose, transform.header.stamp.to_sec())
                if name == "ankurbot_1":
                    stamp_s = transform.header.stamp.to_sec()
                    if cls.track and stamp_s < cls.track[-1][0]:
                        cls.track.clear()  # time has begun again
                    cls.track.append((stamp_s, pose))
            cls.lock.notify_all()

    def event(self, text: str) -> None:
        self.events.publish(String(text))

    def wait(self, condition, what: str, limit_s: float = 30.0) -> None:
        with self.lock:
            self.assertTrue(self.lock.wait_for(condition, timeout=limit_s), f"never came: {what}")

    def send(self, name: str, target: Pose2, action: str = "False", feedback=None) -> SimpleActionClient:
        self.clients[name].send_goal(goal(target, action), feedback_cb=feedback)
        return self.clients[name]

    def finish(self, client: SimpleActionClient, state: int, limit: rospy.Duration = LIMIT) -> str:
        self.assertTrue(client.wait_for_result(limit), "no result")
        message = client.get_result().message
        self.assertEqual(client.get_state(), state, message)
        return message

    def pose_now(self, name: str) -> Pose2:
        """Where a robot is, by a pose that is younger than everything heard so far."""
        now_s = rospy.get_time()
        self.wait(lambda: name in self.poses and self.poses[name][1] > now_s, f"a pose of {name} after {now_s:.3f} s")
        return self.poses[name][0]

    def rest_time(self, since_s: float) -> float:
        """Time from a moment until ankurbot_1 has come to rest, as two seconds of poses tell, s."""
        with self.lock:
            self.assertTrue(self.lock.wait_for(lambda: self.track[-1][0] > since_s + 2.0, timeout=60.0), "no poses")
            track = [sample for sample in self.track if sample[0] >= since_s]
        moving = [b for (a, at), (b, to) in zip(track, track[1:]) if b > a and at.distance(to) > 0.01 * (b - a)]
        return max(moving, default=since_s) - since_s

    def speed(self, name: str) -> float:
        """Speed between now and the next pose, m/s."""
        with self.lock:
            before, before_s = self.poses[name]
            self.lock.wait_for(lambda: self.poses[name][1] > before_s, timeout=10.0)
            after, after_s = self.poses[name]
        return before.distance(after) / (after_s - before_s)

    def test_1_calibration_gives_the_footprint_in_cells(self) -> None:
        client = self.send("ankurbot_1", Pose2(0, 0), "CALIBRATION")
        self.assertEqual(self.finish(client, GoalStatus.SUCCEEDED), "SPACE=XY/AREA=17,7,15")
        self.assertTrue(client.get_result().flag)

    def test_2_two_robots_reach_their_poses_at_once(self) -> None:
        seen: List[MoveRobotFeedback] = []
        targets = {"ankurbot_1": Pose2(0.2, 0.9, 2.5), "ankurbot_2": Pose2(-0.5, -1.9, 0.4)}
        starts = {name: self.pose_now(name).yaw_rad for name in targets}
        clients = [self.send(name, target, feedback=seen.append) for name, target in targets.items()]
        for client in clients:
            self.finish(client, GoalStatus.SUCCEEDED)
        for name, target in targets.items():
            pose = self.pose_now(name)
            self.assertLess(pose.distance(target), 0.03)
            self.assertLess(abs(math.degrees(math.remainder(pose.yaw_rad - target.yaw_rad, 2 * math.pi))), 1.0)
        self.assertEqual({f.robotname for f in seen}, set(targets))
        self.assertEqual({f.robottype for f in seen}, {"Mobile"})
        self.assertGreater(max(math.hypot(f.vx, f.vy) for f in seen), 0.2)
        for name, target in targets.items():
            turns = [f.delta_yaw for f in seen if f.robotname == name]
            expected = math.remainder(target.yaw_rad - starts[name], 2 * math.pi)
            self.assertAlmostEqual(turns[0], expected, delta=0.2)
            self.assertLess(abs(turns[-1]), math.radians(3.0))
        self.assertEqual({(f.delta_roll, f.delta_pitch) for f in seen}, {(0.0, 0.0)})

    def test_3_wrong_targets_are_refused_by_value(self) -> None:
        wrong = goal(Pose2(0, 0), "False")
        wrong.target.position.x = math.nan
        self.clients["ankurbot_1"].send_goal(wrong)
        self.assertIn("nan", self.finish(self.clients["ankurbot_1"], GoalStatus.REJECTED))
        self.clients["ankurbot_1"].send_goal(MoveRobotGoal(action="False"))
        self.assertIn("length 1", self.finish(self.clients["ankurbot_1"], GoalStatus.REJECTED))
        turned = goal(Pose2(0, 0))
        turned.via = [goal(Pose2(0.5, 0.0)).target, goal(Pose2(0.2, 0.0, 0.3)).target]
        self.clients["ankurbot_1"].send_goal(turned)
        refused = self.finish(self.clients["ankurbot_1"], GoalStatus.REJECTED)
        self.assertIn("via[1] is turned by 17.2 deg from the target, allowed 0.5", refused)
        turned.via = [wrong.target]
        self.clients["ankurbot_1"].send_goal(turned)
        self.assertIn("via[0] (nan", self.finish(self.clients["ankurbot_1"], GoalStatus.REJECTED))
        self.clients["ankurbot_1"].send_goal(goal(Pose2(0, 0), "PICK debris_1"))
        self.assertIn("ankurbot_1 has no hand", self.finish(self.clients["ankurbot_1"], GoalStatus.REJECTED))

    def test_4_cancel_stops_within_half_a_second(self) -> None:
        client = self.send("ankurbot_1", Pose2(0.2, 2.4, 2.5))
        self.wait_moving("ankurbot_1")
        cancelled_s = self.poses["ankurbot_1"][1]
        client.cancel_goal()
        self.finish(client, GoalStatus.PREEMPTED)
        self.assertLess(self.rest_time(cancelled_s), 0.5)

    def test_5_a_newer_goal_replaces_the_older(self) -> None:
        first = SimpleActionClient(names.move_robot("ankurbot_1"), MoveRobotAction)
        self.assertTrue(first.wait_for_server(SERVER_LIMIT))
        first.send_goal(goal(Pose2(0.2, 2.4, 2.5)))
        self.wait_moving("ankurbot_1")
        second = self.send("ankurbot_1", Pose2(0.4, 0.9, 2.5))
        self.assertIn("newer", self.finish(first, GoalStatus.PREEMPTED))
        self.finish(second, GoalStatus.SUCCEEDED)

    def test_6_old_poses_stop_the_robot_and_name_the_cause(self) -> None:
        client = self.send("ankurbot_2", Pose2(1.2, -1.9, 0.4))
        self.wait_moving("ankurbot_2")
        self.event("silent")
        message = self.finish(client, GoalStatus.ABORTED)
        silent_s = self.poses["ankurbot_2"][1]
        self.event("talk")
        self.wait(lambda: self.poses["ankurbot_2"][1] > silent_s, "poses again")
        self.assertIn("no pose of ankurbot_2 for", message)
        self.finish(self.send("ankurbot_2", Pose2(0.0, -1.9, 0.4)), GoalStatus.SUCCEEDED)

    def test_7_a_robot_that_does_not_move_is_given_up(self) -> None:
        self.event("freeze ankurbot_2")
        message = self.finish(self.send("ankurbot_2", Pose2(0.5, -1.5, 0.4)), GoalStatus.ABORTED)
        self.event("thaw ankurbot_2")
        self.assertIn("has not moved for 10 s", message)

    def test_8_a_robot_that_goes_loses_its_server_and_gets_it_back(self) -> None:
        client = self.send("ankurbot_2", Pose2(-1.0, -1.5, 0.4))
        self.wait_moving("ankurbot_2")
        self.event("remove ankurbot_2")
        self.assertIn("missing from the seeds", self.finish(client, GoalStatus.ABORTED))
        self.event("add ankurbot_2")
        self.reach_in_the_end("ankurbot_2", Pose2(-0.5, -1.5, 0.4))

    def test_9_time_going_backwards_aborts_and_starts_afresh(self) -> None:
        client = self.send("ankurbot_1", Pose2(0.2, 2.3, 2.5))
        self.wait_moving("ankurbot_1")
        self.event("restart")
        self.assertIn("backwards", self.finish(client, GoalStatus.ABORTED))
        self.reach_in_the_end("ankurbot_1", Pose2(0.4, 0.9, 2.5))

    def test_a_server_that_ends_stops_its_robots_and_comes_back(self) -> None:
        self.send("ankurbot_1", Pose2(0.2, 2.4, 2.5))
        self.wait_moving("ankurbot_1")
        killed, failed = rosnode.kill_nodes(["/multi_robot_controls_server"])
        self.assertEqual((killed, failed), (["/multi_robot_controls_server"], []))
        self.assertLess(self.rest_time(self.poses["ankurbot_1"][1]), 1.5)
        self.reach_in_the_end("ankurbot_1", Pose2(0.4, 0.9, 2.5))

    def reach_in_the_end(self, name: str, target: Pose2) -> None:
        """A goal sent over a connection that has just died is lost, so that a client must try again."""
        client = SimpleActionClient(names.move_robot(name), MoveRobotAction)
        for _ in range(5):
            self.assertTrue(client.wait_for_server(SERVER_LIMIT))
            client.send_goal(goal(target))
            if client.wait_for_result(rospy.Duration(30.0)) and client.get_state() == GoalStatus.SUCCEEDED:
                return
        self.fail(f"{name} not reached: {client.get_goal_status_text()}")

    def wait_moving(self, name: str) -> None:
        for _ in range(600):
            if self.speed(name) > 0.2:
                return
        self.fail(f"{name} never moved")


def goal(target: Pose2, action: str = "False") -> MoveRobotGoal:
    """A pose goal."""
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = target.x, target.y, 0.89
    q = pose.orientation
    q.x, q.y, q.z, q.w = quaternion_from_rpy(0.0, 0.0, target.yaw_rad)
    return MoveRobotGoal(target=pose, action=action)


if __name__ == "__main__":
    init_node("control_test")
    rostest.rosrun("yarm", "control", ControlTest)
