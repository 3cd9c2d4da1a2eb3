"""The judge: perfect maps get everything, each kind of fault costs what it should."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.experiments.explore_samples import ROOM, perfect_map
from yarm.experiments.explore.judge import Judge, Watcher
from yarm.experiments.explore.record import IN_WORLD
from yarm.experiments.explore.true_mapper import TrueMapper
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.sim.kinematic.depth_sensor import DepthSensor

JUDGE = Judge(ROOM)


def test_a_perfect_map_has_all_of_it() -> None:
    grid = perfect_map(JUDGE)
    assert JUDGE.share(grid) == 1.0
    assert JUDGE.detected(grid, IN_WORLD) == {"block_1", "low_1"}
    error = JUDGE.wall_error(JUDGE.occupied_points(grid))
    assert 0.01 < error.mean_m < 0.03 and error.p95_m <= 0.036 and error.spurious == 0.0 and error.cells > 200


def test_what_is_unknown_or_wrong_is_missing() -> None:
    grid = perfect_map(JUDGE)
    cells = grid.cells.copy()
    cells[:, : cells.shape[1] // 2] = -1
    assert JUDGE.share(GridMap(cells, 0.05, grid.origin)) == pytest.approx(0.5, abs=0.05)
    walls_lost = np.where(grid.cells == 100, 0, grid.cells).astype(np.int8)
    assert JUDGE.share(GridMap(walls_lost, 0.05, grid.origin)) == pytest.approx(
        JUDGE.truth.free.sum() / (JUDGE.truth.free.sum() + JUDGE.truth.faces.sum()), abs=1e-6
    )
    phantom = grid.cells.copy()
    row, column = grid.cell_of(-1.0, 0.0)
    phantom[row - 2 : row + 3, column - 2 : column + 3] = 100
    moved = GridMap(phantom, 0.05, grid.origin)
    lost = 25 / (JUDGE.truth.free.sum() + JUDGE.truth.faces.sum())
    assert JUDGE.share(moved) == pytest.approx(1.0 - lost, abs=1e-9)
    assert JUDGE.wall_error(JUDGE.occupied_points(moved)).spurious > 0.05


def test_a_map_frame_elsewhere_is_taken_into_account() -> None:
    start = Pose2(-1.0, 0.4, math.radians(30.0))
    grid = perfect_map(JUDGE, start)
    assert JUDGE.share(grid, start) > 0.999 and JUDGE.detected(grid, start) == {"block_1", "low_1"}
    assert JUDGE.share(grid) < 0.9, "in the wrong frame"


def test_the_best_fit_takes_a_shift_out() -> None:
    points = JUDGE.occupied_points(perfect_map(JUDGE))
    c, s = math.cos(0.05), math.sin(0.05)
    shifted = points @ np.array([[c, s], [-s, c]]) + (0.08, -0.05)
    raw = JUDGE.wall_error(shifted)
    fit = JUDGE.best_fit(shifted)
    c, s = math.cos(fit.yaw_rad), math.sin(fit.yaw_rad)
    fitted = JUDGE.wall_error(shifted @ np.array([[c, s], [-s, c]]) + (fit.x, fit.y))
    assert raw.mean_m > 0.045 and fitted.mean_m < 0.03
    assert fit.yaw_rad == pytest.approx(-0.05, abs=0.02)


def test_no_occupied_cells_have_no_error() -> None:
    assert math.isnan(JUDGE.wall_error(np.zeros((0, 2))).mean_m)
    empty = GridMap(np.full((5, 5), -1, dtype=np.int8), 0.05, Pose2(0.0, 0.0))
    assert JUDGE.detected(empty, IN_WORLD) == set() and JUDGE.share(empty) == 0.0


def test_half_an_outline_is_a_detection_and_less_is_none() -> None:
    grid = perfect_map(JUDGE)
    low = next(o for o in JUDGE.obstacles if o.low)
    cells = np.where(grid.cells == 100, 0, grid.cells).astype(np.int8)
    for share, found in ((0.6, True), (0.2, False)):
        part = cells.copy()
        kept = low.outline[low.outline[:, 1] < -0.7 + 0.4 * share - 0.1]
        index = grid.cells_of(kept)
        part[index[:, 0], index[:, 1]] = 100
        assert (JUDGE.detected(GridMap(part, 0.05, grid.origin), IN_WORLD) == {"low_1"}) == found


def test_all_that_counts_as_mappable_can_be_mapped() -> None:
    sensor = DepthSensor(JUDGE.boxes, 5)
    mapper = TrueMapper(ROOM.lower, ROOM.upper)
    centres = JUDGE.truth.cells.centres()[JUDGE.truth.cells.reachable.ravel()]
    for i, (x, y) in enumerate(centres[::7]):
        for k in range(4):
            base = Pose2(float(x), float(y), i + 0.5 * math.pi * k)
            mapper.add(sensor.scan(base, 0.0), base)
    assert JUDGE.share(mapper.map()) > 0.995


def test_a_watcher_keeps_the_first_time() -> None:
    watcher = Watcher(JUDGE)
    empty = GridMap(np.full((5, 5), -1, dtype=np.int8), 0.05, Pose2(0.0, 0.0))
    assert watcher(1.0, empty) == 0.0 and watcher.first_seen == {}
    assert watcher(2.0, perfect_map(JUDGE)) == 1.0
    watcher(3.0, perfect_map(JUDGE))
    assert watcher.first_seen == {"block_1": 2.0, "low_1": 2.0}
