"""What explorers remember in the map frame: swept ground and failed views, over maps that change."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.exploration.failed import MOST, FailedViews
from yarm.exploration.seen import SweptGround
from yarm.exploration.squares import HALF_M, Squares
from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots import turtlebot

AT = Pose2(0.3, -0.2, 0.5)


def room(shape: tuple[int, int] = (100, 120), origin: tuple[float, float] = (-3.0, -2.5)) -> GridMap:
    return GridMap(np.full(shape, -1, np.int8), 0.05, Pose2(*origin))


def scan(range_m: float) -> Scan:
    return Scan(0.0, np.full(61, range_m, np.float32), math.radians(-30.0), math.radians(1.0), 0.45, 10.0)


def ahead(distance_m: float, bearing_deg: float = 0.0) -> np.ndarray:
    bearing = math.radians(bearing_deg)
    there = AT.compose(Pose2(distance_m * math.cos(bearing), distance_m * math.sin(bearing)))
    return np.array([[there.x, there.y]])


@pytest.mark.parametrize(
    ("distance_m", "bearing_deg", "seen"),
    [
        (1.5, 0.0, True),
        (1.5, 25.0, True),
        (1.5, -25.0, True),
        (1.5, 36.0, False),
        (0.5, 0.0, False),
        (2.3, 0.0, False),
        (-1.5, 0.0, False),
    ],
)
def test_ground_before_the_hits_is_swept(distance_m: float, bearing_deg: float, seen: bool) -> None:
    ground = SweptGround(0.8, 4.0)
    ground.see(AT, scan(2.0), 7.0)
    assert bool(ground.since(ahead(distance_m, bearing_deg), 7.0)[0]) == seen
    assert not ground.since(ahead(distance_m, bearing_deg), 7.1)[0]


@pytest.mark.parametrize("yaw_deg", [*range(0, 360, 20), 45, 90, 180, 270])
def test_a_view_in_any_direction_sweeps_its_whole_sector(yaw_deg: int) -> None:
    ground, base = SweptGround(0.8, 2.0), Pose2(0.31, -0.22, math.radians(yaw_deg))
    seen = scan(3.0)
    ground.see(base, seen, 7.0)
    sensor, every = base.compose(seen.sensor), np.arange(-3.0, 3.0, 0.05) + 0.025
    points = np.stack(np.meshgrid(every, every), axis=-1).reshape(-1, 2)
    away = points - (sensor.x, sensor.y)
    far, bearing = np.hypot(*away.T), np.arctan2(away[:, 1], away[:, 0]) - sensor.yaw_rad
    off = np.abs(np.remainder(bearing + math.pi, 2.0 * math.pi) - math.pi)
    swept = (far >= 0.8) & (far <= 2.0) & (off <= math.radians(30.0))
    assert np.array_equal(ground.since(points, 7.0), swept) and swept.sum() > 600


def test_beams_without_a_range_sweep_nothing() -> None:
    ground = SweptGround(0.8, 4.0)
    ground.see(AT, scan(math.nan), 7.0)
    assert not ground.over(room(), 0.0).any()


def test_the_robots_own_place_is_known() -> None:
    ground = SweptGround(0.8, 4.0)
    ground.stand(AT, 1.0)
    assert ground.since(ahead(0.1, 90.0), 0.0)[0] and not ground.since(ahead(0.4), 0.0)[0]


@pytest.mark.parametrize(
    ("distance_m", "bearing_deg", "seen"), [(0.9, 0.0, True), (1.3, 0.0, False), (1.3, 8.0, True), (1.9, 0.0, False)]
)
def test_floor_behind_a_low_thing_is_not_seen(distance_m: float, bearing_deg: float, seen: bool) -> None:
    ground = SweptGround(0.8, 4.0)
    ground.see(AT, scan(2.0), 7.0, np.array([[1.05, -0.04], [1.05, 0.0], [1.05, 0.04]]))
    assert bool(ground.since(ahead(distance_m, bearing_deg), 7.0)[0]) == seen


def test_a_wall_that_the_scan_hits_hides_nothing_before_it() -> None:
    ground, with_wall = SweptGround(0.8, 4.0), SweptGround(0.8, 4.0)
    wall = np.stack([np.full(41, 1.95), np.linspace(-1.0, 1.0, 41)], axis=1)
    ground.see(AT, scan(2.0), 7.0)
    with_wall.see(AT, scan(2.0), 7.0, wall)
    assert np.array_equal(ground.over(room(), 7.0), with_wall.over(room(), 7.0))


@pytest.mark.parametrize("bearing_deg", range(0, 360, 15))
def test_the_floor_beside_the_robot_is_not_known_because_it_stands_there(bearing_deg: int) -> None:
    ground = SweptGround(0.8, 4.0)
    ground.stand(AT, 1.0)
    assert not ground.since(ahead(turtlebot.RADIUS_M + 0.05, float(bearing_deg)), 0.0)[0]


def test_swept_ground_lies_where_it_is_over_any_map() -> None:
    ground = SweptGround(0.8, 4.0)
    ground.see(AT, scan(2.0), 7.0)
    for grid_map in (room(), room((80, 80), (-1.0, -2.0)), room()):
        over = ground.over(grid_map, 7.0)
        centres = grid_map.centres_of(np.argwhere(np.ones(over.shape, bool)))
        assert np.array_equal(over.ravel(), ground.since(centres, 7.0)) and over.any()


def test_places_at_the_end_of_the_world_do_no_harm() -> None:
    ground = SweptGround(0.8, 4.0)
    far = Pose2(HALF_M - 0.1, -HALF_M - 3.0)
    ground.see(far, scan(2.0), 1.0)
    ground.stand(far, 1.0)
    squares = Squares(0.1)
    assert squares.of_points(np.array([[99.0, -99.0]])).tolist() == [squares.count - 1]


def test_a_failed_view_comes_back_when_the_map_near_it_changes() -> None:
    failed, grid_map = FailedViews(0.3), room()
    failed.map_changed(grid_map)
    failed.add(grid_map, np.array([[50, 50], [50, 51]]))
    assert failed.any() and failed.over(grid_map).sum() == 2
    far = GridMap(grid_map.cells.copy(), 0.05, grid_map.origin)
    far.cells[50, 70] = 0
    failed.map_changed(far)
    assert failed.over(far).sum() == 2
    near = GridMap(far.cells.copy(), 0.05, grid_map.origin)
    near.cells[50, 55] = 0
    failed.map_changed(near)
    assert not failed.any()


def test_what_keeps_failing_waits_for_the_end() -> None:
    failed, grid_map = FailedViews(0.3), room()
    for _ in range(MOST):
        failed.add(grid_map, np.array([[50, 50]]))
    failed.map_changed(grid_map)
    near = GridMap(grid_map.cells.copy(), 0.05, grid_map.origin)
    near.cells[50, 51] = 0
    failed.map_changed(near)
    assert failed.over(near)[50, 50]
    failed.clear()
    assert not failed.any()


def test_a_map_that_is_moved_or_resized_keeps_what_failed_where_it_is() -> None:
    failed, grid_map = FailedViews(0.3), room()
    for _ in range(MOST):
        failed.add(grid_map, np.array([[50, 50]]))
    place = grid_map.centre_of(50, 50)
    failed.map_changed(grid_map)
    other = room((140, 140), (-4.0, -3.0))
    failed.map_changed(other)
    assert failed.over(other)[other.cell_of(*place)] and failed.over(other).sum() == 1
