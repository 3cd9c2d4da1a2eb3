#!/usr/bin/env python3
"""Node tag_recogniser: verdict, objects and outlines of what a camera shows; its services; bad pictures by name."""

from __future__ import annotations

import sys
import time
import unittest
from pathlib import Path

import cv2
import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image
from std_msgs.msg import Float32MultiArray

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from yarm.msg import InspectionStatus, TagVerdict
from yarm.srv import AddTag, LoadTags, RemoveTag

from yarm.ros.common.start import init_node
from yarm.ros.inspection.recogniser_node import picture_message
from yarm.tags.pictures import shipped_pictures, stranger

LIMIT_S = 60.0
TAGS = shipped_pictures()


def shown(picture, left=120, top=90):
    """A room with a picture in it, 300 x 240 px, and noise that never repeats."""
    room = np.full((480, 640), 130.0)
    room[top : top + 240, left : left + 300] = cv2.resize(picture, (300, 240), interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(int(1000 * rospy.get_time())).normal(0.0, 2.0, room.shape)
    return np.clip(room + noise, 0, 255).astype(np.uint8)


class RecogniserTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.now_s = 10.0
        cls.heard = {"verdict": [], "objects": [], "image": [], "diagnostics": []}
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.camera = rospy.Publisher("webcam", Image, queue_size=10)
        cls.status = rospy.Publisher("inspector/status", InspectionStatus, queue_size=1, latch=True)
        topics = (
            ("verdict", "tag_recogniser/verdict", TagVerdict),
            ("objects", "objects", Float32MultiArray),
            ("image", "tag_recogniser/image", Image),
            ("diagnostics", "/diagnostics", DiagnosticArray),
        )
        cls.subscribers = [
            rospy.Subscriber(topic, kind, cls.heard[name].append, queue_size=100) for name, topic, kind in topics
        ]
        cls.services = {
            name: rospy.ServiceProxy(f"tag_recogniser/{name}", kind)
            for name, kind in (("add_tag", AddTag), ("remove_tag", RemoveTag), ("load_tags", LoadTags))
        }
        for service in cls.services.values():
            service.wait_for_service(LIMIT_S)
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end and not (
            cls.clock.get_num_connections()
            and cls.camera.get_num_connections()
            and all(s.get_num_connections() for s in cls.subscribers)
        ):
            time.sleep(0.02)

    def until(self, done, message=None):
        """Time goes on in tenths, each with a picture, until something is true."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            type(self).now_s += 0.1
            self.clock.publish(Clock(rospy.Time.from_sec(self.now_s)))
            if message is not None:
                made = message()
                made.header.stamp, made.header.frame_id = rospy.Time.from_sec(self.now_s), "webcam_frame"
                self.camera.publish(made)
            wait = time.monotonic() + 0.1
            while time.monotonic() < wait:
                if done():
                    return True
                time.sleep(0.01)
        return done()

    def verdict_since(self, begun, wanted):
        """The first verdict on a picture taken after a moment that says what is wanted."""
        fresh = [v for v in list(self.heard["verdict"]) if v.header.stamp.to_sec() > begun + 0.05 and wanted(v)]
        return fresh[0] if fresh else None

    def expect(self, message, wanted):
        begun = self.now_s
        self.assertTrue(
            self.until(lambda: self.verdict_since(begun, wanted) is not None, message), self.heard["verdict"][-1:]
        )
        return self.verdict_since(begun, wanted)

    def test_1_it_says_what_hangs_there_and_where(self):
        found = self.expect(lambda: picture_message(shown(TAGS[7])), lambda v: v.tag == 7)
        self.assertEqual((found.box, found.header.frame_id, found.reason), (0, "webcam_frame", ""))
        self.assertGreater(found.probability, 0.999)
        self.assertEqual(list(found.answers), [*range(1, 16), 0, -1])
        self.assertAlmostEqual(sum(found.scores), 1.0, places=6)
        self.assertTrue(self.until(lambda: any(m.data for m in list(self.heard["objects"]))))
        objects = next(list(m.data) for m in list(self.heard["objects"]) if m.data)
        self.assertEqual(objects[:3], [7.0, 1000.0, 800.0])
        h = np.array(objects[3:]).reshape(3, 3)
        corner = np.array([1000.0, 800.0, 1.0]) @ h
        self.assertLess(abs(corner[:2] / corner[2] - (420, 330)).max(), 5.0)
        self.assertTrue(self.until(lambda: bool(self.heard["image"]), lambda: picture_message(shown(TAGS[7]))))
        drawn = self.heard["image"][-1]
        self.assertEqual((drawn.encoding, drawn.width, drawn.height), ("bgr8", 640, 480))

    def test_1a_the_box_is_the_one_that_a_round_looks_at(self):
        show = lambda: picture_message(shown(TAGS[7]))  # noqa: E731
        for stage, box, told in (("look", 4, 4), ("drive", 4, 0), ("look", 2, 2), ("done", 0, 0)):
            self.status.publish(InspectionStatus(stage=stage, box=box))
            self.assertEqual(self.expect(show, lambda v, told=told: v.tag == 7 and v.box == told).box, told)

    def test_2_tags_come_and_go(self):
        answer = self.services["remove_tag"](7)
        self.assertTrue(answer.success, answer.message)
        self.assertFalse(self.services["remove_tag"](7).success)
        self.expect(lambda: picture_message(shown(TAGS[7])), lambda v: v.tag == TagVerdict.NONE)
        answer = self.services["add_tag"](30, picture_message(stranger(1)), "")
        self.assertTrue(answer.success, answer.message)
        self.expect(lambda: picture_message(shown(stranger(1))), lambda v: v.tag == 30)
        answer = self.services["add_tag"](31, Image(), "/nowhere/tag.png")
        self.assertFalse(answer.success)
        self.assertIn("no such file", answer.message)
        answer = self.services["load_tags"]("/nowhere/tags.yaml")
        self.assertFalse(answer.success)
        self.expect(lambda: picture_message(shown(stranger(1))), lambda v: v.tag == 30)
        self.assertTrue(self.services["load_tags"]("").success)
        self.expect(lambda: picture_message(shown(TAGS[7])), lambda v: v.tag == 7)
        self.expect(lambda: picture_message(shown(stranger(1))), lambda v: v.tag == TagVerdict.NONE)

    def test_3_bad_pictures_are_named(self):
        dark = lambda: picture_message((shown(TAGS[7]) // 20).astype(np.uint8))  # noqa: E731
        depth = lambda: Image(height=2, width=2, encoding="32FC1", step=8, data=bytes(16))  # noqa: E731
        for message, word in ((dark, "dark"), (depth, "encoding '32FC1'"), (None, "silent")):
            begun = self.now_s

            def named(word=word, begun=begun):
                return any(
                    word in status.message and status.name == "tag_recogniser" and status.level == 1
                    for array in list(self.heard["diagnostics"])
                    if array.header.stamp.to_sec() > begun
                    for status in array.status
                )

            self.assertTrue(self.until(named, message), word)
        begun = self.now_s
        self.assertTrue(
            self.until(
                lambda: any(
                    status.level == 0
                    for array in list(self.heard["diagnostics"])
                    if array.header.stamp.to_sec() > begun
                    for status in array.status
                ),
                lambda: picture_message(shown(TAGS[7])),
            )
        )


if __name__ == "__main__":
    init_node("tag_recogniser_test")
    rostest.rosrun("yarm", "recogniser_sees", RecogniserTest)
