"""Descriptions read from URDF text: links, joints, solids, and faults by name."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from yarm.geometry import quaternion_from_rpy, transform_matrix
from yarm.geometry.urdf import DEFAULT_COLOUR, UrdfError, UrdfModel, expand_xacro, parse_urdf

ARM = """
<robot name="arm">
  <material name="blue"><color rgba="0.1 0.2 0.9 1"/></material>
  <link name="base">
    <visual><geometry><box size="1 1 1"/></geometry><material name="blue"/></visual>
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.4 0.3 0.2"/></geometry></collision>
    <collision><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <link name="plate"/>
  <link name="upper"><collision>
    <origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.1" length="0.8"/></geometry>
  </collision></link>
  <link name="tip"/>
  <joint name="bolt" type="fixed">
    <parent link="base"/><child link="plate"/><origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <parent link="plate"/><child link="upper"/><origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="2.5" velocity="3" effort="80"/>
  </joint>
  <joint name="flange" type="fixed"><parent link="upper"/><child link="tip"/><origin xyz="0 0 1"/></joint>
</robot>
"""


@pytest.fixture(name="arm")
def arm_fixture() -> UrdfModel:
    return parse_urdf(ARM)


def test_links_and_solids_come_in_order_of_the_file(arm: UrdfModel) -> None:
    assert (arm.name, arm.links) == ("arm", ("base", "plate", "upper", "tip"))
    found = [(solid.link, solid.shape, solid.size) for solid in arm.solids]
    assert found == [
        ("base", "box", (0.4, 0.3, 0.2)),
        ("base", "sphere", (0.05,)),
        ("upper", "cylinder", (0.1, 0.8)),
    ]


def test_a_solids_pose_is_in_its_links_frame(arm: UrdfModel) -> None:
    assert arm.solids[0].pose == pytest.approx(transform_matrix((0, 0, 0.1), (0, 0, 0, 1)))
    assert arm.solids[1].pose == pytest.approx(np.eye(4))
    lying = arm.solids[2].pose
    assert lying[:3, 3] == pytest.approx([0.0, 0.0, 0.5])
    assert lying[:3, 2] == pytest.approx([1.0, 0.0, 0.0])


def test_colours_come_from_the_materials_and_grey_is_the_rest(arm: UrdfModel) -> None:
    assert arm.solids[0].colour == (0.1, 0.2, 0.9)
    assert arm.solids[2].colour == DEFAULT_COLOUR


def test_joints_have_axes_and_limits(arm: UrdfModel) -> None:
    (shoulder,) = arm.moving_joints
    assert (shoulder.name, shoulder.parent, shoulder.child) == ("shoulder", "plate", "upper")
    assert shoulder.axis == (0.0, 1.0, 0.0)
    assert (shoulder.lower, shoulder.upper, shoulder.velocity, shoulder.effort) == (-1.5, 2.5, 3.0, 80.0)
    assert arm.joints["bolt"].axis == (1.0, 0.0, 0.0)  # URDF's own default


def test_fixed_joints_tie_links_to_the_nearest_one_that_moves(arm: UrdfModel) -> None:
    link, pose = arm.rigid_group("plate")
    assert link == "base"
    assert pose == pytest.approx(transform_matrix((0, 0, 0.2), quaternion_from_rpy(0, 0, math.pi / 2)))
    link, pose = arm.rigid_group("tip")
    assert (link, pose[2, 3]) == ("upper", 1.0)
    link, pose = arm.rigid_group("base")
    assert link == "base" and pose == pytest.approx(np.eye(4))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot", "URDF text"),
        (
            "<robot><link name='a'><collision><geometry><mesh/></geometry></collision></link></robot>",
            "link a: .*sphere",
        ),
        ("<robot><link name='a'><collision/></link></robot>", "link a"),
        (
            "<robot><link name='a'><collision><geometry><box size='1 2'/></geometry></collision></link></robot>",
            "'1 2' must be 3 numbers",
        ),
        (
            "<robot><joint name='j' type='fixed'><parent link='a'/></joint></robot>",
            "joint j: needs a parent and a child",
        ),
        (
            "<robot><joint name='j' type='hinge'><parent link='a'/><child link='b'/></joint></robot>",
            "joint j: its type 'hinge' must be one of fixed, revolute",
        ),
        (
            "<robot><joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
            "<limit lower='1' upper='-0.5'/></joint></robot>",
            "joint j: its limits 1 to -0.5 are reversed, or no numbers",
        ),
        (
            "<robot><joint name='j' type='revolute'><parent link='a'/><child link='b'/>"
            "<limit lower='nan' upper='1'/></joint></robot>",
            "joint j: its limits nan to 1 are reversed, or no numbers",
        ),
    ],
)
def test_what_cannot_be_used_is_named(text: str, words: str) -> None:
    with pytest.raises(UrdfError, match=words):
        parse_urdf(text)


def test_xacro_files_are_expanded_with_their_arguments(tmp_path: Path) -> None:
    file = tmp_path / "box.urdf.xacro"
    file.write_text(
        '<robot name="box" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="side" default="1"/>'
        '<link name="a"><collision><geometry><box size="$(arg side) 1 1"/></geometry></collision></link></robot>'
    )
    assert parse_urdf(expand_xacro(file)).solids[0].size == (1.0, 1.0, 1.0)
    assert parse_urdf(expand_xacro(file, side=2.5)).solids[0].size == (2.5, 1.0, 1.0)


def test_other_substitutions_and_arguments_that_nobody_gives_are_xacros_own(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("SIDE", "3")
    file = tmp_path / "box.urdf.xacro"
    text = (
        '<robot name="box" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"><collision><geometry>'
        '<box size="1 $(env SIDE) 1"/></geometry></collision></link></robot>'
    )
    file.write_text(text)
    assert parse_urdf(expand_xacro(file)).solids[0].size == (1.0, 3.0, 1.0)
    file.write_text(text.replace("$(env SIDE)", "$(arg side)"))
    with pytest.raises(UrdfError, match="side"):
        expand_xacro(file)


def test_a_file_that_is_not_there_or_not_xacro_is_named(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match=r"nothing\.xacro: no such robot description"):
        expand_xacro(tmp_path / "nothing.xacro")
    broken = tmp_path / "broken.xacro"
    broken.write_text("<robot><xacro:if></robot>")
    with pytest.raises(UrdfError, match=r"broken\.xacro: "):
        expand_xacro(broken)
