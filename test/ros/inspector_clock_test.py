#!/usr/bin/env python3
"""Time goes back during a round: the inspector says so, stands, keeps what it has written, and begins afresh."""

from __future__ import annotations

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

STANDS_S = 3.0
"""Simulated time for which the robot is watched after time went back: a drive that goes on moves on in it."""
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

    def test_time_that_goes_back_ends_the_round_and_a_new_one_begins_afresh(self) -> None:
        self.ask(lambda: self.start().success, "a round that begins")
        self.wait(lambda: any(s.stage == Stage.DRIVE and s.verdicts for s in self.kept[STATUS]), "a verdict, a drive")
        subprocess.run(["rosnode", "kill", "/room_simulation"], check=True, capture_output=True, timeout=KILL_LIMIT_S)
        self.wait(lambda: self.reaches(IDLE), "an inspector that is idle in the new time")
        seen = self.wait(self.stood, f"{STANDS_S:g} s of the robot's places")
        first, last = (pose2_of_pose(message.pose.pose) for message in (seen[0], seen[-1]))
        self.assertLess(first.distance(last), STILL_M)
        statuses = list(self.since_reset(STATUS))
        self.assertEqual({(s.stage, len(s.verdicts)) for s in statuses}, {(IDLE, 0)})
        self.assertIn("time went backwards; waits for ~start", {s.reason for s in statuses})
        read = max(len(s.verdicts) for s in self.kept[STATUS])
        self.assertGreaterEqual(len(self.result.read_text().splitlines()), 1 + read)
        self.ask(lambda: self.start().success, "a round that begins again")
        self.wait(lambda: self.reaches(Stage.DRIVE), "a drive in the new time")
        began = next(s for s in self.since_reset(STATUS) if s.stage != IDLE)
        self.assertEqual((began.stage, len(began.verdicts)), (Stage.LOCALISE, 0))

    def stood(self) -> List[object]:
        """The robot's places of the new time, once there are enough of them."""
        truths = self.since_reset(TRUTH)
        lasts = truths and (truths[-1].header.stamp - truths[0].header.stamp).to_sec() >= STANDS_S
        return truths if lasts else []


if __name__ == "__main__":
    init_node("inspector_clock_test")
    rostest.rosrun("yarm", "inspector_clock", InspectorClockTest, sys.argv)
