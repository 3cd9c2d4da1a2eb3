#!/usr/bin/env python3
"""A robot of the simulated cell drives over every cell of a small floor and touches nothing."""

from __future__ import annotations

import sys
import unittest
from pathlib import Path
from typing import List

import numpy as np
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from yarm.msg import Contacts, MoveRobotAction, TransformStampedVector

from yarm.geometry import Pose2
from yarm.manipulation.coverage.sweep import RobotSpace, plan_sweep
from yarm.ros.common import names
from yarm.ros.common.start import init_node
from yarm.ros.manipulation.sweep import CellView, move_goal, sweep

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.participant import Participant

ROBOT = "ankurbot_1"
HALF_M, CELL_M = 1.0, 0.5
GOAL_LIMIT_S = 120.0


class SweepTest(unittest.TestCase):
    """The round of ``rosrun yarm sweep``, its goals sent within the lock-step."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.failures: List[str] = []
        cls.participant = Participant()
        cls.view = CellView(ROBOT)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber(
            names.SEED_TRANSFORMS,
            TransformStampedVector,
            lambda message: cls.participant.took(message.header.stamp),
            queue_size=1000,
        )
        cls.client = SimpleActionClient(names.move_robot(ROBOT), MoveRobotAction)
        cls.participant.wait_for_begin()
        assert cls.client.wait_for_server(rospy.Duration(60.0))

    @classmethod
    def on_contacts(cls, message: Contacts) -> None:
        cls.failures += [f"{c.body_a} - {c.body_b}" for c in message.contacts if c.kind == "failure"]

    @classmethod
    def drive(cls, target: Pose2) -> str:
        cls.participant.ask(lambda: cls.client.send_goal(move_goal(target)))
        if not cls.client.wait_for_result(rospy.Duration(GOAL_LIMIT_S)):
            return "no result"
        return "" if cls.client.get_state() == GoalStatus.SUCCEEDED else cls.client.get_result().message

    def test_every_cell_that_can_be_reached_is_gone_over(self) -> None:
        self.assertEqual(self.view.wait(), "")
        body, reach, solids = self.view.robot()
        self.assertAlmostEqual(reach.x, 1.30, delta=0.02)
        plan = plan_sweep(RobotSpace(solids, self.view.things()), body, HALF_M, CELL_M)
        report = sweep(self.view, plan, reach, self.drive)
        self.assertEqual(report.reason, "")
        self.assertEqual(report.left_out.tolist(), [])
        self.assertEqual(self.failures, [])
        over = plan.gone_over(report.track)
        self.assertFalse(over[3, 3], "the crate stands there")
        self.assertGreaterEqual(int(over.sum()), 8)
        self.assertLess(np.abs(report.track).max(), 2.5)

    def test_an_unknown_robot_is_named_with_those_there_are(self) -> None:
        missing = CellView("nobody").wait(3.0)
        self.assertIn("no robot nobody", missing)
        self.assertIn(ROBOT, missing)


if __name__ == "__main__":
    init_node("sweep")
    rostest.rosrun("yarm", "sweep", SweepTest)
