"""Places beside the map: they enter at once, stay over any map of the frame, and go only by evidence."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import GridMap
from yarm.navigation.overlay import Overlay
from yarm.robots.turtlebot import RADIUS_M, Bumper

BRICK = np.array([[1.5, 0.0], [1.5, 0.06]])
HERE = Pose2(0.2, -0.1, 0.4)
CORNER = Pose2(-3.0, -3.0)


def bare(resolution_m: float = 0.05, origin: Pose2 = CORNER, cells: int = 120) -> GridMap:
    return GridMap(np.zeros((cells, cells), np.int8), resolution_m, origin)


def scan(range_m: float = 4.0) -> Scan:
    return Scan(0.0, np.full(61, range_m, np.float32), math.radians(-30.0), math.radians(1.0), 0.45, 10.0)


def in_map(pose: Pose2, point: np.ndarray) -> Pose2:
    return pose.compose(Pose2(float(point[0]), float(point[1])))


def test_what_is_seen_once_is_in_the_map() -> None:
    overlay, room = Overlay(), bare()
    overlay.see(HERE, BRICK)
    marked = overlay.over(room)
    for point in BRICK:
        place = in_map(HERE, point)
        assert marked.occupied[marked.cell_of(place.x, place.y)]
    assert 1 <= marked.occupied.sum() <= 2 and not room.occupied.any() and overlay.count >= 1


@pytest.mark.parametrize(
    "room",
    [
        bare(origin=Pose2(-2.0, -1.0)),
        bare(resolution_m=0.02, cells=300),
        bare(resolution_m=0.1, cells=60),
        bare(origin=Pose2(0.5, -3.2, 0.6)),
    ],
    ids=["moved", "finer", "coarser", "turned"],
)
def test_places_stay_where_they_are_over_any_map(room: GridMap) -> None:
    overlay = Overlay()
    overlay.see(HERE, BRICK)
    marked = overlay.over(room)
    place = in_map(HERE, BRICK[0])
    assert marked.occupied[marked.cell_of(place.x, place.y)]
    centres = marked.centres_of(np.argwhere(marked.occupied))
    assert np.all(np.hypot(centres[:, 0] - place.x, centres[:, 1] - place.y) < 0.16)


def test_a_finer_map_has_no_holes_in_a_place() -> None:
    overlay = Overlay()
    overlay.see(Pose2(0.0, 0.0), np.array([[1.02, 0.02]]))
    assert overlay.over(bare(0.01, Pose2(0.0, -1.0), 300)).occupied.sum() == 25


def test_a_map_that_has_shrunk_leaves_places_out_without_a_fault() -> None:
    overlay = Overlay()
    overlay.see(HERE, BRICK)
    small = bare(cells=4)
    assert overlay.over(small) is small
    assert overlay.over(bare()).occupied.any()


def test_a_false_place_goes_after_many_views_and_not_before() -> None:
    overlay = Overlay()
    overlay.see(HERE, BRICK, scan())
    for _ in range(5):
        overlay.see(HERE, np.zeros((0, 2)), scan())
    assert len(overlay.points()) == 2
    for _ in range(20):
        overlay.see(HERE, np.zeros((0, 2)), scan())
    assert len(overlay.points()) == 0


@pytest.mark.parametrize(
    ("pose", "seen", "ranges"),
    [
        (HERE, np.zeros((0, 2)), 1.4),
        (HERE, np.array([[1.2, 0.0], [1.2, 0.05]]), 4.0),
        (HERE.compose(Pose2(0.9, 0.0)), np.zeros((0, 2)), 4.0),
        (HERE.compose(Pose2(0.0, 0.0, 1.0)), np.zeros((0, 2)), 4.0),
        (HERE, np.zeros((0, 2)), math.nan),
    ],
    ids=["behind a wall", "behind another", "too near to be seen", "out of view", "scan without ranges"],
)
def test_a_place_that_could_not_be_seen_stays(pose: Pose2, seen: np.ndarray, ranges: float) -> None:
    overlay = Overlay()
    overlay.see(HERE, BRICK[:1], scan())
    place = in_map(HERE, BRICK[0])
    for _ in range(40):
        overlay.see(pose, seen, scan(ranges))
    assert np.hypot(*(overlay.points() - (place.x, place.y)).T).min() < 0.05


@pytest.mark.parametrize(("bumper", "bearing"), [(Bumper.LEFT, 60.0), (Bumper.CENTER, 0.0), (Bumper.RIGHT, -60.0)])
def test_a_bump_marks_what_was_touched_and_stays(bumper: Bumper, bearing: float) -> None:
    overlay = Overlay()
    marked = overlay.bump(HERE, bumper, bare())
    away = np.hypot(marked[:, 0] - HERE.x, marked[:, 1] - HERE.y)
    assert np.all(away > RADIUS_M) and np.all(away < RADIUS_M + 0.05)
    middle = marked.mean(axis=0)
    angle = math.degrees(math.atan2(middle[1] - HERE.y, middle[0] - HERE.x) - HERE.yaw_rad)
    assert angle == pytest.approx(bearing, abs=1.0)
    back = HERE.compose(Pose2(-1.5, 0.0))
    for _ in range(40):
        overlay.see(back, np.zeros((0, 2)), scan())
    assert overlay.over(bare()).occupied.any()


def test_a_bump_into_a_mapped_wall_marks_nothing() -> None:
    room = bare()
    wall = HERE.compose(Pose2(0.22, 0.0))
    room.cells[room.cell_of(wall.x, wall.y)] = 100
    overlay = Overlay()
    assert len(overlay.bump(HERE, Bumper.CENTER, room)) == 0 and len(overlay.points()) == 0
    assert len(overlay.bump(HERE, Bumper.LEFT, room)) > 0
