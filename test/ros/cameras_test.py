#!/usr/bin/env python3
"""Cameras that lie: off their place, frozen, dirty. Each is named, and the set goes on.

The simulator plays the hardware. This test stands between: it passes the clouds on, spoilt where a case wants it, and
tells the cameras' frames, true or not.
"""

from __future__ import annotations

import copy
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from yarm.msg import MapMetaData

from yarm.calibration.poses_file import read_poses
from yarm.ros.common import names
from yarm.ros.common.bodies import transform_message
from yarm.ros.common.conversions import matrix_of_transform
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest

CAMERAS = (1, 2, 3, 4)
OFF, SPOILT = 2, 3
TOPICS = [names.camera_points(n) if n != SPOILT else f"seen/{n}" for n in CAMERAS]
NAMED_S = 10.0
"""Simulated time within which a drift is named."""
FAR_M, FAR_DEG = 0.05, 3.0
DRIFT_DEG = 0.5


class CamerasTest(ListeningTest):
    """The tests build on each other, in the order of their names."""

    limit_s = 400.0

    @classmethod
    def setUpClass(cls):
        cls.listen((names.PLANNING_METADATA, MapMetaData), (names.DIAGNOSTICS, DiagnosticArray))
        cls.spoil, cls.last = None, None
        cls.out = rospy.Publisher(TOPICS[SPOILT - 1], PointCloud2, queue_size=2)
        cls.frames = rospy.Publisher("/tf_static", TFMessage, queue_size=10, latch=True)
        cls.true = {}
        rospy.Subscriber("hardware/tf_static", TFMessage, cls.on_frames, queue_size=10)
        rospy.Subscriber(names.camera_points(SPOILT), PointCloud2, cls.pass_on, queue_size=2, buff_size=1 << 23)

    @classmethod
    def on_frames(cls, message):
        with cls.changed:
            cls.true.update({t.child_frame_id: matrix_of_transform(t.transform) for t in message.transforms})
            cls.changed.notify_all()

    @classmethod
    def pass_on(cls, message):
        spoil = cls.spoil
        cls.out.publish(spoil(message) if spoil else message)
        cls.last = message

    @classmethod
    def tell(cls, **off):
        """The cameras' frames, some of them turned and shifted: name with n in place of a number -> matrix."""
        poses = {frame: pose @ off.get(frame, np.eye(4)) for frame, pose in cls.true.items()}
        cls.frames.publish(transform_message(rospy.Time.now(), poses))

    def said(self, status, words):
        """The stamp of the first message since now that says so under a status, s."""
        since = rospy.get_time()

        def found():
            for array in self.kept[names.DIAGNOSTICS]:
                for s in array.status:
                    if array.header.stamp.to_sec() > since and s.name == status and words in s.message:
                        return array.header.stamp.to_sec()
            return None

        return self.wait(found, f"{words!r} in {status}")

    def test_1_cameras_that_are_right_are_not_named(self):
        self.wait(lambda: names.camera_optical_frame(4) in self.true, "the cameras' frames")
        self.tell()
        self.fresh(names.PLANNING_METADATA)
        self.said("camera_watch: camera poses", "no camera is off")
        words = self.wait(self.judged, "a judgement of every camera")
        self.assertEqual([w for w in words if float(w) >= 3.0], [], "significance")

    def judged(self):
        """The significance of every camera, once all are known."""
        for array in reversed(self.kept[names.DIAGNOSTICS]):
            for s in array.status:
                found = [v.value for v in s.values if v.key.endswith("significance")]
                if s.name == "camera_watch: camera poses" and len(found) == len(CAMERAS):
                    return found
        return None

    def test_2_a_drift_of_half_a_degree_is_named_in_ten_seconds(self):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec([0.0, np.radians(DRIFT_DEG), 0.0]).as_matrix()
        began_s = rospy.get_time()
        self.tell(**{names.camera_optical_frame(OFF): turn})
        named_s = self.said("camera_watch: camera poses", f"{TOPICS[OFF - 1]} is off: ")
        self.assertLess(named_s - began_s, NAMED_S)
        self.tell()
        self.said("camera_watch: camera poses", "no camera is off")

    def test_3_calibration_brings_cameras_back(self):
        rng = np.random.default_rng(7)
        off = {}
        for n in CAMERAS:
            axis, way = rng.normal(size=3), rng.normal(size=3)
            moved = np.eye(4)
            moved[:3, :3] = Rotation.from_rotvec(np.radians(FAR_DEG) * axis / np.linalg.norm(axis)).as_matrix()
            moved[:3, 3] = FAR_M * way / np.linalg.norm(way)
            off[names.camera_optical_frame(n)] = moved
        self.tell(**off)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "cameras.yaml"
            script = os.path.join(os.environ["YARM_ROOT"], "scripts", "calibrate_cameras")
            done = subprocess.run(
                [sys.executable, script, str(file), "--topics", *TOPICS],
                capture_output=True, text=True, timeout=self.limit_s, check=False,
            )  # fmt: skip
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            found = read_poses(file)
        self.assertEqual(set(found), {names.camera_optical_frame(n) for n in CAMERAS})
        for frame, pose in found.items():
            apart = np.linalg.inv(self.true[frame]) @ pose
            self.assertLess(np.linalg.norm(apart[:3, 3]), 0.005, f"{frame}: {done.stdout}")
            turn = Rotation.from_matrix(apart[:3, :3]).as_rotvec()
            self.assertLess(np.degrees(np.linalg.norm(turn)), 0.1, frame)
        self.tell()

    def test_4_a_frozen_camera_is_left_out(self):
        held = copy.copy(self.last)

        def freeze(message):
            held.header = message.header
            return held

        type(self).spoil = staticmethod(freeze)
        self.said("merge_clouds: cameras", f"{TOPICS[SPOILT - 1]}: ")
        self.said("merge_clouds: cameras", "frozen: it has been the same to the byte for")
        self.fresh(names.PLANNING_METADATA)
        type(self).spoil = None
        self.said("merge_clouds: cameras", " sets")

    def test_5_a_spot_of_dirt_is_named(self):
        def dirty(message):
            points = np.frombuffer(message.data, np.float32).reshape(message.height, message.width, 4).copy()
            points[192:240, 128:192, :3] = np.nan
            spotted = copy.copy(message)
            spotted.data = points.tobytes()
            return spotted

        type(self).spoil = staticmethod(dirty)
        self.said(
            "merge_clouds: cameras",
            f"{TOPICS[SPOILT - 1]}: 3.0 % of its image, around pixel 160, 216, used to have readings",
        )
        self.fresh(names.PLANNING_METADATA)
        type(self).spoil = None


if __name__ == "__main__":
    init_node("cameras_test")
    rostest.rosrun("yarm", "cameras", CamerasTest, sys.argv)
