#!/usr/bin/env python3
"""The RGB camera of a simulated layout as other nodes see it."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import rospy
import rostest
import tf2_ros
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from visualization_msgs.msg import MarkerArray
from yarm.msg import SimStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.experiments.inspect.eyes import Camera
from yarm.geometry import Pose2
from yarm.geometry.pinhole import level_camera
from yarm.resources import resource
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_CAMERA, RGB_MOUNT
from yarm.ros.common import names
from yarm.ros.common.conversions import matrix_of_transform, pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.rooms.rgb import frame_number
from yarm.sim.engine.room import TICK_S
from yarm.sim.scenes.layout_file import find_layout
from yarm.sim.sensors.rgb_camera import TAG

LIMIT_S = 60.0
LAYOUT = find_layout(str(resource("test", "ros", "room_layout.yaml")))
RATE_HZ = 30.0


def tick_of(stamp: rospy.Time) -> int:
    return round(stamp.to_sec() / TICK_S)


class RoomLayoutTest(ListeningTest):
    """The first check hears no images yet; the others run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen((names.SIM_STATUS, SimStatus), (names.SIM_POSE, Odometry), (names.SIM_ARENA, MarkerArray))

    def draws(self) -> bool:
        """Whether the newest second of the loop spent time on pictures."""
        return "rgb" in self.kept[names.SIM_STATUS][-1].parts

    def test_a_nothing_is_drawn_while_nobody_listens(self) -> None:
        self.wait(lambda: len(self.kept[names.SIM_STATUS]) >= 3, "three seconds")
        self.assertFalse(any("rgb" in status.parts for status in self.kept[names.SIM_STATUS]))
        listener = self.keep(names.RGB_IMAGE, Image, 20)
        self.wait(lambda: self.kept[names.RGB_IMAGE] and self.draws(), "pictures")
        listener.unregister()
        self.wait(lambda: not self.draws(), "an end of drawing")

    def test_b_pictures_are_those_of_the_camera_with_the_tag_in_view(self) -> None:
        self.keep(names.RGB_IMAGE, Image, 20)
        poses = self.kept[names.SIM_POSE]

        def both() -> Any:
            stamps = {pose.header.stamp: pose for pose in poses}
            pictures = self.kept[names.RGB_IMAGE]
            return next(((m, stamps[m.header.stamp]) for m in reversed(pictures) if m.header.stamp in stamps), None)

        image, truth = self.wait(both, "a picture and the truth of one moment")
        self.assertEqual((image.width, image.height, image.encoding, image.step), (640, 480, "rgb8", 1920))
        self.assertEqual(image.header.frame_id, names.RGB_FRAME)
        number = frame_number(tick_of(image.header.stamp), RATE_HZ)
        drawn = Camera(LAYOUT, LAYOUT.arena.seed).frame(pose2_of_pose(truth.pose.pose), number)
        self.assertGreater(int(np.count_nonzero((drawn.kinds == TAG) & (drawn.owners == 0))), 30000)
        differs = np.frombuffer(image.data, np.uint8) != drawn.rgb().ravel()
        # The yaw goes through a quaternion: its last bits may turn a pixel that lies on a rounding edge.
        self.assertLess(int(np.count_nonzero(differs)), 100)

    def test_c_they_come_thirty_times_a_simulated_second(self) -> None:
        self.kept[names.RGB_IMAGE].clear()
        self.wait(lambda: len(self.kept[names.RGB_IMAGE]) > 5, "pictures")
        ticks = [tick_of(message.header.stamp) for message in self.kept[names.RGB_IMAGE]]
        self.assertEqual(ticks, sorted(ticks))
        due = [frame_number(tick, RATE_HZ) > frame_number(tick - 1, RATE_HZ) for tick in ticks]
        self.assertTrue(all(due), ticks)

    def test_d_its_optics_and_its_place_on_the_robot_are_told(self) -> None:
        info = rospy.wait_for_message(names.RGB_INFO, CameraInfo, LIMIT_S)
        self.assertEqual((info.width, info.height), (RGB_CAMERA.width, RGB_CAMERA.height))
        self.assertEqual(info.K[0], RGB_CAMERA.focal_px)
        self.assertEqual((info.K[2], info.K[5]), (RGB_CAMERA.centre_x, RGB_CAMERA.centre_y))
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        found = buffer.lookup_transform(names.BASE_FOOTPRINT, names.RGB_FRAME, rospy.Time(0), rospy.Duration(30.0))
        wanted = level_camera(Pose2(0.0, 0.0), RGB_MOUNT, CAMERA_Z_M)
        np.testing.assert_allclose(matrix_of_transform(found.transform), wanted, atol=1e-6)
        same = buffer.lookup_transform(names.WORLD_FRAME, names.MAP_FRAME, rospy.Time(0), rospy.Duration(30.0))
        self.assertEqual((same.transform.translation.x, same.transform.rotation.w), (0.0, 1.0))
        del listener

    def test_e_boxes_are_bodies_of_the_room(self) -> None:
        markers = self.wait(lambda: self.kept[names.SIM_ARENA], "the arena")[-1].markers
        boxes = [marker for marker in markers if marker.ns == "box"]
        self.assertEqual([(round(m.pose.position.x, 6), m.scale.x) for m in boxes], [(0.7, 0.16), (0.9, 0.16)])


if __name__ == "__main__":
    init_node("room_layout_test")
    rostest.rosrun("yarm", "room_layout", RoomLayoutTest, sys.argv)
