"""Where a person who walks through the cell is drawn to be in a second."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.console.foresight import AHEAD_S, Foresight
from yarm.geometry import CellMap, GridSpec, MappedObject

SPEC = GridSpec()
RATE_HZ = 10.0


def seen(foresight, name, speed_mps, count=12, begin_s=50.0):
    """Lines of the last of some maps in which a block of cells moves along x."""
    found = []
    for i in range(count):
        x_m = -1.0 + speed_mps * i / RATE_HZ
        column = SPEC.column_of((x_m, 0.5))
        cells = np.array([(column[0] + a, column[1] + b, c) for a in range(4) for b in range(4) for c in range(10)])
        thing = MappedObject(name, "Obstacle", 1, (x_m, 0.5, 0.5), (0.0, 0.0, 0.0, 1.0), cells)
        found = foresight.lines(CellMap(begin_s + i / RATE_HZ, SPEC, np.zeros(SPEC.shape, np.int8), {name: thing}))
    return found, SPEC.centres(cells)[:, :2].mean(axis=0)


@pytest.mark.parametrize("speed_mps", [0.8, 1.2])
def test_a_disc_is_where_it_will_be(speed_mps):
    (way, disc), middle = seen(Foresight(), "unknown_1", speed_mps)
    assert {way.layer, disc.layer} == {"predicted"}
    np.testing.assert_allclose(way.points[0, :2], middle, atol=1e-9)
    there = middle + np.array((AHEAD_S * speed_mps, 0.0))
    np.testing.assert_allclose(way.points[1, :2], there, atol=0.15 * speed_mps)
    np.testing.assert_allclose(disc.points[:-1, :2].mean(axis=0), way.points[1, :2], atol=1e-6)
    radius_m = np.linalg.norm(disc.points[0, :2] - way.points[1, :2])
    assert 1.5 * SPEC.resolution[0] < radius_m < 4 * SPEC.resolution[0]


def test_what_stands_and_what_is_registered_have_none():
    assert seen(Foresight(), "unknown_1", 0.0)[0] == []
    assert seen(Foresight(), "ankurbot_1", 1.0)[0] == []


def test_after_time_went_back_it_begins_anew():
    foresight = Foresight()
    assert seen(foresight, "unknown_1", 1.0)[0]
    foresight.clear()
    assert seen(foresight, "unknown_1", 1.0, count=2, begin_s=1.0)[0] == []
    assert seen(foresight, "unknown_1", 1.0, begin_s=2.0)[0]
