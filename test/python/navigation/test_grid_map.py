"""The flat map: cells and points of it, also when it is turned."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap


def example(yaw_rad: float = 0.0) -> GridMap:
    cells = np.full((4, 6), -1, np.int8)
    cells[1, 2], cells[1, 3], cells[2, 2], cells[3, 5] = 0, 100, 50, 25
    return GridMap(cells, 0.5, Pose2(-1.0, 2.0, yaw_rad))


def test_free_occupied_and_unknown_share_the_cells_out() -> None:
    room = example()
    assert room.free.sum() == 2 and room.occupied.sum() == 1 and room.unknown.sum() == 21
    assert np.all(room.free.astype(int) + room.occupied + room.unknown == 1)
    assert room.known_m2 == pytest.approx(3 * 0.25)


@pytest.mark.parametrize("yaw_rad", [0.0, math.pi / 2, -0.3])
def test_the_centre_of_a_cell_lies_in_it(yaw_rad: float) -> None:
    room = example(yaw_rad)
    for row in range(room.rows):
        for column in range(room.columns):
            assert room.cell_of(*room.centre_of(row, column)) == (row, column)


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0])
def test_many_points_are_as_one(yaw_rad: float) -> None:
    room = example(yaw_rad)
    points = np.random.default_rng(4).uniform(-5.0, 5.0, (50, 2))
    assert [tuple(cell) for cell in room.cells_of(points)] == [room.cell_of(x, y) for x, y in points]


def test_row_0_is_at_the_least_y() -> None:
    room = example()
    assert room.centre_of(0, 0) == (-0.75, 2.25) and room.centre_of(3, 5) == (1.75, 3.75)
    assert room.inside(3, 5) and not room.inside(4, 0) and not room.inside(0, -1)
