"""Grid geometry: property tests against the plain formula."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.geometry import GridError, GridSpec

SPEC = GridSpec()
coordinate = st.floats(-4, 4, allow_nan=False)


@given(st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=1, max_size=30))
def test_cell_is_floor_of_scaled_point_and_outside_has_none(points):
    cells, inside = SPEC.cells_of(points)
    for point, cell, is_in in zip(points, cells, inside):
        expected = [math.floor((p - lo) / r) for p, lo, r in zip(point, SPEC.lower, SPEC.resolution)]
        within = all(0 <= e < n for e, n in zip(expected, SPEC.shape)) and all(
            p < hi for p, hi in zip(point, SPEC.upper)
        )
        assert is_in == within
        if within:
            assert list(cell) == expected


@given(st.integers(0, 49), st.integers(0, 49), st.integers(0, 19))
def test_centre_of_a_cell_lies_in_that_cell(x, y, z):
    cells, inside = SPEC.cells_of(SPEC.centres([(x, y, z)]))
    assert inside.all()
    assert tuple(cells[0]) == (x, y, z)


@given(st.lists(st.integers(0, 50 * 50 * 20 - 1), max_size=40))
def test_ravel_and_unravel_are_inverse(indices):
    assert list(SPEC.ravel(SPEC.unravel(indices))) == indices


@pytest.mark.parametrize("point", [(np.nan, 0, 0.5), (np.inf, 0, 0.5), (2.5, 0, 0.5), (0, 0, 1.3), (0, 0, 0.0)])
def test_points_outside_or_not_finite_have_no_cell(point):
    _, inside = SPEC.cells_of([point])
    assert not inside[0]


def test_column_of_a_point_outside_is_not_clamped():
    assert SPEC.column_of((-2.61, 2.5)) == (-2, 50)
    assert not SPEC.contains([(-2, 50, 0)])[0]


def test_column_of_nan_is_refused_by_value():
    with pytest.raises(GridError, match="finite"):
        SPEC.column_of((np.nan, 0.0))


def test_every_fault_of_a_grid_is_named_at_once():
    with pytest.raises(GridError, match=r"shape \(0, 5, 5\).*lower \(0, 0, 0\)"):
        GridSpec((0, 5, 5), (0, 0, 0), (0, 1, 1))


def test_cells_inside_are_distinct_and_ordered():
    points = [(0.01, 0.01, 0.5), (0.02, 0.02, 0.5), (-1.0, 0.0, 0.5), (9.0, 0.0, 0.5)]
    assert SPEC.cells_inside(points).tolist() == [[15, 25, 7], [25, 25, 7]]
