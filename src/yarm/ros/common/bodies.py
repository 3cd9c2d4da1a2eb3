"""Bodies of the cell as messages: entries of the registry, and their fixed frames."""

from __future__ import annotations

from typing import Iterable, Mapping

import rospy
from geometry_msgs.msg import Pose, TransformStamped
from tf2_msgs.msg import TFMessage

from yarm.geometry import FloatArray
from yarm.geometry.poses import quaternions_of
from yarm.msg import ObjectRegistry, RegisteredObject
from yarm.ros.common import names
from yarm.ros.common.solids import primitive_of
from yarm.sim.scenes.bodies import Body


def registry_message(stamp: rospy.Time, bodies: Iterable[Body]) -> ObjectRegistry:
    """The registry of these bodies."""
    registry = ObjectRegistry(entries=[registry_entry(body) for body in bodies])
    registry.header.stamp, registry.header.frame_id = stamp, names.WORLD_FRAME
    return registry


def registry_entry(body: Body) -> RegisteredObject:
    """What the registry tells of a body."""
    entry = RegisteredObject(name=body.name, object=str(body.kind), type="dynamic" if body.dynamic else "static")
    entry.seed_frame, entry.link_frames = body.seed_frame, list(body.link_frames)
    for item in body.solids if body.drawn else ():
        entry.shapes.append(primitive_of(item.solid))
        entry.shape_poses.append(pose_of_matrix(item.T_frame_solid))
        entry.shape_frames.append(item.frame)
    return entry


def transform_message(stamp: rospy.Time, poses: Mapping[str, FloatArray]) -> TFMessage:
    """Transforms world <- frame from T_world_frame (4, 4) of each frame, metres."""
    message = TFMessage()
    for frame, pose in poses.items():
        entry = TransformStamped(child_frame_id=frame)
        entry.header.stamp, entry.header.frame_id = stamp, names.WORLD_FRAME
        moved = pose_of_matrix(pose)
        entry.transform.translation = moved.position
        entry.transform.rotation = moved.orientation
        message.transforms.append(entry)
    return message


def pose_of_matrix(matrix: FloatArray) -> Pose:
    """The message of a pose (4, 4), metres."""
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = (float(v) for v in matrix[:3, 3])
    x, y, z, w = quaternions_of(matrix[None, :3, :3])[0]
    pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w = map(float, (x, y, z, w))
    return pose
