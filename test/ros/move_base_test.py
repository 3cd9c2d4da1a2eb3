#!/usr/bin/env python3
"""move_base as its clients see it, in a simulated room."""

from __future__ import annotations

import math
import pathlib
import subprocess
import sys
from typing import Any, List

import actionlib
import numpy as np
import rospy
import rostest
import tf2_ros
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from move_base_msgs.msg import MoveBaseAction, MoveBaseActionResult, MoveBaseGoal
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty
from yarm.msg import Contacts

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from support.listening import ListeningTest
from yarm.geometry import Pose2, wrap_angle
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import GridMap
from yarm.navigation.path_check import check_path
from yarm.resources import resource
from yarm.ros.common import names
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_message
from yarm.ros.navigation.outputs import stamped_pose
from yarm.ros.rooms.messages import transform
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import load_arena

LIMIT_S = 60.0
ARENA = load_arena(resource("test", "ros", "move_base_room.yaml"))


def known_map(margin: int = 4) -> GridMap:
    """Walls and screen in a map that reaches so many cells beyond the room."""
    side = round((ARENA.upper[0] - ARENA.lower[0]) / 0.05) + 2 * margin
    corner = Pose2(ARENA.lower[0] - 0.05 * margin, ARENA.lower[1] - 0.05 * margin)
    empty = GridMap(np.zeros((side, side), np.int8), 0.05, corner)
    return with_bodies(empty, list(FlatBoxes(ARENA.blocks).corners()))


def target(x: float, y: float, yaw: float = 0.0, frame: str = "map") -> PoseStamped:
    return stamped_pose(Pose2(x, y, yaw), frame, rospy.Time(0))


