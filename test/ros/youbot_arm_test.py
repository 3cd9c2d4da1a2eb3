#!/usr/bin/env python3
"""The youBot's arm follows what its controller is commanded, says where it is, and why it does not follow."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import rospy
import rostest
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from yarm.manipulation.motion.trajectory import arm_limits, quintic
from yarm.robots.youbot import JOINT_NAMES, mechanical_angles, urdf_angles
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.manipulation.bags import joint_trajectory

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard
from support.listening import ListeningTest

STATES = names.ARM_JOINT_STATES
CANDLE, GOAL = np.zeros(5), np.array([0.4, 0.5, -0.6, 0.3, -0.2])
NEAR_RAD = 0.02


class YoubotArmTest(ListeningTest):
    """One arm, which stands up straight at first; the checks run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        """Hear everything, and be heard."""
        cls.listen((STATES, JointState), ("/rosout", Log))
        cls.command = rospy.Publisher(names.ARM_COMMAND, JointTrajectory, queue_size=10)
        wait_until_heard(names.ARM_COMMAND, "youbot_simulation")

    def off_rad(self, goal: np.ndarray) -> float:
        """Greatest distance of any joint from a goal by the newest joint states."""
        state = self.kept[STATES][-1]
        told = dict(zip(state.name, state.position))
        return float(np.max(np.abs(mechanical_angles([told[name] for name in JOINT_NAMES]) - goal)))

    def stands_at(self, goal: np.ndarray) -> bool:
        return self.off_rad(goal) < NEAR_RAD and max(map(abs, self.kept[STATES][-1].velocity)) < NEAR_RAD

    def test_1_a_motion_is_followed_to_its_end(self) -> None:
        """From the candle to somewhere else, where it stands."""
        self.wait(lambda: self.kept[STATES] and self.stands_at(CANDLE), "the arm straight up")
        self.command.publish(joint_trajectory(quintic(CANDLE, GOAL, arm_limits(0.5))))
        self.wait(lambda: self.stands_at(GOAL), "the goal")

    def test_2_a_motion_that_cannot_be_followed_moves_nothing_and_is_told_why(self) -> None:
        """Other joints, a jump, nothing at all; the next good one is followed."""
        jump = JointTrajectoryPoint(positions=urdf_angles(CANDLE).tolist())
        self.command.publish(JointTrajectory(joint_names=["lift"], points=[JointTrajectoryPoint(positions=[0.1])]))
        self.command.publish(JointTrajectory(joint_names=list(JOINT_NAMES), points=[jump]))
        self.command.publish(JointTrajectory(joint_names=list(JOINT_NAMES)))
        for reason in ("each once", "from where the arm is, at most 0.05", "at least one point"):
            self.wait(lambda r=reason: any(r in log.msg for log in self.kept["/rosout"]), reason)
        self.assertTrue(self.stands_at(GOAL))
        self.command.publish(joint_trajectory(quintic(GOAL, CANDLE, arm_limits(0.5))))
        self.wait(lambda: self.stands_at(CANDLE), "the candle again")


if __name__ == "__main__":
    init_node("youbot_arm_test")
    rostest.rosrun("yarm", "youbot_arm", YoubotArmTest)
