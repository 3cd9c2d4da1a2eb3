#!/usr/bin/env python3
"""What may happen to a round while the robot drives: silent sensors, a lost place, one that jumps, somebody in the way.

Sensors fall silent, and somebody stands in the way, between the room and everybody else. Our localisation says that it
is lost before its place jumps; another's need not, so the test sends the jump in its stead. Simulation and navigation
die and come again: the robot stands meanwhile, and nothing read is lost.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Callable, List, Optional

import numpy as np
import rospy
import rostest
import tf2_ros
from between import PERSON_RADIUS_M, Between, ScanBetween
from geometry_msgs.msg import PoseWithCovarianceStamped
from move_base_msgs.msg import MoveBaseActionGoal
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger
from yarm.msg import InspectionStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard
from support.listening import ListeningTest
from yarm.geometry import Pose2
from yarm.inspection.model import Stage
from yarm.inspection.session import IDLE
from yarm.robots.turtlebot import RADIUS_M
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose, pose_message
from yarm.ros.common.frames import Frames
from yarm.ros.common.start import init_node
from yarm.ros.experiment.usage import node_pids
from yarm.ros.rooms.messages import transform

STANDS_S = 3.0
"""Simulated time for which the robot is watched after something died: a drive that goes on moves on in it."""
STILL_M = 0.02
KILL_LIMIT_S = 60.0
FAST_MPS = 0.1
AHEAD_M, WAITS_S = 0.80, 5.0
"""So far before a robot that drives somebody steps into its way, and stands there for so long."""
WRONG = Pose2(0.6, 0.0, 0.6)
"""How far beside its true place the robot is told to be."""
FOUND_M = 0.10
JUMPED = Pose2(0.5, 0.0)
"""By which the place jumps."""
PASS_S = 0.2
"""A goal that is given again at the pass that finds the jump has a stamp so near to that of its status."""
STATUS, TRUTH, PLACE = names.inspector("status"), names.SIM_POSE, names.AMCL_POSE
GOAL = names.move_base("goal")


class InspectorClockTest(ListeningTest):
    """The messages of the second life are those from the first stamp on that lies before its forerunner's."""

    limit_s = 250.0
    restarted = False

    @classmethod
    def setUpClass(cls) -> None:
        cls.result = Path(rospy.get_param("~result"))
        cls.listen()
        cls.scan = ScanBetween("room_scan", names.SCAN)
        cls.odometry = Between("room_odom", names.ODOM, Odometry)
        cls.guess = rospy.Publisher(names.INITIAL_POSE, PoseWithCovarianceStamped, queue_size=1)
        cls.frames, cls.tf = Frames(), tf2_ros.TransformBroadcaster()
        for topic, kind in (
            (STATUS, InspectionStatus),
            (TRUTH, Odometry),
            (PLACE, PoseWithCovarianceStamped),
            (GOAL, MoveBaseActionGoal),
        ):
            cls.keep(topic, kind, most=100000)
        cls.start = rospy.ServiceProxy(names.inspector("start"), Trigger)
        cls.start.wait_for_service(cls.limit_s)

    def since_reset(self, topic: str) -> List[object]:
        """What has come of a topic since time went back; empty before."""
        kept = self.kept[topic]
        for i in range(len(kept) - 1, 0, -1):
            if kept[i].header.stamp < kept[i - 1].header.stamp:
                return kept[i:]
        return []

    def reaches(self, stage: str) -> bool:
        """Whether the inspector has been at a stage in the new time; it may have left it since."""
        return any(status.stage == stage for status in self.since_reset(STATUS))

    def status_since(self, mark: int, holds: Callable[[InspectionStatus], bool], what: str) -> InspectionStatus:
        """The first status since a count of them of which something holds."""
        return self.wait(lambda: next((s for s in self.kept[STATUS][mark:] if holds(s)), None), what)

    def driving(self, *stages: str) -> int:
        """The count of statuses at a moment at which the robot drives, to a box unless other stages are given."""

        def drives() -> bool:
            statuses, truths = self.kept[STATUS], self.kept[TRUTH]
            in_stage = statuses and statuses[-1].stage in (stages or (Stage.DRIVE,))
            return bool(in_stage and truths and truths[-1].twist.twist.linear.x > FAST_MPS)

        self.wait(drives, "a robot that drives")
        with self.changed:
            return len(self.kept[STATUS])

    def truth(self) -> Pose2:
        """Where the robot is."""
        return pose2_of_pose(self.fresh(TRUTH).pose.pose)

    def test_1_without_scan_or_odometry_it_stands_and_then_it_drives_on(self) -> None:
        for topic in (names.SCAN, names.ODOM):
            for node in ("inspector", "amcl" if topic == names.SCAN else "move_base"):
                wait_until_heard(topic, node)
        self.ask(lambda: self.start().success, "a round that begins")
        for sensor, sent in (("scan", self.scan), ("odometry", self.odometry)):
            mark = self.driving()
            sent.silent = True
            words = f"{sensor}: none newer than"
            sick = self.status_since(mark, lambda s, words=words: any(words in text for text in s.sensors), words)
            self.assertEqual(sick.stage, Stage.DRIVE)
            self.assert_it_stands_from(sick.header.stamp.to_sec() + 0.5)
            with self.changed:
                mark = len(self.kept[STATUS])
            sent.silent = False
            self.status_since(mark, lambda s: not s.sensors, f"{sensor} again")

    def test_2_a_place_that_is_lost_is_found_again_by_a_turn(self) -> None:
        mark = self.driving()
        told = PoseWithCovarianceStamped()
        told.header.frame_id, told.header.stamp = names.MAP_FRAME, rospy.Time.now()
        wrong = self.truth().compose(WRONG)
        told.pose.pose = pose_message(wrong.x, wrong.y, 0.0, wrong.yaw_rad)
        told.pose.covariance = (np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]) * 0.05**2).ravel().tolist()
        self.guess.publish(told)
        self.status_since(mark, lambda s: "the pose given" in s.reason, "a place that is doubted")
        self.status_since(mark, lambda s: s.stage == Stage.LOCALISE, "a turn to find the place")
        mark = self.driving()
        place = self.fresh(PLACE)
        at = self.wait(
            lambda: next((m for m in self.kept[TRUTH] if m.header.stamp >= place.header.stamp), None),
            "the true place at that moment",
        )
        self.assertLess(pose2_of_pose(place.pose.pose).distance(pose2_of_pose(at.pose.pose)), FOUND_M)

    def test_3_a_place_that_jumps_is_told_and_the_goal_is_given_again(self) -> None:
        mark = self.driving()
        beside = self.frames.link(names.ODOM_FRAME).pose.compose(JUMPED)

        def jumped() -> Optional[InspectionStatus]:
            self.tf.sendTransform(transform(names.MAP_FRAME, names.ODOM_FRAME, beside, rospy.Time.now()))
            said = (s for s in self.kept[STATUS][mark:] if s.stage == Stage.DRIVE)
            return next((s for s in said if s.reason.startswith("the place has jumped by")), None)

        told = self.ask(jumped, "a drive that is told that its place has jumped")
        at_s = told.header.stamp.to_sec()
        self.wait(
            lambda: any(abs(goal.header.stamp.to_sec() - at_s) < PASS_S for goal in self.kept[GOAL]),
            "the goal, given again",
        )
        self.driving()

    def test_4_who_steps_into_the_way_is_not_run_into_and_the_round_goes_on(self) -> None:
        mark = self.driving()
        ahead = self.truth().compose(Pose2(AHEAD_M, 0.0))
        self.scan.person = np.array([ahead.x, ahead.y])
        came_s = rospy.get_time()
        stays = self.wait(
            lambda: self.kept[TRUTH][-1].header.stamp.to_sec() >= came_s + WAITS_S and list(self.kept[TRUTH]),
            f"{WAITS_S:g} s with somebody in the way",
        )
        self.scan.person = None
        nearest_m = min(pose2_of_pose(m.pose.pose).distance(ahead) for m in stays if m.header.stamp.to_sec() >= came_s)
        self.assertGreater(nearest_m, RADIUS_M + PERSON_RADIUS_M)
        read = len(self.kept[STATUS][mark - 1].verdicts)
        self.status_since(mark, lambda s: len(s.verdicts) > read, "another verdict")

    def test_5_time_that_goes_back_ends_the_round_and_a_new_one_begins_afresh(self) -> None:
        self.driving(Stage.DRIVE, Stage.HOME)
        type(self).restarted = True
        subprocess.run(["rosnode", "kill", "/room_simulation"], check=True, capture_output=True, timeout=KILL_LIMIT_S)
        self.wait(lambda: self.reaches(IDLE), "an inspector that is idle in the new time")
        self.assert_it_stands_from(0.0)
        statuses = list(self.since_reset(STATUS))
        self.assertEqual({(s.stage, len(s.verdicts)) for s in statuses}, {(IDLE, 0)})
        self.assertIn("time went backwards; waits for ~start", {s.reason for s in statuses})
        read = max(len(s.verdicts) for s in self.kept[STATUS])
        self.assertGreaterEqual(len(self.result.read_text().splitlines()), 1 + read)
        self.ask(lambda: self.start().success, "a round that begins again")
        self.wait(lambda: self.reaches(Stage.DRIVE), "a drive in the new time")
        began = next(s for s in self.since_reset(STATUS) if s.stage != IDLE)
        self.assertEqual((began.stage, len(began.verdicts)), (Stage.LOCALISE, 0))

    def test_6_while_the_navigation_is_gone_it_stands_and_then_it_goes_on(self) -> None:
        os.kill(node_pids()[f"/{names.MOVE_BASE}"], signal.SIGKILL)
        gone = self.wait(lambda: next((s for s in self.since_reset(STATUS) if any(
            text.startswith("navigation: silent for") and "start move_base" in text for text in s.sensors
        )), None), "an inspector that misses its navigation")  # fmt: skip
        self.assert_it_stands_from(gone.header.stamp.to_sec())
        read = len(self.since_reset(STATUS)[-1].verdicts)
        with subprocess.Popen(["rosrun", "yarm", "move_base"]) as again:
            try:
                self.wait(
                    lambda: any(len(s.verdicts) > read and not s.sensors for s in self.since_reset(STATUS)),
                    "another verdict",
                )
            finally:
                again.send_signal(signal.SIGINT)

    def assert_it_stands_from(self, from_s: float) -> None:
        """The robot's true places of so long, in the new time once it has begun."""
        seen = self.wait(lambda: self.stood(from_s), f"{STANDS_S:g} s of the robot's places")
        first, last = (pose2_of_pose(message.pose.pose) for message in (seen[0], seen[-1]))
        self.assertLess(first.distance(last), STILL_M)

    def stood(self, from_s: float) -> List[object]:
        """The robot's places from a moment on, in the new time if there is one, once there are enough of them."""
        heard = self.since_reset(TRUTH) if self.restarted else self.kept[TRUTH]
        truths = [truth for truth in heard if truth.header.stamp.to_sec() >= from_s]
        lasts = truths and (truths[-1].header.stamp - truths[0].header.stamp).to_sec() >= STANDS_S
        return truths if lasts else []


if __name__ == "__main__":
    init_node("inspector_clock_test")
    rostest.rosrun("yarm", "inspector_clock", InspectorClockTest, sys.argv)