class MoveBaseTest(ListeningTest):
    """One launch serves every check; they run in the order of their names, the restart last."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.passes_scans, cls.sends_tf = True, True
        cls.scan = rospy.Publisher(names.SCAN, LaserScan, queue_size=5, tcp_nodelay=True)
        cls.map = rospy.Publisher(names.MAP, OccupancyGrid, queue_size=1, latch=True)
        cls.simple = rospy.Publisher(names.SIMPLE_GOAL, PoseStamped, queue_size=1)
        cls.broadcaster = tf2_ros.TransformBroadcaster()
        rospy.Subscriber("scan_raw", LaserScan, cls.pass_on, queue_size=5, buff_size=1 << 20, tcp_nodelay=True)
        cls.listen(
            ("/clock", Clock), (names.SIM_POSE, Odometry), (names.SIM_CONTACTS, Contacts),
            (names.mux_input("navi"), Twist), ("move_base/result", MoveBaseActionResult),
            ("move_base/NavfnROS/plan", Path), ("move_base/local_plan", Path),
            ("move_base/global_costmap/costmap", OccupancyGrid), ("move_base/local_costmap/costmap", OccupancyGrid),
        )  # fmt: skip
        cls.client, cls.other = (actionlib.SimpleActionClient(names.MOVE_BASE, MoveBaseAction) for _ in range(2))
        assert all(client.wait_for_server(rospy.Duration(LIMIT_S)) for client in (cls.client, cls.other))
        for service in ("make_plan", "NavfnROS/make_plan", "clear_costmaps", "clear_unknown_space"):
            rospy.wait_for_service(names.move_base(service), LIMIT_S)
        cls.make_plan = rospy.ServiceProxy(names.move_base("make_plan"), GetPlan)

    @classmethod
    def pass_on(cls, message: LaserScan) -> None:
        if cls.sends_tf:
            cls.broadcaster.sendTransform(transform("map", "odom", Pose2(0.0, 0.0), message.header.stamp))
        if cls.passes_scans:
            cls.scan.publish(message)

    def here(self) -> Pose2:
        return pose2_of_pose(self.fresh(names.SIM_POSE).pose.pose)

    def send(self, goal: PoseStamped, **callbacks: Any) -> None:
        self.client.send_goal(MoveBaseGoal(target_pose=goal), **callbacks)

    def result(self) -> str:
        """The end of the goal: state and text."""
        self.assertTrue(self.client.wait_for_result(rospy.Duration(120.0)), "no result")
        return f"{GoalStatus.to_string(self.client.get_state())}: {self.client.get_goal_status_text()}"

    def plan(self, start: PoseStamped, goal: PoseStamped, tolerance: float = 0.0) -> np.ndarray:
        found = self.make_plan(start, goal, tolerance).plan
        return np.array([(p.pose.position.x, p.pose.position.y) for p in found.poses]).reshape(-1, 2)

    def moving(self) -> None:
        self.wait(lambda: self.kept[names.SIM_POSE][-1].twist.twist.linear.x > 0.1, "the robot drives")

    def standing(self) -> None:
        def rests() -> bool:
            twist = self.kept[names.SIM_POSE][-1].twist.twist
            return abs(twist.linear.x) < 0.005 and abs(twist.angular.z) < 0.02

        self.wait(rests, "the robot stands")

    def touched(self) -> List[str]:
        contacts = [contact for message in self.kept[names.SIM_CONTACTS] for contact in message.contacts]
        return [f"{c.body_a}-{c.body_b}" for c in contacts if c.kind == "failure"]

    def test_a_without_a_map_nothing_moves_and_the_map_is_named(self) -> None:
        self.send(target(0.5, 0.0))
        self.assertIn("ABORTED: there is no map", self.result())
        self.assertEqual(len(self.plan(target(0.0, 0.0), target(1.0, 0.0))), 0)

    def test_b_a_goal_behind_the_screen_is_reached(self) -> None:
        self.map.publish(grid_message(known_map(), "map", rospy.Time.now()))
        self.wait(lambda: self.kept["move_base/global_costmap/costmap"], "a costmap")
        places: List[PoseStamped] = []
        self.send(target(1.5, 0.6, math.pi / 2), feedback_cb=lambda f: places.append(f.base_position))
        self.assertIn("SUCCEEDED: goal reached", self.result())
        self.assertLess(self.here().distance(Pose2(1.5, 0.6)), 0.15 + 0.02)
        self.assertLess(abs(self.here().yaw_rad - math.pi / 2), 0.3 + 0.05)
        self.standing()
        self.assertEqual(self.touched(), [])
        self.assertGreater(len(places), 10)
        self.assertEqual(places[-1].header.frame_id, "map")
        speeds = [message.linear.x for message in self.kept[names.mux_input("navi")]]
        self.assertLessEqual(max(speeds), 0.3)
        path = self.kept["move_base/NavfnROS/plan"][-1]
        end = path.poses[-1].pose.position
        self.assertLess(math.hypot(end.x - 1.5, end.y - 0.6), 0.05)
        self.wait(lambda: self.kept["move_base/local_plan"], "a local plan")
        local = self.wait(lambda: self.kept["move_base/local_costmap/costmap"], "a local costmap")[-1]
        whole = self.kept["move_base/global_costmap/costmap"][-1]
        self.assertLessEqual(local.info.width, 82)
        self.assertEqual((whole.header.frame_id, max(whole.data)), ("map", 100))

    def test_c_plans_are_made_while_driving_and_a_cancel_stops_it(self) -> None:
        self.send(target(-1.4, -1.4))
        self.moving()
        for service in ("make_plan", "NavfnROS/make_plan"):
            self.make_plan = rospy.ServiceProxy(names.move_base(service), GetPlan)
            path = self.plan(target(-1.0, 1.0), target(1.5, 1.0))
            self.assertTrue(check_path(known_map(), path, 0.2).clear)
            self.assertLess(np.abs(path[[0, -1]] - ((-1.0, 1.0), (1.5, 1.0))).max(), 1e-6)
        self.client.cancel_goal()
        self.assertIn("PREEMPTED", self.result())
        self.standing()
        here = self.here()
        self.assertGreater(here.distance(Pose2(-1.4, -1.4)), 0.3)
        from_here = self.plan(PoseStamped(), target(1.0, -1.0))[0]
        self.assertLess(math.hypot(from_here[0] - here.x, from_here[1] - here.y), 0.05)
        self.assertEqual(len(self.plan(PoseStamped(), target(0.8, 0.6))), 0)
        self.assertGreater(len(self.plan(PoseStamped(), target(0.8, 0.6), 0.8)), 0)

    def test_d_a_new_goal_takes_over_also_one_in_the_robots_frame(self) -> None:
        ended: List[int] = []
        self.send(target(-1.4, -1.4), done_cb=lambda state, _: ended.append(state))
        self.moving()
        places: List[PoseStamped] = []
        goal = MoveBaseGoal(target_pose=target(0.0, 0.0, 0.5, "base_footprint"))
        self.other.send_goal(goal, feedback_cb=lambda f: places.append(f.base_position))
        self.assertTrue(self.other.wait_for_result(rospy.Duration(60.0)))
        self.assertEqual(self.other.get_state(), GoalStatus.SUCCEEDED)
        self.assertIn("PREEMPTED: cancelled: another goal has come", self.result())
        taken = pose2_of_pose(places[0].pose)
        self.assertLess(self.here().distance(taken), 0.25)
        self.assertLess(abs(wrap_angle(self.here().yaw_rad - taken.yaw_rad - 0.5)), 0.4)

    def test_e_what_cannot_be_a_goal_is_refused_and_named(self) -> None:
        for bad, named in (
            (target(math.nan, 0.0), "must be finite"),
            (target(0.5, 0.0, frame="moon"), "its frame 'moon'"),
            (target(0.5, 0.0, frame=""), "it has no frame"),
        ):
            self.send(bad)
            self.assertRegex(self.result(), f"ABORTED: goal refused: .*{named}")
        zero = target(0.5, 0.0)
        zero.pose.orientation.w = 0.0
        self.send(zero)
        self.assertRegex(self.result(), "ABORTED: goal refused: quaternion .* must have length 1")

    def test_f_a_goal_inside_the_screen_is_given_up_and_named(self) -> None:
        self.send(target(0.8, 0.6))
        self.assertIn("ABORTED: the goal (0.80, 0.60) lies inside an obstacle", self.result())
        self.standing()

    def test_g_a_goal_from_rviz_is_driven_to(self) -> None:
        self.kept["move_base/result"].clear()
        self.wait(lambda: self.simple.get_num_connections() > 0, "a listener to goals")
        self.simple.publish(target(0.0, -1.0))
        ended = self.wait(lambda: self.kept["move_base/result"], "a result")[0]
        self.assertEqual(ended.status.status, GoalStatus.SUCCEEDED, ended.status.text)
        self.assertLess(self.here().distance(Pose2(0.0, -1.0)), 0.17)

    def test_h_a_silent_scan_and_a_lost_transform_stop_it_and_are_named(self) -> None:
        for fault, named in (("passes_scans", "the newest scan is"), ("sends_tf", "transform map -> odom")):
            self.send(target(-1.4, 1.4 if fault == "sends_tf" else -1.4))
            self.moving()
            setattr(type(self), fault, False)
            self.standing()
            self.assertRegex(self.result(), f"ABORTED: .*{named}.*waited 5 s")
            setattr(type(self), fault, True)

    def test_i_a_map_of_another_size_under_way_is_taken(self) -> None:
        self.send(target(1.4, -1.4))
        self.moving()
        self.map.publish(grid_message(known_map(11), "map", rospy.Time.now()))
        self.assertIn("SUCCEEDED", self.result())
        wider = known_map(11).columns
        self.wait(lambda: self.kept["move_base/global_costmap/costmap"][-1].info.width == wider, "the wider costmap")
        self.assertLess(self.here().distance(Pose2(1.4, -1.4)), 0.17)

    def test_j_costmaps_are_cleared_on_request(self) -> None:
        for service in ("clear_costmaps", "clear_unknown_space"):
            rospy.ServiceProxy(names.move_base(service), Empty)()
        self.assertGreater(len(self.plan(PoseStamped(), target(1.5, 1.5))), 0)

    def test_k_a_restart_of_the_simulation_ends_the_goal_and_the_next_one_is_driven(self) -> None:
        self.send(target(-1.5, -1.0))
        self.moving()
        late_s = self.kept["/clock"][-1].clock.to_sec()
        subprocess.run(["rosnode", "kill", "/room_simulation"], check=True, capture_output=True, timeout=LIMIT_S)
        self.wait(lambda: self.kept["/clock"][-1].clock.to_sec() < late_s - 5.0, "time from the beginning")
        self.wait(lambda: self.kept[names.SIM_POSE][-1].header.stamp.to_sec() < late_s - 5.0, "the new room's truth")
        with self.changed:
            del self.kept[names.SIM_POSE][:-1]
        texts = [message.status.text for message in self.kept["move_base/result"]]
        self.wait(lambda: "simulated time went backwards" in [m.status.text for m in self.kept["move_base/result"]],
                  f"the end of the goal; {texts[-3:]}")  # fmt: skip
        self.client = actionlib.SimpleActionClient(names.MOVE_BASE, MoveBaseAction)
        self.assertTrue(self.client.wait_for_server(rospy.Duration(LIMIT_S)))
        self.send(target(-0.8, 0.0))
        self.assertIn("SUCCEEDED", self.result())
        self.assertLess(self.here().distance(Pose2(-0.8, 0.0)), 0.17)


if __name__ == "__main__":
    init_node("move_base_test")
    rostest.rosrun("yarm", "move_base_clients", MoveBaseTest, sys.argv)
