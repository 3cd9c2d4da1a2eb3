"""The hand picks debris up in full physics, holds it while the robot moves, lets it go, misses it and loses it."""

from __future__ import annotations

import math
from typing import Iterator

import numpy as np
import pybullet
import pytest

from yarm.robots.ankurbot import HAND_LIFTS_KG
from yarm.sim.engine.bodies import link_names
from yarm.sim.engine.world import SimWorld
from yarm.sim.robots.ankurbot import Ankurbot
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.hand import PRESSING_FORCE_N, SuctionHand
from yarm.sim.scenes.bodies import SpawnError, description
from yarm.sim.scenes.scene import load_scene, scene_from
from yarm.sim.scenes.specs import ThingSpec

PLACE = (0.2, 0.3)
TABLE_M = 0.70
DEBRIS_M = 0.04
DEBRIS_KG = 0.30


@pytest.fixture
def world() -> Iterator[SimWorld]:
    """A robot whose tip is over the table, 0.25 m in from its edge."""
    robot = {"name": "ankurbot_1", "type": "ankurbot", "x": PLACE[0] + 1.3, "y": PLACE[1], "heading_deg": 180.0}
    scene = scene_from({"name": "test", "fixtures": ["table"], "robots": [robot]}, "test")
    with SimWorld(scene, hands=True) as built:
        built.run(0.3)
        yield built


def hand_of(world: SimWorld) -> SuctionHand:
    hand = world.robots["ankurbot_1"].hand
    assert hand is not None
    return hand


def put(world: SimWorld, dx: float = 0.0, dy: float = 0.0, yaw: float = 0.5) -> int:
    """Debris under the tip; its PyBullet number."""
    spot = ThingSpec("debris_1", "Debris", PLACE[0] + dx, PLACE[1] + dy, TABLE_M + 0.5 * DEBRIS_M + 0.003, yaw)
    world.spawn(spot)
    world.run(0.5)
    return int(world.bodies["debris_1"].uids[0])


def height(world: SimWorld, uid: int) -> float:
    return float(pybullet.getBasePositionAndOrientation(uid, physicsClientId=world.client)[0][2])


def lower(world: SimWorld, hand: SuctionHand, down_m: float = 0.165) -> float:
    """Lower until something is taken or the way ends; the greatest force on the cup."""
    hand.on()
    hand.lift_to(down_m)
    most = 0.0
    for _ in range(120):
        world.run(1.0 / 60.0)
        most = max([most, *hand.press_n().values()])
        if hand.grasping:
            break
    return most


@pytest.mark.parametrize(("dx", "dy", "yaw"), [(0.0, 0.0, 0.5), (0.02, 0.0, 0.0), (-0.015, 0.01, 2.0)])
def test_debris_is_picked_carried_and_let_go(world: SimWorld, dx: float, dy: float, yaw: float) -> None:
    uid, hand = put(world, dx, dy, yaw), hand_of(world)
    world.contacts.take()
    force = lower(world, hand)
    assert hand.held_uid == uid
    assert force <= PRESSING_FORCE_N + 2.0
    hand.lift_to(0.0)
    world.run(2.0)
    assert hand.grasping
    assert height(world, uid) == pytest.approx(0.97 - 0.075 - 0.5 * DEBRIS_M, abs=0.01)
    robot = world.robots["ankurbot_1"]
    drive(world, robot)
    assert hand.grasping
    assert hand.lost == 0
    carried = pybullet.getBasePositionAndOrientation(uid, physicsClientId=world.client)[0]
    assert np.linalg.norm(np.array(carried[:2]) - hand.cup[:2, 3]) < 0.05
    assert not world.failures()
    world.contacts.set_goals({"ankurbot_1": "debris_2"})
    world.run(0.2)
    assert any({c.a.link, c.b.link} >= {"hand"} for c in world.contacts.take()), (
        "it hangs on the cup, wherever it is sent"
    )
    world.run(0.2)
    assert not world.failures()
    hand.off()
    assert not hand.grasping
    world.run(1.0)
    assert height(world, uid) < 0.3


def drive(world: SimWorld, robot: Ankurbot) -> None:
    """Back off by half a metre and more, and stop."""
    for caster in ("fl", "fr", "rl", "rr"):
        robot.steer(caster, 0.0)
    world.run(0.5)
    robot.drive(-0.5, 0.0, 5.0)
    world.run(1.6)
    robot.drive(0.0, 0.0, 5.0)
    world.run(0.8)


