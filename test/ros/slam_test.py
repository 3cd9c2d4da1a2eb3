#!/usr/bin/env python3
"""Node slam_gmapping: its map against the true walls, its pose against the truth, gmapping's interface, sick inputs."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from typing import Callable, List, Tuple

import numpy as np
import rospy
import rostest
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap
from std_msgs.msg import Float64
from tf2_msgs.msg import TFMessage

from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support import slam_log
from support.scan_player import LIMIT_S, MOUNT, UNKNOWN, ScanPlayer, scan_of, transform

PROGRAMS = Path(os.environ["CMAKE_PREFIX_PATH"].split(os.pathsep)[0]) / "lib" / "yarm"
ROOM, SCANS = 4, 900
HEALTH = "slam_gmapping: mapping"


class Player(ScanPlayer):
    """A player that keeps the maps, too."""

    def __init__(self) -> None:
        super().__init__(HEALTH)
        self.maps: List[OccupancyGrid] = self.hear("map", OccupancyGrid)
        self.metadata: List[MapMetaData] = self.hear("map_metadata", MapMetaData)
        self.entropy: List[Float64] = self.hear("slam_gmapping/entropy", Float64)


class SlamTest(unittest.TestCase):
    player: Player
    tour: slam_log.Tour

    @classmethod
    def setUpClass(cls) -> None:
        with tempfile.TemporaryDirectory() as folder:
            cls.tour = slam_log.record(PROGRAMS / "slam_world_log", ROOM, SCANS, Path(folder) / "tour.txt")
        cls.player = Player()
        cls.player.connect()
        cls.player.tick(cls.tour.moments[0].stamp_ns - 500_000_000)

    def play(self, moments: List[slam_log.Moment]) -> Tuple[float, float]:
        """Play and compare; RMSE of the position (m) and of the heading (rad) from the first pose on."""
        first = moments[0].truth
        off, turned = [], []
        for moment in moments:
            believed = slam_log.compose(first, self.player.step(moment))
            off.append(math.hypot(believed[0] - moment.truth[0], believed[1] - moment.truth[1]))
            turned.append(math.remainder(believed[2] - moment.truth[2], 2.0 * math.pi))
        return float(np.sqrt(np.mean(np.square(off)))), float(np.sqrt(np.mean(np.square(turned))))

    def check_map(self, mean_m: float, spurious: float, within_5cm: float) -> None:
        message = self.player.maps[-1]
        self.assertEqual(message.header.frame_id, "map")
        self.assertAlmostEqual(message.info.resolution, 0.05, places=6)
        self.assertLessEqual(set(message.data), {-1, 0, 100})
        grid = np.array(message.data, np.int8).reshape(message.info.height, message.info.width)
        origin = message.info.origin.position
        cells = slam_log.occupied(grid, 0.05, (origin.x, origin.y), self.tour.moments[0].truth)
        distances = slam_log.clearance(cells, self.tour.surfaces)
        self.assertGreater(len(cells), 300)
        self.assertLess(distances.mean(), mean_m)
        self.assertLess(np.mean(distances > 0.10), spurious)
        self.assertGreater(slam_log.share_near(self.tour.seen, cells, 0.05), within_5cm)

    def keep_saying(self, say: Callable[[], None], answer: str) -> None:
        """Until the node's health has a word; a fixed transform sent before may reach it later than the first scan."""
        self.player.forget_health()
        end = time.monotonic() + LIMIT_S
        while answer not in self.player.health.get(HEALTH, ""):
            self.assertLess(time.monotonic(), end, self.player.health)
            say()
            time.sleep(0.1)

    def test_1_before_the_first_scan(self) -> None:
        self.player.wait_for_health("scan: nothing heard yet, 1 publishers")
        rospy.wait_for_service("dynamic_map", LIMIT_S)
        with self.assertRaises(rospy.ServiceException):
            rospy.ServiceProxy("dynamic_map", GetMap)()

    def test_2_transforms_that_are_missing_or_tilted(self) -> None:
        moment = self.tour.moments[0]
        self.player.tick(moment.stamp_ns - 100_000_000)
        early = slam_log.Moment(moment.stamp_ns - 100_000_000, moment.odometry, moment.truth, moment.ranges)
        self.player.scan.publish(scan_of(early))
        self.player.wait_for_health("no transform base_footprint <- camera_depth_frame", "who publishes it?")
        tilted = transform("base_footprint", "camera_depth_frame", MOUNT, rospy.Time(0), 0.297)
        tilted.transform.rotation.x, tilted.transform.rotation.w = math.sin(0.2), math.cos(0.2)
        self.player.static.publish(TFMessage([tilted]))
        self.keep_saying(lambda: self.player.send(early), "tilted")
        self.player.static.publish(
            TFMessage([transform("base_footprint", "camera_depth_frame", MOUNT, rospy.Time(0), 0.297)])
        )
        empty = scan_of(early)
        empty.ranges = []

        def say_nothing() -> None:
            self.player.tick(early.stamp_ns)
            odometry = transform("odom", "base_footprint", early.odometry, rospy.Time(0, early.stamp_ns))
            self.player.tf.publish(TFMessage([odometry]))
            self.player.scan.publish(empty)

        self.keep_saying(say_nothing, "no beams")

    def test_3_map_and_pose_against_the_truth(self) -> None:
        rmse, heading = self.play(self.tour.moments)
        rospy.loginfo("room %d: pose RMSE %.1f mm, heading %.2f deg", ROOM, 1e3 * rmse, math.degrees(heading))
        self.assertLess(rmse, 0.045)
        self.assertLess(heading, 0.02)
        count = len(self.player.maps)
        last = self.tour.moments[-1]
        for i in range(1, 60):  # until the next map is due
            later = slam_log.Moment(last.stamp_ns + i * 100_000_000, last.odometry, last.truth, last.ranges)
            self.player.step(later)
            if len(self.player.maps) > count:
                break
        self.player.wait("another map", lambda: len(self.player.maps) > count)
        self.check_map(mean_m=0.030, spurious=0.01, within_5cm=0.95)
        self.assertGreaterEqual(len(self.player.maps), 18)

    def test_4_service_and_topics_agree(self) -> None:
        answer = rospy.ServiceProxy("dynamic_map", GetMap)().map
        self.player.wait("the map of the answer", lambda: self.player.maps[-1].header.stamp == answer.header.stamp)
        newest = self.player.maps[-1]
        self.assertEqual(answer.data, newest.data)
        self.assertEqual(answer.info, newest.info)
        self.assertEqual(answer.header.stamp, newest.header.stamp)
        self.player.wait("as many metadata", lambda: len(self.player.metadata) == len(self.player.maps))
        self.assertEqual(self.player.metadata[-1], newest.info)
        self.player.wait("50 entropies", lambda: len(self.player.entropy) > 50)
        self.assertTrue(all(math.isfinite(value.data) for value in self.player.entropy))

    def test_5_latched(self) -> None:
        again = rospy.wait_for_message("map", OccupancyGrid, LIMIT_S)
        self.assertEqual(again.data, self.player.maps[-1].data)

    def test_6_a_silent_scan_is_said(self) -> None:
        self.player.forget_health()
        self.player.tick(self.tour.moments[-1].stamp_ns + 20_000_000_000)
        self.player.wait_for_health("silent for", "is the sensor running?")

    def test_7_time_starts_again(self) -> None:
        maps = len(self.player.maps)
        self.player.forget_health()
        self.player.tick(self.tour.moments[0].stamp_ns - 500_000_000)
        self.player.wait_for_health("no scan could be taken yet")
        rmse, _ = self.play(self.tour.moments[:200])
        self.assertLess(rmse, 0.045)
        self.player.wait("a map", lambda: len(self.player.maps) > maps)
        first_again = self.player.maps[maps]
        self.assertLess(
            np.sum(np.array(first_again.data) > 50), 0.5 * np.sum(np.array(self.player.maps[maps - 1].data) > 50)
        )

    def test_7b_a_scan_that_is_said_again_is_answered_again(self) -> None:
        """In lock-step the first moment is said until everybody has heard the answer."""
        last = self.tour.moments[199]
        answer = self.player.T_map_odom
        self.assertEqual(answer[0], last.stamp_ns)
        for _ in range(2):
            self.player.T_map_odom = UNKNOWN
            self.player.step(last)
            self.assertEqual(self.player.T_map_odom, answer)

    def test_8_wrong_parameters_are_refused_all_at_once(self) -> None:
        command = [
            str(PROGRAMS / "slam_gmapping"),
            "__name:=slam_wrong",
            "_delta:=-1.0",
            "_particles:=many",
            "_dleta:=1",
        ]
        done = subprocess.run(
            command, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LIMIT_S
        )
        self.assertEqual(done.returncode, 1, done.stdout)
        for part in ("delta = -1", "0.005 to 1 m", "particles = many", "a whole number", "dleta: unknown parameter"):
            self.assertIn(part, done.stdout)


if __name__ == "__main__":
    init_node("slam_test")
    rostest.rosrun("yarm", "slam_test", SlamTest)
