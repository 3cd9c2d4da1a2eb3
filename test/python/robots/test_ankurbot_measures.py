"""The mobile robot's measures are those of its description."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from typing import Tuple

import numpy as np
import pytest
import yaml

from yarm.control.base.params import BaseParams
from yarm.geometry import FloatArray, GridSpec
from yarm.geometry.urdf import JointKind, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.ankurbot import (
    ANKURBOT_BEAMS,
    ANKURBOT_DISCS,
    ARM_REACH_M,
    BODY_RADIUS_M,
    CASTER_XY_M,
    CASTERS,
    EE_HEIGHT_M,
    HALF_WHEEL_BASE_M,
    HAND_BEAMS,
    HAND_DISCS,
    HAND_EE_HEIGHT_M,
    HAND_LIFTS_KG,
    HAND_STROKE_M,
    LIFT_LINKS,
    WHEEL_RADIUS_M,
    Beam,
    Disc,
    drawn_up,
)
from yarm.sim.robots.suction import HOLDING_N


@pytest.fixture(scope="module")
def model() -> UrdfModel:
    return parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro")))


def test_reach_height_and_radius(model: UrdfModel) -> None:
    assert model.rigid_group("ee")[1][:3, 3] == pytest.approx([ARM_REACH_M, 0.0, EE_HEIGHT_M])
    body = next(solid for solid in model.solids if solid.link == "base_link")
    assert body.half_extent[0] == pytest.approx(BODY_RADIUS_M)


def test_the_hands_stroke() -> None:
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand="true"))
    assert model.joints["lift_joint"].upper == pytest.approx(HAND_STROKE_M)


def test_a_hand_that_is_drawn_up_is_where_it_is_said() -> None:
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand="true"))
    T_base_ee = model.rigid_group("ee")[1]
    assert T_base_ee[:3, 3] == pytest.approx([ARM_REACH_M, 0.0, HAND_EE_HEIGHT_M])
    T_base_slide = model.rigid_group("slide")[1]
    moved = {joint.child: joint for joint in model.joints.values() if joint.kind is JointKind.PRISMATIC}
    assert set(moved) == set(LIFT_LINKS)
    for link, joint in moved.items():
        found = drawn_up("a_1", f"a_1/{link}")
        assert found is not None
        assert T_base_ee @ found == pytest.approx(T_base_slide @ joint.T_parent_child)
    assert drawn_up("a_1", "a_1/base_link") is None
    assert drawn_up("a_1", "a_10/hand") is None


def test_casters_and_wheels(model: UrdfModel) -> None:
    for caster, (x, y) in zip(CASTERS, CASTER_XY_M):
        assert model.joints[f"{caster}_caster_joint"].T_parent_child[:3, 3] == pytest.approx([x, y, WHEEL_RADIUS_M])
        wheel = next(solid for solid in model.solids if solid.link == f"{caster}_wheel")
        assert wheel.half_extent == pytest.approx([WHEEL_RADIUS_M] * 3)


@pytest.mark.parametrize(
    ("hand", "discs", "beams"), [("false", ANKURBOT_DISCS, ANKURBOT_BEAMS), ("true", HAND_DISCS, HAND_BEAMS)]
)
def test_discs_and_beams_hold_every_solid_tightly(hand: str, discs: Tuple[Disc, ...], beams: Tuple[Beam, ...]) -> None:
    """In the end effector's frame: no solid sticks out, and together they are as long, wide and high as the robot."""
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand=hand))
    boxes = [((d.x - d.radius, d.x + d.radius), (d.y - d.radius, d.y + d.radius), d.z) for d in discs]
    boxes += [(b.x, b.y, b.z) for b in beams]
    ours = [np.array(box) for box in boxes]
    seen = []
    for solid in model.solids:
        pose, link = solid.pose, solid.link
        while link != "base_link":
            joint = next(j for j in model.joints.values() if j.child == link)
            pose, link = joint.T_parent_child @ pose, joint.parent
        middle = pose[:3, 3] - (ARM_REACH_M, 0.0, 0.0)
        reach = np.abs(pose[:3, :3]) @ solid.half_extent
        low, high = middle - reach, middle + reach
        seen.append((low, high))
        assert any(np.all(low >= box[:, 0] - 1e-9) and np.all(high <= box[:, 1] + 1e-9) for box in ours), solid.link
    lowest, highest = np.min([low for low, _ in seen], axis=0), np.max([high for _, high in seen], axis=0)
    assert np.min([box[:, 0] for box in ours], axis=0) == pytest.approx(lowest, abs=1e-9)
    assert np.max([box[:, 1] for box in ours], axis=0) == pytest.approx(highest, abs=1e-9)


