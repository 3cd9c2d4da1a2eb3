"""What a map says of where a disc can be, kept for searches from several places."""

from __future__ import annotations

import numpy as np
import pytest

from python.navigation.map_samples import cluttered, drawn
from yarm.geometry import Pose2
from yarm.navigation.ground import Ground, PlanSettings
from yarm.navigation.planner import Field

ROOM = drawn("########\n#......#\n#..#...#\n########", scale=10)


@pytest.mark.parametrize("seed", range(3))
def test_a_field_over_ground_that_is_kept_is_the_same(seed: int) -> None:
    room = cluttered(seed)
    ground = Ground(room)
    for cell in np.argwhere(room.free)[:: max(1, int(room.free.sum()) // 4)]:
        start = Pose2(*room.centre_of(int(cell[0]), int(cell[1])))
        kept, fresh = Field(room, start, ground=ground), Field(room, start)
        assert np.array_equal(kept.cost, fresh.cost) and np.array_equal(kept.length, fresh.length)
        assert kept.reason == fresh.reason


def test_touching_tight_and_wide_contain_each_other() -> None:
    ground = Ground(ROOM)
    assert np.all(ground.touching | ~ground.tight), "who touches wherever it stands touches at the centre"
    assert np.all(~ground.touching | ~ground.wide), "who touches nowhere does not touch at the centre"
    assert ground.tight.any() and ground.wide.any()


def test_unknown_cells_around_the_start_may_be_stood_on() -> None:
    patchy = drawn("######\n#.?..#\n#....#\n######", scale=8)
    ground = Ground(patchy)
    near, far = ground.standable_from(Pose2(0.9, 1.0)), ground.standable_from(Pose2(1.9, 0.6))
    unknown = patchy.unknown
    assert near[unknown].any() and not far[unknown].any() and far is ground.standable
    assert not Ground(patchy, PlanSettings(known_near_m=0.0)).standable_from(Pose2(0.9, 1.0))[unknown].any()


def test_the_graph_over_known_ground_is_made_once() -> None:
    ground = Ground(ROOM)
    assert ground.graph(ground.standable) is ground.graph(ground.standable)
    assert ground.graph(ground.standable).costs.shape[0] == int((ground.standable & ~ground.touching).sum())


@pytest.mark.parametrize("seed", range(3))
def test_the_graph_joins_the_neighbours_that_cut_no_corner_and_no_others(seed: int) -> None:
    ground = Ground(cluttered(seed))
    passable = ground.standable & ~ground.touching
    graph = ground.graph(ground.standable)
    rows, columns = passable.shape
    ways = {}
    for row, column in np.argwhere(passable):
        for dr, dc in np.argwhere(np.ones((3, 3), bool)) - 1:
            beside = [(row + dr, column + dc), (row + dr, column), (row, column + dc)]
            inside = all(0 <= r < rows and 0 <= c < columns for r, c in beside)
            if (dr or dc) and inside and all(passable[place] for place in beside):
                weight = ground.weights[row, column] + ground.weights[row + dr, column + dc]
                ends = (row * columns + column, (row + dr) * columns + column + dc)
                ways[ends] = 0.5 * weight * float(np.hypot(dr, dc)) * ground.grid_map.resolution_m
    costs = graph.costs.tocoo()
    found = dict(zip(zip(graph.nodes[costs.row], graph.nodes[costs.col]), costs.data))
    assert len(found) == costs.nnz and found == pytest.approx(ways, abs=1e-12) and ways
    assert graph.costs.has_sorted_indices
