"""Ways from pose to pose: they end at the goal itself, are clear by the independent check, or say why there is none."""

from __future__ import annotations

import numpy as np
import pytest

from python.navigation.map_samples import cluttered, drawn
from yarm.geometry import Pose2
from yarm.navigation.ground import PlanSettings
from yarm.navigation.path_check import check_path
from yarm.navigation.ways import find_way

DISC = PlanSettings(radius_m=0.20, comfort_m=0.5, decay_per_m=5.0)
HALL = """
#########
#.......#
#.......#
#.......#
#...#...#
#...#...#
#...#..??
#########
"""


@pytest.mark.parametrize("seed", range(6))
def test_ways_are_clear_and_end_at_the_goal(seed: int) -> None:
    grid = cluttered(seed)
    rng = np.random.default_rng(seed)
    found = 0
    for _ in range(12):
        (sx, sy), (gx, gy) = rng.uniform(-3.2, 3.2, (2, 2))
        way = find_way(grid, Pose2(sx, sy), Pose2(gx, gy), DISC)
        if way.reason:
            assert len(way.path) == 0
            continue
        found += 1
        assert check_path(grid, way.path, 0.20).clear
        assert np.hypot(*(way.path[-1] - (gx, gy))) < 0.036
        assert way.length_m == pytest.approx(np.hypot(*np.diff(way.path, axis=0).T).sum())
    assert found >= 2, f"seed {seed}"


def test_each_reason_is_named() -> None:
    hall, start = drawn(HALL), Pose2(0.5, 0.7)
    for goal, named in (
        (Pose2(9.0, 0.5), "outside the map"),
        (Pose2(0.9, 0.5), "inside an obstacle"),
        (Pose2(0.72, 0.5), "the disc needs 0.2 m"),
        (Pose2(1.7, 0.3), "not known"),
    ):
        assert named in find_way(hall, start, goal, DISC).reason, goal
    assert "lies outside the map" in find_way(hall, Pose2(-3.0, 0.0), start, DISC).reason
    shut = drawn(HALL.replace("#.......#", "#...#...#"))
    assert "no way to the goal (1.30, 0.70)" in find_way(shut, start, Pose2(1.3, 0.7), DISC).reason


def test_a_tolerance_ends_the_way_at_the_nearest_place() -> None:
    hall = drawn(HALL)
    end = find_way(hall, Pose2(0.5, 0.7), Pose2(0.72, 0.5), DISC, 0.3).path[-1]
    assert 0.0 < np.hypot(end[0] - 0.72, end[1] - 0.5) <= 0.3
    assert find_way(hall, Pose2(0.5, 0.7), Pose2(0.9, 0.5), DISC, 0.05).reason


def test_narrow_ways_cost_more_by_the_costmaps_rule() -> None:
    wide = PlanSettings(radius_m=0.20, comfort_m=0.5, decay_per_m=0.1, narrow_weight=5.0)
    near = find_way(drawn(HALL), Pose2(0.5, 0.7), Pose2(1.3, 0.7), PlanSettings(radius_m=0.20, narrow_weight=0.0))
    far = find_way(drawn(HALL), Pose2(0.5, 0.7), Pose2(1.3, 0.7), wide)
    assert near.field is not None and far.field is not None
    cell = near.field.grid_map.cell_of(1.3, 0.7)
    assert far.field.cost[cell] > near.field.cost[cell] and far.length_m >= near.length_m
