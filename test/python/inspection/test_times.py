"""How long drives take: undisturbed, and what they hardly ever exceed."""

from __future__ import annotations

import math

import pytest

from yarm.geometry import Pose2
from yarm.inspection.times import PRIOR_RATIO, SPEED_MPS, START_S, TURN_RADPS, TYPICAL_RATIO, DriveTimes


def test_a_straight_way_takes_its_length_and_its_turns() -> None:
    start, goal = Pose2(0.0, 0.0, 0.0), Pose2(0.0, 3.0, math.pi)
    assert DriveTimes.undisturbed_s(3.0, start, goal) == pytest.approx(START_S + 3.0 / SPEED_MPS + math.pi / TURN_RADPS)
    assert DriveTimes.undisturbed_s(math.inf, start, goal) == math.inf


def test_in_place_only_the_turn_counts() -> None:
    assert DriveTimes.undisturbed_s(0.0, Pose2(0.0, 0.0), Pose2(0.0, 0.0, 0.8)) == pytest.approx(START_S + 1.0)


def test_it_learns_from_what_was_driven() -> None:
    times = DriveTimes()
    assert times.ratio == PRIOR_RATIO and times.typical == TYPICAL_RATIO
    for _ in range(40):
        times.add(10.0, 11.0)
    assert times.ratio == pytest.approx(1.1) and times.late_s(20.0) == pytest.approx(22.0)
    for _ in range(4):
        times.add(10.0, 30.0)
    assert times.ratio == pytest.approx(3.0), "one drive in twenty is late"
    assert times.typical == pytest.approx(1.1)
