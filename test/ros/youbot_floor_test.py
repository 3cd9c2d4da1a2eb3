#!/usr/bin/env python3
"""The youBot clears its floor by ground truth; the page shows it where it is, and a stop stops it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import rospy
import rostest
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory
from yarm.msg import YoubotStatus

from yarm.console.params import ConsoleParams
from yarm.console.wire import decode
from yarm.geometry import FloatArray
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.console.view import LiveView

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard
from support.listening import ListeningTest

STATUS = names.youbot("status")
BASE, CUP = "base_link", "suction_cup"
REST_S, RESTS_FOR_S, STILL_M, NEAR_M = 0.5, 1.0, 0.002, 0.05


class YoubotFloorTest(ListeningTest):
    """One floor; the checks run in the order of their names."""

    limit_s = 400.0

    @classmethod
    def setUpClass(cls) -> None:
        """Hear everything, and look as a page does."""
        cls.listen((STATUS, YoubotStatus))
        cls.keep("/tf", TFMessage)
        cls.view = LiveView(ConsoleParams())
        cls.command = rospy.Publisher(names.ARM_COMMAND, JointTrajectory, queue_size=10)
        wait_until_heard(names.ARM_COMMAND, names.YOUBOT_NODE)
        cls.stop = staticmethod(rospy.ServiceProxy(names.SAFETY_STOP, SetBool))

    def frames(self, since_s: float = 0.0) -> FloatArray:
        """Time, base's place and cup's place of each message of frames, (n, 7)."""
        with self.changed:
            found = list(self.kept["/tf"])
        rows = []
        for message in found:
            at = {t.child_frame_id: t.transform.translation for t in message.transforms}
            stamp_s = message.transforms[0].header.stamp.to_sec()
            if stamp_s >= since_s:
                rows.append((stamp_s, *(v for f in (BASE, CUP) for v in (at[f].x, at[f].y, at[f].z))))
        return np.array(rows).reshape(-1, 7)

    def under_way(self) -> bool:
        """Base or cup has moved since the last frames."""
        frames = self.frames()[-3:]
        return len(frames) == 3 and bool(np.abs(np.diff(frames[:, 1:], axis=0)).max() > 0.002)

    def test_1_while_it_works_the_page_shows_it_where_it_is(self) -> None:
        """And what others command is refused."""
        self.wait(lambda: self.kept[STATUS] and self.kept[STATUS][-1].clearing and self.under_way(), "its work")
        self.command.publish(JointTrajectory())
        self.wait(lambda: self.kept[STATUS][-1].refused == "it clears the floor by itself", "the refusal")
        self.assertTrue(self.stop(True).success)
        begun_s = self.frames()[-1, 0]
        self.wait(lambda: self.frames()[-1, 0] > begun_s + REST_S + RESTS_FOR_S, "time")
        rest = self.frames(begun_s + REST_S)
        self.assertLess(np.abs(rest[:, 1:] - rest[0, 1:]).max(), STILL_M)
        scene, _ = decode(self.view.parts()["scene"].message)
        header, arrays = decode(self.view.state())
        self.assertEqual(header["room"]["title"], "youBot: clears its floor")
        self.assertTrue(header["stop"]["latched"])
        self.assertEqual(header["silent"], [])
        poses = dict(zip(scene["frames"], arrays["poses"]))
        for frame, place in ((BASE, rest[-1, 1:4]), (CUP, rest[-1, 4:])):
            self.assertLess(np.abs(poses[frame][:3] - place).max(), NEAR_M)
        self.assertTrue(np.isfinite(arrays["poses"]).all(), "every frame has been heard")
        self.assertTrue(self.stop(False).success)
        self.wait(self.under_way, "its work again")

    def test_2_all_is_in_the_bin_by_ground_truth(self) -> None:
        """Nothing else was touched, and it takes commands again."""
        status = self.wait(lambda: not self.kept[STATUS][-1].clearing and self.kept[STATUS][-1], "the end")
        self.assertEqual(status.doing, "the floor is clear, 3 pieces are in the bin")
        self.assertEqual((status.in_bin, status.touches, status.held), ([True] * 3, [], ""))


if __name__ == "__main__":
    init_node("youbot_floor_test")
    rostest.rosrun("yarm", "youbot_floor", YoubotFloorTest)
