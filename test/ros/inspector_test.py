#!/usr/bin/env python3
"""Node inspector: names what is wrong with its camera, reads boxes of which one was moved and one taken away, is home.

The test stands between the camera and the inspector, and takes part in the lock-step: no picture is ever late.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Callable, Dict, List, Optional

import numpy as np
import rospy
import rostest
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from yarm.msg import InspectionStatus, TagVerdict

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import linked
from support.listening import ListeningTest
from support.participant import Participant
from yarm.geometry import Pose2
from yarm.inspection.model import Stage
from yarm.inspection.session import IDLE, STOPPED
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.sim.scenes.layout_file import find_layout

RESULT = Path(os.environ.get("ROS_HOME", "/tmp")) / "inspector_test" / "result.txt"
LAYOUT = find_layout(str(resource("test", "system", "inspected_room.yaml")))
GIVEN = {1: 5, 2: TagVerdict.BLANK, 3: 11, 4: 2}
MOVED, TAKEN_AWAY = 3, 5
"""Boxes of inspector_boxes.yaml: one stands elsewhere, one is not there at all."""
ENDS = (Stage.DONE, Stage.FAILED)
AT_REST = (IDLE, STOPPED, *ENDS)
STATUS, VERDICT, TRUTH = names.inspector("status"), names.inspector("verdict"), names.SIM_POSE
RELAYED = "relayed_image"
RESTS_S, STANDS_S = 2.0, 2.0
"""Simulated time in which it comes to rest, and for which it is watched then."""


class Relay:
    """The camera as the inspector has it; ``way`` says how a picture is passed on."""

    def __init__(self) -> None:
        """Nothing passes yet."""
        self._out = rospy.Publisher(RELAYED, Image, queue_size=10)
        self._first: Optional[Image] = None
        self._ways: Dict[str, Callable[[Image], Optional[Image]]] = {
            "well": lambda image: image,
            "silent": lambda image: None,
            "frozen: the stamp": self._first_again,
            "frozen: 5 pictures": self._first_pixels,
            "dark": lambda image: self._evenly(image, 0),
            "over-exposed": lambda image: self._evenly(image, 251),
            "320 x 480 pixels, expected 640 x 480": self._half,
            "encoding '32FC1'": lambda image: self._changed(image, encoding="32FC1"),
        }
        self.way = "silent"

    @property
    def faults(self) -> List[str]:
        """Ways to pass a picture on that the inspector is to find fault with, each in its words."""
        return [way for way in self._ways if way not in ("well", "silent")]

    def take(self, image: Image) -> None:
        """Pass a picture on."""
        self._first = self._first or image
        passed = self._ways[self.way](image)
        if passed is not None:
            self._out.publish(passed)

    @staticmethod
    def _changed(image: Image, **changes: object) -> Image:
        """Another message with the same stamp."""
        kept = {name: getattr(image, name) for name in image.__slots__}
        return Image(**{**kept, **changes})

    def _first_again(self, image: Image) -> Image:
        return self._first or image

    def _first_pixels(self, image: Image) -> Image:
        return self._changed(image, data=(self._first or image).data)

    def _evenly(self, image: Image, grey: int) -> Image:
        """Pixels of one grey, with noise that is another in each picture."""
        noise = np.random.default_rng(image.header.stamp.to_nsec()).integers(0, 4, len(image.data), np.uint8)
        return self._changed(image, data=(noise + grey).astype(np.uint8).tobytes())

    def _half(self, image: Image) -> Image:
        return self._changed(image, width=image.width // 2)


class InspectorTest(ListeningTest):
    """What is asserted is asserted of what was said since a moment of the history, and of where the robot truly is."""

    limit_s = 600.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen()
        for topic, kind in ((STATUS, InspectionStatus), (VERDICT, TagVerdict), (TRUTH, Odometry)):
            cls.keep(topic, kind, most=100000)
        cls.relay, cls.me = Relay(), Participant()
        cls.camera = rospy.Subscriber(names.RGB_IMAGE, Image, cls.see, queue_size=10, buff_size=2**22)
        cls.services = {name: rospy.ServiceProxy(names.inspector(name), Trigger)
                        for name in ("start", "stop", "return_home", "save")}  # fmt: skip
        for service in cls.services.values():
            service.wait_for_service(cls.limit_s)

    @classmethod
    def see(cls, image: Image) -> None:
        """Time goes on when the picture is on its way."""
        cls.relay.take(image)
        cls.me.took(image.header.stamp)

    def count(self) -> int:
        """Statuses so far."""
        with self.changed:
            return len(self.kept[STATUS])

    def status_since(self, mark: int, holds: Callable[[InspectionStatus], bool], what: str) -> InspectionStatus:
        """The first status since a count of them of which something holds."""
        return self.wait(lambda: next((s for s in self.kept[STATUS][mark:] if holds(s)), None), what)

    def truth_at(self, stamp_s: float) -> Pose2:
        """Where the robot is, by the first message from a time on."""
        found = self.wait(
            lambda: next((m for m in self.kept[TRUTH] if m.header.stamp.to_sec() >= stamp_s), None),
            f"the robot's pose at {stamp_s:.1f} s",
        )
        return pose2_of_pose(found.pose.pose)

    def begin(self) -> int:
        """Start a round; the count of statuses from which on they are this round's."""
        mark = self.count()
        self.assertTrue(self.services["start"]().success)
        begun = self.status_since(mark, lambda s: s.stage not in AT_REST, "a round that begins")
        with self.changed:
            return self.kept[STATUS].index(begun)

    def end_of(self, mark: int) -> InspectionStatus:
        """How the round ends, at home by the truth."""
        end = self.status_since(mark, lambda s: s.stage in ENDS, "the end of the round")
        self.assertEqual((end.stage, end.reason), (Stage.DONE, ""))
        self.assertLess(self.truth_at(end.header.stamp.to_sec()).distance(LAYOUT.start), 0.10)
        return end

    def test_1_it_names_what_is_wrong_with_the_camera_and_refuses_what_makes_no_sense(self) -> None:
        me = rospy.get_name().strip("/")
        for sender, topic, hears in (
            ("inspector", STATUS, me),
            ("inspector", VERDICT, me),
            ("room_simulation", TRUTH, me),
            (me, RELAYED, "inspector"),
        ):
            self.ask(lambda sender=sender, topic=topic, hears=hears: linked(sender, topic, hears), f"{topic}: {hears}")
        self.status_since(0, lambda s: "waits for ~start" in s.reason, "an inspector that waits for ~start")
        none_yet = "camera: no picture has come yet"
        self.status_since(0, lambda s: any(none_yet in text for text in s.sensors), none_yet)
        self.assertFalse(self.services["return_home"]().success)
        for fault in self.relay.faults:
            mark = self.count()
            self.relay.way = fault
            self.status_since(mark, lambda s, fault=fault: any(fault in t for t in s.sensors), f"a camera {fault}")
        mark = self.count()
        self.assertTrue(self.services["start"]().success)
        waits = self.status_since(mark, lambda s: s.reason.startswith("waits: camera: "), "a round that waits")
        self.assertEqual(waits.stage, IDLE)
        self.assertIn("look at the camera", waits.reason)
        self.assertFalse(self.services["start"]().success)
        self.assertTrue(self.services["stop"]().success)

    def test_2_it_reads_every_box_finds_the_moved_one_and_the_missing_one_and_is_home(self) -> None:
        self.relay.way = "well"
        mark = self.begin()
        end = self.end_of(mark)
        self.wait(lambda: len(self.kept[VERDICT]) >= 5, "five verdicts")
        found = {verdict.box: verdict for verdict in self.kept[VERDICT]}
        self.assertEqual({box: verdict.tag for box, verdict in found.items()}, {**GIVEN, TAKEN_AWAY: TagVerdict.NONE})
        moved = found[MOVED]
        self.assertEqual((moved.finding, moved.has_pose), ("moved", True))
        self.assertLess(pose2_of_pose(moved.pose).distance(LAYOUT.boxes[MOVED - 1].pose), 0.06)
        self.assertEqual(found[TAKEN_AWAY].finding, "missing")
        self.assertIn("nothing stands where the box must be", found[TAKEN_AWAY].reason)
        self.assertEqual(len(RESULT.read_text().splitlines()), 1 + 5)
        self.assertEqual(len(end.verdicts), 5)
        self.assertGreater(end.left, 300.0)

    def test_3_without_a_camera_it_ends_with_reasons_and_is_home(self) -> None:
        mark = self.begin()
        self.status_since(mark, lambda s: len(s.verdicts) > 1, "two verdicts")
        self.relay.way = "silent"
        self.status_since(mark, lambda s: any("camera: silent" in text for text in s.sensors), "a silent camera")
        end = self.end_of(mark)
        blind = [verdict for verdict in end.verdicts if verdict.tag == TagVerdict.NONE and verdict.box != TAKEN_AWAY]
        self.assertEqual(len(end.verdicts), 5)
        self.assertTrue(blind)
        for verdict in blind:
            self.assertIn("camera: silent", verdict.reason)
        self.assertTrue(self.services["save"]().success)
        self.assertIn("unmatched", RESULT.read_text())

    def test_4_stopped_while_it_drives_it_stands(self) -> None:
        mark = self.count()
        self.relay.way = "well"
        self.status_since(mark, lambda s: not s.sensors, "a camera that is well")
        mark = self.begin()
        driving = self.status_since(mark, lambda s: s.stage == Stage.DRIVE, "a drive")
        self.truth_at(driving.header.stamp.to_sec() + 1.0)
        self.assertTrue(self.services["stop"]().success)
        stopped = self.status_since(mark, lambda s: s.stage == STOPPED, "a round that is stopped")
        rests_s = stopped.header.stamp.to_sec() + RESTS_S
        self.assertLess(self.truth_at(rests_s).distance(self.truth_at(rests_s + STANDS_S)), 0.02)


if __name__ == "__main__":
    init_node("inspector_rounds")
    rostest.rosrun("yarm", "inspector_rounds", InspectorTest)
