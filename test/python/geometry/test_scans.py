"""Laser scans: which beams mean anything, and where their hits are on the robot."""

from __future__ import annotations

import math

import numpy as np

from yarm.geometry import Pose2
from yarm.geometry.scans import Scan

SCAN = Scan(1.0, np.array([0.4, 1.0, np.nan, 2.0, 11.0], np.float32), -math.pi / 2, math.pi / 4, 0.45, 10.0)


def test_only_what_lies_within_the_limits_is_valid() -> None:
    assert list(SCAN.valid()) == [False, True, False, True, False]


def test_points_lie_at_their_bearings() -> None:
    half = math.sqrt(0.5)
    assert np.allclose(SCAN.points(), [[half, -half], [2 * half, 2 * half]])


def test_points_are_of_the_robots_base() -> None:
    turned = Scan(1.0, np.array([2.0], np.float32), 0.0, 0.1, 0.45, 10.0, Pose2(-0.1, 0.2, math.pi / 2))
    assert np.allclose(turned.points(), [[-0.1, 2.2]])
