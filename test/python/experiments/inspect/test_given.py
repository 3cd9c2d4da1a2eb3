"""What a round is given: the empty room's map lies over the room, the boxes' file says where they are."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from yarm.experiments.inspect.eyes import boxes_of
from yarm.experiments.inspect.given import CELL_M, FINE_CELL_M, room_map, write_given
from yarm.inspection.inputs import read_boxes
from yarm.navigation.bodies import with_bodies
from yarm.navigation.map_file import read_map
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.layout import Layout
from yarm.sim.scenes.layout_file import find_layout


@pytest.fixture(scope="module", params=["practice", "wall_2"])
def layout(request: pytest.FixtureRequest) -> Layout:
    return find_layout(request.param)


@pytest.fixture(params=[CELL_M, FINE_CELL_M])
def cell_m(request: pytest.FixtureRequest) -> float:
    return float(request.param)


def test_the_room_is_free_inside_its_walls_and_not_known_beyond(layout: Layout, cell_m: float) -> None:
    grid = room_map(layout, cell_m)
    for x, y in np.random.default_rng(1).uniform(layout.arena.lower, layout.arena.upper, (200, 2)):
        gap = min(x - layout.arena.lower[0], y - layout.arena.lower[1])
        gap = min(gap, layout.arena.upper[0] - x, layout.arena.upper[1] - y)
        if gap > 1.2 * cell_m:
            assert grid.free[grid.cell_of(float(x), float(y))], (x, y)
    for x, y in ((layout.arena.lower[0] - 0.025, 0.0), (0.0, layout.arena.upper[1] + 0.025)):
        assert grid.occupied[grid.cell_of(x, y)]
    assert grid.unknown[0, 0] and grid.unknown[-1, -1]


def test_walls_in_the_map_lie_where_they_are(layout: Layout, cell_m: float) -> None:
    grid = room_map(layout, cell_m)
    middles = grid.centres_of(np.argwhere(grid.occupied))
    walls = FlatBoxes([block for block in layout.arena.blocks if block.kind == "wall"])
    assert walls.signed(middles).min(axis=1).max() <= 0.5 * cell_m + 1e-9


def test_the_faces_of_the_walls_lie_on_middles_of_cells(layout: Layout, cell_m: float) -> None:
    """On the border between two cells rounding would choose, and the place be half a cell off."""
    grid, (lower, upper) = room_map(layout, cell_m), (layout.arena.lower, layout.arena.upper)
    row, column = grid.cell_of(0.5 * (lower[0] + upper[0]), 0.5 * (lower[1] + upper[1]))
    along_x = grid.centres_of(np.argwhere(~grid.occupied[row : row + 1] & ~grid.unknown[row : row + 1]))[:, 0]
    along_y = grid.centres_of(
        np.argwhere(~grid.occupied[:, column : column + 1] & ~grid.unknown[:, column : column + 1])
    )
    for free, low, high in ((along_x, lower[0], upper[0]), (along_y[:, 1], lower[1], upper[1])):
        assert (free.min() - cell_m, free.max() + cell_m) == pytest.approx((low, high), abs=1e-6)


def test_the_files_say_the_same(layout: Layout, tmp_path: Path) -> None:
    given = write_given(layout, tmp_path / "new")
    boxes = read_boxes(given.boxes)
    assert [box.size for box in boxes] == [box.size for box in boxes_of(layout)]
    for box, true in zip(boxes, layout.boxes):
        assert box.pose.distance(true.pose) < 1e-12 and math.isclose(box.pose.yaw_rad, true.pose.yaw_rad)
    for cell_m, file in ((CELL_M, given.map), (FINE_CELL_M, given.fine_map)):
        grid, read = room_map(layout, cell_m), read_map(file)
        assert np.array_equal(grid.occupied, read.occupied) and np.array_equal(grid.free, read.free)
        assert read.origin.distance(grid.origin) < 1e-9 and read.resolution_m == cell_m


def test_with_the_boxes_drawn_in_every_box_is_in_the_map(layout: Layout) -> None:
    grid = with_bodies(room_map(layout), [box.corners() for box in boxes_of(layout)])
    assert all(grid.occupied[grid.cell_of(block.pose.x, block.pose.y)] for block in layout.boxes)
    assert grid.free[grid.cell_of(layout.start.x, layout.start.y)]
