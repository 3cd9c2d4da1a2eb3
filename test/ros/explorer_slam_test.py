#!/usr/bin/env python3
"""The mapping is killed in mid-run and comes back: stand, say so, keep the map, go on."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
import unittest

import rospy
import rostest
from nav_msgs.msg import Odometry
from yarm.msg import ExplorerStatus

from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.experiment.usage import node_pids

LIMIT_S = 120.0
STILL_MPS = 0.005


class SlamKilledTest(unittest.TestCase):
    def setUp(self):
        self.changed = threading.Condition()
        self.status = ExplorerStatus()
        self.lost = None
        self.speed = math.nan
        self.since_lost = []
        rospy.Subscriber(names.explorer("status"), ExplorerStatus, self.on_status)
        rospy.Subscriber(names.SIM_POSE, Odometry, self.on_pose)

    def on_status(self, message):
        with self.changed:
            self.status = message
            if self.lost is None and message.reason.startswith("pose: lost"):
                self.lost = message
            self.changed.notify_all()

    def on_pose(self, message):
        with self.changed:
            self.speed = math.hypot(message.twist.twist.linear.x, 0.115 * message.twist.twist.angular.z)
            if self.lost is not None:
                self.since_lost.append(self.speed)
            self.changed.notify_all()

    def wait(self, what, condition):
        end = time.monotonic() + LIMIT_S
        with self.changed:
            while not condition():
                left = end - time.monotonic()
                self.assertGreater(left, 0.0, f"waited {LIMIT_S:.0f} s for {what}; {self.status}")
                self.changed.wait(left)

    def test_it_stands_while_nobody_maps_and_goes_on_afterwards(self):
        self.wait("the robot to drive", lambda: self.status.moving and self.speed > 0.05)
        pid = node_pids()["/slam_gmapping"]
        with self.changed:
            self.lost = None
            os.kill(pid, signal.SIGKILL)
        # The mapping comes back by itself: what counts is what was said and done meanwhile, not what is so by now.
        self.wait("the explorer to notice", lambda: self.lost is not None)
        self.assertIn("look at the mapping node", self.lost.reason)
        self.assertEqual((self.lost.state, self.lost.behaviour), ("exploring", "hold"))
        self.wait("the robot to stand", lambda: any(speed < STILL_MPS for speed in self.since_lost))
        self.wait("the robot to go on", lambda: not self.status.reason and self.speed > 0.05)
        self.assertEqual(self.status.state, "exploring")


if __name__ == "__main__":
    init_node("explorer_slam_test")
    rostest.rosrun("yarm", "explorer_slam", SlamKilledTest)
