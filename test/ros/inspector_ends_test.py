#!/usr/bin/env python3
"""The inspector is told to end, is killed, or hangs while the robot drives: it stands, and what was read is kept."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import rospy
import rostest
from nav_msgs.msg import Odometry
from yarm.msg import InspectionStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.geometry import Pose2
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.graph import node_pids
from yarm.ros.common.start import init_node

NODE = f"/{names.INSPECTOR_NODE}"
FAST_MPS, FAST_RADPS = 0.1, 0.2
STOPS_S, STANDS_S = 1.5, 4.0
"""Simulated time in which it comes to rest, and for which it is watched then: a drive that goes on moves on in it."""
STILL_M, STILL_RAD = 0.02, 0.05


class InspectorEndsTest(ListeningTest):
    limit_s = 400.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.result = Path(rospy.get_param("~result"))
        cls.listen((names.inspector("status"), InspectionStatus), (names.SIM_POSE, Odometry))

    def drives_on_after_a_verdict(self) -> bool:
        """It has read a box, and drives to the next one."""
        statuses, truths = self.kept[names.inspector("status")], self.kept[names.SIM_POSE]
        if not statuses or not truths or statuses[-1].stage != "drive" or not statuses[-1].verdicts:
            return False
        twist = truths[-1].twist.twist
        return bool(math.hypot(twist.linear.x, twist.linear.y) > FAST_MPS or abs(twist.angular.z) > FAST_RADPS)

    def truth_after(self, at_s: float) -> Pose2:
        """Where the robot is at the first message from a time on."""
        found = self.wait(
            lambda: next((m for m in self.kept[names.SIM_POSE] if m.header.stamp.to_sec() >= at_s), None),
            f"the robot's pose at {at_s:.1f} s",
        )
        return pose2_of_pose(found.pose.pose)

    def test_1_told_to_end_it_leaves_a_robot_that_stands_and_what_was_read(self) -> None:
        self.end_by(signal.SIGINT)

    def test_2_killed_it_leaves_a_robot_that_stands_and_what_was_read(self) -> None:
        self.end_another_by(signal.SIGKILL)

    def test_3_so_it_does_when_a_launch_file_ends_it(self) -> None:
        self.end_another_by(signal.SIGTERM)

    def test_4_and_when_it_hangs(self) -> None:
        self.end_another_by(signal.SIGSTOP)

    def end_another_by(self, number: signal.Signals) -> None:
        """Start an inspector anew and end it by a signal in its round."""
        with self.changed:
            self.kept[names.inspector("status")].clear()
        with subprocess.Popen(["rosrun", "yarm", "inspector"]) as again:
            try:
                self.end_by(number)
            finally:
                again.kill()

    def end_by(self, number: signal.Signals) -> None:
        """End the inspector by a signal while the robot drives on after a verdict."""
        self.wait(self.drives_on_after_a_verdict, "a drive after the first verdict")
        pid = node_pids()[NODE]
        read = len(self.kept[names.inspector("status")][-1].verdicts)
        os.kill(pid, number)
        over = "State:\tT" if number == signal.SIGSTOP else "State:\tZ"
        self.ask(lambda: not Path(f"/proc/{pid}").exists() or over in Path(f"/proc/{pid}/status").read_text(),
                 "the inspector's end")  # fmt: skip
        ended_s = rospy.get_time()
        rested = self.truth_after(ended_s + STOPS_S)
        later = self.truth_after(ended_s + STOPS_S + STANDS_S)
        self.assertLess(rested.distance(later), STILL_M)
        self.assertLess(abs(math.remainder(later.yaw_rad - rested.yaw_rad, 2.0 * math.pi)), STILL_RAD)
        lines = self.result.read_text().splitlines()
        self.assertEqual(lines[0], "Tag is 0 means blank")
        self.assertGreaterEqual(len(lines), 1 + read)
        self.assertEqual(len([line for line in lines if line.startswith("boxNumber: ")]), len(lines) - 1)


if __name__ == "__main__":
    init_node("inspector_ends_test")
    rostest.rosrun("yarm", "inspector_ends", InspectorEndsTest, sys.argv)
