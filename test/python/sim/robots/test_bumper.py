"""Contacts to sectors, changes to events."""

from __future__ import annotations

import math

import pytest

from yarm.geometry import Pose2
from yarm.robots.turtlebot import RADIUS_M, Bumper, BumperEvent
from yarm.sim.robots.bumper import BumperLogic, Point, pressed_sectors

BASE = Pose2(1.0, -2.0, math.radians(170.0))


def contact(bearing_deg: float, z: float = 0.06) -> Point:
    """A point on the body, world, at a bearing from ahead of BASE."""
    angle = BASE.yaw_rad + math.radians(bearing_deg)
    return (BASE.x + RADIUS_M * math.cos(angle), BASE.y + RADIUS_M * math.sin(angle), z)


@pytest.mark.parametrize(
    ("bearing_deg", "sector"),
    [
        (0.0, Bumper.CENTER), (29.0, Bumper.CENTER), (-29.0, Bumper.CENTER), (31.0, Bumper.LEFT), (89.0, Bumper.LEFT),
        (-31.0, Bumper.RIGHT), (-89.0, Bumper.RIGHT), (91.0, None), (180.0, None), (-91.0, None),
    ],
)  # fmt: skip
def test_a_contact_presses_the_sector_at_its_bearing(bearing_deg: float, sector: Bumper) -> None:
    assert pressed_sectors(BASE, [contact(bearing_deg)]) == ({sector} - {None})


def test_the_bumper_ends_below_the_plates_and_above_the_floor() -> None:
    assert pressed_sectors(BASE, [contact(0.0, 0.005), contact(0.0, 0.14)]) == set()
    assert pressed_sectors(BASE, [contact(0.0, 0.011), contact(60.0, 0.129)]) == {Bumper.CENTER, Bumper.LEFT}


def test_only_changes_are_events() -> None:
    logic = BumperLogic()
    assert logic.look(set()) == ()
    assert logic.look({Bumper.LEFT}) == (BumperEvent(Bumper.LEFT, True),)
    assert logic.look({Bumper.LEFT}) == ()
    assert logic.look({Bumper.RIGHT}) == (BumperEvent(Bumper.LEFT, False), BumperEvent(Bumper.RIGHT, True))
    assert logic.look(set()) == (BumperEvent(Bumper.RIGHT, False),)


def test_what_is_pressed_at_first_is_told_of_when_it_is_let_go() -> None:
    logic = BumperLogic()
    assert logic.pressed == frozenset()
    assert logic.look({Bumper.CENTER}) == ()
    assert logic.pressed == {Bumper.CENTER}
    assert logic.look({Bumper.CENTER, Bumper.LEFT}) == (BumperEvent(Bumper.LEFT, True),)
    assert logic.look(set()) == (BumperEvent(Bumper.LEFT, False), BumperEvent(Bumper.CENTER, False))
    assert logic.look({Bumper.CENTER}) == (BumperEvent(Bumper.CENTER, True),)