def test_a_piece_let_go_over_a_bin_is_in_it_when_it_rests() -> None:
    robot = {"name": "ankurbot_1", "type": "ankurbot", "x": 1.75, "y": -1.45, "heading_deg": 180.0}
    bins = [{"name": "bin_1", "x": 0.45, "y": -1.45}]
    scene = scene_from({"name": "test", "fixtures": ["table"], "robots": [robot], "bins": bins}, "test")
    with SimWorld(scene, hands=True) as world:
        hand = hand_of(world)
        world.spawn(ThingSpec("post", "Obstacle", 0.45, -1.45, 0.36, size=(0.1, 0.1, 0.67)))
        world.spawn(ThingSpec("debris_1", "Debris", 0.45, -1.45, 0.72, 0.3))
        world.run(0.3)
        lower(world, hand, 0.2)
        hand.lift_to(0.0)
        world.run(1.5)
        world.delete("post")
        world.contacts.take()
        assert hand.grasping
        assert world.bin_of("debris_1") == ""
        hand.lift_to(0.19)
        world.run(2.0)
        held = world.transforms()["debris_1"][:3, 3]
        assert held[2] == pytest.approx(0.97 - 0.075 - 0.19 - 0.5 * DEBRIS_M, abs=0.01)
        assert world.bin_of("debris_1") == "", "in the hand"
        hand.off()
        world.run(0.2)
        assert world.bin_of("debris_1") == "", "falling"
        world.run(2.0)
        assert world.bin_of("debris_1") == "bin_1"
        assert not world.failures()
        with pytest.raises(SpawnError, match="a Obstacle of the cell stays"):
            world.delete("bin_1")


def test_a_piece_beside_a_bin_is_in_none(world: SimWorld) -> None:
    put(world)
    world.run(0.5)
    assert world.bin_of("debris_1") == ""
    with pytest.raises(KeyError):
        world.bin_of("debris_9")


def test_the_hand_stays_up_and_the_robot_stands(world: SimWorld) -> None:
    hand = hand_of(world)
    world.run(2.0)
    assert hand.lift_m == pytest.approx(0.0, abs=1e-3)
    assert hand.cup[2, 3] == pytest.approx(0.97 - 0.075, abs=3e-3)
    assert hand.cup[2, 2] > 0.9999


def test_ground_truth_tells_how_hard_links_push(world: SimWorld) -> None:
    put(world)
    world.contacts.take()
    world.run(0.2)
    (resting,) = (c for c in world.contacts.take() if {c.a.body, c.b.body} == {"debris_1", "table"})
    assert resting.force_n == pytest.approx(DEBRIS_KG * 9.81, rel=0.05)
    most = lower(world, hand_of(world))
    pushed = [
        c.force_n
        for c in world.contacts.take()
        if {c.a.link, c.b.link} >= {"hand"} and "debris_1" in (c.a.body, c.b.body)
    ]
    assert most <= max(pushed) <= 30.0
    assert [c.force_n for c in world.contacts.take()] == []


def test_beside_debris_nothing_is_taken(world: SimWorld) -> None:
    """The cup's edge presses on it, and does not cover it."""
    put(world, dy=0.06, yaw=0.0)
    hand = hand_of(world)
    assert lower(world, hand) > 2.0
    assert not hand.grasping


def test_the_table_is_not_lifted_nor_pressed_hard(world: SimWorld) -> None:
    """With nothing there the cup comes down on the table, which holds on to it: suction takes whatever it covers."""
    hand = hand_of(world)
    hand.lift_to(0.2)
    most = 0.0
    for _ in range(120):
        world.run(1.0 / 60.0)
        most = max([most, *hand.press_n().values()])
    assert hand.cup[2, 3] == pytest.approx(TABLE_M, abs=3e-3)
    assert 2.0 < most <= PRESSING_FORCE_N + 2.0


def test_weak_suction_loses_the_piece(world: SimWorld) -> None:
    """2 N hold less than the 2.9 N that the piece weighs."""
    uid = put(world)
    robot = world.robots["ankurbot_1"]
    model = description("ankurbot.urdf.xacro", hand=True)[1]
    hand = robot.hand = SuctionHand(world.client, robot.uid, link_names(world.client, robot.uid), model, holding_n=2.0)
    lower(world, hand)
    hand.lift_to(0.0)
    world.run(2.0)
    assert not hand.grasping
    assert hand.lost >= 1
    assert height(world, uid) < TABLE_M + DEBRIS_M


