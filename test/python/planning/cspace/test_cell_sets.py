"""Boards against sets of tuples."""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Set, Tuple

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from yarm.planning.cspace import cell_sets as cs

LAYOUT = cs.Layout((7, 5, 4), 3)
GRIDS = arrays(np.bool_, LAYOUT.shape)
STEPS = st.integers(-9, 9)


def columns_of(column_set: int, layout: cs.Layout = LAYOUT) -> Set[Tuple[int, int]]:
    bits = cs.bits_of(column_set)
    return {(bit // layout.stride - layout.border, bit % layout.stride - layout.border) for bit in bits}


@settings(max_examples=30)
@given(GRIDS)
def test_a_grid_comes_back_from_layers(grid: np.ndarray) -> None:
    cell_set = LAYOUT.set_of_grid(grid)
    assert np.array_equal(LAYOUT.cells_of_set(cell_set), np.argwhere(grid))
    assert cell_set == LAYOUT.set_of_cells(np.argwhere(grid).astype(np.int64))


@settings(max_examples=30)
@given(GRIDS)
def test_a_margin_is_all_26_neighbours(grid: np.ndarray) -> None:
    inflated = cs.dilated(LAYOUT.set_of_grid(grid), LAYOUT.stride)
    padded = np.pad(grid, 1)
    gx, gy, gz = grid.shape
    expected = np.zeros_like(grid)
    for dx in range(3):
        for dy in range(3):
            for dz in range(3):
                expected |= padded[dx : dx + gx, dy : dy + gy, dz : dz + gz]
    assert np.array_equal(LAYOUT.cells_of_set(inflated), np.argwhere(expected))


def test_a_rectangle_and_the_field() -> None:
    assert columns_of(LAYOUT.rectangle(1, 3, -1, 0)) == {(x, y) for x in (1, 2, 3) for y in (-1, 0)}
    assert LAYOUT.rectangle(3, 2, 0, 4) == 0
    assert columns_of(LAYOUT.field) == {(x, y) for x in range(7) for y in range(5)}


@settings(max_examples=30)
@given(arrays(np.bool_, (7, 5)))
def test_an_image_comes_back_from_a_board(image: np.ndarray) -> None:
    assert np.array_equal(LAYOUT.image_of_set(LAYOUT.set_of_image(image)), image)


def touched(dx: int, dy: int) -> Set[Tuple[int, int]]:
    """Columns overlapped by a unit square on its way, by looking at very many places."""
    hit = set()
    for t in np.linspace(0.0, 1.0, 40 * (abs(dx) + abs(dy)) + 2):
        x, y = t * dx, t * dy
        for i in range(int(np.floor(x)) - 1, int(np.ceil(x)) + 2):
            for j in range(int(np.floor(y)) - 1, int(np.ceil(y)) + 2):
                if abs(i - x) < 1.0 - 1e-9 and abs(j - y) < 1.0 - 1e-9:
                    hit.add((i, j))
    return hit


@settings(max_examples=40)
@given(STEPS, STEPS)
def test_a_band_is_every_column_a_sliding_square_overlaps(dx: int, dy: int) -> None:
    layout = cs.Layout((40, 40, 1), 0)
    start = (15, 15)
    low = layout.bit(min(start[0], start[0] + dx), min(start[1], start[1] + dy))
    band = columns_of(cs.band(dx, dy, layout.stride) << low, layout)
    assert band == {(start[0] + i, start[1] + j) for i, j in touched(dx, dy)}


@given(STEPS, STEPS)
def test_a_band_is_the_same_both_ways(dx: int, dy: int) -> None:
    assert cs.band(dx, dy, 64) == cs.band(-dx, -dy, 64)


@given(st.integers(0, 2**40), st.integers(1, 20))
def test_smear_is_a_union_of_shifts(column_set: int, length: int) -> None:
    assert cs.smear(column_set, length) == reduce(or_, (column_set << k for k in range(length)))


def test_set_operations() -> None:
    a, b = (0b1100, 0b0001), (0b1010, 0b0010)
    assert cs.union(a, b) == (0b1110, 0b0011)
    assert cs.intersection(a, b) == (0b1000, 0)
    assert cs.difference(a, b) == (0b0100, 0b0001)
    assert cs.overlap(a, b)
    assert not cs.overlap((0, 1), (1, 0))
