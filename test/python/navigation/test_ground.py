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
