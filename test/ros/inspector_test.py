#!/usr/bin/env python3
"""Node inspector: waits for its camera, reads four boxes of which one was moved, comes home though the camera dies."""

from __future__ import annotations

import os
import threading
import time
import unittest
from pathlib import Path

import rospy
import rostest
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from yarm.msg import InspectionStatus, TagVerdict

from yarm.geometry import Pose2
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node

WALL_LIMIT_S = 350.0
STALL_S = 60.0
RESULT = Path(os.environ.get("ROS_HOME", "/tmp")) / "inspector_test" / "result.txt"
STANDS_AT = Pose2(-1.4, 0.7)
"""Box 3."""


class InspectorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.lock = threading.Lock()
        cls.passing = False
        cls.statuses, cls.verdicts = [], []
        cls.relayed = rospy.Publisher("relayed_image", Image, queue_size=5)
        cls.subscribers = [
            rospy.Subscriber(names.RGB_IMAGE, Image, cls.relay, queue_size=5, buff_size=2**22),
            rospy.Subscriber(names.inspector("status"), InspectionStatus, cls.statuses.append, queue_size=100),
            rospy.Subscriber(names.inspector("verdict"), TagVerdict, cls.verdicts.append, queue_size=100),
        ]
        cls.services = {
            name: rospy.ServiceProxy(names.inspector(name), Trigger)
            for name in ("start", "stop", "return_home", "save")
        }
        for service in cls.services.values():
            service.wait_for_service(WALL_LIMIT_S)

    @classmethod
    def relay(cls, message):
        if cls.passing:
            cls.relayed.publish(message)

    def until(self, done):
        """Whether something becomes true while time goes on."""
        end = moved = time.monotonic()
        end, newest_s = end + WALL_LIMIT_S, -1.0
        while time.monotonic() < end and time.monotonic() - moved < STALL_S:
            if done():
                return True
            if self.statuses and self.statuses[-1].header.stamp.to_sec() > newest_s:
                newest_s, moved = self.statuses[-1].header.stamp.to_sec(), time.monotonic()
            time.sleep(0.02)
        return done()

    def status(self):
        return self.statuses[-1] if self.statuses else InspectionStatus()

    def ask(self, name):
        return self.services[name]()

    def test_1_it_names_the_camera_that_it_waits_for_and_refuses_what_makes_no_sense(self):
        self.assertTrue(self.until(lambda: "waits for ~start" in self.status().reason), self.status())
        self.assertFalse(self.ask("return_home").success)
        self.assertTrue(self.ask("start").success)
        self.assertTrue(self.until(lambda: "camera: no picture has come yet" in self.status().reason), self.status())
        self.assertEqual(self.status().stage, "idle")
        self.assertTrue(any("look at the camera" in text for text in self.status().sensors))
        self.assertFalse(self.ask("start").success)

    def test_2_it_reads_every_box_finds_the_moved_one_and_is_home(self):
        type(self).passing = True
        self.assertTrue(self.until(lambda: self.status().stage in ("done", "failed")), self.status())
        self.assertEqual((self.status().stage, self.status().reason), ("done", ""))
        self.assertTrue(self.until(lambda: len(self.verdicts) >= 4))
        found = {verdict.box: verdict for verdict in self.verdicts[:4]}
        self.assertEqual({box: verdict.tag for box, verdict in found.items()}, {1: 5, 2: 0, 3: 11, 4: 2})
        moved = found[3]
        self.assertEqual((moved.finding, moved.has_pose), ("moved", True))
        self.assertLess(pose2_of_pose(moved.pose).distance(STANDS_AT), 0.06)
        self.assertEqual(len(RESULT.read_text().splitlines()), 5)
        self.assertEqual(len(self.status().verdicts), 4)
        self.assertGreater(self.status().left, 300.0)

    def test_3_without_a_camera_it_ends_with_reasons_and_is_home(self):
        before = len(self.verdicts)
        self.assertTrue(self.ask("start").success)
        self.assertTrue(self.until(lambda: len(self.verdicts) > before), self.status())
        type(self).passing = False
        self.assertTrue(self.until(lambda: "silent" in "; ".join(self.status().sensors)), self.status())
        self.assertTrue(self.until(lambda: self.status().stage in ("done", "failed")), self.status())
        self.assertEqual(self.status().stage, "done")
        blind = [verdict for verdict in self.status().verdicts if verdict.tag == TagVerdict.NONE]
        self.assertEqual(len(self.status().verdicts), 4)
        self.assertTrue(blind)
        for verdict in blind:
            self.assertIn("camera: silent", verdict.reason)
        self.assertTrue(self.ask("save").success)
        self.assertIn("unmatched", RESULT.read_text())

    def test_4_stopped_it_stands_and_keeps_what_it_has(self):
        type(self).passing = True
        self.assertTrue(self.until(lambda: not self.status().sensors), self.status())
        self.assertTrue(self.ask("start").success)
        self.assertTrue(self.until(lambda: self.status().stage == "drive"), self.status())
        self.assertTrue(self.ask("stop").success)
        self.assertTrue(self.until(lambda: self.status().stage == "stopped"), self.status())
        begun = self.status().header.stamp.to_sec()
        self.assertTrue(self.until(lambda: self.status().header.stamp.to_sec() > begun + 2.0))
        here = pose2_of_pose(self.status().pose)
        self.assertTrue(self.until(lambda: self.status().header.stamp.to_sec() > begun + 4.0))
        self.assertLess(pose2_of_pose(self.status().pose).distance(here), 0.02)


if __name__ == "__main__":
    init_node("inspector_test")
    rostest.rosrun("yarm", "inspector_rounds", InspectorTest)
