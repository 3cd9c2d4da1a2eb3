"""When the map is saved, and that a mapping that begins anew does not cost the good one."""

from __future__ import annotations

import numpy as np

from yarm.exploration.map_keeper import EVERY_S, MapKeeper
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap


def grid(known):
    """A map of 20 x 20 cells of 0.1 m of which so many are free."""
    cells = np.full((20, 20), -1, np.int8)
    cells.ravel()[:known] = 0
    return GridMap(cells, 0.1, Pose2(0.0, 0.0))


def test_nothing_to_save_before_the_first_map():
    keeper = MapKeeper()
    assert keeper.take(None, 0, 0.0) is None
    assert keeper.order(5.0, "stop") is None
    assert keeper.due(1000.0) is None
    assert keeper.known_m2 == 0.0


def test_every_thirty_seconds_while_maps_come():
    keeper = MapKeeper()
    saved_s = []
    for now_s in range(100):
        if now_s < 70:
            keeper.take(grid(100 + now_s), now_s, float(now_s))
        order = keeper.due(float(now_s))
        if order is not None:
            saved_s.append(now_s)
            assert order.map is keeper.newest
            assert "every 30 s" in order.why
    assert saved_s == [30, 60, 90]


def test_a_map_that_does_not_change_is_not_saved_again():
    keeper = MapKeeper()
    keeper.take(grid(100), 1, 0.0)
    assert keeper.due(EVERY_S) is not None
    keeper.take(grid(100), 1, 0.0)
    assert keeper.due(3.0 * EVERY_S) is None


def test_the_last_good_map_of_a_mapping_that_began_anew_is_kept():
    keeper = MapKeeper()
    good = grid(300)
    keeper.take(grid(200), 1, 0.0)
    assert keeper.take(good, 2, 0.0) is None
    keeper.doubt()
    assert keeper.is_lost(grid(40))
    order = keeper.take(grid(40), 3, 0.0)
    assert order is not None
    assert order.map is good
    assert order.last_good
    assert keeper.take(grid(60), 4, 0.0) is None, "the new map is what counts from now on"
    assert keeper.known_m2 == 60 * 0.1**2


def test_a_mapping_that_thinks_better_of_it_is_no_new_one():
    keeper = MapKeeper()
    keeper.take(grid(300), 1, 0.0)
    assert keeper.take(grid(40), 2, 0.0) is None


def test_a_map_that_shrinks_a_little_is_no_new_one():
    keeper = MapKeeper()
    keeper.take(grid(300), 1, 0.0)
    keeper.doubt()
    assert keeper.take(grid(250), 2, 0.0) is None
