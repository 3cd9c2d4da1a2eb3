"""Measures of an outline."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.tags.quads import (
    angles_deg,
    area,
    bottom_left,
    bottom_left_angle_deg,
    effective_area,
    is_tangled,
    mapped_corners,
)

SQUARE = np.array([[10.0, 10.0], [110.0, 10.0], [110.0, 90.0], [10.0, 90.0]])


def test_a_rectangle() -> None:
    assert area(SQUARE) == 8000.0
    assert angles_deg(SQUARE) == pytest.approx((90.0,) * 4)
    assert bottom_left(SQUARE) == 3
    assert not is_tangled(SQUARE)


def test_the_bottom_left_corner_is_found_on_a_tag_that_stands_on_its_head() -> None:
    turned = SQUARE[[2, 3, 0, 1]]
    assert bottom_left(turned) == 1
    skewed = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [-100.0, 100.0]])
    assert bottom_left_angle_deg(skewed) == pytest.approx(45.0)


def test_a_bow_tie_is_tangled() -> None:
    assert is_tangled(SQUARE[[0, 1, 3, 2]])
    assert is_tangled(SQUARE[[0, 2, 1, 3]])


def test_corners_that_fall_together_have_no_angle() -> None:
    assert np.isnan(angles_deg(SQUARE[[0, 0, 2, 3]])[0])


def test_what_is_outside_the_image_counts_against_the_outline() -> None:
    assert effective_area(SQUARE, 640, 480) == pytest.approx(8000.0, rel=0.03)
    half = SQUARE - (60.0, 0.0)
    assert effective_area(half, 640, 480) == pytest.approx(4000.0 - 0.5 * 4000.0, rel=0.12)
    assert effective_area(SQUARE + 1e6, 640, 480) == pytest.approx(-4000.0, rel=0.03)


def test_corners_are_mapped_in_order() -> None:
    moved = mapped_corners(np.array([[2.0, 0.0, 5.0], [0.0, 2.0, 7.0], [0.0, 0.0, 1.0]]), 10, 8)
    assert moved.tolist() == [[5.0, 7.0], [25.0, 7.0], [25.0, 23.0], [5.0, 23.0]]
