#!/usr/bin/env python3
"""The mapping is killed in mid-run and comes back: stand, say so, keep the map, go on."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import rostest
from nav_msgs.msg import Odometry
from yarm.msg import ExplorerStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.ros.common import names
from yarm.ros.common.graph import node_pids
from yarm.ros.common.start import init_node

STATUS = names.explorer("status")
STILL_MPS, DRIVES_MPS = 0.005, 0.05
STANDS_S = 1.0
MAPPING = "/slam_gmapping"


def speed(message):
    """Of the robot's fastest wheel over the ground, m/s."""
    twist = message.twist.twist
    return math.hypot(twist.linear.x, 0.115 * twist.angular.z)


class SlamKilledTest(ListeningTest):
    limit_s = 240.0
    mapping: subprocess.Popen

    @classmethod
    def setUpClass(cls):
        cls.listen((STATUS, ExplorerStatus), (names.SIM_POSE, Odometry))
        cls.start_mapping()

    @classmethod
    def tearDownClass(cls):
        os.killpg(cls.mapping.pid, signal.SIGTERM)
        cls.mapping.wait(cls.limit_s)

    @classmethod
    def start_mapping(cls):
        command = ["rosrun", "yarm", "slam_gmapping", f"__name:={MAPPING[1:]}"]
        cls.mapping = subprocess.Popen(command, start_new_session=True)

    def since(self, topic, from_s):
        """What has been heard with a stamp after a moment."""
        return [message for message in self.kept[topic] if message.header.stamp.to_sec() > from_s]

    def wait_until_it_drives(self, from_s):
        """That it explores, nothing is wrong, and the robot really moves, all after a moment."""

        def drives():
            said = [m for m in self.since(STATUS, from_s) if m.moving and not m.reason]
            after_s = said[0].header.stamp.to_sec() if said else math.inf
            return any(speed(pose) > DRIVES_MPS for pose in self.since(names.SIM_POSE, after_s)) and said[0]

        return self.wait(drives, f"the robot drives after {from_s:.1f} s")

    def test_it_stands_while_nobody_maps_and_goes_on_afterwards(self):
        self.wait_until_it_drives(0.0)
        pid = self.ask(lambda: node_pids().get(MAPPING), "the mapping's process")
        killed_s = self.kept[STATUS][-1].header.stamp.to_sec()
        os.kill(pid, signal.SIGKILL)
        lost = self.wait(
            lambda: next((m for m in self.since(STATUS, killed_s) if "pose: lost" in m.reason), None),
            "the explorer notices",
        )
        self.assertIn("look at the mapping node", lost.reason)
        self.assertEqual((lost.state, lost.behaviour), ("exploring", "hold"))
        lost_s = lost.header.stamp.to_sec()
        rested_s = self.wait(lambda: self.rest_after(lost_s), f"the robot stands for {STANDS_S:g} s")
        self.mapping.wait(self.limit_s)
        self.start_mapping()
        self.assertEqual(self.wait_until_it_drives(rested_s).state, "exploring")

    def rest_after(self, from_s):
        """The end of the first time after a moment that the robot has stood for so long; None before."""
        since_s = math.inf
        for pose in self.since(names.SIM_POSE, from_s):
            now_s = pose.header.stamp.to_sec()
            since_s = min(since_s, now_s) if speed(pose) < STILL_MPS else math.inf
            if now_s - since_s >= STANDS_S:
                return now_s
        return None


if __name__ == "__main__":
    init_node("explorer_slam_test")
    rostest.rosrun("yarm", "explorer_slam", SlamKilledTest)
