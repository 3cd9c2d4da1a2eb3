"""Robot descriptions: expansion, reading, and the numbers they must have."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from yarm.geometry import transform_matrix
from yarm.geometry.urdf import UrdfError, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots import turtlebot


def model(name: str, system: str = "cell", **args: str) -> UrdfModel:
    return parse_urdf(expand_xacro(resource("urdf", system, f"{name}.urdf.xacro"), **args))


@pytest.mark.parametrize("file", sorted(resource("urdf").glob("*/*.urdf.xacro")), ids=lambda file: file.name)
def test_every_description_expands(file: Path) -> None:
    assert parse_urdf(expand_xacro(file)).solids


def test_the_turtlebot_is_what_the_code_knows_of_it() -> None:
    robot = model("turtlebot", "exploration")
    root, T_footprint_camera = robot.rigid_group("camera_depth_frame")
    assert root == "base_footprint"
    mount = turtlebot.DEPTH_CAMERA
    assert T_footprint_camera[:3, 3] == pytest.approx([mount.x, mount.y, turtlebot.CAMERA_Z_M])
    assert T_footprint_camera[:3, :3] == pytest.approx(np.eye(3))
    assert robot.joints["base_joint"].T_parent_child[2, 3] == pytest.approx(turtlebot.BASE_LINK_Z_M)
    wheels = [robot.joints[name] for name in turtlebot.WHEEL_JOINTS]
    places = [turtlebot.BASE_LINK_Z_M * np.array([0, 0, 1]) + joint.T_parent_child[:3, 3] for joint in wheels]
    half = 0.5 * turtlebot.WHEEL_BASE_M
    assert places[0] == pytest.approx([0.0, half, turtlebot.WHEEL_RADIUS_M])
    assert places[1] == pytest.approx([0.0, -half, turtlebot.WHEEL_RADIUS_M])
    assert {joint.effort for joint in wheels} == {turtlebot.WHEEL_TORQUE_NM}
    tops, reaches = [], []
    for solid in robot.solids:
        pose = robot.rigid_group(solid.link)[1] @ solid.pose
        if solid.link.endswith("_wheel"):
            continue
        tops.append(pose[2, 3] + solid.half_extent[2])
        reaches.append(np.hypot(*pose[:2, 3]) + (solid.size[0] if solid.shape == "cylinder" else 0.0))
        if solid.link == "base_link":
            low, high = pose[2, 3] - solid.half_extent[2], pose[2, 3] + solid.half_extent[2]
            assert (solid.size[0], low, high) == pytest.approx(
                (turtlebot.RADIUS_M, turtlebot.BODY_BOTTOM_M, turtlebot.BODY_TOP_M)
            )
    assert max(tops) == pytest.approx(turtlebot.HEIGHT_M)
    assert max(reaches) == pytest.approx(turtlebot.RADIUS_M)


def test_the_turtlebot_weighs_what_it_weighs() -> None:
    text = expand_xacro(resource("urdf", "exploration", "turtlebot.urdf.xacro"))
    masses = [float(mass.get("value", "0")) for mass in ET.fromstring(text).iter("mass")]
    assert sum(masses) == pytest.approx(turtlebot.MASS_KG, abs=0.01)


def test_the_hc10_is_the_makers() -> None:
    hc10 = model("hc10")
    joints = hc10.moving_joints
    assert [joint.name for joint in joints] == [f"joint_{n}" for n in ("1_s", "2_l", "3_u", "4_r", "5_b", "6_t")]
    degrees = [[round(math.degrees(v)) for v in (j.lower, j.upper, j.velocity)] for j in joints]
    assert degrees == [
        [-180, 180, 130], [-180, 180, 130], [-5, 355, 180], [-180, 180, 180], [-180, 180, 250], [-180, 180, 250]
    ]  # fmt: skip
    pose = np.eye(4)
    for joint in joints:
        pose = pose @ joint.T_parent_child
    _, tool = hc10.rigid_group("tool0")
    assert (pose @ tool)[:3, 3] == pytest.approx([0.0, 0.162, 0.345], abs=1e-9)
    assert (pose @ tool)[:3, 2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
    _, tip = hc10.rigid_group("sander_tip")
    assert np.linalg.inv(tool) @ tip == pytest.approx(transform_matrix((0, 0, 0.12), (0, 0, 0, 1)), abs=1e-9)


def test_the_ankurbot_has_its_casters_and_reach() -> None:
    ankurbot = model("ankurbot")
    for caster, x, y in (("fl", 0.15, 0.15), ("fr", 0.15, -0.15), ("rl", -0.15, 0.15), ("rr", -0.15, -0.15)):
        joint = ankurbot.joints[f"{caster}_caster_joint"]
        assert joint.T_parent_child[:3, 3] == pytest.approx([x, y, 0.05])
        assert (joint.lower, joint.upper) == pytest.approx((-math.pi, math.pi))
    assert ankurbot.rigid_group("ee")[1][:3, 3] == pytest.approx([1.30, 0.0, 0.89])


def test_the_table_and_its_part() -> None:
    tops = {}
    table = model("cell", part="table")
    for solid in table.solids:
        pose = table.rigid_group(solid.link)[1] @ solid.pose
        tops[solid.link] = (pose[2, 3] + solid.half_extent[2], pose[0, 3])
    assert tops["table"] == pytest.approx((0.70, 0.0))
    assert tops["part"] == pytest.approx((0.73, -0.25))


def test_debris_is_as_large_as_a_door_handle() -> None:
    debris = model("debris")
    corners = []
    for solid in debris.solids:
        reach = np.abs(solid.pose[:3, :3]) @ solid.half_extent
        corners += [solid.pose[:3, 3] - reach, solid.pose[:3, 3] + reach]
    size = np.max(corners, axis=0) - np.min(corners, axis=0)
    assert size == pytest.approx([0.15, 0.06, 0.04], abs=0.004)


def test_faults_name_the_file_or_the_element(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match=r"nowhere\.xacro: no such robot description"):
        expand_xacro(tmp_path / "nowhere.xacro")
    bad = tmp_path / "bad.xacro"
    bad.write_text("<robot")
    with pytest.raises(UrdfError, match=r"bad\.xacro"):
        expand_xacro(bad)
    with pytest.raises(UrdfError, match="URDF text"):
        parse_urdf("<robot")
    mesh = "<robot><link name='l'><collision><geometry><mesh/></geometry></collision></link></robot>"
    with pytest.raises(UrdfError, match="link l: its geometry must be"):
        parse_urdf(mesh)
