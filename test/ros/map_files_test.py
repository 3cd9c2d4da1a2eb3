#!/usr/bin/env python3
"""Nodes map_saver and map_server: a map saved, read by a reader of the test's own, served, and saved again alike."""

from __future__ import annotations

import math
import re
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np
import rospy
import rostest
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap
from rosgraph_msgs.msg import Clock

from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
LIMIT_S = 60.0
YAW_RAD = 0.3


def command(name: str, *arguments: str) -> List[str]:
    return [sys.executable, str(SCRIPTS / name), *arguments]


def run(name: str, *arguments: str) -> Tuple[int, str]:
    """Run a node to its end; exit code and all it said."""
    done = subprocess.run(
        command(name, *arguments),
        check=False,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )
    return done.returncode, done.stdout


def sample(seed: int = 4) -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id, message.header.stamp = "map", rospy.Time(10)
    message.info.resolution, message.info.width, message.info.height = 0.05, 31, 17
    message.info.origin.position.x, message.info.origin.position.y = -3.25, 1.5
    message.info.origin.orientation.z = math.sin(YAW_RAD / 2.0)
    message.info.origin.orientation.w = math.cos(YAW_RAD / 2.0)
    values = [-1, 0, 25, 26, 50, 64, 65, 100]
    message.data = np.random.default_rng(seed).choice(values, 31 * 17).tolist()
    return message


def trinary(data: Tuple[int, ...], occupied: int = 65, free: int = 25) -> List[int]:
    return [100 if v >= occupied else 0 if 0 <= v <= free else -1 for v in data]


def read(name: Path) -> Tuple[Dict[str, str], List[List[int]]]:
    """YAML keys as text and shades from top to bottom: a reader after the formats' descriptions alone.

    PGM: "P5", white space, width, white space, height, white space, the largest shade, one white space character, then
    rows from top to bottom, one byte a pixel; from a "#" to the end of its line is a comment.
    """
    keys = dict(line.split(": ", 1) for line in Path(f"{name}.yaml").read_text().splitlines() if line)
    data = Path(f"{name}.pgm").read_bytes()
    words, at = [], 0
    while len(words) < 4:
        if data[at : at + 1] == b"#":
            at = data.index(b"\n", at) + 1
        elif data[at : at + 1].isspace():
            at += 1
        else:
            end = at + len(re.match(rb"\S+", data[at:]).group())
            words.append(data[at:end])
            at = end
    assert words[0] == b"P5" and words[3] == b"255", words
    width, height = int(words[1]), int(words[2])
    pixels = data[at + 1 :]
    assert len(pixels) == width * height, (len(pixels), width, height)
    return keys, [list(pixels[row * width : (row + 1) * width]) for row in range(height)]


class Served:
    """A map_server that runs while its answers are heard."""

    def __init__(self, path: Path) -> None:
        self.changed = threading.Condition()
        self.maps: List[OccupancyGrid] = []
        self.metadata: List[MapMetaData] = []
        self._subscribers = [
            rospy.Subscriber("served_map", OccupancyGrid, self._keep, self.maps),
            rospy.Subscriber("map_metadata", MapMetaData, self._keep, self.metadata),
        ]
        self._child = subprocess.Popen(command("map_server", str(path), "map:=served_map", "_frame_id:=room"))

    def __enter__(self) -> Served:
        return self

    def __exit__(self, *_: object) -> None:
        self._child.terminate()
        self._child.wait(LIMIT_S)
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _keep(self, message: object, where: List[object]) -> None:
        with self.changed:
            where.append(message)
            self.changed.notify_all()

    def wait(self, maps: int) -> None:
        end = time.monotonic() + LIMIT_S
        with self.changed:
            while len(self.maps) < maps or len(self.metadata) < maps:
                left = end - time.monotonic()
                assert left > 0.0, f"{len(self.maps)} maps and {len(self.metadata)} metadata of {maps} in {LIMIT_S} s"
                self.changed.wait(left)


