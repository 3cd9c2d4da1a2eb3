#!/usr/bin/env python3
"""move_base in lock-step at the platform's 5 Hz: the room goes on, every pass is acknowledged, a goal is reached."""

from __future__ import annotations

import sys
from pathlib import Path

import actionlib
import numpy as np
import rospy
import rostest
import tf2_ros
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry
from nav_msgs.srv import GetPlan
from yarm.msg import StepAck

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.geometry import Pose2
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import GridMap
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_message
from yarm.ros.navigation.outputs import stamped_pose
from yarm.ros.rooms.messages import transform
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import load_arena

LIMIT_S = 100.0
"""Simulated time for the goal, s."""
ARENA = load_arena(resource("test", "ros", "move_base_room.yaml"))
GOAL = Pose2(-1.2, 0.8)


class MoveBaseSyncTest(ListeningTest):
    """One goal."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen((names.STEP_ACK, StepAck), (names.SIM_POSE, Odometry))
        cls.static = tf2_ros.StaticTransformBroadcaster()
        cls.static.sendTransform(transform("map", "odom", Pose2(0.0, 0.0), rospy.Time(0)))
        empty = GridMap(np.zeros((88, 88), np.int8), 0.05, Pose2(-2.2, -2.2))
        known = with_bodies(empty, list(FlatBoxes(ARENA.blocks).corners()))
        cls.map = rospy.Publisher(names.MAP, OccupancyGrid, queue_size=1, latch=True)
        cls.map.publish(grid_message(known, "map", rospy.Time(0)))

    def test_a_goal_is_reached_and_every_pass_acknowledged(self) -> None:
        client = actionlib.SimpleActionClient(names.MOVE_BASE, MoveBaseAction)
        self.wait(lambda: self.kept[names.STEP_ACK] and self.kept[names.SIM_POSE], "an acknowledged pass")
        self.assertTrue(client.wait_for_server(rospy.Duration(LIMIT_S)))
        plan = rospy.ServiceProxy(names.move_base("make_plan"), GetPlan)
        goal = stamped_pose(GOAL, "map", rospy.Time(0))
        self.ask(lambda: plan(PoseStamped(), goal, 0.0).plan.poses, "a plan from where the robot is")
        client.send_goal(MoveBaseGoal(target_pose=goal))
        self.assertTrue(client.wait_for_result(rospy.Duration(LIMIT_S)))
        self.assertEqual(client.get_state(), GoalStatus.SUCCEEDED, client.get_goal_status_text())
        self.assertLess(pose2_of_pose(self.fresh(names.SIM_POSE).pose.pose).distance(GOAL), 0.15 + 0.1)
        with self.changed:
            acks = list(self.kept[names.STEP_ACK])
        stamps = [ack.header.stamp.to_sec() for ack in acks]
        self.assertEqual({round(float(step), 6) for step in np.diff(stamps)} - {0.0}, {0.1})
        commands = acks[-1].commands_sent - acks[0].commands_sent
        self.assertLessEqual(commands, round((stamps[-1] - stamps[0]) * 5.0) + 1)


if __name__ == "__main__":
    init_node("move_base_sync_test")
    rostest.rosrun("yarm", "move_base_sync", MoveBaseSyncTest, sys.argv)
