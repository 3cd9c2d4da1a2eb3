#!/usr/bin/env python3
"""Map server, amcl and move_base together in the practice world: localised from a rough pose, driven to a tag."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import List

import actionlib
import rosgraph
import rospy
import rostest
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, Twist
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry
from nav_msgs.srv import GetPlan
from std_msgs.msg import Bool
from yarm.msg import Contacts

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.experiments.inspect.given import CELL_M, FINE_CELL_M
from yarm.geometry import Pose2, wrap_angle
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose, pose_message
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_of
from yarm.ros.navigation.outputs import stamped_pose
from yarm.sim.scenes.layout_file import find_layout

LIMIT_S = 90.0
AMCLS_MAP = f"localisation/{names.MAP}"
LAYOUT = find_layout("practice")
BOX = LAYOUT.boxes[5].pose
BEFORE_BOX = BOX.compose(Pose2(0.5, 0.0, 3.141592653589793))
"""Where the sixth box's tag is read from."""


class KnownRoomTest(ListeningTest):
    """One launch serves every check; they run in the order of their names."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.listen(
            (names.MAP, OccupancyGrid), (AMCLS_MAP, OccupancyGrid),
            (names.SIM_POSE, Odometry), (names.SIM_CONTACTS, Contacts),
            ("amcl/localised", Bool), (names.AMCL_POSE, PoseWithCovarianceStamped),
        )  # fmt: skip
        cls.guess = rospy.Publisher(names.INITIAL_POSE, PoseWithCovarianceStamped, queue_size=1)
        cls.teleop = rospy.Publisher(names.TELEOP, Twist, queue_size=1)
        cls.client = actionlib.SimpleActionClient(names.MOVE_BASE, MoveBaseAction)
        assert cls.client.wait_for_server(rospy.Duration(LIMIT_S))
        rospy.wait_for_service(names.move_base("make_plan"), LIMIT_S)

    def truth(self) -> Pose2:
        return pose2_of_pose(self.fresh(names.SIM_POSE).pose.pose)

    def plan(self, goal: Pose2) -> List[PoseStamped]:
        """The way from the layout's start."""
        start, end = (stamped_pose(pose, "map", rospy.Time(0)) for pose in (LAYOUT.start, goal))
        return rospy.ServiceProxy(names.move_base("make_plan"), GetPlan)(start, end, 0.0).plan.poses

    def localised(self) -> bool:
        return bool(self.kept["amcl/localised"] and self.kept["amcl/localised"][-1].data)

    def test_a_the_map_has_the_boxes_in_it(self) -> None:
        for topic, cell_m in ((names.MAP, CELL_M), (AMCLS_MAP, FINE_CELL_M)):
            grid = grid_of(self.wait(lambda topic=topic: self.kept[topic], topic)[-1])
            self.assertAlmostEqual(grid.resolution_m, cell_m)
            for block in LAYOUT.boxes:
                self.assertTrue(grid.occupied[grid.cell_of(block.pose.x, block.pose.y)], f"{topic}: {block.name}")
            self.assertTrue(grid.free[grid.cell_of(0.0, 0.0)])

    def test_a_amcl_hears_the_fine_map_and_move_base_the_other(self) -> None:
        def hearers(topic):
            return dict(rosgraph.Master(rospy.get_name()).getSystemState()[1]).get(f"/{topic}", [])

        self.ask(lambda: "/amcl" in hearers(AMCLS_MAP) and "/move_base" in hearers(names.MAP), "who hears the maps")
        self.assertNotIn("/amcl", hearers(names.MAP))

    def test_b_until_it_is_localised_a_goal_is_refused_with_its_reason(self) -> None:
        self.ask(lambda: self.plan(BEFORE_BOX), "a plan over the map")
        self.client.send_goal(MoveBaseGoal(target_pose=stamped_pose(BEFORE_BOX, "map", rospy.Time(0))))
        self.assertTrue(self.client.wait_for_result(rospy.Duration(60.0)))
        self.assertEqual(self.client.get_state(), GoalStatus.ABORTED)
        self.assertIn("is the localisation running?", self.client.get_goal_status_text())

    def test_c_from_a_rough_pose_it_is_localised_and_drives_to_a_tag(self) -> None:
        guess = PoseWithCovarianceStamped()
        guess.header.frame_id = "map"
        guess.pose.pose = pose_message(0.2, -0.2, 0.0, 0.2)
        guess.pose.covariance[0] = guess.pose.covariance[7] = 0.3**2
        guess.pose.covariance[35] = 0.3**2
        self.wait(lambda: self.guess.get_num_connections() > 0, "amcl")
        self.guess.publish(guess)
        turning = Twist()
        turning.angular.z = 0.5
        spin = rospy.Timer(rospy.Duration(0.1), lambda _: self.teleop.publish(turning))
        self.wait(self.localised, "localised")
        spin.shutdown()
        self.assertGreater(len(self.plan(BEFORE_BOX)), 5)
        self.assertEqual(len(self.plan(BOX)), 0)
        goal = stamped_pose(BEFORE_BOX, "map", rospy.Time(0))
        self.client.send_goal(MoveBaseGoal(target_pose=goal))
        self.assertTrue(self.client.wait_for_result(rospy.Duration(120.0)))
        self.assertEqual(self.client.get_state(), GoalStatus.SUCCEEDED, self.client.get_goal_status_text())
        truth = self.truth()
        self.assertLess(truth.distance(BEFORE_BOX), 0.05 + 0.05)
        self.assertLess(abs(wrap_angle(truth.yaw_rad - BEFORE_BOX.yaw_rad)), 0.04 + 0.06)
        contacts = [c for message in self.kept[names.SIM_CONTACTS] for c in message.contacts if c.kind == "failure"]
        self.assertEqual([f"{c.body_a}-{c.body_b}" for c in contacts], [])


if __name__ == "__main__":
    init_node("known_room_test")
    rostest.rosrun("yarm", "known_room", KnownRoomTest, sys.argv)