@pytest.mark.parametrize(("beyond_kg", "lifted"), [(-0.1, True), (0.1, False)])
def test_a_piece_that_is_heavier_than_the_lift_raises_holds_it_down(
    world: SimWorld, beyond_kg: float, lifted: bool
) -> None:
    uid, hand = put(world), hand_of(world)
    pybullet.changeDynamics(uid, -1, mass=HAND_LIFTS_KG + beyond_kg, physicsClientId=world.client)
    lower(world, hand)
    hand.lift_to(0.0)
    most = 0.0
    for _ in range(120):
        world.run(1.0 / 60.0)
        most = max([most, *hand.press_n().values()])
    assert hand.held_uid == uid and most <= PRESSING_FORCE_N + 2.0
    assert (height(world, uid) > TABLE_M + 0.1) is lifted
    assert (hand.lift_m < 0.003) is lifted


@pytest.mark.parametrize("aside", [-0.005, 0.0, 0.005])
def test_of_two_pieces_side_by_side_the_one_under_the_cup_is_taken(world: SimWorld, aside: float) -> None:
    """5 mm apart: the cup rests on both, and the other may bear more of its force."""
    uid = put(world, dy=aside, yaw=0.0)
    for name, dy in (("debris_2", 0.065), ("debris_3", -0.065)):
        world.spawn(ThingSpec(name, "Debris", PLACE[0], PLACE[1] + aside + dy, TABLE_M + 0.025, 0.0))
    world.run(0.5)
    hand = hand_of(world)
    lower(world, hand)
    assert hand.held_uid == uid
    hand.lift_to(0.0)
    world.run(1.5)
    assert hand.held_uid == uid and height(world, uid) > TABLE_M + 0.1


def test_without_vacuum_a_piece_is_lost_and_none_is_taken_until_it_works_again(world: SimWorld) -> None:
    hand, uid = hand_of(world), put(world)
    lower(world, hand)
    hand.lift_to(0.0)
    world.run(0.4)
    assert hand.held_uid == uid
    assert world.fail_vacuum("ankurbot_1", True) and not world.fail_vacuum("nobody", True)
    world.run(1.5)
    assert not hand.grasping and hand.lost == 1 and height(world, uid) < TABLE_M + DEBRIS_M
    lower(world, hand)
    assert not hand.grasping
    hand.lift_to(0.0)
    world.run(1.5)
    world.fail_vacuum("ankurbot_1", False)
    lower(world, hand)
    assert hand.held_uid == uid


def test_a_piece_that_is_deleted_is_no_longer_held(world: SimWorld) -> None:
    put(world)
    hand = hand_of(world)
    lower(world, hand)
    assert hand.grasping
    world.delete("debris_1")
    assert not hand.grasping
    world.run(0.1)


def test_without_suction_nothing_is_taken(world: SimWorld) -> None:
    uid, hand = put(world), hand_of(world)
    hand.lift_to(0.16)
    world.run(2.0)
    assert sum(hand.press_n().values()) > 2.0
    assert not hand.grasping
    hand.lift_to(0.0)
    world.run(2.0)
    assert height(world, uid) < TABLE_M + DEBRIS_M


@pytest.mark.parametrize("down_m", [-0.01, 0.21, math.nan, math.inf])
def test_a_lift_beyond_the_stroke_is_refused(world: SimWorld, down_m: float) -> None:
    with pytest.raises(CommandError, match=r"must be within 0 to 0\.2 m"):
        hand_of(world).lift_to(down_m)


def test_a_type_of_robot_has_a_hand_beside_one_that_has_none() -> None:
    robots = [
        {"name": f"ankurbot_{n}", "type": kind, "x": 1.6, "y": 1.5 * n - 1.5, "heading_deg": 0.0}
        for n, kind in ((1, "ankurbot"), (2, "ankurbot_hand"))
    ]
    with SimWorld(scene_from({"name": "test", "fixtures": ["table"], "robots": robots}, "test")) as world:
        assert list(world.hands) == ["ankurbot_2"]
        heights = [world.transforms()[f"ankurbot_{n}/ee"][2, 3] for n in (1, 2)]
        assert heights == pytest.approx([0.89, 0.97], abs=0.01)


def test_robots_have_no_hand_unless_asked_for() -> None:
    with SimWorld(load_scene("1m1ma")) as world:
        assert world.robots["ankurbot_1"].hand is None
        assert world.transforms()["ankurbot_1/ee"][2, 3] == pytest.approx(0.89, abs=0.01)
