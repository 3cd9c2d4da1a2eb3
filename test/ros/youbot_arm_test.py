#!/usr/bin/env python3
"""The youBot does what arm and base are commanded, says where it is and why it does not, and is stopped."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import TransformStamped, Twist
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import Empty, SetBool
from tf2_msgs.msg import TFMessage
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from yarm.msg import SafetyStatus, YoubotStatus

from yarm.manipulation.motion.trajectory import arm_limits, quintic
from yarm.robots.youbot import JOINT_NAMES, NAME, mechanical_angles, urdf_angles
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.manipulation.bags import joint_trajectory

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import wait_until_heard
from support.listening import ListeningTest

STATES, STATUS = names.ARM_JOINT_STATES, names.youbot("status")
CANDLE, GOAL = np.zeros(5), np.array([0.4, 0.5, -0.6, 0.3, -0.2])
NEAR_RAD = 0.02
REST_S, RESTS_FOR_S, STILL_RADPS, STILL_M = 0.5, 1.0, 0.03, 0.002


class YoubotArmTest(ListeningTest):
    """One arm, which stands up straight at first; the checks run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        """Hear everything, and be heard."""
        cls.listen((STATES, JointState), ("/rosout", Log), (STATUS, YoubotStatus), (names.SAFETY_STATUS, SafetyStatus))
        cls.keep("/tf", TFMessage)
        cls.command = rospy.Publisher(names.ARM_COMMAND, JointTrajectory, queue_size=10)
        cls.velocity = rospy.Publisher(names.YOUBOT_VELOCITY, Twist, queue_size=10)
        for topic in (names.ARM_COMMAND, names.YOUBOT_VELOCITY):
            wait_until_heard(topic, names.YOUBOT_NODE)
        cls.stop = staticmethod(rospy.ServiceProxy(names.SAFETY_STOP, SetBool))

    def base(self) -> np.ndarray:
        """Where the base is by the newest frames, (2,) metres."""
        at = self.base_frame().transform.translation
        return np.array((at.x, at.y))

    def base_frame(self) -> TransformStamped:
        """The newest frame of the base."""
        return next(t for t in self.kept["/tf"][-1].transforms if t.child_frame_id == "base_link")

    def later(self, seconds: float) -> JointState:
        """The first joint states of so much later, simulated; the frames, which come by themselves, are as new."""
        until_s = self.kept[STATES][-1].header.stamp.to_sec() + seconds
        if self.kept["/tf"]:
            self.wait(lambda: self.base_frame().header.stamp.to_sec() >= until_s, "frames")
        return self.wait(
            lambda: next((m for m in self.kept[STATES][-100:] if m.header.stamp.to_sec() >= until_s), None), "time"
        )

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

    def test_3_a_person_stops_it_in_mid_motion_and_it_goes_on_after_the_release(self) -> None:
        """At rest within half a second, also for commands that come meanwhile, which are refused by who stopped it."""
        self.command.publish(joint_trajectory(quintic(CANDLE, GOAL, arm_limits(0.05))))
        self.wait(lambda: self.off_rad(CANDLE) > 0.1, "the arm under way")
        answer = self.stop(True)
        self.assertTrue(answer.success)
        self.later(REST_S)
        held = self.later(0.0).position
        self.later(RESTS_FOR_S)
        state = self.kept[STATES][-1]
        self.assertLess(max(map(abs, state.velocity)), STILL_RADPS)
        self.assertLess(max(abs(a - b) for a, b in zip(state.position, held)), NEAR_RAD)
        self.assertGreater(self.off_rad(GOAL), 0.1, "it was stopped before its end")
        self.wait(lambda: self.kept[names.SAFETY_STATUS][-1].latched, "the stop on safety/status")
        self.command.publish(joint_trajectory(quintic(GOAL, CANDLE, arm_limits(0.5))))
        self.wait(lambda: self.kept[STATUS][-1].refused.startswith("stopped by /youbot_arm"), "who stopped it")
        self.assertTrue(self.stop(False).success)
        self.wait(lambda: self.stands_at(GOAL), "the goal of the motion that was stopped")
        self.wait(lambda: not self.kept[names.SAFETY_STATUS][-1].latched, "its end on safety/status")

    def test_4_the_base_follows_a_velocity_for_half_a_second_and_stands_under_a_stop(self) -> None:
        """What is no number is refused."""
        self.wait(lambda: self.kept["/tf"], "frames")
        begin = self.base()
        wanted = Twist()
        wanted.linear.x = 0.2

        def on_its_way() -> bool:
            self.velocity.publish(wanted)
            return bool(np.linalg.norm(self.base() - begin) > 0.05)

        self.ask(on_its_way, "the base on its way")
        self.later(2 * REST_S)
        rested = self.base()
        self.later(RESTS_FOR_S)
        self.assertLess(np.linalg.norm(self.base() - rested), STILL_M)
        wanted.linear.y = float("nan")
        self.velocity.publish(wanted)
        self.wait(lambda: "must be 3 finite numbers" in self.kept[STATUS][-1].refused, "the refusal")
        wanted.linear.y = 0.0
        self.stop(True)

        def refused() -> bool:
            self.velocity.publish(wanted)
            return self.kept[STATUS][-1].refused.startswith("stopped by")

        self.ask(refused, "the refusal")
        self.assertLess(np.linalg.norm(self.base() - rested), STILL_M)
        self.stop(False)

    def test_5_the_cup_is_switched_and_says_what_it_holds(self) -> None:
        """Nothing is under it."""
        self.keep(names.gripper(NAME, "grasping"), Bool)
        self.wait(lambda: self.kept[names.gripper(NAME, "grasping")], "what hangs on the cup")
        for name in ("on", "off"):
            rospy.ServiceProxy(names.gripper(NAME, name), Empty)()
        self.later(0.1)
        self.assertFalse(self.kept[names.gripper(NAME, "grasping")][-1].data)
        self.assertEqual(self.kept[STATUS][-1].in_bin, [False] * 3)


if __name__ == "__main__":
    init_node("youbot_arm_test")
    rostest.rosrun("yarm", "youbot_arm", YoubotArmTest)
