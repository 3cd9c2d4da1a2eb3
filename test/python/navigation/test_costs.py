"""Room on a flat map: exact discs against squares."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.navigation.costs import FAR_M, Room, blocked, clearance, disc_kernel, drive_cost, near, passable
from yarm.navigation.grid_map import GridMap


def room_with(cells: list[tuple[int, int]], shape: tuple[int, int] = (12, 16), yaw_rad: float = 0.0) -> GridMap:
    grid = np.zeros(shape, np.int8)
    for cell in cells:
        grid[cell] = 100
    return GridMap(grid, 0.05, Pose2(1.0, -2.0, yaw_rad))


def square_distance(room: GridMap, x: float, y: float) -> float:
    """To the nearest occupied square, by looking at every one."""
    local = room.origin.inverse().compose(Pose2(x, y))
    best = math.inf
    for row, column in np.argwhere(room.occupied):
        dx = max(abs((column + 0.5) * 0.05 - local.x) - 0.025, 0.0)
        dy = max(abs((row + 0.5) * 0.05 - local.y) - 0.025, 0.0)
        best = min(best, math.hypot(dx, dy))
    return best


def test_clearance_is_the_distance_between_centres() -> None:
    room = room_with([(5, 5)])
    assert clearance(room)[5, 9] == pytest.approx(0.2) and clearance(room)[8, 9] == pytest.approx(0.25)
    assert np.all(clearance(room_with([])) == FAR_M)


@pytest.mark.parametrize("radius", [0.0, 0.4, 1.0, 3.6, 3.68])
def test_blocked_is_where_a_disc_touches_a_square(radius: float) -> None:
    rng = np.random.default_rng(3)
    cells = [(int(r), int(c)) for r, c in zip(rng.integers(0, 12, 6), rng.integers(0, 16, 6))]
    room = room_with(cells)
    found = blocked(room.occupied, radius)
    for row in range(room.rows):
        for column in range(room.columns):
            touches = square_distance(room, *room.centre_of(row, column)) < radius * 0.05 - 1e-9
            assert found[row, column] == touches, (row, column)


def test_the_kernel_is_kept_and_cannot_be_changed() -> None:
    kernel = disc_kernel(3.6)
    with pytest.raises(ValueError, match="read-only"):
        kernel[0, 0] = True


def test_unknown_ground_is_passable_only_when_asked_for() -> None:
    room = room_with([(5, 5)])
    room.cells[:, 10:] = -1
    assert passable(room, 0.18)[0, 9] and not passable(room, 0.18)[0, 11]
    assert passable(room, 0.18, unknown_passable=True)[0, 11]
    assert not passable(room, 0.18, unknown_passable=True)[5, 6]


@pytest.mark.parametrize("yaw_rad", [0.0, 0.7])
def test_room_around_points_is_exact(yaw_rad: float) -> None:
    room = room_with([(2, 3), (6, 6), (6, 7), (11, 0)], yaw_rad=yaw_rad)
    points = np.array([1.0, -2.0]) + np.random.default_rng(5).uniform(-0.3, 1.2, (200, 2))
    found = Room(room, 0.2).distances(points)
    for point, distance in zip(points, found):
        assert distance == pytest.approx(min(square_distance(room, *point), 0.2), abs=1e-9)
    assert len(Room(room, 0.2).distances(np.zeros((0, 2)))) == 0


def test_a_way_costs_more_where_it_is_narrow() -> None:
    cost = drive_cost(np.array([0.1, 0.18, 0.28, 0.38, 5.0]), 0.18, 0.38, 2.0)
    assert cost == pytest.approx([3.0, 3.0, 2.0, 1.0, 1.0])
    assert drive_cost(np.array([0.18, 0.38]), 0.18) == pytest.approx([2.0, 1.0])


def test_near_is_a_disc_of_cells() -> None:
    room = room_with([])
    x, y = room.centre_of(5, 5)
    found = near(room, x, y, 0.1)
    assert found.sum() == 13 and found[5, 7] and not found[6, 7]
