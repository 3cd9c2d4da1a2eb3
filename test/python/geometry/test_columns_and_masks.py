"""Column images and masks against cell-by-cell brute force."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import binary_dilation

from yarm.geometry import (
    GridError,
    GridSpec,
    Mask,
    cells_from_columns,
    columns_from_cells,
    columns_from_grid,
    dilated,
    grid_from_columns,
    shifted,
)

SHAPE = (7, 6, 20)
cell_sets = st.lists(st.tuples(st.integers(0, 6), st.integers(0, 5), st.integers(0, 19)), unique=True, max_size=60).map(
    lambda cells: np.array(sorted(cells), dtype=np.int64).reshape(-1, 3)
)


def grid_of(cells):
    grid = np.zeros(SHAPE, dtype=np.int8)
    grid[tuple(cells.T)] = 1
    return grid


@given(cell_sets)
def test_cells_columns_and_grid_agree(cells):
    image = columns_from_cells(cells, SHAPE[:2])
    assert np.array_equal(image, columns_from_grid(grid_of(cells)))
    assert np.array_equal(grid_from_columns(image, SHAPE[2]), grid_of(cells) != 0)
    assert np.array_equal(cells_from_columns(image, SHAPE[2]), cells)


@given(cell_sets, st.integers(1, 2))
def test_margin_is_the_26_neighbourhood(cells, margin):
    grid = grid_of(cells) != 0
    expected = binary_dilation(grid, np.ones((3, 3, 3)), iterations=margin) if margin else grid
    assert np.array_equal(grid_from_columns(dilated(columns_from_grid(grid), SHAPE[2], margin), SHAPE[2]), expected)


@given(cell_sets, st.integers(-8, 8), st.integers(-8, 8))
def test_shift_moves_every_cell_and_loses_what_leaves(cells, dx, dy):
    moved = cells + np.array([dx, dy, 0])
    kept = moved[(moved[:, 0] >= 0) & (moved[:, 0] < 7) & (moved[:, 1] >= 0) & (moved[:, 1] < 6)]
    image = shifted(columns_from_cells(cells, SHAPE[:2]), dx, dy)
    assert np.array_equal(cells_from_columns(image, SHAPE[2]), kept)


def test_cells_outside_the_columns_are_refused():
    with pytest.raises(GridError, match="7 x 6"):
        columns_from_cells([(7, 0, 0)], SHAPE[:2])


@settings(max_examples=30)
@given(st.floats(-math.pi, math.pi), st.integers(0, 2**32 - 1))
def test_turned_mask_covers_the_turned_solid(angle, seed):
    """Points of the solid, turned exactly, lie in the turned mask or a neighbouring cell; no cells are lost."""
    rng = np.random.default_rng(seed)
    spec = GridSpec()
    mask = Mask.from_cells([(x, y, 5) for x in range(0, 13) for y in range(-2, 3)], (0, 0))
    turned = mask.turned(angle, spec)
    picked = mask.cells[rng.integers(len(mask.cells), size=200)]
    points = picked[:, :2] + rng.uniform(-0.5, 0.5, (200, 2))
    c, s = math.cos(angle), math.sin(angle)
    exact = np.rint(points @ np.array([[c, s], [-s, c]])).astype(int)
    have = {tuple(cell[:2]) for cell in turned.cells}
    for cell in exact:
        assert any((cell[0] + i, cell[1] + j) in have for i in (-1, 0, 1) for j in (-1, 0, 1)), f"seed {seed}"
    assert len(turned.cells) >= len(mask.cells)


def test_quarter_turn_is_exact_and_four_come_back():
    spec = GridSpec()
    mask = Mask.from_cells([(0, 0, 1), (1, 0, 1), (2, 0, 2)], (0, 0))
    quarter = mask.turned(math.pi / 2, spec)
    assert quarter.cells.tolist() == [[0, 0, 1], [0, 1, 1], [0, 2, 2]]
    again = mask
    for _ in range(4):
        again = again.turned(math.pi / 2, spec)
    assert np.array_equal(again.cells, mask.cells)


def test_empty_mask_is_refused():
    with pytest.raises(GridError, match="at least one cell"):
        Mask.from_cells([], (0, 0))
