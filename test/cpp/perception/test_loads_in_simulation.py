"""A piece that is picked up in the simulated cell is the robot's on the map; lost or let go, it is debris at once."""

from __future__ import annotations

from typing import Iterator, Set, Tuple

import numpy as np
import pytest

from support.perception_chain import ChainMap
from support.simulated_cell import SimulatedCell
from yarm.geometry import FloatArray
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.sim.engine.bodies import link_names
from yarm.sim.robots.hand import SuctionHand
from yarm.sim.scenes.bodies import description

ROBOT, PIECE = "ankurbot_1", "debris_1"
PLACE = (-0.12, 0.10)
"""Where the scene drops its piece, metres."""
CALIBRATION_SETS, PICK_SETS, CARRY_SETS, FALL_SETS = 5, 60, 25, 30
LOWERED_M, EVERY = 0.08, 3
"""A hand farther down than this is a cell lower, metres; it is looked at in every so many-th set."""
CUP_MIDDLE_M = 0.015
"""The middle of the cup over its face, metres."""
WEAK_N = 2.0
"""A cup that holds less than the piece weighs (2.9 N): it is taken, and torn off as the hand goes up."""


@pytest.fixture(name="cell")
def cell_fixture() -> Iterator[SimulatedCell]:
    """The scene 1m1ma_bin, calibrated; its robot's tip is over the place of its piece, which has fallen there."""
    cell = SimulatedCell("1m1ma_bin", hands=True, start=(PLACE[0] + ARM_REACH_M, PLACE[1]))
    cell.world.run(0.5)
    for _ in range(CALIBRATION_SETS):
        cell.next_set(calibrating=True)
    cell.spawn_all()
    cell.world.run(0.5)
    yield cell
    cell.close()


def cells_of(chain_map: ChainMap, name: str) -> Set[Tuple[int, ...]]:
    return {tuple(cell) for cell in chain_map.cells[name].tolist()}


def cells_around(cell: SimulatedCell) -> Set[Tuple[int, ...]]:
    """Cell of the piece's middle on the usual grid."""
    return {cell_at(cell.world.transforms()[PIECE][:3, 3])}


def cell_at(point: FloatArray) -> Tuple[int, ...]:
    """Cell of a point (3,), metres, world, on the usual grid."""
    low, size = np.array([-2.5, -2.5, 0.01]), np.array([0.1, 0.1, 1.29 / 20])
    return tuple(((point - low) / size).astype(int).tolist())


def pick(cell: SimulatedCell, hand: SuctionHand) -> ChainMap:
    """Take the piece; the map of the first set in which the hand says that it holds it."""
    hand.on()
    hand.lift_to(hand.stroke_m)
    for _ in range(PICK_SETS):
        found = cell.next_set(calibrating=False)
        if hand.grasping:
            return found
        assert found.carriers == {}, "nothing is carried before the hand says so"
        assert len(found.cells[PIECE]), "a piece that is not held is debris"
    raise AssertionError("the hand takes nothing")


def check_carried(cell: SimulatedCell, found: ChainMap) -> None:
    assert found.carriers == {PIECE: ROBOT}
    assert len(found.cells[PIECE]) == 0
    assert PIECE not in found.pieces
    assert cells_around(cell) <= cells_of(found, ROBOT)


def check_debris(cell: SimulatedCell, found: ChainMap) -> None:
    assert found.carriers == {}
    assert cells_around(cell) <= cells_of(found, PIECE)


def test_a_piece_is_the_robots_from_grasp_to_release(cell: SimulatedCell) -> None:
    hand = cell.world.hands[ROBOT]
    check_carried(cell, pick(cell, hand))
    hand.lift_to(0.0)
    for _ in range(2 * CARRY_SETS):
        check_carried(cell, cell.next_set(calibrating=False))
    robot = cell.world.robots[ROBOT]
    robot.drive(-0.3, 0.0, 5.0)
    for _ in range(CARRY_SETS):
        check_carried(cell, cell.next_set(calibrating=False))
    robot.drive(0.0, 0.0, 5.0)
    for _ in range(CARRY_SETS):
        check_carried(cell, cell.next_set(calibrating=False))
    hand.off()
    for _ in range(FALL_SETS):
        check_debris(cell, cell.next_set(calibrating=False))


def test_a_hand_that_is_down_is_seen_where_it_is_and_is_its_robots(cell: SimulatedCell) -> None:
    """On the way down, on the piece, and on the way up; never something that nobody knows."""
    hand = cell.world.hands[ROBOT]
    down = []
    hand.on()
    hand.lift_to(hand.stroke_m)
    for number in range(PICK_SETS):
        if hand.grasping:
            hand.lift_to(0.0)
        found = cell.next_set(calibrating=False)
        assert set(found.cells) <= set(cell.world.bodies), "nothing but what is there"
        if hand.lift_m > LOWERED_M and number % EVERY == 0:
            down.append(hand.lift_m)
            cup = cell.world.transforms()[f"{ROBOT}/hand"]
            assert cell_at(cup[:3, 3] + (0.0, 0.0, CUP_MIDDLE_M)) in cells_of(found, ROBOT)
    assert len(down) > 3 and not hand.lift_m > LOWERED_M, "it has been down, and is up again"


def test_a_load_that_is_torn_off_is_debris_in_the_next_map(cell: SimulatedCell) -> None:
    robot = cell.world.robots[ROBOT]
    model = description("ankurbot.urdf.xacro", hand=True)[1]
    names = link_names(cell.world.client, robot.uid)
    hand = robot.hand = SuctionHand(cell.world.client, robot.uid, names, model, holding_n=WEAK_N)
    check_carried(cell, pick(cell, hand))
    hand.lift_to(0.0)
    lost = 0
    for _ in range(4 * CARRY_SETS):
        found = cell.next_set(calibrating=False)
        if hand.grasping:
            check_carried(cell, found)
        else:
            check_debris(cell, found)
            lost += 1
    assert hand.lost and lost, "it was torn off"
