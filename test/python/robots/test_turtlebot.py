"""Facts of the TurtleBot: sectors of its bumper."""

from __future__ import annotations

import math

import pytest

from yarm.robots.turtlebot import Bumper, bumper_at


@pytest.mark.parametrize(
    "bearing_deg, sector",
    [
        *((0, Bumper.CENTER), (29, Bumper.CENTER), (-29, Bumper.CENTER)),
        *((31, Bumper.LEFT), (89, Bumper.LEFT), (-31, Bumper.RIGHT), (-89, Bumper.RIGHT)),
        *((91, None), (180, None), (-91, None)),
    ],
)
def test_a_contact_presses_the_sector_it_is_in(bearing_deg: float, sector: Bumper) -> None:
    assert bumper_at(math.radians(bearing_deg)) == sector
