"""Frontier cells and their groups."""

from __future__ import annotations

import numpy as np
import pytest

from python.navigation.map_samples import drawn
from yarm.exploration.frontiers import beside, frontier_cells, frontiers_of

ROOM = drawn("?????\n?...?\n?.#.#\n?...?", scale=1)


def test_frontiers_are_unknown_cells_beside_free_ones() -> None:
    cells = frontier_cells(ROOM)
    assert np.all(ROOM.unknown[cells])
    expected = {(0, 0), (1, 0), (2, 0), (3, 1), (3, 2), (3, 3), (0, 4), (2, 4)}
    assert {(int(r), int(c)) for r, c in np.argwhere(cells)} == expected, "corners and what lies behind walls are none"


def test_groups_are_joined_across_corners_and_have_centroids() -> None:
    groups = frontiers_of(ROOM, frontier_cells(ROOM))
    assert sorted(len(group.cells) for group in groups) == [1, 7]
    long = max(groups, key=lambda group: len(group.cells))
    rows, columns = long.cells[:, 0], long.cells[:, 1]
    assert long.x == pytest.approx((columns.mean() + 0.5) * 0.05) and long.y == pytest.approx(
        (rows.mean() + 0.5) * 0.05
    )
    assert frontiers_of(ROOM, np.zeros((4, 5), bool)) == []


def test_beside_is_the_four_neighbours() -> None:
    one = np.zeros((3, 3), bool)
    one[1, 1] = True
    assert beside(one).tolist() == [[False, True, False], [True, False, True], [False, True, False]]
