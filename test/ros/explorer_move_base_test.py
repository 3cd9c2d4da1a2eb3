#!/usr/bin/env python3
"""The explorer's goals driven by move_base, from the start to the end of a small room: mapped, at rest, nothing hit."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Twist
from move_base_msgs.msg import MoveBaseActionGoal, MoveBaseActionResult
from nav_msgs.msg import OccupancyGrid, Odometry
from yarm.msg import ExplorerStatus, StepAck

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.experiments.explore.judge import Judge
from yarm.exploration.session import State
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_of
from yarm.sim.scenes.arena import load_arena

ARENA = load_arena(resource("test", "ros", "room_arena.yaml"))
STATUS, MAP = names.explorer("status"), names.explorer("map")
GOAL, RESULT = names.move_base("goal"), names.move_base("result")
ENDED = (State.DONE.value, State.FAILED.value)
SHARE = 0.97
REST_MPS = 0.005
TRUTHS = 100_000
"""True poses that are kept: half an hour, so that the moment after the end is among them however late that is."""


class ExplorerMoveBaseTest(ListeningTest):
    """One run; the explorer waits for this node before its first pass."""

    limit_s = 600.0

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen(
            (STATUS, ExplorerStatus),
            (GOAL, MoveBaseActionGoal),
            (RESULT, MoveBaseActionResult),
            (MAP, OccupancyGrid),
            (names.NAVI, Twist),
        )
        cls.keep(names.SIM_POSE, Odometry, TRUTHS)
        cls.ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=10)

    def begun(self) -> bool:
        """Say that this node hears, until the run has begun."""
        self.ack.publish(step_ack(rospy.Time(0), 0))
        with self.changed:
            return any(status.state != State.IDLE.value for status in self.kept[STATUS])

    def ended(self):
        return next((status for status in self.kept[STATUS] if status.state in ENDED), None)

    def test_the_room_is_mapped_by_goals_alone_and_nothing_is_hit(self) -> None:
        self.ask(self.begun, "the first pass of the run")
        end = self.wait(self.ended, "the end of the exploration")
        said = f"{end.state}: {end.reason}"
        self.assertEqual(end.state, State.DONE.value, said)
        self.assertGreater(end.left, 1.0, said)
        self.assertEqual(end.bumps, 0, said)
        judge = Judge(ARENA)
        self.wait(
            lambda: self.kept[MAP] and judge.share(grid_of(self.kept[MAP][-1]), ARENA.start) >= SHARE,
            f"a map of {SHARE:.0%} after {end.elapsed:.1f} s; {said}",
        )
        self.check_goals(end.elapsed)
        self.check_rest(end.header.stamp.to_sec() + 1.0)

    def check_goals(self, elapsed_s: float) -> None:
        """Each goal has a name of its own; all that ended were reached or taken back; commands drove the way."""
        with self.changed:
            goals = [goal.goal_id.id for goal in self.kept[GOAL]]
            ends = {result.status.goal_id.id: result.status for result in self.kept[RESULT]}
            moved = sum(command.linear.x > 0.02 for command in self.kept[names.NAVI])
        rospy.loginfo("%d goals in %.1f s, %d passes ahead: %s", len(goals), elapsed_s, moved, list(ends.values()))
        self.assertGreaterEqual(len(goals), 3)
        self.assertEqual(len(set(goals)), len(goals))
        self.assertLessEqual(set(ends), set(goals))
        aborted = [status.text for status in ends.values() if status.status == GoalStatus.ABORTED]
        self.assertEqual(aborted, [])
        self.assertGreater(moved, 50)

    def check_rest(self, from_s: float) -> None:
        """By the truth, for a second, however long ago."""

        def watched():
            poses = [pose for pose in self.kept[names.SIM_POSE] if from_s <= pose.header.stamp.to_sec() < from_s + 1.0]
            return poses if self.kept[names.SIM_POSE][-1].header.stamp.to_sec() >= from_s + 1.0 else None

        poses = [pose2_of_pose(pose.pose.pose) for pose in self.wait(watched, "a second of the truth after the end")]
        self.assertGreater(len(poses), 10)
        steps = [a.distance(b) for a, b in zip(poses, poses[1:])]
        self.assertLess(float(np.sum(steps)), REST_MPS)


if __name__ == "__main__":
    init_node("explorer_move_base")
    rostest.rosrun("yarm", "explorer_move_base", ExplorerMoveBaseTest, sys.argv)
