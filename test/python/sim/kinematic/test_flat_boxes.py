"""Boxes from above: distances and rays against sums done by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from yarm.geometry import Pose2
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Block

BOX = Block("box", "block", Pose2(2.0, 0.0), (1.0, 2.0, 0.6))
TURNED = Block("turned", "block", Pose2(0.0, 3.0, math.radians(45.0)), (math.sqrt(2.0), math.sqrt(2.0), 0.6))


def test_distances_and_nearest_points() -> None:
    boxes = FlatBoxes([BOX, TURNED])
    assert boxes.distances(0.0, 0.0) == pytest.approx([1.5, 2.0])
    assert boxes.nearest_points(0.0, 0.5)[0] == pytest.approx([1.5, 0.5])
    assert boxes.nearest_point(1, 0.0, 0.0) == pytest.approx((0.0, 2.0))
    assert boxes.distances(2.0, 0.5)[0] == 0.0
    assert boxes.near(0.0, 0.0, 1.6) == [0]


def test_signed_distances_and_the_nearest_outline() -> None:
    boxes = FlatBoxes([BOX, TURNED])
    points = np.array([[0.0, 0.0], [1.6, 0.0], [0.0, 2.9]])
    assert boxes.signed(points)[:, 0] == pytest.approx([1.5, -0.1, math.hypot(1.5, 1.9)])
    assert boxes.signed(points)[2, 1] == pytest.approx(-0.9 * math.sqrt(0.5))
    closest = boxes.closest(points)
    assert closest[0] == pytest.approx([1.5, 0.0]) and closest[1] == pytest.approx([1.5, 0.0])
    assert boxes.signed(closest).min(axis=1) == pytest.approx(0.0, abs=1e-9)


def test_rays_meet_the_nearest_face_at_its_angle() -> None:
    hits = FlatBoxes([BOX, TURNED]).cast(0.0, 0.0, np.array([0.0, math.atan2(0.9, 1.5), 0.5 * math.pi - 1e-3, math.pi]))
    assert hits.ranges[:2] == pytest.approx([1.5, math.hypot(1.5, 0.9)])
    assert hits.cosines[:2] == pytest.approx([1.0, 1.5 / math.hypot(1.5, 0.9)])
    assert list(hits.boxes) == [0, 0, 1, -1] and math.isinf(hits.ranges[3])
    assert hits.cosines[2] == pytest.approx(math.sqrt(0.5), abs=2e-3)


def test_a_ray_from_inside_does_not_meet_its_box() -> None:
    assert FlatBoxes([BOX]).cast(2.0, 0.0, np.array([0.0])).boxes[0] == -1


def test_nothing_to_meet() -> None:
    assert np.all(np.isinf(FlatBoxes([]).cast(0.0, 0.0, np.array([0.0, 1.0])).ranges))


@given(
    st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-math.pi, math.pi), st.floats(0.1, 1.0), st.floats(0.1, 1.0)
)
def test_the_end_of_a_ray_lies_on_the_outline(x: float, y: float, yaw: float, width: float, depth: float) -> None:
    boxes = FlatBoxes([Block("b", "block", Pose2(x, y, yaw), (width, depth, 0.6))])
    # From a point of the outline itself a ray may run along it.
    assume(boxes.distances(0.0, 0.0)[0] > 1e-6)
    bearings = np.linspace(-math.pi, math.pi, 73)
    hits = boxes.cast(0.0, 0.0, bearings)
    for bearing, length in zip(bearings, hits.ranges):
        if math.isfinite(length):
            end = (length * math.cos(bearing), length * math.sin(bearing))
            assert boxes.distances(*end)[0] == pytest.approx(0.0, abs=1e-6)
            before = 0.5 * length
            assert boxes.distances(before * math.cos(bearing), before * math.sin(bearing))[0] > 0.0


@given(st.integers(0, 10_000))
def test_a_narrow_fan_meets_what_the_full_circle_meets(seed: int) -> None:
    draw = np.random.default_rng(seed)
    blocks = [
        Block(str(i), "block", Pose2(*draw.uniform(-3, 3, 2), draw.uniform(-3, 3)), (*draw.uniform(0.05, 2, 2), 0.6))
        for i in range(12)
    ]
    boxes = FlatBoxes(blocks)
    fan = draw.uniform(-3, 3) + np.linspace(-0.5, 0.5, 41)
    wide = np.concatenate([fan, fan + math.pi])
    assert np.array_equal(boxes.cast(0.1, 0.2, fan).boxes, boxes.cast(0.1, 0.2, wide).boxes[:41]), f"seed {seed}"
