"""Bags of checkpoints and motions: what is written is read again, what is wrong is named."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import rosbag
import rospy
from geometry_msgs.msg import Quaternion, Transform, Vector3
from std_msgs.msg import String

from yarm.geometry import FloatArray
from yarm.manipulation.kinematics.forward import forward
from yarm.manipulation.motion.checkpoints import CheckpointError
from yarm.manipulation.motion.trajectory import arm_limits, jerk_limited
from yarm.manipulation.obstacles.collision import arm_description
from yarm.robots.youbot import JOINT_NAMES, mechanical_angles, urdf_angles
from yarm.ros.manipulation.bags import joint_trajectory, read_checkpoints, write_motion
from yarm.ros.manipulation.coursework import load, main

HALF = 0.5**0.5
FIRST = Transform(Vector3(0.2, 0.0, 0.4), Quaternion(0.0, HALF, 0.0, HALF))
SECOND = Transform(Vector3(0.25, 0.0, 0.3), Quaternion(0.0, HALF, 0.0, HALF))
GOAL = np.array([0.5, 0.4, 0.8, 0.3, -0.6])


def bag_of(path: Path, *messages: object, topic: str = "/target_position") -> Path:
    with rosbag.Bag(str(path), "w") as bag:
        for number, message in enumerate(messages, start=1):
            bag.write(topic, message, rospy.Time(number))
    return path


@pytest.mark.parametrize("topic", ["target_position", "/target_position"])
def test_checkpoints_come_in_the_order_they_were_recorded(tmp_path: Path, topic: str) -> None:
    points = read_checkpoints(bag_of(tmp_path / "targets.bag", FIRST, SECOND, topic=topic))
    assert [point.name for point in points] == ["1", "2"]
    assert points[0].pose[:3, 3] == pytest.approx([0.2, 0.0, 0.4])
    assert points[0].pose[:3, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    assert load(tmp_path / "targets.bag").checkpoints[1].pose[2, 3] == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("messages", "topic", "says"),
    [
        ((FIRST,), "/goals", r"needs target_position of geometry_msgs/Transform; it holds goals \(geometry_msgs/Tr"),
        ((String("here"),), "/target_position", r"it holds target_position \(std_msgs/String\)"),
        ((), "/target_position", "it holds nothing"),
        ((FIRST, FIRST), "/target_position", "checkpoints 1 and 2 are the same pose"),
        ((Transform(Vector3(0.2, 0.0, 0.4), Quaternion(0.0, 0.0, 0.0, 0.5)),), "/target_position", "length 0.5, not 1"),
        ((Transform(Vector3(float("nan"), 0, 0), Quaternion(0, 0, 0, 1)),), "/target_position", "finite numbers"),
    ],
)
def test_a_bag_that_cannot_be_used_says_why(tmp_path: Path, messages: tuple, topic: str, says: str) -> None:
    with pytest.raises(CheckpointError, match=says):
        read_checkpoints(bag_of(tmp_path / "targets.bag", *messages, topic=topic))


def test_what_is_no_bag_is_refused(tmp_path: Path) -> None:
    (tmp_path / "targets.bag").write_text("no bag\n")
    with pytest.raises(CheckpointError, match="not readable as a bag"):
        read_checkpoints(tmp_path / "targets.bag")
    with pytest.raises(CheckpointError, match="no such bag"):
        read_checkpoints(tmp_path / "other.bag")
    assert main(["--checkpoints", str(tmp_path / "targets.bag"), "--results", str(tmp_path)]) == 2


def test_a_motion_is_written_in_the_drivers_angles(tmp_path: Path) -> None:
    motion = jerk_limited(np.zeros(5), GOAL, arm_limits())
    with rosbag.Bag(str(write_motion(motion, tmp_path))) as bag:
        ((topic, message, _),) = list(bag.read_messages())
    assert topic == "EffortJointInterface_trajectory_controller/command"
    assert tuple(message.joint_names) == JOINT_NAMES
    first, last = message.points[0], message.points[-1]
    assert list(first.positions) == pytest.approx(urdf_angles(np.zeros(5)))
    assert forward(mechanical_angles(last.positions)) == pytest.approx(forward(GOAL), abs=1e-9)
    assert last.time_from_start.to_sec() == pytest.approx(motion.duration_s)
    assert list(last.velocities) == pytest.approx([0.0] * 5, abs=1e-9)
    limits = [arm_description()[1].joints[name] for name in JOINT_NAMES]
    assert all(j.lower <= value <= j.upper for point in message.points for j, value in zip(limits, point.positions))


def test_velocities_are_the_positions_derivatives() -> None:
    points = joint_trajectory(jerk_limited(np.zeros(5), GOAL, arm_limits()), 0.001).points
    times, q, speed = (column(points, name) for name in ("time", "positions", "velocities"))
    numeric = np.gradient(q, times[:, 0], axis=0)
    assert np.max(np.abs(numeric[2:-2] - speed[2:-2])) < 0.01


def column(points: list, name: str) -> FloatArray:
    """One field of all points, (m, k)."""
    if name == "time":
        return np.array([[point.time_from_start.to_sec()] for point in points])
    return np.array([getattr(point, name) for point in points])
