"""Solids to and from messages: the one place that knows SolidPrimitive's order of sizes."""

from __future__ import annotations

from typing import Dict, List, Mapping, Optional, Tuple

import numpy as np
from geometry_msgs.msg import Pose
from shape_msgs.msg import SolidPrimitive

from yarm.geometry import FloatArray
from yarm.geometry.solids import Shape, Solid
from yarm.msg import RegisteredObject
from yarm.robots.ankurbot import drawn_up
from yarm.ros.common.conversions import matrix_of_pose

SHAPE_OF: Dict[int, Shape] = {
    SolidPrimitive.BOX: Shape.BOX,
    SolidPrimitive.SPHERE: Shape.SPHERE,
    SolidPrimitive.CYLINDER: Shape.CYLINDER,
}
TYPE_OF: Dict[Shape, int] = {shape: kind for kind, shape in SHAPE_OF.items()}


def solids_of(entry: RegisteredObject) -> List[Tuple[str, Solid]]:
    """The known solids of an object, each with the tf frame it is fixed to; primitives of other shapes are left out."""
    known = [(f, solid_of(shape, p)) for shape, p, f in zip(entry.shapes, entry.shape_poses, entry.shape_frames)]
    return [(frame, solid) for frame, solid in known if solid is not None]


def solids_at_tip(entry: RegisteredObject, poses: Mapping[str, FloatArray]) -> Optional[List[Solid]]:
    """The known solids of a mobile robot in its end effector's frame, a hand drawn up; None while frames are missing.

    Args:
        entry: of the robot.
        poses: T_world_frame (4, 4) of frames, by name.
    """
    T_world_ee = poses.get(entry.seed_frame)
    if T_world_ee is None:
        return None
    T_ee_world, found = np.linalg.inv(T_world_ee), []
    for frame, solid in solids_of(entry):
        T_ee_frame = drawn_up(entry.name, frame)
        if T_ee_frame is None:
            if frame not in poses:
                return None
            T_ee_frame = T_ee_world @ poses[frame]
        found.append(solid.seen_from(T_ee_frame))
    return found


def solid_of(primitive: SolidPrimitive, pose: Pose) -> Optional[Solid]:
    """The solid of a message, in the frame its pose is given in; None for a shape that is not one of ours."""
    if primitive.type not in SHAPE_OF:
        return None
    size = tuple(float(value) for value in primitive.dimensions)
    return Solid(SHAPE_OF[primitive.type], _turned(SHAPE_OF[primitive.type], size), matrix_of_pose(pose))


def primitive_of(solid: Solid) -> SolidPrimitive:
    """The message of a solid, without its pose."""
    return SolidPrimitive(type=TYPE_OF[solid.shape], dimensions=list(_turned(solid.shape, solid.size)))


def _turned(shape: Shape, size: Tuple[float, ...]) -> Tuple[float, ...]:
    """Sizes in the other order: ours has a cylinder's radius first, the message its height."""
    return size[::-1] if shape == Shape.CYLINDER else size