class MapFilesTest(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(tempfile.mkdtemp())
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10, latch=True)
        self.clock.publish(Clock(rospy.Time(100)))
        self.source = rospy.Publisher("room_map", OccupancyGrid, queue_size=1, latch=True)

    def save(self, message: OccupancyGrid, name: str, *arguments: str) -> Path:
        self.source.publish(message)
        code, said = run("map_saver", "-f", str(self.folder / name), *arguments, "map:=room_map")
        self.assertEqual(code, 0, said)
        return self.folder / name

    def test_1_saved_files_as_described(self) -> None:
        message = sample()
        keys, rows = read(self.save(message, "room"))
        self.assertEqual(keys["image"], "room.pgm")
        self.assertEqual(float(keys["resolution"]), 0.05)
        self.assertEqual(keys["negate"], "0")
        np.testing.assert_allclose(np.fromstring(keys["origin"].strip("[]"), sep=","), (-3.25, 1.5, 0.3), atol=1e-5)
        shade_of = {100: 0, 0: 254, -1: 205}
        expected = np.array([shade_of[v] for v in trinary(message.data)]).reshape(17, 31)[::-1]
        self.assertEqual(rows, expected.tolist())
        darkness = {shade: (255 - shade) / 255.0 for shade in shade_of.values()}
        self.assertGreater(darkness[0], float(keys["occupied_thresh"]))
        self.assertLess(darkness[254], float(keys["free_thresh"]))
        self.assertGreater(darkness[205], float(keys["free_thresh"]))

    def test_2_saved_served_and_saved_again(self) -> None:
        message = sample()
        name = self.save(message, "room", "--occ", "50", "--free", "0")
        with Served(Path(f"{name}.yaml")) as served:
            served.wait(maps=1)
            found = served.maps[0]
            self.assertEqual(list(found.data), trinary(message.data, occupied=50, free=0))
            self.assertEqual(found.header.frame_id, "room")
            self.assertEqual(served.metadata[0], found.info)
            self.assertEqual((found.info.width, found.info.height), (31, 17))
            for value, expected in (
                (found.info.resolution, 0.05),
                (found.info.origin.position.x, -3.25),
                (found.info.origin.position.y, 1.5),
                (2.0 * math.atan2(found.info.origin.orientation.z, found.info.origin.orientation.w), YAW_RAD),
            ):
                self.assertAlmostEqual(value, expected, places=5)
            rospy.wait_for_service("static_map", LIMIT_S)
            answer = rospy.ServiceProxy("static_map", GetMap)().map
            self.assertEqual((answer.data, answer.info), (found.data, found.info))
            self.assertEqual(rospy.wait_for_message("served_map", OccupancyGrid, LIMIT_S).data, found.data)
            code, said = run("map_saver", "-f", str(self.folder / "again"), "map:=served_map")
            self.assertEqual(code, 0, said)
            wait_until_heard("clock", "map_server")
            self.clock.publish(Clock(rospy.Time(3)))
            served.wait(maps=2)
            self.assertEqual((served.maps[1].data, served.maps[1].header.stamp), (found.data, rospy.Time(3)))
        self.assertEqual((self.folder / "again.pgm").read_bytes(), Path(f"{name}.pgm").read_bytes())

    def test_3_no_map_and_wrong_words(self) -> None:
        name = str(self.folder / "none")
        for arguments, words in (
            (("-f", name, "--wait", "0.5", "map:=nobody"), "/nobody: no map within 0 s; who publishes it?"),
            (("-f", name, "--occ", "20"), "the free threshold is 25, expected at least 0 and below"),
            (("-f", name, "--occ", "101"), "the occupied threshold is 101, expected 1 to 100"),
            (("-f", f"{self.folder}/nowhere/map"), "map.pgm cannot be written: No such file"),
            (("--hurry",), "unrecognized arguments"),
        ):
            code, said = run("map_saver", *arguments)
            self.assertNotEqual(code, 0, said)
            self.assertIn(words, said)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_4_a_sick_map_is_not_saved(self) -> None:
        sick = sample()
        sick.data = sick.data[:-1]
        self.source.publish(sick)
        code, said = run("map_saver", "-f", str(self.folder / "sick"), "--wait", "10", "map:=room_map")
        self.assertEqual(code, 1)
        self.assertIn("526 cells for 31 x 17", said)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_5_files_that_cannot_be_served(self) -> None:
        name = self.save(sample(), "room")
        text = Path(f"{name}.yaml").read_text()
        Path(f"{name}.yaml").write_text(text.replace("negate: 0\n", "").replace("0.65", "2"))
        code, said = run("map_server", f"{name}.yaml")
        self.assertEqual(code, 1)
        self.assertIn("room.yaml: negate is missing: expected 0 or 1", said)
        self.assertIn("room.yaml: occupied_thresh = 2: expected a number within 0 to 1", said)
        Path(f"{name}.yaml").write_text(text)
        boxes = self.folder / "boxes.yaml"
        boxes.write_text("boxes:\n  - {number: 7, x: 40.0, y: -3.0, phi: 0.0}\n")
        code, said = run("map_server", f"{name}.yaml", f"_boxes:={boxes}")
        self.assertEqual(code, 1)
        self.assertRegex(
            said, r"boxes\.yaml: box 7 = \(40\.0, -3\.0\): expected a place in the map, 1\.55 x 0\.85 m from"
        )
        code, said = run("map_server", f"{name}.yaml", "_frame:=room")
        self.assertEqual(code, 1)
        self.assertIn("frame: unknown parameter", said)


if __name__ == "__main__":
    init_node("map_files_test")
    rostest.rosrun("yarm", "map_files_test", MapFilesTest)
