#!/usr/bin/env python3
"""slam_gmapping in the simulated room: a tour in lock-step, driven by the truth; its map and its poses after it."""

from __future__ import annotations

import math
import sys
import threading
import time
import unittest
from pathlib import Path
from typing import Dict, List, Optional, Tuple

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage
from yarm.msg import StepAck

from yarm.experiments.explore.judge import Judge
from yarm.geometry import Pose2, wrap_angle, yaw_of_quaternion
from yarm.resources import resource
from yarm.ros.common import api_rooms, names
from yarm.ros.common.acks import step_ack
from yarm.ros.common.conversions import pose2_of_pose
from yarm.ros.common.start import init_node
from yarm.ros.navigation.maps import grid_of
from yarm.sim.scenes.arena import load_arena

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support.links import linked

LIMIT_S = 700.0
PASS_NS = 100_000_000
ARENA = load_arena(resource("test", "ros", "room_arena.yaml"))
STOPS = ((-0.1, 0.1), (-0.2, 1.0), (-1.0, 1.0), (-0.6, -0.2), (0.9, -0.2))
"""Places of the tour, world, metres; at each the robot turns once round."""
SPEED_MPS, TURN_RADPS = 0.2, 0.6


class Tour:
    """From stop to stop by the true pose, a full turn at each."""

    def __init__(self) -> None:
        self._stops = list(STOPS)
        self._left_rad, self._last_rad = 0.0, ARENA.start.yaw_rad

    @property
    def done(self) -> bool:
        return not self._stops and self._left_rad <= 0.0

    def step(self, pose: Pose2) -> Tuple[float, float]:
        turned = wrap_angle(pose.yaw_rad - self._last_rad)
        self._last_rad = pose.yaw_rad
        if self._left_rad > 0.0:
            self._left_rad -= max(turned, 0.0)
            return 0.0, TURN_RADPS
        if not self._stops:
            return 0.0, 0.0
        x, y = self._stops[0]
        if math.hypot(x - pose.x, y - pose.y) < 0.05:
            self._stops.pop(0)
            self._left_rad = 2.0 * math.pi
            return 0.0, 0.0
        error = wrap_angle(math.atan2(y - pose.y, x - pose.x) - pose.yaw_rad)
        turn = min(max(2.0 * error, -TURN_RADPS), TURN_RADPS)
        return (SPEED_MPS if abs(error) < 0.3 else 0.0), turn


class Driver:
    """The lock-step's participant: answers each pass with a command, and keeps what is said of the pose."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.tour = Tour()
        self.truths: Dict[int, Pose2] = {}
        self.beliefs: Dict[int, Pose2] = {}
        self.odometry: Dict[int, Pose2] = {}
        self.map: Optional[OccupancyGrid] = None
        self.maps_after_done = 0
        self._ready, self._answered_ns, self._sent = False, -1, 0
        self._velocity = rospy.Publisher(names.TELEOP, Twist, queue_size=10, tcp_nodelay=True)
        self._ack = rospy.Publisher(names.STEP_ACK, StepAck, queue_size=100, tcp_nodelay=True)
        self._subscribers = [
            rospy.Subscriber("/clock", Clock, self._on_clock, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber(names.SIM_POSE, Odometry, self._on_truth, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber("/tf", TFMessage, self._on_tf, queue_size=100, tcp_nodelay=True),
            rospy.Subscriber(names.MAP, OccupancyGrid, self._on_map, queue_size=1),
        ]
        self._now_ns = -1

    def run(self) -> None:
        """Answer passes until the tour is over and a map has come after it."""
        end = time.monotonic() + LIMIT_S
        with self.changed:
            while not (self.tour.done and self.maps_after_done > 0):
                assert time.monotonic() < end, f"the tour did not end in {LIMIT_S:.0f} s; at {self._now_ns / 1e9:.2f} s"
                self._answer()
                self.changed.wait(0.2)

    def _answer(self) -> None:
        now_ns = self._now_ns
        if now_ns < 0 or now_ns % PASS_NS or now_ns not in self.truths:
            return
        self._ready = self._ready or linked(api_rooms.MUX, names.BASE_VELOCITY, api_rooms.ROOM)
        if not self._ready or not (self._velocity.get_num_connections() and self._ack.get_num_connections()):
            return
        if now_ns != self._answered_ns:
            command = Twist()
            command.linear.x, command.angular.z = self.tour.step(self.truths[now_ns])
            self._velocity.publish(command)
            self._sent += 1
            self._answered_ns = now_ns
            self._ack.publish(step_ack(rospy.Time(0, now_ns), self._sent))

    def _on_clock(self, message: Clock) -> None:
        with self.changed:
            self._now_ns = message.clock.to_nsec()
            self.changed.notify_all()

    def _on_truth(self, message: Odometry) -> None:
        with self.changed:
            self.truths[message.header.stamp.to_nsec()] = pose2_of_pose(message.pose.pose)
            self.changed.notify_all()

    def _on_tf(self, message: TFMessage) -> None:
        with self.changed:
            for found in message.transforms:
                t, r = found.transform.translation, found.transform.rotation
                pose = Pose2(t.x, t.y, yaw_of_quaternion((r.x, r.y, r.z, r.w)))
                kept = {"base_footprint": self.odometry, "odom": self.beliefs}.get(found.child_frame_id)
                if kept is not None:
                    kept[found.header.stamp.to_nsec()] = pose

    def _on_map(self, message: OccupancyGrid) -> None:
        with self.changed:
            self.map = message
            self.maps_after_done += int(self.tour.done)
            self.changed.notify_all()


class RoomSlamTest(unittest.TestCase):
    """One tour; then its map and its poses."""

    def test_map_and_pose_against_the_truth(self) -> None:
        driver = Driver()
        driver.run()
        off: List[float] = []
        turned: List[float] = []
        with driver.changed:  # its subscribers hear on
            for stamp, T_map_odom in driver.beliefs.items():
                if stamp in driver.truths and stamp in driver.odometry:
                    believed = ARENA.start.compose(T_map_odom).compose(driver.odometry[stamp])
                    off.append(believed.distance(driver.truths[stamp]))
                    turned.append(wrap_angle(believed.yaw_rad - driver.truths[stamp].yaw_rad))
        self.assertGreater(len(off), 600)
        rmse = float(np.sqrt(np.mean(np.square(off))))
        heading = float(np.sqrt(np.mean(np.square(turned))))
        judge = Judge(ARENA)
        grid = grid_of(driver.map)
        error = judge.wall_error(judge.occupied_points(grid, ARENA.start))
        share = judge.share(grid, ARENA.start)
        rospy.loginfo("%d poses, RMSE %.1f mm, %.2f deg", len(off), 1e3 * rmse, math.degrees(heading))
        rospy.loginfo("%s, share %.3f", error, share)
        self.assertLess(rmse, 0.03)
        self.assertLess(heading, 0.02)
        self.assertLess(error.mean_m, 0.03)
        self.assertLess(error.spurious, 0.01)
        self.assertGreater(share, 0.8)


if __name__ == "__main__":
    init_node("room_driver")
    rostest.rosrun("yarm", "room_slam", RoomSlamTest)
