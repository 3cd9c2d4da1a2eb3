"""Next best views: gain against time, poses rather than points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.navigation.map_samples import drawn
from yarm.exploration.choice import Choice, ChoiceSettings
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.navigation.planner import Field

# A free hall: unknown ground to the left near by and to the right farther away.
HALL = drawn("##########\n?........?\n?........?\n?........?\n##########", scale=10)

DEFAULT = ChoiceSettings()


def choice(pose: Pose2, grid_map: GridMap = HALL, settings: ChoiceSettings = DEFAULT) -> Choice:
    return Choice(Field(grid_map, pose), pose, grid_map.unknown.astype(float), settings)


def test_the_nearer_of_two_equal_views_wins_and_is_looked_at_in_its_direction() -> None:
    made = choice(Pose2(1.6, 1.25, math.pi))
    view = made.best(made.likely())
    assert view is not None and view.x < 1.7 and abs(math.remainder(view.yaw_rad - math.pi, 2 * math.pi)) < 0.7


def test_a_turn_in_place_is_a_view_too() -> None:
    one_sided = GridMap(np.where(HALL.unknown & (np.arange(100) > 50), np.int8(100), HALL.cells), 0.05, HALL.origin)
    made = choice(Pose2(1.0, 1.25, 0.0), one_sided, DEFAULT)
    view = made.best(made.likely())
    assert view is not None and math.hypot(view.x - 1.0, view.y - 1.25) < 0.5
    assert abs(math.remainder(view.yaw_rad - math.pi, 2 * math.pi)) < 0.9


def test_what_it_looks_at_already_is_no_reason_to_stay() -> None:
    made = choice(Pose2(1.0, 1.25, math.pi))
    own = np.array([HALL.cell_of(1.0, 1.25)])
    view = made.best(own)
    assert view is None or abs(math.remainder(view.yaw_rad - math.pi, 2 * math.pi)) > 0.3


def test_a_known_map_has_no_views() -> None:
    known = drawn("#####\n#...#\n#####", scale=12)
    made = choice(Pose2(1.2, 0.9), known)
    assert made.best(made.likely()) is None and made.best(made.reachable(made.everywhere())) is None
    assert made.best(np.zeros((0, 2), np.int64)) is None


def test_a_view_is_worth_less_when_its_cells_are_seen() -> None:
    made = choice(Pose2(1.6, 1.25, math.pi))
    view = made.best(made.likely())
    assert view is not None
    again = made.again(view)
    assert again is not None and again.cells == pytest.approx(view.cells, rel=0.5)
    seen = Choice(Field(HALL, Pose2(1.6, 1.25, math.pi)), Pose2(1.6, 1.25, math.pi), np.zeros(HALL.cells.shape))
    assert seen.again(view) is not None and seen.again(view).cells == 0.0  # type: ignore[union-attr]


def test_a_view_out_of_reach_is_gone() -> None:
    made = choice(Pose2(1.6, 1.25, math.pi))
    view = made.best(made.likely())
    assert view is not None
    cells = HALL.cells.copy()
    cells[:, 30:50] = 100
    shut = GridMap(cells, 0.05, HALL.origin)
    assert choice(Pose2(3.5, 1.25), shut).again(view) is None


def test_everywhere_is_all_the_disc_can_get_to() -> None:
    made = choice(Pose2(1.6, 1.25))
    points = made.everywhere()
    cells = made.reachable(points)
    assert len(cells) == len(points) > 100
    assert len(made.reachable(np.array([[0.1, 0.1], [99.0, 0.0]]))) == 0
