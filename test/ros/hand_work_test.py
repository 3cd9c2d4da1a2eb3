#!/usr/bin/env python3
"""A piece is aligned with, picked up, carried, and let go into a bin, by goals of the controls server alone."""

from __future__ import annotations

import sys
import threading
import unittest
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple

import numpy as np
import rospy
import rostest
from actionlib import SimpleActionClient
from actionlib_msgs.msg import GoalStatus
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage
from yarm.msg import Contacts, MoveRobotAction, MoveRobotGoal, SimStatus, TransformStampedVector

from yarm.control.hand import CARRYING_M
from yarm.geometry.poses import quaternion_from_rpy
from yarm.robots import bin as bins
from yarm.robots.ankurbot import LIFT_JOINT
from yarm.ros.common import names
from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.participant import Participant

ROBOT, PIECE = "ankurbot_1", "debris_1"
BIN_XY = (0.45, -1.45)
LIMIT_S = 300.0
NEAR_M = 0.012
FALL_S = 1.0
LOWERED_M = 0.1
MANY = 20
STANDS_M = 0.005


class HandWorkTest(unittest.TestCase):
    """The checks run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        """Take part in the lock-step, and keep what is told of poses and touches."""
        cls.changed = threading.Condition()
        cls.at: Dict[str, Tuple[float, np.ndarray]] = {}
        cls.failures: List[str] = []
        cls.in_bin: List[Tuple[float, Dict[str, str]]] = []
        cls.lifts: List[Tuple[float, np.ndarray]] = [(0.0, np.zeros(2))]
        cls.participant = Participant()
        rospy.Subscriber(names.SEED_TRANSFORMS, TransformStampedVector, cls.on_seeds, queue_size=1000)
        rospy.Subscriber(names.SIM_CONTACTS, Contacts, cls.on_contacts, queue_size=1000)
        rospy.Subscriber(names.SIM_STATUS, SimStatus, cls.on_status, queue_size=1000)
        rospy.Subscriber("/tf", TFMessage, cls.on_tf, queue_size=1000)
        rospy.Subscriber(names.joint_states(ROBOT), JointState, cls.on_joints, queue_size=1000)
        cls.client = SimpleActionClient(names.move_robot(ROBOT), MoveRobotAction)
        cls.participant.wait_for_begin()
        assert cls.client.wait_for_server(rospy.Duration(60.0))

    @classmethod
    def on_seeds(cls, message: TransformStampedVector) -> None:
        """The next camera set comes when the test has this one."""
        cls.participant.took(message.header.stamp)

    @classmethod
    def on_contacts(cls, message: Contacts) -> None:
        """Keep what nobody may do."""
        cls.failures += [f"{c.link_a} - {c.link_b}" for c in message.contacts if c.kind == "failure"]

    @classmethod
    def on_status(cls, message: SimStatus) -> None:
        """Keep what the simulator says lies in which bin."""
        with cls.changed:
            cls.in_bin.append((message.header.stamp.to_sec(), dict(zip(message.debris, message.bins))))
            cls.changed.notify_all()

    @classmethod
    def on_tf(cls, message: TFMessage) -> None:
        """Keep where everything is, and when."""
        with cls.changed:
            for transform in message.transforms:
                at = transform.transform.translation
                cls.at[transform.child_frame_id] = (transform.header.stamp.to_sec(), np.array([at.x, at.y, at.z]))
            cls.changed.notify_all()

    @classmethod
    def on_joints(cls, message: JointState) -> None:
        """Keep how far down the hand was, and where its robot was last seen."""
        with cls.changed:
            _, at = cls.at.get(f"{ROBOT}/ee", (0.0, np.zeros(3)))
            cls.lifts.append((message.position[message.name.index(LIFT_JOINT)], at[:2]))
            cls.changed.notify_all()

    def place(self, frame: str, from_s: float = 0.0) -> np.ndarray:
        """Where a frame is at a time, s, or later."""
        with self.changed:
            found = self.changed.wait_for(lambda: frame in self.at and self.at[frame][0] >= from_s, timeout=LIMIT_S)
            self.assertTrue(found, f"no {frame} at {from_s:.2f} s")
            return self.at[frame][1]

    def ask(self, action: str, xy: Tuple[float, float], heard: Optional[List[Tuple[str, float]]] = None) -> Any:
        """State and message at the end of a goal with the tip over a place; ``heard`` takes stages and lifts."""
        told: List[Tuple[str, float]] = [] if heard is None else heard
        self.participant.ask(
            lambda: self.client.send_goal(
                goal_over(action, xy), feedback_cb=lambda feedback: told.append((feedback.stage, feedback.lift))
            )
        )
        self.assertTrue(self.client.wait_for_result(rospy.Duration(LIMIT_S)), f"{action}: no end")
        return self.client.get_state(), self.client.get_result().message

    def test_0_a_name_that_is_none_is_refused_and_nothing_moves(self) -> None:
        """By name, with what is wanted."""
        here = tuple(self.place(f"{ROBOT}/ee")[:2].tolist())
        for action, words in (
            ("PICK chair", "nobody in object_registry is called chair"),
            ("PICK table", "table is no piece of debris"),
            ("DROP debris_1", "debris_1 is no bin"),
            ("PICK", "needs the name of a piece of debris, as in 'PICK debris_1'"),
        ):
            self.participant.ask(lambda a=action: self.client.send_goal(goal_over(a, (here[0] + 0.2, here[1]))))
            self.assertTrue(self.client.wait_for_result(rospy.Duration(LIMIT_S)), f"{action}: no end")
            self.assertEqual(self.client.get_state(), GoalStatus.REJECTED)
            self.assertIn(words, self.client.get_goal_status_text())

    def test_1_with_an_empty_hand_nothing_is_let_go(self) -> None:
        """The base goes there all the same."""
        state, said = self.ask("DROP bin_1", (0.22, 0.3))
        self.assertEqual((state, said), (GoalStatus.ABORTED, "nothing hangs on the cup"))

    def test_2_a_piece_is_aligned_with_and_picked_up(self) -> None:
        """The tip is brought within a centimetre, which a base alone does not do."""
        piece = self.place(PIECE)
        heard: List[Tuple[str, float]] = []
        state, said = self.ask(f"PICK {PIECE}", (float(piece[0]), float(piece[1])), heard)
        self.assertEqual(state, GoalStatus.SUCCEEDED, said)
        stages = [stage for stage, _ in heard]
        self.assertEqual(list(dict.fromkeys(stages)), ["aligning", "down", "up"])
        self.assertGreater(max(lift_m for _, lift_m in heard), LOWERED_M)
        self.assertRegex(said, r"picked up 0\.1[45]\d m down")
        stamp_s = self.at[PIECE][0]
        tip, piece = self.place(f"{ROBOT}/ee", stamp_s), self.place(PIECE, stamp_s)
        self.assertLess(float(np.hypot(*(tip - piece)[:2])), NEAR_M)
        self.assertAlmostEqual(float(piece[2]), 0.97 - 0.075 - 0.02, delta=0.01)

    def test_3_another_piece_is_not_picked_up_meanwhile(self) -> None:
        """One at a time."""
        state, said = self.ask(f"PICK {PIECE}", tuple(self.place(f"{ROBOT}/ee")[:2].tolist()))
        self.assertEqual((state, said), (GoalStatus.ABORTED, "something hangs on the cup already"))

    def test_4_after_a_cancelled_drop_the_base_stands_until_the_hand_is_up(self) -> None:
        """It is sent on at once; over a bin's rim it would sweep the piece along."""
        here = tuple(self.place(f"{ROBOT}/ee")[:2].tolist())
        self.participant.ask(lambda: self.client.send_goal(goal_over("DROP bin_1", here)))
        with self.changed:
            self.assertTrue(self.changed.wait_for(lambda: self.lifts[-1][0] > LOWERED_M, timeout=LIMIT_S))
            del self.lifts[:-1]
        state, said = self.ask("", (here[0] + 0.3, here[1]))
        self.assertEqual(state, GoalStatus.SUCCEEDED, said)
        down = np.array([at for lift_m, at in self.lifts if lift_m > CARRYING_M])
        self.assertGreater(len(down), MANY)
        self.assertLess(float(np.ptp(down, axis=0).max()), STANDS_M)
        self.assertGreater(float(np.ptp([at for _, at in self.lifts], axis=0).max()), 0.25)
        self.assertEqual(self.failures, [])

    def test_5_it_is_carried_and_let_go_into_the_bin(self) -> None:
        """Ground truth says where it lies; nothing else was touched."""
        state, said = self.ask("DROP bin_1", BIN_XY)
        self.assertEqual(state, GoalStatus.SUCCEEDED, said)
        piece = self.place(PIECE, self.at[PIECE][0] + FALL_S)
        self.assertTrue(bins.inside(piece - (*BIN_XY, 0.0)), piece)
        with self.changed:
            told = self.changed.wait_for(lambda: {PIECE: "bin_1"} in [said for _, said in self.in_bin], LIMIT_S)
            self.assertTrue(told, self.in_bin[-3:])
            self.assertEqual(self.in_bin[0][1], {PIECE: ""})
        self.assertEqual(self.failures, [])

    def test_6_where_nothing_is_nothing_is_picked_up(self) -> None:
        """Over the floor the lift ends before anything is met."""
        state, said = self.ask(f"PICK {PIECE}", (0.7, -1.6))
        self.assertEqual(state, GoalStatus.ABORTED)
        self.assertRegex(said, r"nothing met down to 0\.(19|20)\d m")
        self.assertEqual(self.failures, [])


def goal_over(action: str, xy: Tuple[float, float]) -> MoveRobotGoal:
    """A goal with the tip over a place, metres."""
    goal = MoveRobotGoal(action=action)
    goal.target.position.x, goal.target.position.y, goal.target.position.z = *xy, 0.97
    q = goal.target.orientation
    q.x, q.y, q.z, q.w = quaternion_from_rpy(0.0, 0.0, np.pi)
    return goal


if __name__ == "__main__":
    init_node("hand_work")
    rostest.rosrun("yarm", "hand_work", HandWorkTest, sys.argv)
