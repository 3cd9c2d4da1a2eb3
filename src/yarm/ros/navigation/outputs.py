"""What move_base says: velocities, costmaps, plans; costmaps and plans are made when somebody listens."""

from __future__ import annotations

from typing import Hashable, Optional, Tuple

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import OccupancyGrid, Path

from yarm.geometry import FloatArray, Pose2
from yarm.msg import StepAck
from yarm.navigation.costmap import inflated, window
from yarm.navigation.follower import Drive
from yarm.navigation.grid_map import GridMap
from yarm.ros.common import names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose_message
from yarm.ros.navigation.maps import grid_message
from yarm.ros.navigation.params import MoveBaseNodeParams

STEP_M = 0.05
"""Between two poses of a plan."""


class MoveBaseOutputs:
    """Publishers; called from the loop alone."""

    def __init__(self, params: MoveBaseNodeParams) -> None:
        """Advertise everything."""
        self._params = params
        self._velocity = rospy.Publisher(names.mux_input("navi"), Twist, queue_size=10, tcp_nodelay=True)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._global = rospy.Publisher("~global_costmap/costmap", OccupancyGrid, queue_size=1, latch=True)
        self._local = rospy.Publisher("~local_costmap/costmap", OccupancyGrid, queue_size=1, latch=True)
        self._plan = rospy.Publisher("~NavfnROS/plan", Path, queue_size=1, latch=True)
        self._ahead = rospy.Publisher("~local_plan", Path, queue_size=1)
        self._goal = rospy.Publisher("~current_goal", PoseStamped, queue_size=1, latch=True)
        self.forget()

    def forget(self) -> None:
        """Time went backwards: nothing has been said."""
        self._sent = 0
        self._costmap_s = -1.0
        self._drawn: Hashable = None
        self._path: FloatArray = np.zeros((0, 2))

    def connected(self) -> bool:
        """Somebody hears the commands and the acknowledgements."""
        return all(int(publisher.get_num_connections()) > 0 for publisher in (self._velocity, self._ack))

    def velocity(self, drive: Drive) -> None:
        """What the base is told."""
        message = Twist()
        message.linear.x, message.angular.z = drive.v_mps, drive.w_radps
        self._velocity.publish(message)
        self._sent += 1

    def acknowledge(self, stamp: rospy.Time) -> None:
        """Lock-step: this pass is done."""
        if self._params.sync:
            self._ack.publish(step_ack(stamp, self._sent))

    def goal(self, goal: Pose2, stamp: rospy.Time) -> None:
        """What is driven to."""
        self._goal.publish(stamped_pose(goal, self._params.map_frame, stamp))

    def plans(self, path: FloatArray, ahead: FloatArray, goal: Optional[Pose2], stamp: rospy.Time) -> None:
        """The way as it was planned, when it is another, and what is left of it."""
        if path is not self._path and len(path):
            self._path = path
            self._plan.publish(path_message(path, goal, self._params.map_frame, stamp))
        if len(ahead) and self._ahead.get_num_connections():
            self._ahead.publish(path_message(ahead, goal, self._params.map_frame, stamp))

    def costmaps(self, grid: GridMap, version: Tuple[int, ...], pose: Optional[Pose2], stamp: rospy.Time) -> None:
        """Both costmaps, not too often and when they have changed."""
        listeners = (self._global.get_num_connections(), self._local.get_num_connections())
        now_s = stamp.to_sec()
        if not any(listeners) or 0.0 <= now_s - self._costmap_s < 1.0 / self._params.publish_frequency:
            return
        self._costmap_s = now_s
        drawn = (version, listeners)
        if drawn != self._drawn:
            self._drawn = drawn
            self._global.publish(self._message(grid, stamp))
        if pose is not None:
            self._local.publish(self._message(window(grid, pose, self._params.local_width), stamp))

    def _message(self, grid: GridMap, stamp: rospy.Time) -> OccupancyGrid:
        p = self._params
        values = inflated(grid, p.robot_radius, p.inflation_radius, p.cost_scaling_factor)
        return grid_message(GridMap(values, grid.resolution_m, grid.origin), p.map_frame, stamp)


def stamped_pose(pose: Pose2, frame: str, stamp: rospy.Time) -> PoseStamped:
    """A pose in a frame."""
    made = PoseStamped(pose=pose_message(pose.x, pose.y, 0.0, pose.yaw_rad))
    made.header.frame_id, made.header.stamp = frame, stamp
    return made


def path_message(path: FloatArray, goal: Optional[Pose2], frame: str, stamp: rospy.Time) -> Path:
    """A way (n, 2) as poses every 0.05 m that look along it; the last one looks as the goal does."""
    made = Path()
    made.header.frame_id, made.header.stamp = frame, stamp
    if len(path) == 0:
        return made
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    count = int(np.ceil(along[-1] / STEP_M)) + 1
    marks = np.union1d(np.linspace(0.0, along[-1], count), along)
    points = np.stack([np.interp(marks, along, path[:, i]) for i in range(2)], axis=1)
    steps = np.diff(points, axis=0)
    yaws = [float(yaw) for yaw in np.arctan2(steps[:, 1], steps[:, 0])]
    yaws.append(goal.yaw_rad if goal is not None else (yaws[-1] if yaws else 0.0))
    for (x, y), yaw in zip(points, yaws):
        made.poses.append(stamped_pose(Pose2(float(x), float(y), yaw), frame, stamp))
    return made
