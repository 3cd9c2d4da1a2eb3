"""The checker against distances found by dense sampling."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.navigation.map_samples import cluttered, drawn
from yarm.geometry import Pose2
from yarm.navigation.costs import Room
from yarm.navigation.grid_map import GridMap
from yarm.navigation.path_check import check_path

WALL = drawn("......\n..##..\n......", scale=4)


def test_a_way_past_a_corner_is_measured_at_the_corner() -> None:
    verdict = check_path(WALL, np.array([[0.1, 0.1], [0.7, 0.1]]), 0.09)
    assert verdict.clear and verdict.clearance_m == pytest.approx(0.1)
    assert verdict.reason == "" and verdict.piece is None


def test_a_way_that_comes_too_near_is_named() -> None:
    path = np.array([[0.1, 0.1], [0.3, 0.1], [0.3, 0.15], [0.9, 0.15]])
    verdict = check_path(WALL, path, 0.09)
    assert not verdict.clear and verdict.piece == 2
    assert "(0.30, 0.15)" in verdict.reason and "0.050 m" in verdict.reason and "needs 0.09 m" in verdict.reason


@pytest.mark.parametrize("path", [[[0.1, 0.3], [1.1, 0.3]], [[0.5, 0.0], [0.5, 0.6]], [[0.1, 0.0], [1.1, 0.6]]])
def test_a_way_through_a_wall_has_no_clearance(path: list[list[float]]) -> None:
    verdict = check_path(WALL, np.array(path), 0.01)
    assert not verdict.clear and verdict.clearance_m == 0.0


@pytest.mark.parametrize("seed", range(4))
def test_clearance_agrees_with_dense_samples(seed: int) -> None:
    room = cluttered(seed, yaw_rad=0.5 * seed)
    rng = np.random.default_rng(seed)
    dense = Room(room, 0.4)
    for _ in range(20):
        a = rng.uniform(-2.5, 2.5, 2)
        b = a + rng.uniform(-0.6, 0.6, 2)
        samples = a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a)
        least = float(dense.distances(samples).min())
        found = check_path(room, np.array([a, b]), 0.0).clearance_m
        assert min(found, 0.4) == pytest.approx(least, abs=2e-3) and min(found, 0.4) <= least + 1e-9


def test_a_start_too_near_may_only_be_left() -> None:
    start = [0.3, 0.3]
    assert check_path(WALL, np.array([start, [0.1, 0.3], [0.1, 0.6]]), 0.18).clear
    assert not check_path(WALL, np.array([start, [0.36, 0.3], [0.1, 0.3]]), 0.18).clear
    assert not check_path(WALL, np.array([start, [0.3, 0.25]]), 0.18).clear
    assert not check_path(WALL, np.array([start]), 0.18).clear


def test_single_points_and_empty_maps() -> None:
    assert check_path(WALL, np.array([[0.1, 0.3]]), 0.18).clear
    nothing = GridMap(np.zeros((3, 3), np.int8), 0.05, Pose2(0.0, 0.0))
    verdict = check_path(nothing, np.array([[0.0, 0.0], [1.0, 1.0]]), 0.18)
    assert verdict.clear and verdict.clearance_m == math.inf
    assert not check_path(WALL, np.zeros((0, 2)), 0.18).clear


@pytest.mark.parametrize("path", [np.zeros(3), np.zeros((2, 3)), np.array([[0.0, math.nan]])])
def test_no_path_is_refused(path: np.ndarray) -> None:
    with pytest.raises(ValueError, match=r"\(n, 2\)"):
        check_path(WALL, path, 0.18)
