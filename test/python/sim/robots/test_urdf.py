"""Robot descriptions: expansion, reading, and the numbers they must have."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from yarm.geometry import transform_matrix
from yarm.geometry.urdf import UrdfError, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource


def model(name: str, **args: str) -> UrdfModel:
    return parse_urdf(expand_xacro(resource("urdf", f"{name}.urdf.xacro"), **args))


@pytest.mark.parametrize("file", sorted(path.name for path in resource("urdf").glob("*.urdf.xacro")))
def test_every_description_expands(file: str) -> None:
    assert parse_urdf(expand_xacro(resource("urdf", file))).solids


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
        pose = table.rigid_group(solid.link)[1] @ solid.T_link_solid
        tops[solid.link] = (pose[2, 3] + solid.half_extent[2], pose[0, 3])
    assert tops["table"] == pytest.approx((0.70, 0.0))
    assert tops["part"] == pytest.approx((0.73, -0.25))


def test_debris_is_as_large_as_a_door_handle() -> None:
    debris = model("debris")
    corners = []
    for solid in debris.solids:
        reach = np.abs(solid.T_link_solid[:3, :3]) @ solid.half_extent
        corners += [solid.T_link_solid[:3, 3] - reach, solid.T_link_solid[:3, 3] + reach]
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
