#!/usr/bin/env python3
"""Node amcl: its pose against the truth from nothing and from a rough pose, AMCL's interface, sick inputs."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import List, Optional, Tuple

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import SetMap
from std_msgs.msg import Bool, String
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

from yarm.ros.common.start import init_node

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from support import slam_log
from support.scan_player import LIMIT_S, MOUNT, UNKNOWN, ScanPlayer, transform

PROGRAMS = Path(os.environ["CMAKE_PREFIX_PATH"].split(os.pathsep)[0]) / "lib" / "yarm"
ROOM, TURN, SCANS = 2, 160, 500
RESOLUTION = 0.05
CORNER: slam_log.Pose = (-0.27, -0.26, 0.0)


def map_of(tour: slam_log.Tour) -> OccupancyGrid:
    """The room as a map: cells that a surface passes through are occupied, the rest is free."""
    message = OccupancyGrid()
    message.header.frame_id, message.info.resolution = "map", RESOLUTION
    message.info.width = message.info.height = size = 131
    set_origin(message, CORNER)
    cells = np.zeros((size, size), np.int8)
    share = np.linspace(0.0, 1.0, 2000)[:, None]
    for surface in tour.surfaces:
        points = surface[:2] + share * (surface[2:] - surface[:2])
        columns, rows = np.floor((points - CORNER[:2]) / RESOLUTION).astype(int).T
        cells[rows, columns] = 100
    message.data = cells.ravel().tolist()
    return message


def set_origin(message: OccupancyGrid, origin: slam_log.Pose) -> None:
    message.info.origin.position.x, message.info.origin.position.y = origin[:2]
    message.info.origin.orientation.z = math.sin(origin[2] / 2.0)
    message.info.origin.orientation.w = math.cos(origin[2] / 2.0)


def planar(pose) -> slam_log.Pose:
    return pose.position.x, pose.position.y, 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)


def belief(pose: slam_log.Pose, sigma_m: float = 0.5, sigma_rad: float = math.pi / 12.0) -> PoseWithCovarianceStamped:
    message = PoseWithCovarianceStamped()
    message.header.frame_id = "map"
    message.pose.pose.position.x, message.pose.pose.position.y = pose[:2]
    message.pose.pose.orientation.z = math.sin(pose[2] / 2.0)
    message.pose.pose.orientation.w = math.cos(pose[2] / 2.0)
    message.pose.covariance = [0.0] * 36
    message.pose.covariance[0] = message.pose.covariance[7] = sigma_m**2
    message.pose.covariance[35] = sigma_rad**2
    return message


def apart(a: slam_log.Pose, b: slam_log.Pose) -> Tuple[float, float]:
    return math.hypot(a[0] - b[0], a[1] - b[1]), abs(math.remainder(a[2] - b[2], 2.0 * math.pi))


class Player(ScanPlayer):
    """A player that knows a scan is done with by the cloud of its stamp."""

    def __init__(self) -> None:
        super().__init__("amcl: localisation")
        self.clouds: List[PoseArray] = self.hear("particlecloud", PoseArray)
        self.poses: List[PoseWithCovarianceStamped] = self.hear("amcl_pose", PoseWithCovarianceStamped)
        self.localised: List[Bool] = self.hear("amcl/localised", Bool)
        self.reasons: List[String] = self.hear("amcl/reason", String)
        self.states: List[DiagnosticArray] = self.hear("amcl/state", DiagnosticArray)
        self.map = rospy.Publisher("map", OccupancyGrid, queue_size=1, latch=True)
        self.initial = rospy.Publisher("initialpose", PoseWithCovarianceStamped, queue_size=2)

    def offer(self, moment: slam_log.Moment) -> None:
        """Send one moment and wait until the node has taken it."""
        self.send(moment)
        self.wait(
            f"a cloud of {moment.stamp_ns} ns",
            lambda: bool(self.clouds) and self.clouds[-1].header.stamp.to_nsec() == moment.stamp_ns,
        )
        self.wait(f"a state of {moment.stamp_ns} ns", lambda: self.state_of(moment) is not None)

    def state_of(self, moment: slam_log.Moment) -> Optional[DiagnosticArray]:
        """What the node says became of a moment."""
        return next((s for s in reversed(self.states) if s.header.stamp.to_nsec() == moment.stamp_ns), None)

    def forget_answers(self) -> None:
        with self.changed:
            self.clouds.clear()
            self.poses.clear()
            self.states.clear()
            self.T_map_odom = UNKNOWN

    def is_localised(self) -> bool:
        """The node's last word."""
        return bool(self.localised) and self.localised[-1].data

    def until_localised(self, moments: List[slam_log.Moment]) -> int:
        """Play until the node says that it is; number of the last moment played."""
        for i, moment in enumerate(moments):
            self.offer(moment)
            if self.state_of(moment).status[0].level == DiagnosticStatus.OK:
                self.wait("the same word for people", self.is_localised)
                self.wait("pose and transform of that moment", lambda now=moment: self.is_sure(now))
                return i
        raise AssertionError(f"not localised: {self.reasons[-1].data}")

    def is_sure(self, moment: slam_log.Moment) -> bool:
        """Whether pose and transform of a moment have come, and the pose is sure to 0.1 m."""
        if not self.poses or self.poses[-1].header.stamp.to_nsec() != moment.stamp_ns:
            return False
        variances = self.poses[-1].pose.covariance
        return max(variances[0], variances[7]) < 0.1**2 and self.T_map_odom[0] == moment.stamp_ns


