"""Debris that nobody registered: found on part and table, carried, followed into the bin, forgotten when it is gone."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Iterator

import numpy as np
import pytest

from support.piece_errors import calibrated_cell
from support.simulated_cell import SimulatedCell
from support.strays import drop, errors, look, places, seen_at, strays, take_away
from yarm.robots.ankurbot import ARM_REACH_M
from yarm.sim.scenes.specs import ThingSpec

REST_SETS = 20
FOUND_SETS = 60
"""Two seconds: half of one to come to rest, one at rest, and what the average lags behind."""
GONE_SETS = 45
CALIBRATION_SETS, PICK_SETS, FALL_SETS = 5, 60, 120
ROBOT = "ankurbot_1"
PLACE = (-0.12, 0.10)


@pytest.fixture(name="cell")
def cell_fixture() -> Iterator[SimulatedCell]:
    """The scene `single`: a robot, the table, no HC10."""
    cell = calibrated_cell()
    yield cell
    cell.close()


def test_pieces_are_found_measured_and_forgotten(cell: SimulatedCell, tmp_path: Path) -> None:
    """Handle-sized boxes; the bounds are what pixels 6 cm apart, of four cameras, allow."""
    size, rng = (0.15, 0.06, 0.04), np.random.default_rng(4)
    names = drop(cell, tmp_path, size, places(rng))
    early = look(cell, REST_SETS)
    assert strays(early) == [], "at rest for less than a second"
    found = look(cell, FOUND_SETS - REST_SETS)
    assert len(strays(found)) == len(names)
    assert [name for name in found.cells if name.startswith("unknown_")] == []
    truth = cell.world.transforms()
    for name in names:
        piece = seen_at(found, truth[name])
        assert piece is not None
        off = errors(piece, truth[name], size)
        assert all(error < bound for error, bound in zip(off, (0.03, 0.01, 0.045, 0.03, math.radians(20.0)))), off
    assert strays(take_away(cell, names, GONE_SETS)) == []


def test_boxes_of_6_cm_are_found(cell: SimulatedCell, tmp_path: Path) -> None:
    names = drop(cell, tmp_path, (0.06, 0.04, 0.04), places(np.random.default_rng(6)))
    assert len(strays(look(cell, FOUND_SETS))) == len(names)
    assert strays(take_away(cell, names, GONE_SETS)) == []


def test_what_is_too_large_is_no_debris(cell: SimulatedCell, tmp_path: Path) -> None:
    names = drop(cell, tmp_path, (0.30, 0.10, 0.10), places(np.random.default_rng(5))[2:])
    found = look(cell, FOUND_SETS)
    assert strays(found) == []
    assert [name for name in found.cells if name.startswith("unknown_")] != [], "it is there all the same"
    take_away(cell, names, GONE_SETS)


def test_what_moves_is_no_debris(cell: SimulatedCell, tmp_path: Path) -> None:
    (name,) = drop(cell, tmp_path, (0.10, 0.06, 0.05), [(0.20, -0.45, 0.70)])
    cell.world.push(name, 0.0, 0.25)
    assert strays(look(cell, 2 * REST_SETS)) == []
    assert len(strays(look(cell, FOUND_SETS))) == 1
    take_away(cell, [name], GONE_SETS)


def test_what_lies_there_in_calibration_is_the_tables(tmp_path: Path) -> None:
    cell = SimulatedCell("single")
    try:
        drop(cell, tmp_path, (0.10, 0.06, 0.05), [(0.20, -0.45, 0.70)])
        cell.world.run(0.5)
        for _ in range(2 * CALIBRATION_SETS):
            cell.next_set(calibrating=True)
        assert strays(look(cell, FOUND_SETS)) == []
    finally:
        cell.close()


def test_a_piece_is_the_robots_from_grasp_to_release_and_keeps_its_name() -> None:
    cell = SimulatedCell("1m1ma_bin", hands=True, start=(PLACE[0] + ARM_REACH_M, PLACE[1]))
    try:
        cell.world.run(0.5)
        for _ in range(CALIBRATION_SETS):
            cell.next_set(calibrating=True)
        cell.world.robots[ROBOT].drive(-0.3, 0.0, 5.0)
        look(cell, FOUND_SETS)
        cell.world.robots[ROBOT].drive(0.0, 0.0, 5.0)
        cell.world.spawn(ThingSpec("loose", "Debris", *PLACE, 0.755, 0.5, registered=False))
        cell.tell()
        carried_and_let_go(cell)
    finally:
        cell.close()


def carried_and_let_go(cell: SimulatedCell) -> None:
    """The robot comes back over the piece, takes it, drives off with it, and lets it fall."""
    (piece,) = strays(look(cell, FOUND_SETS))
    robot, hand = cell.world.robots[ROBOT], cell.world.hands[ROBOT]
    for _ in range(2 * FOUND_SETS):
        off_m = cell.world.seed_xy()[ROBOT][0] - PLACE[0]
        robot.drive(float(np.clip(2.0 * off_m, -0.2, 0.2)), 0.0, 5.0)
        assert strays(cell.next_set(calibrating=False)) == [piece]
    assert abs(off_m) < 0.01, "the tip is over the piece"
    hand.on()
    hand.lift_to(hand.stroke_m)
    for _ in range(PICK_SETS):
        found = cell.next_set(calibrating=False)
        assert strays(found) == [piece]
        if hand.grasping:
            break
    assert found.carriers == {piece: ROBOT}
    hand.lift_to(0.0)
    look(cell, FOUND_SETS)
    found = look(cell, FOUND_SETS)
    assert found.carriers == {piece: ROBOT}
    assert len(found.cells[piece]) == 0
    seen, truth = found.pieces[piece].top_m, cell.world.transforms()["loose"]
    assert math.dist(seen[:2], truth[:2, 3]) < 0.04
    assert abs(seen[2] - truth[2, 3] - 0.02) < 0.03
    hand.off()
    found = look(cell, FALL_SETS)
    assert strays(found) == [piece], "the same piece, back on the part"
    assert found.carriers == {}
