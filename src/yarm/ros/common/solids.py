"""Solids to and from messages: the one place that knows SolidPrimitive's order of sizes."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

from geometry_msgs.msg import Pose
from shape_msgs.msg import SolidPrimitive

from yarm.geometry.solids import Shape, Solid
from yarm.msg import RegisteredObject
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
