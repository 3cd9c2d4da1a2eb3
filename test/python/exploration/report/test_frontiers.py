"""The report's frontier cells on small maps counted by hand."""

from __future__ import annotations

import heapq
import math
from typing import Dict, Tuple

import numpy as np
import pytest

from support.report_rig import room
from yarm.exploration.report.frontiers import Reach, cropped, frontier_cells, frontiers, padded, with_probabilities
from yarm.exploration.report.params import ReportParams
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap

PARAMS = ReportParams()


def test_cropping_keeps_three_cells_around_where_they_fit() -> None:
    cells = np.full((30, 40), -1, np.int8)
    cells[10:12, 1:5] = 0
    small = cropped(GridMap(cells, 0.1, Pose2(1.0, 2.0)))
    assert small is not None and small.cells.shape == (8, 8)
    assert small.origin == Pose2(1.0, 2.7) and small.cell_of(1.25, 3.05) == (3, 2)
    assert cropped(GridMap(np.full((4, 4), -1, np.int8), 0.1, Pose2(0.0, 0.0))) is None


def test_specks_go_and_walls_are_padded() -> None:
    cells = np.zeros((40, 40), np.int8)
    cells[5, 5:8] = 100
    cells[30, 20:24] = 100
    thick = padded(GridMap(cells, 0.05, Pose2(0.0, 0.0)), 5)
    assert not (thick[:15] == 100).any(), "three cells in a window are a speck"
    assert (thick == 100).sum() == 11 * 14 and thick[25, 15] == 100 and thick[24, 15] == 0


def test_frontier_cells_are_free_beside_unknown_and_not_outermost() -> None:
    cells = np.zeros((8, 8), np.int8)
    cells[:, 5:] = -1
    found = frontier_cells(cells)
    assert [tuple(cell) for cell in np.argwhere(found)] == [(row, 4) for row in range(1, 7)]


def test_windows_of_five_take_the_sum_and_use_the_others_up() -> None:
    cells = np.zeros((12, 9), np.int8)
    cells[:, 5:] = -1
    found = frontiers(cells, (6, 0), PARAMS)
    assert [(f.row, f.column) for f in found] == [(1, 4), (4, 4), (7, 4), (10, 4)]
    assert [f.unknown for f in found] == [18.0, 18.0, 18.0, 6.0]
    assert found[1].distance == pytest.approx(math.hypot(2, 4)) and found[1].fitness == pytest.approx(
        18 + math.sqrt(20)
    )


def test_obstacles_weigh_a_hundred_a_cell() -> None:
    cells = np.zeros((9, 9), np.int8)
    cells[:, 6:] = -1
    cells[4, 3] = 100
    found = {(f.row, f.column): f for f in frontiers(cells, (0, 0), PARAMS)}
    assert found[(4, 5)].obstacles == 100.0
    beside = found[(4, 5)]
    assert beside.fitness == pytest.approx(beside.distance + beside.unknown - 10.0)


def test_the_draw_is_proportional_to_the_fitness_above_the_least_and_one() -> None:
    cells = np.zeros((12, 9), np.int8)
    cells[:, 5:] = -1
    shared = with_probabilities(frontiers(cells, (6, 0), PARAMS))
    assert sum(f.probability for f in shared) == pytest.approx(1.0)
    least = min(shared, key=lambda f: f.fitness)
    for f in shared:
        assert f.probability / least.probability == pytest.approx(f.fitness - least.fitness + 1.0)
    assert with_probabilities([]) == []


def by_hand(free: np.ndarray, start: Tuple[int, int]) -> Dict[Tuple[int, int], float]:
    lengths, queue = {start: 0.0}, [(0.0, start)]
    while queue:
        length, (row, column) = heapq.heappop(queue)
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                cell = (row + down, column + right)
                if not (0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1]) or not free[cell]:
                    continue
                further = length + math.hypot(down, right)
                if further < lengths.get(cell, math.inf) - 1e-12:
                    lengths[cell] = further
                    heapq.heappush(queue, (further, cell))
    return lengths


@pytest.mark.parametrize("seed", range(6))
def test_ways_are_the_shortest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = np.where(rng.random((17, 23)) < 0.35, 100, 0).astype(np.int8)
    cells[8, 8] = 100
    reach = Reach(cells, (8, 8))
    free = cells == 0
    free[8, 8] = True
    lengths = by_hand(free, (8, 8))
    for row in range(17):
        for column in range(23):
            assert reach.distance(row, column) == pytest.approx(lengths.get((row, column), math.inf))
    far = max(lengths, key=lambda cell: lengths[cell])
    path = reach.path(*far)
    assert tuple(path[0]) == (8, 8) and tuple(path[-1]) == far
    assert np.abs(np.diff(path, axis=0)).max() == 1 and all(free[tuple(cell)] for cell in path)


def test_the_door_of_a_room_is_a_frontier_that_can_be_reached() -> None:
    small = cropped(room())
    assert small is not None
    cells = padded(small, PARAMS.padding)
    robot = small.cell_of(0.0, 0.0)
    reach = Reach(cells, robot)
    found = [f for f in frontiers(cells, robot, PARAMS) if math.isfinite(reach.distance(f.row, f.column))]
    assert found
    assert all(abs(small.centre_of(f.row, f.column)[0] - 0.975) < 0.2 for f in found)
