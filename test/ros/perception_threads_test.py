#!/usr/bin/env python3
"""The perception process under ThreadSanitizer: the golden recording gives what it must, and nothing races.

While it is played somebody asks for predictions and comes and goes as a listener; then time goes back, the recording
is played once more, and the process is told to end.
"""

from __future__ import annotations

import itertools
import sys
import threading
import unittest
import xmlrpc.client
from pathlib import Path

import psutil
import rospy
import rostest
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from perception_player import LIMIT_S, Player, wait_for
from yarm.msg import MapMetaData
from yarm.srv import PredictNewState

from support import golden

SPACE, NODE = "threads", "/threads/perception"
FOUND, THERE = "WARNING: ThreadSanitizer", "Running under ThreadSanitizer"


def pid_of(node):
    return int(xmlrpc.client.ServerProxy(rospy.get_master().lookupNode(node)[2]).getPid(rospy.get_name())[2])


class Bystander(threading.Thread):
    """Asks and listens from other connections until it is told to stop."""

    def __init__(self):
        super().__init__()
        self._stopped = threading.Event()
        self.asked, self.came, self.fault = 0, 0, None

    def run(self):
        try:
            predict = rospy.ServiceProxy(f"{SPACE}/{names.PREDICT_NEW_STATE}", PredictNewState)
            predict.wait_for_service(LIMIT_S)
            while not self._stopped.is_set():
                self._listen()
                predict()
                self.asked += 1
        except (rospy.ROSException, rospy.ServiceException) as error:
            self.fault = error

    def _listen(self):
        topics = ((names.VOXELIZED_CLOUD, PointCloud2), (names.MERGED_POINTS, PointCloud2), (names.COVERAGE, Marker))
        heard = [rospy.Subscriber(f"{SPACE}/{topic}", kind, lambda _: None) for topic, kind in topics]
        self._stopped.wait(0.2)
        for one in heard:
            one.unregister()
        self.came += 1

    def stop(self):
        self._stopped.set()
        self.join()


class ThreadsTest(unittest.TestCase):
    def test_the_golden_recording_races_nowhere(self):
        recording = golden.load()
        process = psutil.Process(pid_of(NODE))
        report = Path(f"{rospy.get_param(SPACE + '/report')}.{process.pid}")
        wait_for(report.is_file, f"{report}, which the sanitizer begins")
        player, bystander = Player(recording, (SPACE,)), Bystander()
        bystander.start()
        try:
            found = list(itertools.chain(player.play()[0], player.play()[0]))
        finally:
            bystander.stop()
        self.assertIsNone(bystander.fault)
        self.assertGreater(min(bystander.asked, bystander.came), 0)
        for golden_set, got in zip(recording.sets, found):
            expected = golden.from_bytes(MapMetaData, golden_set.metadata)
            self.assertEqual(golden.differences(expected, got), [], f"set of {golden_set.stamp_ns}")
        self.assertEqual(len(found), 2 * len(recording.sets))
        process.terminate()
        process.wait(LIMIT_S)
        told = report.read_text(errors="replace")
        self.assertIn(THERE, told)
        self.assertNotIn(FOUND, told, told[-20000:])


if __name__ == "__main__":
    init_node("perception_threads_test")
    rostest.rosrun("yarm", "perception_threads_test", ThreadsTest, sys.argv)
