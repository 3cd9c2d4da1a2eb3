"""The graph over the particles: connected, few edges, the nearest first."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from yarm.planning.roadmap.graph import NearestTable, delaunay_edges, nearest, neighbours_of


def test_added_particles_are_joined_with_their_nearest_in_use() -> None:
    points = np.array([(0, 0), (9, 9), (1, 0), (2, 0), (3, 0)])
    table = NearestTable(points, 2)
    used = np.array([True, True, True, True, False])
    assert table.edges(np.array([2, 3]), used).tolist() == [[0, 2], [2, 3]]
    used[4] = True
    assert table.edges(np.array([2, 3, 4]), used).tolist() == [[0, 2], [2, 3], [2, 4], [3, 4]]
    assert len(table.edges(np.array([], dtype=np.int64), used)) == 0


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), unique=True, min_size=1, max_size=40), st.data())
def test_the_nearest_are_the_same_whenever_they_are_asked_for(columns: list, data: st.DataObject) -> None:
    points = np.array(columns, dtype=np.int64)
    everything = np.arange(len(points))
    at_once, in_parts = NearestTable(points, 5), NearestTable(points, 5)
    for _ in range(3):
        in_parts.of(np.array(data.draw(st.lists(st.sampled_from(everything.tolist()), unique=True)), dtype=np.int64))
    near = at_once.of(everything)
    assert np.array_equal(in_parts.of(everything), near)
    distances = np.linalg.norm(points[:, None] - points, axis=2)
    assert np.allclose(np.take_along_axis(distances, near, 1), np.sort(distances, axis=1)[:, : near.shape[1]])


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
