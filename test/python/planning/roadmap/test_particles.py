"""Particles: every column once, even from the first to the last, denser where free space is narrow."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from yarm.planning.cspace.cell_sets import Layout
from yarm.planning.roadmap.particles import (
    cell_order,
    moved_order,
    narrow_columns,
    random_particles,
    threshold_particles,
)
from yarm.planning.roadmap.roadmap import even_roadmap

SHAPE = (50, 50)


@pytest.mark.parametrize("shape", [(50, 50), (7, 3), (1, 9), (1, 1)])
def test_the_order_holds_every_column_once(shape: tuple) -> None:
    order = cell_order(shape)
    assert len(order) == shape[0] * shape[1]
    assert len(np.unique(order, axis=0)) == len(order)
    assert np.all((order >= 0) & (order < shape))


def largest_pocket(particles: np.ndarray) -> float:
    """Radius, cells, of the largest circle around a column that holds no particle."""
    distances, _ = cKDTree(particles).query(np.argwhere(np.ones(SHAPE, dtype=bool)))
    return float(distances.max())


@pytest.mark.parametrize("count", [20, 100, 333, 1000])
def test_every_beginning_of_the_order_is_more_even_than_a_random_draw(count: int) -> None:
    even = largest_pocket(cell_order(SHAPE)[:count])
    drawn = [largest_pocket(random_particles(count, SHAPE, np.random.default_rng(s))) for s in range(20)]
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
    layout = Layout((*SHAPE, 1), 8)
    narrow = layout.image_of_set(narrow_columns(layout.set_of_image(free), layout.stride))
    assert narrow[20:30, 22].all()
    assert not narrow[10, 10]
    roadmap = even_roadmap(SHAPE, 333, 0, 3.0).denser(lambda columns: narrow[columns[:, 0], columns[:, 1]])
    assert roadmap.nearest((25, 22), 1), "asking for columns in use is what chooses the further ones"
    first, added = roadmap.particles[:333], roadmap.particles[333:]
    assert narrow[added[:, 0], added[:, 1]].all()
    assert len(added) > int(narrow[first[:, 0], first[:, 1]].sum())
    assert len(np.unique(roadmap.particles, axis=0)) == len(roadmap.particles)
    bounded = even_roadmap(SHAPE, 333, 0, 3.0, 400).denser(lambda columns: np.ones(len(columns), dtype=bool))
    assert bounded.nearest((25, 22), 1)
    assert bounded.used == len(bounded.particles) == 400


def test_the_threshold_of_the_original() -> None:
    assert threshold_particles((50, 50, 20)) == 333
    with pytest.raises(ValueError, match="positive"):
        threshold_particles((50, 50, 20), 0.0)


def test_narrow_is_what_the_definition_says_whatever_is_free() -> None:
    for seed in range(20):
        free = np.random.default_rng(seed).random((9, 7)) < 0.7
        layout = Layout((9, 7, 1), 8)
        found = layout.image_of_set(narrow_columns(layout.set_of_image(free), layout.stride, 2))
        padded = np.pad(~free, 2, constant_values=True)
        for x, y in np.argwhere(free) + 2:
            along_x = padded[x - 2 : x, y].any() and padded[x + 1 : x + 3, y].any()
            along_y = padded[x, y - 2 : y].any() and padded[x, y + 1 : y + 3].any()
            assert found[x - 2, y - 2] == (along_x or along_y), (seed, x, y)
        assert not (found & ~free).any()
