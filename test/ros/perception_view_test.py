#!/usr/bin/env python3
"""A map never says "free" because nothing was seen: a box that nobody registered, under every way of not seeing it."""

from __future__ import annotations

import sys
import unittest

import numpy as np
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from perception_cell import CAMERAS, SET_S, Cell, Thing, box_points, wait_for

from yarm.ros.common import names
from yarm.ros.common.start import init_node

CAMERA_HEALTH = "merge_clouds: cameras"
THINGS = (
    ("table", "Obstacle", "static", (0.9, 1.2, 0.7), (0.0, 0.0, 0.35)),
    ("ankurbot_1", "Mobile", "dynamic", (0.4, 0.4, 0.6), (1.6, 0.0, 0.4)),
)
BOX = box_points((-1.5, -1.5, 0.4), (0.4, 0.4, 0.5))
PHASES_S = {1: 0.0, 2: 0.005, 3: 0.017, 4: 0.025}


def make_blind(message):
    message.data = np.full(len(message.data) // 4, np.nan, np.float32).tobytes()


def spoil_one_pixel(message):
    points = np.frombuffer(message.data, np.float32).reshape(-1, 4).copy()
    points[17, 1] = np.inf
    message.data = points.tobytes()


def all_cameras(spoil):
    return {f"camera_{camera}": spoil for camera in CAMERAS}


def unknown_cells(metadata):
    return sum(len(i.indices) for n, i in zip(metadata.frames, metadata.grid_indices) if n.startswith("unknown_"))


class PerceptionViewTest(unittest.TestCase):
    cell: Cell

    @classmethod
    def setUpClass(cls):
        cls.cell = Cell()
        cls.cell.register(*[Thing(*row) for row in THINGS])
        cls.cell.switch(False)
        cls.cell.wait_for_nodes()
        cls.cell.place_cameras(CAMERAS)
        for _ in range(10):
            cls.cell.step()
        cls.cell.switch(True)
        wait_for(lambda: cls.cell.step().frames[:2] == ["table", "ankurbot_1"], "a map of a running cell")

    def setUp(self):
        self.cell.extra = BOX
        self.cell.seen_by = {}
        for _ in range(5):
            metadata = self.cell.step()
        self.whole = unknown_cells(metadata)
        self.assertGreater(self.whole, 20)

    def box_stays(self, sets, **step):
        for _ in range(sets):
            self.assertGreaterEqual(unknown_cells(self.cell.step(**step)), self.whole)

    def only(self, seen_by):
        """From now on these cameras alone see these points; what that gives is the whole."""
        self.cell.extra = np.empty((0, 3))
        self.cell.seen_by = seen_by
        for _ in range(5):
            metadata = self.cell.step()
        self.whole = unknown_cells(metadata)
        self.assertGreater(self.whole, 20)

    def box_goes(self):
        self.cell.extra = np.empty((0, 3))
        self.cell.seen_by = {}
        for _ in range(5):
            metadata = self.cell.step()
        self.assertEqual(unknown_cells(metadata), 0)

    def test_all_cameras_dark_give_no_map_and_say_so(self):
        before = len(self.cell.metadata)
        with self.cell._lock:
            self.cell.health.clear()

        def said():
            self.cell.send_set(**all_cameras(make_blind))
            return "0 of 4 cameras see, at least 2 must" in self.cell.health.get(CAMERA_HEALTH, "")

        wait_for(said, "that no camera sees")
        self.assertEqual(self.cell.levels[CAMERA_HEALTH], DiagnosticStatus.ERROR)
        for camera in CAMERAS:
            self.assertIn(names.camera_points(camera) + ": blind: 0.0 %", self.cell.health[CAMERA_HEALTH])
        self.box_stays(1)  # the first set that is seen is the first map
        self.assertEqual(len(self.cell.metadata) - before, 1)
        self.box_goes()

    def test_three_cameras_dark_give_no_map(self):
        before = len(self.cell.metadata)
        for _ in range(5):
            self.cell.send_set(camera_1=make_blind, camera_2=make_blind, camera_3=make_blind)
        self.box_stays(1)
        self.assertEqual(len(self.cell.metadata) - before, 1)

    def test_one_infinite_pixel_costs_one_pixel(self):
        self.box_stays(20, **all_cameras(spoil_one_pixel))

        def said():
            self.cell.step(**all_cameras(spoil_one_pixel))
            return f"{names.camera_points(2)}: infinite or absurd points in" in self.cell.health.get(CAMERA_HEALTH, "")

        wait_for(said, "that points are absurd")

    def test_cameras_that_run_free_share_sets(self):
        self.only({1: BOX})
        self.run_free(15)
        began = len(self.cell.metadata)
        self.run_free(60)
        found = self.cell.metadata_since(began)
        self.assertAlmostEqual(len(found), 60, delta=2)
        for metadata in found:
            self.assertGreaterEqual(unknown_cells(metadata), self.whole, f"{metadata.header.stamp.to_sec():.3f}")
        stamps = [metadata.header.stamp.to_sec() for metadata in found]
        self.assertGreater(np.diff(stamps).min(), 0.5 * SET_S)
        for _ in range(5):
            self.cell.step()  # synchronised again
        self.box_goes()

    def run_free(self, periods):
        """Clouds at the phases of PHASES_S for so many periods."""
        base_s, began = self.cell.now_s + 2 * SET_S, len(self.cell.metadata)
        for period in range(periods):
            for camera, phase_s in PHASES_S.items():
                stamp = self.cell.tick_to(base_s + period * SET_S + phase_s)
                self.cell.send(camera, self.cell.cloud(camera, stamp))
            wait_for(lambda n=period: len(self.cell.metadata) - began >= n - 1, f"metadata of period {period}")

    def test_what_only_a_silent_camera_saw_stays_until_it_is_back(self):
        self.only_camera_two_sees(only=[1, 3, 4])

    def test_what_only_a_blind_camera_saw_stays_until_it_is_back(self):
        self.only_camera_two_sees(camera_2=make_blind)

    def only_camera_two_sees(self, **without):
        self.only({2: BOX})
        self.box_stays(60, **without)
        self.box_stays(10)
        self.box_stays(10, **without)
        self.cell.seen_by = {}
        self.box_stays(10, **without)  # nobody has looked
        self.box_goes()

    def test_what_it_saw_most_of_stays_too(self):
        self.only({2: BOX})
        alone = self.whole
        self.only({2: BOX, 4: BOX[BOX[:, 2] > 0.6]})
        self.box_stays(30, camera_2=make_blind)
        self.cell.seen_by = {2: BOX}
        self.whole = alone  # camera 4 sees that its part is gone
        self.box_stays(30, camera_2=make_blind)
        self.box_goes()

    def test_a_robot_leaves_no_ghost(self):
        for _ in range(60):
            self.cell.things["ankurbot_1"].centre[1] += 0.02
            metadata = self.cell.step(camera_2=make_blind)
            self.assertEqual(unknown_cells(metadata), self.whole)
        self.cell.things["ankurbot_1"].centre[1] = 0.0
        self.box_goes()


if __name__ == "__main__":
    init_node("perception_view_test")
    rostest.rosrun("yarm", "perception_view_test", PerceptionViewTest, sys.argv)
