from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.planning.graph import delaunay_edges, nearest, nearest_edges, neighbours_of
from yarm.planning.particles import (
    cell_order,
    largest_pocket,
    moved_order,
    narrow_columns,
    narrow_particles,
    random_particles,
    threshold_particles,
)

SHAPE = (50, 50)


@pytest.mark.parametrize("shape", [(50, 50), (7, 3), (1, 9), (1, 1)])
def test_the_order_holds_every_column_once(shape: tuple) -> None:
    order = cell_order(shape)
    assert len(order) == shape[0] * shape[1]
    assert len(np.unique(order, axis=0)) == len(order)
    assert np.all((order >= 0) & (order < shape))


@pytest.mark.parametrize("count", [20, 100, 333, 1000])
def test_every_beginning_of_the_order_is_more_even_than_a_random_draw(count: int) -> None:
    even = largest_pocket(cell_order(SHAPE)[:count], SHAPE)
    drawn = [largest_pocket(random_particles(count, SHAPE, np.random.default_rng(s)), SHAPE) for s in range(20)]
    assert even < np.median(drawn) if count == 20 else even < min(drawn)


def test_the_original_draw_repeats_itself_and_the_order_never_does() -> None:
    drawn = random_particles(2496, SHAPE, np.random.default_rng(0))
    assert 1500 < len(np.unique(drawn, axis=0)) < 1650
    assert len(np.unique(cell_order(SHAPE)[:2496], axis=0)) == 2496


def test_moved_orders_are_as_even_and_differ() -> None:
    moved = [moved_order(cell_order(SHAPE), SHAPE, number) for number in range(16)]
    assert all(len(np.unique(order, axis=0)) == 2500 for order in moved)
    assert len({order[:333].tobytes() for order in moved}) == 16


def test_narrow_places_get_more_particles() -> None:
    free = np.ones(SHAPE, dtype=bool)
    free[20:30, :20] = False
    free[20:30, 25:] = False
    narrow = narrow_columns(free)
    assert narrow[20:30, 22].all()
    assert not narrow[10, 10]
    order = cell_order(SHAPE)
    added = narrow_particles(order, 333, narrow, 3.0)
    assert narrow[added[:, 0], added[:, 1]].all()
    in_gap = int(narrow[order[:333, 0], order[:333, 1]].sum())
    assert len(added) > in_gap
    together = np.concatenate([order[:333], added])
    assert len(np.unique(together, axis=0)) == len(together)


def test_added_particles_are_joined_with_their_nearest() -> None:
    edges = nearest_edges(np.array([(0, 0), (9, 9), (1, 0), (2, 0)]), 2, 2)
    assert edges.tolist() == [[0, 2], [0, 3], [2, 3]]
    assert len(nearest_edges(np.array([(0, 0), (9, 9)]), 2, 2)) == 0


def test_the_threshold_of_the_original() -> None:
    assert threshold_particles((50, 50, 20)) == 333
    with pytest.raises(ValueError, match="positive"):
        threshold_particles((50, 50, 20), 0.0)


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), unique=True, max_size=40))
def test_the_graph_is_connected_whatever_the_particles(columns: list) -> None:
    points = np.array(columns, dtype=np.int64).reshape(-1, 2)
    edges = delaunay_edges(points)
    assert np.all(edges[:, 0] < edges[:, 1])
    neighbours = neighbours_of(len(points), edges)
    reached, stack = set(), [0] if len(points) else []
    while stack:
        i = stack.pop()
        if i not in reached:
            reached.add(i)
            stack.extend(neighbours[i])
    assert len(reached) == len(points)


def test_particles_on_a_line_make_a_chain() -> None:
    edges = delaunay_edges(np.array([(3, 3), (1, 1), (2, 2), (0, 0)]))
    assert edges.tolist() == [[0, 2], [1, 2], [1, 3]]


def test_triangles_meet_only_at_their_edges() -> None:
    edges = delaunay_edges(np.array([(0, 0), (4, 0), (0, 4), (5, 5)]))
    assert edges.tolist() in ([[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]], [[0, 1], [0, 2], [0, 3], [1, 3], [2, 3]])


def test_nearest_come_nearest_first() -> None:
    points = np.array([(0, 0), (5, 5), (1, 0), (9, 9)])
    assert nearest(points, (0, 0), 3) == (0, 2, 1)
    assert nearest(points, (0, 0), 99) == (0, 2, 1, 3)
