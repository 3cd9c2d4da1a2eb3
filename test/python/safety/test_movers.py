"""How fast things move that only the grid knows."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.safety.movers import FASTEST_MPS, LEAST_MAPS, Movers

SPEC = GridSpec()
RATE_HZ = 30.0


def cells_at(rng, x, y):
    """Cells of a person of 0.4 x 0.4 x 1.2 m whose surface is seen with noise, a tenth of it not at all."""
    points = rng.uniform((-0.2, -0.2, 0.05), (0.2, 0.2, 1.2), size=(6000, 3))
    points += rng.normal(0.0, 0.01, points.shape) + np.array([x, y, 0.0])
    cells = np.unique(SPEC.cells_inside(points), axis=0)
    return cells[rng.random(len(cells)) > 0.1]


def walk(movers, rng, maps, velocity, start=(0.0, 0.0), name="unknown_1"):
    for i in range(maps):
        at = np.array(start) + np.array(velocity) * i / RATE_HZ
        movers.see(i / RATE_HZ, SPEC, {name: cells_at(rng, *at)})
    return movers.velocity(name)


@pytest.mark.parametrize("velocity", [(1.0, 0.0), (0.0, -1.0), (-0.7, 0.7), (0.5, 0.0), (1.1, 1.1)])
def test_a_walk_is_measured(velocity):
    assert walk(Movers(0.3), np.random.default_rng(1), 12, velocity) == pytest.approx(velocity, abs=0.2)


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.05, 0.0), (0.3, 0.25), (0.0, 0.1)])
def test_somebody_who_stands_does_not_move_whatever_the_noise_at_the_edges(place):
    movers = Movers(0.3)
    rng = np.random.default_rng(2)
    for i in range(40):
        movers.see(i / RATE_HZ, SPEC, {"unknown_1": cells_at(rng, *place)})
        assert movers.velocity("unknown_1") == (0.0, 0.0)


def test_who_has_stopped_walking_stands_after_the_window():
    movers, rng = Movers(0.3), np.random.default_rng(3)
    walk(movers, rng, 10, (1.0, 0.0))
    for i in range(10, 20):
        movers.see(i / RATE_HZ, SPEC, {"unknown_1": cells_at(rng, 0.3, 0.0)})
    assert movers.velocity("unknown_1") == (0.0, 0.0)


def test_few_maps_tell_nothing_and_a_new_name_begins_anew():
    movers, rng = Movers(0.3), np.random.default_rng(4)
    assert walk(movers, rng, LEAST_MAPS - 1, (1.0, 0.0)) == (0.0, 0.0)
    assert movers.velocity("unknown_2") == (0.0, 0.0)
    movers.see(1.0, SPEC, {"unknown_2": cells_at(rng, 0.3, 0.0)})
    assert movers.velocity("unknown_1") == (0.0, 0.0)


def test_what_comes_into_view_does_not_move():
    movers, rng = Movers(0.3), np.random.default_rng(5)
    whole = cells_at(rng, 0.0, 0.0)
    for i in range(8):
        shown = whole[whole[:, 0] <= whole[:, 0].min() + i // 2]
        movers.see(i / RATE_HZ, SPEC, {"unknown_1": shown})
        assert movers.velocity("unknown_1") == (0.0, 0.0)


def test_a_map_seen_twice_counts_once_and_nobody_is_faster_than_the_fastest():
    movers, rng = Movers(0.3), np.random.default_rng(6)
    for _ in range(8):
        movers.see(0.5, SPEC, {"unknown_1": cells_at(rng, 0.0, 0.0)})
    assert movers.velocity("unknown_1") == (0.0, 0.0)
    movers.reset()
    assert np.hypot(*walk(movers, rng, 8, (4.0, 0.0))) == pytest.approx(FASTEST_MPS)
