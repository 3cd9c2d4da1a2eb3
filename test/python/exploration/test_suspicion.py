"""Ground where a thing that was bumped into may go on: dear to pass, until it was seen from near enough."""

from __future__ import annotations

import math

import numpy as np

from python.exploration.explorer_samples import far_scan
from python.navigation.map_samples import drawn
from yarm.exploration.seen import SweptGround
from yarm.exploration.suspicion import REACH_M, WEIGHT, Suspicion
from yarm.geometry import Pose2
from yarm.navigation.ground import Ground, PlanSettings
from yarm.navigation.planner import Field
from yarm.robots.turtlebot import RADIUS_M, Bumper

HALL = drawn("############\n#..........#\n#..........#\n#..........#\n#..........#\n############", scale=10)
HERE = Pose2(2.0, 1.5)
DISC_M = 0.18


def test_where_nothing_was_met_nothing_is_dearer() -> None:
    assert Suspicion(SweptGround(0.85, 2.5)).weights(HALL, DISC_M) is None


def test_ground_around_the_contact_is_dear_and_what_is_far_is_not() -> None:
    suspicion = Suspicion(SweptGround(0.85, 2.5))
    suspicion.met(HERE, Bumper.CENTER)
    weights = suspicion.weights(HALL, DISC_M)
    assert weights is not None and set(np.unique(weights)) == {0.0, WEIGHT}
    contact = np.array([HERE.x + RADIUS_M, HERE.y])
    rows, columns = np.nonzero(weights)
    away = np.hypot(*(HALL.centres_of(np.stack([rows, columns], axis=1)) - contact).T)
    assert REACH_M < away.max() < REACH_M + DISC_M + 0.1
    assert weights[HALL.cell_of(HERE.x, HERE.y)] == WEIGHT


def test_a_side_is_suspected_where_it_was_hit() -> None:
    centres = {}
    for bumper in Bumper:
        suspicion = Suspicion(SweptGround(0.85, 2.5))
        suspicion.met(Pose2(3.0, 1.5), bumper)
        weights = suspicion.weights(HALL, DISC_M)
        assert weights is not None
        centres[bumper] = HALL.centres_of(np.argwhere(weights > 0.0)).mean(axis=0)
    assert centres[Bumper.LEFT][1] > centres[Bumper.CENTER][1] > centres[Bumper.RIGHT][1]
    assert centres[Bumper.CENTER][0] > centres[Bumper.LEFT][0]


def test_ground_that_the_camera_has_seen_is_not_dear_and_ways_keep_to_it() -> None:
    floor = SweptGround(0.85, 2.5)
    suspicion = Suspicion(floor)
    suspicion.met(HERE, Bumper.CENTER)
    for yaw_rad in np.radians([-20.0, 0.0, 20.0]):
        floor.see(Pose2(0.7, 0.9, float(yaw_rad)), far_scan(3.0), 0.0)
    weights = suspicion.weights(HALL, DISC_M)
    assert weights is not None and weights[HALL.cell_of(2.0, 0.9)] == 0.0
    start, goal = Pose2(0.9, 2.0), (4.3, 2.0)
    plain = Field(HALL, start).path_to(HALL.cell_of(*goal))
    settings = PlanSettings(radius_m=DISC_M)
    wary = Field(HALL, start, ground=Ground(HALL, settings, weights)).path_to(HALL.cell_of(*goal))
    assert passes(plain, HERE) < 0.6 < math.inf
    assert dear_metres(wary, weights) < 0.5 * dear_metres(plain, weights)


def points_of(path: np.ndarray) -> np.ndarray:
    """(n, 2) points every centimetre or so along a path."""
    return np.concatenate([a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a) for a, b in zip(path, path[1:])])


def passes(path: np.ndarray, place: Pose2) -> float:
    return float(np.hypot(*(points_of(path) - (place.x, place.y)).T).min())


def dear_metres(path: np.ndarray, weights: np.ndarray) -> float:
    points = points_of(path)
    steps = np.hypot(*np.diff(points, axis=0).T)
    cells = HALL.cells_of(points[1:])
    return float(steps[weights[cells[:, 0], cells[:, 1]] > 0.0].sum())