def mass_and_middle(hand: str) -> Tuple[float, FloatArray]:
    """Mass, kg, and centre of mass (3,), metres, in the base's frame, the hand drawn up."""
    root = ET.fromstring(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand=hand))
    model = parse_urdf(ET.tostring(root, encoding="unicode"))
    moment, mass = np.zeros(3), 0.0
    for link in root.findall("link"):
        inertial = link.find("inertial")
        assert inertial is not None
        origin = inertial.find("origin")
        place = np.array(
            [*(float(v) for v in (origin.get("xyz", "0 0 0") if origin is not None else "0 0 0").split()), 1]
        )
        name = link.get("name", "")
        while name != "base_link":
            joint = next(j for j in model.joints.values() if j.child == name)
            place, name = joint.T_parent_child @ place, joint.parent
        own = float(inertial.find("mass").get("value"))
        moment, mass = moment + own * place[:3], mass + own
    return mass, moment / mass


@pytest.mark.parametrize("hand", ["false", "true"])
def test_the_whole_robot_balances_over_its_wheels(hand: str) -> None:
    """The ballast takes up arm and hand: the centre of mass is over the wheels' centre."""
    assert mass_and_middle(hand)[1][0] == pytest.approx(0.0, abs=1e-3)


def test_with_the_heaviest_piece_it_brakes_without_tipping_and_without_losing_it() -> None:
    """Ahead, where the arm is, over the front wheels; the cup bears the piece's weight and its braking."""
    gravity = 9.81
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand="true"))
    cup = model.joints["slide_joint"].T_parent_child @ model.joints["lift_joint"].T_parent_child
    mass, middle = mass_and_middle("true")
    middle = (mass * middle + HAND_LIFTS_KG * cup[:3, 3]) / (mass + HAND_LIFTS_KG)
    braking = BaseParams().deceleration_mps2
    assert gravity * (HALF_WHEEL_BASE_M - middle[0]) / middle[2] > 2.0 * braking
    assert HAND_LIFTS_KG * np.hypot(gravity, braking) < HOLDING_N


def test_a_hand_that_is_up_leaves_a_layer_of_cells_free_over_debris_on_the_part() -> None:
    """So does a piece in the hand: the planner keeps one cell between everybody."""
    spec = GridSpec()
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro"), hand="true"))
    face = model.joints["slide_joint"].T_parent_child @ model.joints["lift_joint"].T_parent_child
    part_m, piece_m = 0.73, 0.0405

    def layer(z: float) -> int:
        return int(np.floor((z - spec.lower[2]) / spec.resolution[2]))

    assert layer(part_m + piece_m - 1e-6) == 11
    assert layer(face[2, 3]) == layer(face[2, 3] - piece_m) == 13
    assert face[2, 3] - piece_m - (spec.lower[2] + 13 * spec.resolution[2]) == pytest.approx(0.006, abs=1e-4)


def test_perception_maps_the_volume_of_the_grid() -> None:
    spec = GridSpec()
    for file, key in (("cluster_assoc", "{}{}"), ("merge_clouds", "{}_{}")):
        config = yaml.safe_load(resource("config", "cell", f"{file}.yaml").read_text(encoding="utf-8"))
        assert tuple(config[key.format(axis, "min")] for axis in "xyz") == spec.lower, file
        assert tuple(config[key.format(axis, "max")] for axis in "xyz") == spec.upper, file
