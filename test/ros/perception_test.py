#!/usr/bin/env python3
"""Every fault an input of perception can have: the sets go on, and diagnostics name the sick input."""

from __future__ import annotations

import math
import os
import subprocess
import sys
import time
import unittest
from pathlib import Path

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import Pose
from perception_cell import CAMERAS, LIMIT_S, SET_S, Cell, Thing, stamped, wait_for
from scipy.spatial.transform import Rotation
from yarm.msg import TransformStampedVector
from yarm.srv import PredictNewState

from yarm.ros.common import names
from yarm.ros.common.start import init_node

MERGE_CLOUDS = str(Path(os.environ["CMAKE_PREFIX_PATH"].split(os.pathsep)[0]) / "lib" / "yarm" / "merge_clouds")
CAMERA_HEALTH = "merge_clouds: cameras"
ASSOC_HEALTH = "cluster_assoc: inputs"
POSE_HEALTH = "cluster_assoc: camera poses"
TABLE = ("table", "Obstacle", "static", (0.9, 1.2, 0.7), (0.0, 0.0, 0.35))
ROBOT = ("ankurbot_1", "Mobile", "dynamic", (0.4, 0.4, 0.6), (1.6, 0.0, 0.4))
GUEST = ("debris_7", "Debris", "dynamic", (0.3, 0.3, 0.3), (0.0, 1.8, 0.25))


def things(*rows):
    return [Thing(*row) for row in rows]


def cells(metadata, name):
    return len(metadata.grid_indices[metadata.frames.index(name)].indices)


