"""Contacts that last are one touch; how fast the robot was before it."""

from __future__ import annotations

import math

import pytest

from yarm.geometry import Pose2
from yarm.sim.touches import APART_S, TouchLog


def driven(log: TouchLog, seconds: float, v_mps: float, began_s: float = 0.0) -> None:
    for i in range(round(50 * seconds)):
        log.moved(began_s + i / 50, Pose2(v_mps * i / 50, 0.0, 0.5))


def test_a_contact_that_goes_on_is_one_touch_and_a_later_one_another() -> None:
    log = TouchLog({"brick": 0.1, "wall": 0.6})
    driven(log, 2.0, 0.2)
    for t_s in (2.0, 2.1, 2.3):
        log.contact(t_s, "brick", 1.0, 0.0)
    log.contact(2.3, "wall", 1.0, 0.2)
    log.contact(2.3 + APART_S + 0.01, "brick", 1.0, 0.0)
    assert [touch.block for touch in log.touches] == ["brick", "wall", "brick"]
    assert [touch.t_s for touch in log.touches] == pytest.approx([2.0, 2.3, 2.61])
    first = log.touches[0]
    assert first.height_m == 0.1 and (first.x, first.y) == (1.0, 0.0)
    assert first.bearing_rad == pytest.approx(-0.5) and first.speed_mps == pytest.approx(0.2)


def test_the_speed_is_the_greatest_of_the_moments_just_before() -> None:
    log = TouchLog({})
    driven(log, 1.0, 0.3)
    for i in range(5):
        log.moved(1.0 + i / 50, Pose2(0.294, 0.0, 0.5))
    log.contact(1.1, "unknown", 0.5, 0.0)
    assert log.touches[0].speed_mps == pytest.approx(0.3) and math.isinf(log.touches[0].height_m)
    for i in range(50):
        log.moved(1.12 + i / 50, Pose2(0.294, 0.0, 0.5))
    log.contact(2.2, "unknown", 0.5, 0.0)
    assert log.touches[1].speed_mps == 0.0, "it has stood since"


def test_before_the_robot_was_seen_nothing_counts() -> None:
    log = TouchLog({})
    log.contact(0.0, "wall", 1.0, 0.0)
    assert log.touches == []
