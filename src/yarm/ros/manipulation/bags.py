"""Checkpoints out of a bag, and motions of the youBot's arm as messages in one."""

from __future__ import annotations

from pathlib import Path
from typing import List, Tuple

import rosbag
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from yarm.manipulation.motion.checkpoints import Checkpoint, CheckpointError, checked_checkpoints, checkpoint
from yarm.manipulation.motion.trajectory import Trajectory
from yarm.robots.youbot import JOINT_NAMES, urdf_angles, urdf_rates
from yarm.ros.common import names

TRANSFORM = "geometry_msgs/Transform"
MOTION_STEP_S = 0.05
BEGINNING_S = 1.0
"""Stamp of the first message of a bag that is written: a bag has no time 0."""


def read_checkpoints(path: Path, topic: str = names.TARGET_POSITION) -> Tuple[Checkpoint, ...]:
    """Checkpoints of a bag in the order they were recorded, named by their numbers from 1.

    Args:
        path: of the bag.
        topic: of geometry_msgs/Transform messages.

    Raises:
        CheckpointError: no bag, no such topic in it, another type on it, or transforms that cannot be used.
    """
    if not path.is_file():
        raise CheckpointError(f"{path}: no such bag")
    try:
        bag = rosbag.Bag(str(path))
    except (rosbag.ROSBagException, OSError) as error:
        raise CheckpointError(f"{path}: not readable as a bag: {error}") from error
    with bag:
        topics = {name.lstrip("/"): info.msg_type for name, info in bag.get_type_and_topic_info().topics.items()}
        found = topics.get(topic.lstrip("/"))
        if found != TRANSFORM:
            there = ", ".join(f"{name} ({kind})" for name, kind in sorted(topics.items())) or "nothing"
            raise CheckpointError(f"{path}: needs {topic} of {TRANSFORM}; it holds {there}")
        wanted = [topic.lstrip("/"), f"/{topic.lstrip('/')}"]
        points: List[Checkpoint] = []
        for _, message, _ in bag.read_messages(topics=wanted):
            v, q = message.translation, message.rotation
            points.append(checkpoint(str(len(points) + 1), (v.x, v.y, v.z), (q.x, q.y, q.z, q.w)))
    return checked_checkpoints(points, f"{path}, {topic}")


def joint_trajectory(motion: Trajectory, step_s: float = MOTION_STEP_S) -> JointTrajectory:
    """A motion (5 joints) as the arm's controller takes it: the driver's angles, with speeds and accelerations.

    Args:
        motion: in mechanical angles.
        step_s: between two points, at most.
    """
    message = JointTrajectory(joint_names=list(JOINT_NAMES))
    times, q, speed, acceleration = motion.sampled(step_s)
    rows = zip(times, urdf_angles(q), urdf_rates(speed), urdf_rates(acceleration))
    for time_s, positions, velocities, accelerations in rows:
        message.points.append(
            JointTrajectoryPoint(
                positions=positions.tolist(),
                velocities=velocities.tolist(),
                accelerations=accelerations.tolist(),
                time_from_start=rospy.Duration.from_sec(float(time_s)),
            )
        )
    return message


def write_motion(motion: Trajectory, folder: Path) -> Path:
    """Write a motion into ``tour.bag`` of a folder, on the topic of the arm's controller; the file."""
    path = folder / "tour.bag"
    with rosbag.Bag(str(path), "w") as bag:
        bag.write(names.ARM_COMMAND, joint_trajectory(motion), rospy.Time.from_sec(BEGINNING_S))
    return path