class PerceptionTest(unittest.TestCase):
    cell: Cell

    @classmethod
    def setUpClass(cls):
        cls.cell = Cell()
        cls.cell.register(*things(TABLE, ROBOT))
        cls.cell.switch(False)
        cls.cell.wait_for_nodes()
        cls.cell.tick()

    def healthy(self):
        self.cell.wait_for_health(lambda m: m.endswith(" sets") and ";" not in m, CAMERA_HEALTH, "that all is well")

    def complains(self, node, *parts, **kwargs):
        text = self.cell.wait_for_health(lambda m: all(p in m for p in parts), node, f"{parts}", **kwargs)
        return text

    def held_up_by_none(self, step):
        """Sets that waited for a camera would take camera_timeout each, twice as long as they may."""
        began, sets = time.monotonic(), 10
        for _ in range(sets):
            step()
        self.assertLess(time.monotonic() - began, 0.5 * sets * rospy.get_param("merge_clouds/camera_timeout"))

    def keep_sending_bad(self, camera, spoil, *parts):
        before = len(self.cell.metadata)
        self.cell.forget_health()
        end = time.monotonic() + LIMIT_S
        steps = 0
        while not self.cell.has_said(CAMERA_HEALTH, *parts):
            self.assertLess(time.monotonic(), end, f"{parts} never named; last: {self.cell.health}")
            metadata = self.cell.step(**{f"camera_{camera}": spoil})
            steps += 1
            self.assertGreater(cells(metadata, "table"), 100)
            time.sleep(0.01)
        self.assertEqual(len(self.cell.metadata) - before, steps)

    def test_01_missing_transform_then_there(self):
        self.cell.place_cameras([1, 2, 3])
        blamed = (names.camera_points(4), "no transform", "unknown to tf")
        others = tuple(names.camera_points(camera) for camera in (1, 2, 3))
        self.cell.wait_for_health(
            lambda m: all(part in m for part in blamed) and not any(other in m for other in others),
            CAMERA_HEALTH,
            f"{blamed} and nothing of {others}",
        )
        self.cell.place_cameras(CAMERAS)
        self.healthy()

    def test_02_calibrates_and_runs(self):
        metadata = self.cell.step_until(lambda m: m.frames == ["table", "ankurbot_1"], "both objects in the map")
        self.assertEqual(metadata.objects, ["Obstacle", "Mobile"])
        self.assertEqual(metadata.header.frame_id, "world")
        self.assertGreater(cells(metadata, "table"), 100)
        self.assertGreater(cells(metadata, "ankurbot_1"), 20)
        self.assertEqual(list(metadata.collisions), [])
        self.cell.switch(True)
        wait_for(
            lambda: self.cell.values.get(ASSOC_HEALTH, {}).get("calibrating") == "no", "the end of the calibration"
        )
        stamps = [self.cell.step().header.stamp for _ in range(10)]
        self.assertEqual(stamps, sorted(set(stamps)))

    def test_03_silent_camera_and_back(self):
        others = [1, 3, 4]
        self.cell.step(only=others)
        self.cell.forget_health()
        end = time.monotonic() + LIMIT_S
        while not self.cell.has_said(CAMERA_HEALTH, names.camera_points(2) + ": silent for"):
            self.assertLess(time.monotonic(), end, f"{self.cell.health}")
            self.cell.step(only=others)
        self.held_up_by_none(lambda: self.cell.step(only=others))
        self.healthy()

    def test_04_empty_and_nan_clouds_count_as_received(self):
        def empty(message):
            message.width = message.height = message.row_step = 0
            message.data = b""

        def blind(message):
            message.data = np.full(len(message.data) // 4, np.nan, np.float32).tobytes()

        self.healthy()
        for spoil in (empty, blind):
            self.held_up_by_none(
                lambda spoil=spoil: self.assertGreater(cells(self.cell.step(camera_3=spoil), "table"), 100)
            )
        self.keep_sending_bad(3, blind, names.camera_points(3) + ": blind: 0.0 % of its points are finite")
        self.healthy()

    def test_05_wrong_frame(self):
        def spoil(message):
            message.header.frame_id = "world"

        self.keep_sending_bad(1, spoil, names.camera_points(1), "frame 'world', must be", "camera_frames")
        self.healthy()

    def test_06_wrong_layout(self):
        def spoil(message):
            message.fields[1].offset = 4000

        self.keep_sending_bad(2, spoil, names.camera_points(2), "field y at offset 4000")
        self.healthy()

    def test_07_infinite_coordinates(self):
        def spoil(message):
            points = np.frombuffer(message.data, np.float32).copy()
            points[4 * 10] = math.inf
            message.data = points.tobytes()

        self.keep_sending_bad(3, spoil, names.camera_points(3), "infinite or absurd")
        self.healthy()

    def test_08_stamp_backwards(self):
        def spoil(message):
            message.header.stamp -= rospy.Duration(1.0)

        self.keep_sending_bad(4, spoil, names.camera_points(4), "stamp went back by")
        self.healthy()

    def test_09_stamp_in_the_future_does_not_block_the_camera(self):
        def spoil(message):
            message.header.stamp += rospy.Duration(1000.0)

        self.keep_sending_bad(4, spoil, names.camera_points(4), "ahead of the clock")
        self.healthy()

    def test_10_object_comes_and_is_deleted(self):
        self.cell.register(*things(TABLE, ROBOT, GUEST))
        metadata = self.cell.step_until(
            lambda m: "debris_7" in m.frames and cells(m, "debris_7") > 0, "debris_7 in the map"
        )
        first = metadata.UIDs[metadata.frames.index("debris_7")]
        self.cell.register(*things(TABLE, ROBOT))
        metadata = self.cell.step_until(lambda m: "debris_7" not in m.frames, "debris_7 gone")
        self.assertNotIn(first, metadata.UIDs)
        self.assertNotIn("", metadata.objects)
        self.cell.register(*things(TABLE, ROBOT, GUEST))
        metadata = self.cell.step_until(lambda m: "debris_7" in m.frames, "debris_7 again")
        self.assertNotEqual(metadata.UIDs[metadata.frames.index("debris_7")], first)
        self.cell.register(*things(TABLE, ROBOT))

    def test_10a_a_robot_that_no_topic_can_be_called_after_ends_nothing(self):
        _, *how = ROBOT
        odd = ("../odd", *how[:-1], (9.0, 9.0, 0.4))
        self.cell.register(*things(TABLE, ROBOT, odd))
        for _ in range(3):
            self.assertEqual(self.cell.step().frames[:2], ["table", "ankurbot_1"])
        self.cell.register(*things(TABLE, ROBOT))
        self.cell.step_until(lambda m: m.frames == ["table", "ankurbot_1"], "the registry of before")

    def test_11_seeds_silent(self):
        self.cell.step()
        self.cell.tf_on = False
        self.complains(ASSOC_HEALTH, names.SEED_TRANSFORMS, "without seeds of their time")
        self.cell.tf_on = True
        self.cell.wait_for_health(lambda m: m.endswith(" sets") and ";" not in m, ASSOC_HEALTH, "that all is well")

    def test_12_seeds_of_another_sender_from_another_time(self):
        elsewhere = np.eye(4)
        elsewhere[:3, 3] = -1.5, -1.5, 0.7
        other = rospy.Publisher(names.SEED_TRANSFORMS, TransformStampedVector, queue_size=10)
        wait_for(lambda: other.get_num_connections() > 0, "cluster_assoc listening to a second sender of seeds")
        self.cell.wait_for_health(lambda m: m.endswith(" sets") and ";" not in m, ASSOC_HEALTH, "that all is well")
        for stamp in (rospy.Time(0), rospy.Time.from_sec(self.cell.now_s + 1e5)):
            wrong = TransformStampedVector(
                transforms=[stamped("ankurbot_1", elsewhere, stamp)],
                type=["dynamic"],
                frame=["ankurbot_1"],
                object=["Mobile"],
            )
            wrong.header.stamp = stamp
            self.cell.forget_health()
            end = time.monotonic() + LIMIT_S
            named = f"from {rospy.get_name()}: its stamp {stamp.to_sec():.3f} s"
            while not self.cell.has_said(ASSOC_HEALTH, named):
                self.assertLess(time.monotonic(), end, f"{named} never said; last: {self.cell.health}")
                other.publish(wrong)
                metadata = self.cell.step()
                self.assertEqual(metadata.frames, ["table", "ankurbot_1"])
                self.assertGreater(cells(metadata, "ankurbot_1"), 20)
                self.assertAlmostEqual(metadata.seed_poses[1].transform.translation.x, ROBOT[4][0], places=6)
            self.assertNotIn("without seeds of their time", self.cell.health[ASSOC_HEALTH])
        other.unregister()
        self.cell.wait_for_health(lambda m: m.endswith(" sets") and ";" not in m, ASSOC_HEALTH, "that all is well")

    def test_13_predict_new_state(self):
        rospy.wait_for_service(names.PREDICT_NEW_STATE, LIMIT_S)
        predict = rospy.ServiceProxy(names.PREDICT_NEW_STATE, PredictNewState)
        self.cell.step()
        there = Pose()
        there.position.x, there.position.z, there.orientation.w = 0.3, 0.7, 1.0
        answer = predict(["ankurbot_1"], [there])
        self.assertTrue(answer.collision, answer.message)
        self.assertEqual(answer.pairs, ["ankurbot_1 table"])
        self.assertGreater(len(answer.cells), 0)
        there.position.x = 1.7
        self.assertFalse(predict(["ankurbot_1"], [there]).collision)
        self.assertIn("refused", predict(["nobody"], [there]).message)
        there.orientation.w = 0.0
        self.assertIn("refused: ankurbot_1", predict(["ankurbot_1"], [there]).message)
        self.assertIn("refused: 1 names for 0 poses", predict(["ankurbot_1"], []).message)

    def test_14_clock_reset(self):
        before_s = self.cell.now_s
        self.cell.now_s = 1.0 + 0.5 * SET_S  # no stamp comes twice
        self.cell.tick()
        wait_for(lambda: 0.0 < self.cell.said_s[CAMERA_HEALTH] < before_s - 1.0, "the nodes' clock going back")
        began = len(self.cell.metadata)
        for _ in range(5):
            metadata = self.cell.step()
        self.assertAlmostEqual(metadata.header.stamp.to_sec(), self.cell.now_s, places=6)
        self.assertEqual(len(self.cell.metadata) - began, 5)
        self.assertIn("ankurbot_1", metadata.frames)
        self.healthy()

    def test_15_wrong_parameters_are_refused_all_at_once(self):
        ended = subprocess.run(
            [
                "rosrun",
                "yarm",
                "merge_clouds",
                "__name:=merge_refused",
                "_voxel_size_x:=9.0",
                "_backend:=magic",
                "_tpyo:=1",
            ],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        self.assertEqual(ended.returncode, 1)
        for part in ("voxel_size_x = 9", "0.001 to 1 m", "one of 'fused', 'pcl'", "tpyo: unknown parameter"):
            self.assertIn(part, ended.stdout + ended.stderr)

    def test_16_a_turned_camera_is_named(self):
        def all_well(message):
            return message == "no camera is off"

        self.cell.wait_for_health(all_well, POSE_HEALTH, "that no camera is off")
        self.assertEqual(self.cell.levels[POSE_HEALTH], DiagnosticStatus.OK)
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_euler("x", 1.0, degrees=True).as_matrix()
        self.cell.place_cameras(CAMERAS, {2: self.cell.poses[2] @ turn})
        text = self.complains(POSE_HEALTH, names.camera_points(2) + ": is off: turned by")
        self.assertIn(self.cell.levels[POSE_HEALTH], (DiagnosticStatus.WARN, DiagnosticStatus.ERROR))
        for camera in (1, 3, 4):
            self.assertNotIn(names.camera_points(camera), text)
        self.cell.place_cameras(CAMERAS)
        self.cell.wait_for_health(all_well, POSE_HEALTH, "that the camera is right again")
        self.assertEqual(self.cell.levels[POSE_HEALTH], DiagnosticStatus.OK)

    def test_17_every_set_gave_one_metadata(self):
        stamps = [m.header.stamp.to_nsec() for m in self.cell.metadata]
        self.assertEqual(len(stamps), len(set(stamps)))


if __name__ == "__main__":
    init_node("perception_test")
    rostest.rosrun("yarm", "perception_test", PerceptionTest, sys.argv)