class AmclTest(unittest.TestCase):
    player: Player
    tour: slam_log.Tour

    @classmethod
    def setUpClass(cls) -> None:
        with tempfile.TemporaryDirectory() as folder:
            cls.tour = slam_log.record(PROGRAMS / "slam_world_log", ROOM, SCANS, Path(folder) / "tour.txt", boxes=True)
        cls.player = Player()
        cls.player.connect()
        cls.player.static.publish(
            TFMessage([transform("base_footprint", "camera_depth_frame", MOUNT, rospy.Time(0), 0.297)])
        )
        cls.player.tick(cls.tour.moments[0].stamp_ns - 500_000_000)

    def start_again(self) -> None:
        """Time goes back: the node forgets where it was, and the player what it heard: stamps come again."""
        self.player.forget_health()
        self.player.tick(self.tour.moments[0].stamp_ns - 500_000_000)
        self.player.wait_for_health("no scan could be taken yet")
        self.player.forget_answers()

    def check(self, moment: slam_log.Moment, truth: slam_log.Pose, most_m: float = 0.06) -> None:
        """amcl_pose, tf and cloud against the truth."""
        off_m, off_rad = apart(planar(self.player.poses[-1].pose.pose), truth)
        self.assertLess(off_m, most_m)
        self.assertLess(off_rad, 0.03)
        by_tf = slam_log.compose(self.player.T_map_odom[1], moment.odometry)
        self.assertLess(apart(by_tf, planar(self.player.poses[-1].pose.pose))[0], 1e-6)
        cloud = [apart(planar(pose), truth)[0] for pose in self.player.clouds[-1].poses]
        self.assertEqual(len(cloud), 50)
        self.assertLess(np.median(cloud), 0.1)

    def test_1_without_a_map(self) -> None:
        self.player.wait_for_health("map: no map yet", "scan: nothing heard yet, 1 publishers")
        rospy.wait_for_service("global_localization", LIMIT_S)
        for name in ("global_localization", "request_nomotion_update"):
            with self.assertRaises(rospy.ServiceException):
                rospy.ServiceProxy(name, Empty)()
        self.player.send(self.tour.moments[0])
        self.player.wait_for_health("1 scans dropped: no map has come yet")
        self.player.initial.publish(belief((1.0, 1.0, 0.0)))
        self.player.wait_for_health("initialpose refused: no map has come yet")

    def test_2_sick_maps(self) -> None:
        for change, words in (
            (lambda m: setattr(m.header, "frame_id", "odom"), "its frame is 'odom'"),
            (lambda m: setattr(m, "data", m.data[:-1]), "cells for 131 x 131"),
            (lambda m: setattr(m.info, "resolution", 0.0), "its cells are 0.0"),
            (lambda m: setattr(m.info.origin.orientation, "w", 9.0), "its origin cannot be used"),
            (lambda m: setattr(m, "data", [0] * len(m.data)), "0 cells of surfaces"),
        ):
            sick = map_of(self.tour)
            change(sick)
            self.player.map.publish(sick)
            self.player.wait_for_health("map refused", words)

    def test_3_from_nothing_after_one_turn(self) -> None:
        self.player.map.publish(map_of(self.tour))
        self.player.wait_for_health("not localised: no pose is known")
        first = self.tour.moments[1]
        self.player.offer(first)
        state = self.player.state_of(first)
        self.assertEqual((state.header.frame_id, state.status[0].level), ("", DiagnosticStatus.WARN))
        self.assertIn("no pose is known", state.status[0].message)
        spread = np.std([planar(pose)[0] for pose in self.player.clouds[-1].poses])
        self.assertGreater(spread, 1.0)
        last = 2 + self.player.until_localised(self.tour.moments[2:TURN])
        self.assertGreater(last, 140)
        state = self.player.state_of(self.tour.moments[last])
        self.assertEqual((state.header.frame_id, state.status[0].message), ("map", ""))
        self.player.wait("no reason against it", lambda: self.player.reasons[-1].data == "")
        self.check(self.tour.moments[last], self.tour.moments[last].truth)
        off = []
        for moment in self.tour.moments[last + 1 :]:
            self.player.offer(moment)
            self.player.wait("its transform", lambda stamp=moment.stamp_ns: self.player.T_map_odom[0] == stamp)
            off.append(apart(slam_log.compose(self.player.T_map_odom[1], moment.odometry), moment.truth)[0])
        rospy.loginfo("room %d: RMSE %.1f mm", ROOM, 1e3 * float(np.sqrt(np.mean(np.square(off)))))
        self.assertLess(float(np.sqrt(np.mean(np.square(off)))), 0.03)
        self.assertTrue(self.player.is_localised())

    def test_4_an_update_without_motion_on_request_only(self) -> None:
        last = self.tour.moments[-1]
        standing = [
            slam_log.Moment(last.stamp_ns + i * 100_000_000, last.odometry, last.truth, last.ranges)
            for i in range(1, 6)
        ]
        for moment in standing[:3]:
            self.player.offer(moment)
        rospy.ServiceProxy("request_nomotion_update", Empty)()
        self.player.offer(standing[3])
        asked_ns = standing[3].stamp_ns
        stamps = [moment.stamp_ns for moment in standing]
        self.player.wait("a pose", lambda: self.player.poses[-1].header.stamp.to_nsec() == asked_ns)
        heard = [pose.header.stamp.to_nsec() for pose in self.player.poses]
        self.assertEqual([stamp for stamp in heard if stamp in stamps], [asked_ns])

    def test_5_from_a_rough_pose(self) -> None:
        self.start_again()
        x, y, yaw = self.tour.moments[0].truth
        for change, words in (
            (lambda m: setattr(m.header, "frame_id", "odom"), "its frame is 'odom'"),
            (lambda m: setattr(m.pose.pose.position, "x", math.nan), "must be finite"),
            (lambda m: setattr(m.pose.pose.orientation, "w", 0.0), "quaternion of length 1"),
            (lambda m: setattr(m.pose, "covariance", [-1.0] * 36), "negative direction"),
        ):
            sick = belief((x, y, 0.0))
            change(sick)
            self.player.initial.publish(sick)
            self.player.wait_for_health("initialpose refused", words)
        self.player.initial.publish(belief((x + 0.3, y - 0.4, yaw + 0.5)))
        self.player.forget_health()
        self.player.offer(self.tour.moments[0])
        self.player.wait_for_health("not localised", "not yet confirmed")
        last = 1 + self.player.until_localised(self.tour.moments[1:TURN])
        self.assertLess(last, 140)
        self.check(self.tour.moments[last], self.tour.moments[last].truth)
        self.player.wait("the word that it is localised", self.player.is_localised)

    def test_6_global_localization_forgets(self) -> None:
        stamp = self.player.T_map_odom[0]
        rospy.ServiceProxy("global_localization", Empty)()
        self.player.offer(self.tour.moments[TURN])
        self.player.wait("the word that it is not localised", lambda: not self.player.is_localised())
        self.player.offer(self.tour.moments[TURN + 1])
        self.assertEqual(self.player.T_map_odom[0], stamp)
        self.player.wait("why not", lambda: "turn round once" in self.player.reasons[-1].data)

    def test_7_set_map_with_a_turned_origin(self) -> None:
        self.start_again()
        set_map = rospy.ServiceProxy("set_map", SetMap)
        sick = map_of(self.tour)
        sick.info.width = 7
        self.assertFalse(set_map(sick, belief((0.0, 0.0, 0.0))).success)
        turned = map_of(self.tour)
        origin = (2.0, -1.0, 0.8)
        set_origin(turned, origin)
        T_map_room = slam_log.compose(origin, slam_log.inverse(CORNER))
        truth = slam_log.compose(T_map_room, self.tour.moments[0].truth)
        self.assertTrue(set_map(turned, belief((truth[0] + 0.2, truth[1] + 0.2, truth[2] - 0.2))).success)
        last = self.player.until_localised(self.tour.moments[:TURN])
        self.check(self.tour.moments[last], slam_log.compose(T_map_room, self.tour.moments[last].truth))

    def test_8_wrong_parameters_are_refused_all_at_once(self) -> None:
        command = [str(PROGRAMS / "amcl"), "__name:=amcl_wrong", "_update_min_d:=-1.0", "_kld_err:=many", "_alpha:=1"]
        done = subprocess.run(
            command, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=LIMIT_S
        )
        self.assertEqual(done.returncode, 1, done.stdout)
        for part in ("update_min_d = -1", "0 to 10 m", "kld_err = many", "alpha: unknown parameter"):
            self.assertIn(part, done.stdout)

    def test_9_parameters_without_effect_are_named(self) -> None:
        command = [str(PROGRAMS / "amcl"), "__name:=amcl_idle", "_kld_err:=0.5", "_odom_model_type:=omni"]
        command += ["_std_warn_level_x:=0.5", "_bag_scan_period:=-1.0"]
        named = "kld_err, odom_model_type, std_warn_level_x"
        said = f"set, but without effect here (they are for AMCL's particle filter and tools): {named}"
        elsewhere = [f"{name}:=idle/{name}" for name in ("scan", "map", "global_localization")]
        child = subprocess.Popen([*command, *elsewhere], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            rospy.wait_for_service("idle/global_localization", timeout=LIMIT_S)
        finally:
            # Told to end, not killed: what it has said is in its buffer until then.
            child.send_signal(signal.SIGINT)
            output, _ = child.communicate(timeout=LIMIT_S)
        self.assertIn(said, output)
        self.assertNotIn("bag_scan_period", output, "it has its own value")


if __name__ == "__main__":
    init_node("amcl_test")
    rostest.rosrun("yarm", "amcl_test", AmclTest)
