#!/usr/bin/env python3
"""A sander decides nothing while nobody listens to its motions, and the next one halts the arm once somebody does."""

from __future__ import annotations

import os
import signal
import sys
import xmlrpc.client
from pathlib import Path

import numpy as np
import rospy
import rostest
from sensor_msgs.msg import JointState, Joy
from trajectory_msgs.msg import JointTrajectory
from yarm.msg import SanderStatus

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.control.arm.model import load_arm
from yarm.control.sander.states import Button
from yarm.ros.common import names
from yarm.ros.common.start import init_node

ARM, SANDER = "hc10_barc", "hc10_state_machine"
RATE_HZ, READINGS = 50.0, 100
AWAY_RAD = 0.4
"""The arm goes on by so much at joint 6 while its sander is dead."""


class SanderDriverTest(ListeningTest):
    limit_s = 120.0

    @classmethod
    def setUpClass(cls) -> None:
        arm = load_arm()
        cls.joint_names = [joint.name for joint in arm.model.moving_joints]
        cls.q, cls.told = arm.storage.copy(), 0
        cls.listen((names.sander_status(ARM), SanderStatus))
        cls.joints = rospy.Publisher(names.joint_states(ARM), JointState, queue_size=5, tcp_nodelay=True)
        cls.joy = rospy.Publisher(names.sander_joy(ARM), Joy, queue_size=5)
        cls.timer = rospy.Timer(rospy.Duration(1.0 / RATE_HZ), cls.tell)

    @classmethod
    def tell(cls, _: object) -> None:
        """One reading of the arm's joints."""
        message = JointState(name=cls.joint_names, position=cls.q.tolist())
        message.header.stamp = rospy.Time.now()
        cls.joints.publish(message)
        with cls.changed:
            cls.told = cls.told + 1 if cls.joints.get_num_connections() else 0
            cls.changed.notify_all()

    def unheard(self) -> None:
        """The sander hears the joints many times, and nobody its motions: it says nothing."""
        with self.changed:
            type(self).told = 0
        self.wait(lambda: self.told > READINGS, "readings heard")
        self.assertEqual(self.kept[names.sander_status(ARM)], [])

    def test_nobody_listens(self) -> None:
        self.unheard()
        path = names.joint_path_command(ARM)
        driver = self.keep(path, JointTrajectory)
        self.wait(lambda: self.kept[names.sander_status(ARM)], "the sander's word once its motions are heard")
        self.ask(self.joy.get_num_connections, "a sander that hears buttons")
        self.joy.publish(Joy(buttons=[int(button is Button.ADVANCE) for button in Button]))
        self.wait(lambda: self.kept[path], "a motion")
        self.killed(driver)
        self.unheard()
        self.keep(path, JointTrajectory)
        halt, onward = self.wait(lambda: self.kept[path][1:] and self.kept[path][:2], "a halt, and the way on")
        self.assertEqual(len(halt.points), 1)
        np.testing.assert_allclose(halt.points[0].positions, self.q, atol=1e-9)
        self.assertGreater(len(onward.points), 1)

    def killed(self, driver: rospy.Subscriber) -> None:
        """The sander dies; the arm goes on for a while, and its driver is not connected to the next one yet."""
        uri = rospy.get_master().lookupNode("/" + SANDER)[2]
        pid = int(xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2])
        driver.unregister()
        os.kill(pid, signal.SIGKILL)
        self.ask(lambda: not self.joints.get_num_connections(), "the end of the sander's connections")
        type(self).q = self.q + np.array([0.0, 0.0, 0.0, 0.0, 0.0, AWAY_RAD])
        with self.changed:
            self.kept[names.sander_status(ARM)].clear()


if __name__ == "__main__":
    init_node("sander_driver_test")
    rostest.rosrun("yarm", "sander_driver_test", SanderDriverTest, sys.argv)
