"""The youBot's numbers against its URDF, link by link."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.geometry import FloatArray
from yarm.geometry.urdf import UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots import youbot

FILE = resource("urdf", "manipulation", "youbot.urdf.xacro")


def model(base: bool) -> UrdfModel:
    return parse_urdf(expand_xacro(FILE, base=str(base).lower()))


def test_the_limits_are_the_models() -> None:
    joints = model(base=True).joints
    for name, low, high in zip(youbot.JOINT_NAMES, youbot.LOWER_RAD, youbot.UPPER_RAD):
        index = youbot.JOINT_NAMES.index(name)
        ends = [youbot.urdf_angles(np.full(5, angle))[index] for angle in (low, high)]
        assert sorted(ends) == pytest.approx([joints[name].lower, joints[name].upper], abs=1e-9)
        assert joints[name].velocity == youbot.SPEED_RADPS


def test_the_arm_stands_on_the_base_where_it_is_said() -> None:
    with_base, alone = model(base=True), model(base=False)
    T_floor_link0 = with_base.rigid_group("arm_link_0")[1]
    T_frame_link0 = alone.rigid_group("arm_link_0")[1]
    arm_frame = T_floor_link0 @ np.linalg.inv(T_frame_link0)
    assert arm_frame[:3, 3] == pytest.approx(youbot.ARM_ON_BASE_XYZ_M, abs=1e-12)
    assert np.allclose(arm_frame[:3, :3], np.eye(3))


def test_the_wheels_stand_on_the_floor() -> None:
    base = model(base=True)
    wheels = [solid for solid in base.solids if solid.link.startswith("wheel_")]
    assert len(wheels) == 4
    for wheel in wheels:
        joint = base.joints[f"wheel_joint_{wheel.link[6:]}"]
        height = base.rigid_group("base_link")[1] @ joint.T_parent_child
        assert height[2, 3] - wheel.size[0] == pytest.approx(0.0, abs=1e-12)


def test_readings_and_mechanical_angles_are_inverse() -> None:
    q = youbot.random_joints(np.random.default_rng(3), 50)
    assert np.allclose(youbot.mechanical_angles(youbot.urdf_angles(q)), q)
    assert np.all(youbot.within_limits(q))
    outside: FloatArray = np.array(youbot.UPPER_RAD) + 1e-6
    assert not youbot.within_limits(outside)
