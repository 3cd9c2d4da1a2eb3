"""Known bodies in a map: what they cover is occupied, their sides lie where they are, faults are named."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.geometry import Pose2
from yarm.navigation.bodies import distances, with_bodies
from yarm.navigation.grid_map import GridMap

EMPTY = GridMap(np.zeros((60, 80), np.int8), 0.05, Pose2(-2.0, -1.5))
SQUARE = np.array([(0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)])


def placed(x: float, y: float, yaw: float, wide: float, deep: float) -> np.ndarray:
    return Pose2(x, y, yaw).moved(SQUARE * (wide, deep))


poses = st.tuples(
    st.floats(-1.2, 1.2), st.floats(-0.7, 0.7), st.floats(-math.pi, math.pi), st.floats(0.1, 0.6), st.floats(0.1, 0.6)
)


@given(poses)
def test_cells_within_half_a_cell_of_the_body_are_taken_and_no_others(box: tuple) -> None:
    outline = placed(*box)
    made = with_bodies(EMPTY, [outline])
    rows, columns = np.indices(EMPTY.cells.shape)
    local = Pose2(*box[:3]).inverse().moved(EMPTY.centres_of(np.stack([rows.ravel(), columns.ravel()], axis=1)))
    beyond = np.maximum(np.abs(local) - 0.5 * np.array(box[3:]), 0.0)
    gap = np.hypot(*beyond.T).reshape(EMPTY.cells.shape)
    sure = np.abs(gap - 0.025) > 1e-9
    assert np.array_equal(made.occupied[sure], (gap <= 0.025)[sure])


def test_the_map_that_was_given_stays_as_it_was_and_other_cells_keep_their_values() -> None:
    cells = np.full((20, 20), -1, np.int8)
    given_map = GridMap(cells, 0.05, Pose2(0.0, 0.0))
    made = with_bodies(given_map, [placed(0.5, 0.5, 0.3, 0.2, 0.2)])
    assert (given_map.cells == -1).all() and set(np.unique(made.cells)) == {-1, 100}


def test_a_body_outside_or_half_outside_the_map_is_cut_off() -> None:
    assert not with_bodies(EMPTY, [placed(9.0, 9.0, 0.0, 0.5, 0.5)]).occupied.any()
    assert with_bodies(EMPTY, [placed(-2.0, 0.0, 0.0, 0.5, 0.5)]).occupied[:, :6].any()


def test_a_turned_map_takes_bodies_where_they_are() -> None:
    turned = GridMap(np.zeros((40, 40), np.int8), 0.05, Pose2(0.3, -0.2, 0.7))
    made = with_bodies(turned, [placed(0.5, 0.9, 0.1, 0.2, 0.2)])
    middles = made.centres_of(np.argwhere(made.occupied))
    assert np.abs(middles.mean(axis=0) - (0.5, 0.9)).max() < 0.02


def test_distances_are_zero_inside_and_to_the_nearest_side_or_corner_outside() -> None:
    found = distances(np.array([(0.0, 0.0), (0.8, 0.0), (0.8, 0.9)]), SQUARE)
    assert found == pytest.approx([0.0, 0.3, 0.5])


@pytest.mark.parametrize(
    "outline",
    [SQUARE[:2], SQUARE[::-1], np.zeros((4, 2)), SQUARE * np.nan, np.array([(0, 0), (1, 0), (0.2, 0.2), (0, 1.0)])],
)
def test_outlines_that_are_none_are_refused(outline: np.ndarray) -> None:
    with pytest.raises(ValueError, match="outline 1 must be"):
        with_bodies(EMPTY, [SQUARE, outline])
