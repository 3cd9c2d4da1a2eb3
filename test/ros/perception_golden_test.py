#!/usr/bin/env python3
"""The golden recording gives the metadata it must, with nodelets, standalone nodes and the pcl back end alike.

``rostest yarm perception_golden.test write:=--write-golden`` keeps what is found as what must be found from now on.
"""

from __future__ import annotations

import sys
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
from visualization_msgs.msg import Marker

from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from perception_player import Player, wait_for
from yarm.msg import MapMetaData

from support import golden

SPACES = ("nodelets", "standalone", "pcl")
WRITE = "--write-golden" in sys.argv


def numbers(pose):
    t, q = pose.transform.translation, pose.transform.rotation
    return [t.x, t.y, t.z, q.x, q.y, q.z, q.w]


class GoldenTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.recording = golden.load()
        cls.cells = {}
        for space in SPACES:
            for topic in (names.HIDDEN_CELLS, names.COVERAGE):
                key = f"{space}/{topic}"
                rospy.Subscriber(key, Marker, lambda m, k=key: cls.cells.setdefault(k, []).append(m), queue_size=100)
        cls.found = dict(zip(SPACES, Player(cls.recording, SPACES).play()))
        if WRITE:
            cls.recording = golden.with_metadata(cls.recording, [golden.to_bytes(m) for m in cls.found[SPACES[0]]])
            golden.save(cls.recording)

    def test_every_set_gives_the_metadata_kept_with_it(self):
        for golden_set, got in zip(self.recording.sets, self.found["nodelets"]):
            expected = golden.from_bytes(MapMetaData, golden_set.metadata)
            self.assertEqual(golden.differences(expected, got), [], f"set of {golden_set.stamp_ns}")

    def test_standalone_nodes_say_the_same_to_the_byte(self):
        for nodelets, standalone in zip(self.found["nodelets"], self.found["standalone"]):
            # A pose that went through a message is normalised once more: its last bit may differ.
            for ours, theirs in zip(nodelets.seed_poses, standalone.seed_poses):
                np.testing.assert_allclose(numbers(theirs), numbers(ours), rtol=0.0, atol=1e-12)
            standalone.seed_poses = nodelets.seed_poses
            standalone.header.seq = nodelets.header.seq
            standalone.visibility, standalone.hidden_by, standalone.age_s = b"", [], []
            self.assertEqual(golden.to_bytes(standalone), golden.to_bytes(nodelets))

    def test_the_pcl_back_end_gives_the_same_map(self):
        for fused, pcl in zip(self.found["nodelets"], self.found["pcl"]):
            self.assertEqual(golden.differences(fused, pcl), [])

    def test_what_the_cameras_see_of_the_cells_is_on_the_map_where_visibility_is_on(self):
        for got in self.found["nodelets"]:
            self.assertEqual((len(got.visibility), len(got.hidden_by), len(got.age_s)), (0, 0, 0))
        for got in self.found["pcl"]:
            states = np.frombuffer(bytes(got.visibility), np.int8)
            self.assertEqual(len(states), len(got.grid))
            self.assertEqual(len(got.hidden_by), np.count_nonzero(states < 2))
            self.assertIn(len(got.age_s), (0, len(got.grid)))
            self.assertGreater(np.count_nonzero(states == 2), 30000)
            self.assertGreater(np.count_nonzero(np.array(got.hidden_by) & 0x3FFFFFFF), 1000)
        ages = [np.array(got.age_s) for got in self.found["pcl"] if len(got.age_s)]
        self.assertTrue(0 < len(ages) < len(self.found["pcl"]))
        states = np.frombuffer(bytes(self.found["pcl"][0].visibility), np.int8)
        np.testing.assert_array_equal(ages[0], np.where(states < 2, np.inf, 0.0))

    def test_no_cell_is_claimed_twice_while_calibrating(self):
        for golden_set, got in zip(self.recording.sets, self.found["nodelets"]):
            if golden_set.calibrating:
                self.assertEqual(len(got.collisions), 0)

    def test_cells_that_no_camera_sees_are_shown_where_visibility_is_on_and_nowhere_else(self):
        wanted = {f"{space}/{topic}" for space in SPACES[1:] for topic in (names.HIDDEN_CELLS, names.COVERAGE)}
        wait_for(lambda: wanted <= set(self.cells), f"{wanted}")
        self.assertEqual(set(self.cells), wanted)
        for key in wanted:
            last = self.cells[key][-1]
            middles = np.array([(p.x, p.y, p.z) for p in last.points])
            self.assertEqual(last.header.frame_id, "world")
            self.assertTrue(np.all(np.abs(middles[:, :2]) < 2.5) and np.all(np.abs(middles[:, 2] - 0.655) < 0.645))
        self.assertGreater(len(self.cells[f"standalone/{names.HIDDEN_CELLS}"][-1].points), 500)

    def test_a_difference_is_noticed(self):
        got = golden.from_bytes(MapMetaData, golden.to_bytes(self.found["nodelets"][-1]))
        lost = next(cells for cells in got.grid_indices if cells.indices)
        lost.indices.pop()
        self.assertNotEqual(golden.differences(self.found["nodelets"][-1], got), [])

    def test_a_piece_that_moved_or_is_gone_is_noticed(self):
        last = self.found["nodelets"][-1]
        moved, gone = (golden.from_bytes(MapMetaData, golden.to_bytes(last)) for _ in range(2))
        moved.pieces[0].top.x += 0.001
        gone.pieces.pop()
        for got in (moved, gone):
            self.assertNotEqual(golden.differences(last, got), [])


if __name__ == "__main__":
    init_node("perception_golden_test")
    rostest.rosrun("yarm", "perception_golden_test", GoldenTest, sys.argv)
