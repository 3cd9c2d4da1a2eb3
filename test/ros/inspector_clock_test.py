#!/usr/bin/env python3
"""Simulation and navigation die during a round and come again: the robot stands meanwhile, and nothing read is lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import List

import rospy
import rostest
from nav_msgs.msg import Odometry
from std_srvs.srv import Trigger
from yarm.msg import InspectionStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.inspection.model import Stage
from yarm.inspection.session import IDLE
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.experiment.usage import node_pids

STANDS_S = 3.0
"""Simulated time for which the robot is watched after something died: a drive that goes on moves on in it."""
STILL_M = 0.02
KILL_LIMIT_S = 60.0
STATUS, TRUTH = names.inspector("status"), names.SIM_POSE


class InspectorClockTest(ListeningTest):
    """The messages of the second life are those from the first stamp on that lies before its forerunner's."""

    limit_s = 250.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.result = Path(rospy.get_param("~result"))
        cls.listen()
        for topic, kind in ((STATUS, InspectionStatus), (TRUTH, Odometry)):
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

    def test_1_time_that_goes_back_ends_the_round_and_a_new_one_begins_afresh(self) -> None:
        self.ask(lambda: self.start().success, "a round that begins")
        self.wait(lambda: any(s.stage == Stage.DRIVE and s.verdicts for s in self.kept[STATUS]), "a verdict, a drive")
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

    def test_2_while_the_navigation_is_gone_it_stands_and_then_it_goes_on(self) -> None:
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
        """The robot's true places of so long, in the new time."""
        seen = self.wait(lambda: self.stood(from_s), f"{STANDS_S:g} s of the robot's places")
        first, last = (pose2_of_pose(message.pose.pose) for message in (seen[0], seen[-1]))
        self.assertLess(first.distance(last), STILL_M)

    def stood(self, from_s: float) -> List[object]:
        """The robot's places of the new time from a moment on, once there are enough of them."""
        truths = [truth for truth in self.since_reset(TRUTH) if truth.header.stamp.to_sec() >= from_s]
        lasts = truths and (truths[-1].header.stamp - truths[0].header.stamp).to_sec() >= STANDS_S
        return truths if lasts else []


if __name__ == "__main__":
    init_node("inspector_clock_test")
    rostest.rosrun("yarm", "inspector_clock", InspectorClockTest, sys.argv)
