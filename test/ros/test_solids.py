"""Solids and their messages: SolidPrimitive has a cylinder's height first, ours its radius."""

from __future__ import annotations

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from shape_msgs.msg import SolidPrimitive
from yarm.msg import RegisteredObject

from yarm.geometry.solids import Shape, Solid
from yarm.ros.commander.markers import solid_markers
from yarm.ros.common.solids import primitive_of, solid_of, solids_of

POSE = Pose(Point(1.0, 2.0, 3.0), Quaternion(0.0, 0.0, np.sin(0.3), np.cos(0.3)))
SOLIDS = [("box", (0.1, 0.2, 0.3)), ("cylinder", (0.35, 0.45)), ("sphere", (0.05,))]


@pytest.mark.parametrize(("shape", "size"), SOLIDS)
def test_a_solid_comes_back_as_it_went(shape, size):
    back = solid_of(primitive_of(Solid(shape, size, np.eye(4))), POSE)
    assert (back.shape, back.size) == (shape, size)
    assert back.pose[:3, 3] == pytest.approx([1.0, 2.0, 3.0])
    assert back.pose[:2, 0] == pytest.approx([np.cos(0.6), np.sin(0.6)])


def test_a_cylinder_tells_its_height_and_radius_where_the_message_wants_them():
    message = primitive_of(Solid(Shape.CYLINDER, (0.35, 0.45), np.eye(4)))
    assert message.dimensions[SolidPrimitive.CYLINDER_RADIUS] == 0.35
    assert message.dimensions[SolidPrimitive.CYLINDER_HEIGHT] == 0.45


def test_shapes_nobody_draws_are_left_out_with_their_frames():
    cone = SolidPrimitive(type=SolidPrimitive.CONE, dimensions=[1.0, 0.2])
    ball = SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.2])
    entry = RegisteredObject(shapes=[cone, ball], shape_poses=[Pose(), POSE], shape_frames=["a", "b"])
    assert [(frame, solid.shape) for frame, solid in solids_of(entry)] == [("b", "sphere")]


@pytest.mark.parametrize(
    ("shape", "size", "scale"),
    [
        ("box", (0.1, 0.2, 0.3), (0.1, 0.2, 0.3)),
        ("cylinder", (0.35, 0.45), (0.7, 0.7, 0.45)),
        ("sphere", (0.05,), (0.1, 0.1, 0.1)),
    ],
)
def test_a_marker_has_the_full_size(shape, size, scale):
    primitive = primitive_of(Solid(shape, size, np.eye(4)))
    entry = RegisteredObject(name="thing", shapes=[primitive], shape_poses=[POSE], shape_frames=["thing"])
    (made,) = solid_markers(entry)
    assert (made.scale.x, made.scale.y, made.scale.z) == pytest.approx(scale)
    assert (made.header.frame_id, made.pose) == ("thing", POSE)
