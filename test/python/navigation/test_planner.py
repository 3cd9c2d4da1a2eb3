"""Ways of a disc over a map; every one is put before the independent checker."""

from __future__ import annotations

import math

import numpy as np
import pytest

from python.navigation.map_samples import cluttered, drawn
from yarm.geometry import Pose2
from yarm.navigation.ground import PlanSettings
from yarm.navigation.path_check import check_path
from yarm.navigation.planner import Field

ROOM = """
    ##########
    #........#
    #...##...#
    #...##...#
    #........#
    ##########
"""


def length(path: np.ndarray) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


@pytest.mark.parametrize("seed", range(6))
def test_ways_in_cluttered_rooms_are_clear_and_no_longer_than_along_the_cells(seed: int) -> None:
    room = cluttered(seed, yaw_rad=0.3 * seed)
    rng = np.random.default_rng(seed)
    free = np.argwhere(room.free)
    field = Field(room, Pose2(*room.centre_of(*free[rng.integers(len(free))])))
    reached = np.argwhere(np.isfinite(field.cost))
    for row, column in reached[rng.integers(len(reached), size=15)] if len(reached) else []:
        path = field.path_to((int(row), int(column)))
        verdict = check_path(room, path, 0.18)
        assert verdict.clear, verdict.reason
        assert length(path) <= field.length[row, column] + 1e-6
        assert path[-1] == pytest.approx(room.centre_of(row, column))


def test_an_open_room_is_crossed_straight() -> None:
    room = drawn(ROOM, scale=10)
    field = Field(room, Pose2(0.8, 0.75), PlanSettings(narrow_weight=0.0))
    path = field.path_to(room.cell_of(4.1, 0.76))
    assert len(path) == 2 and length(path) == pytest.approx(3.3, abs=0.05)


def test_a_block_is_gone_round_with_the_disc_clear() -> None:
    room = drawn(ROOM, scale=10)
    field = Field(room, Pose2(1.2, 1.6))
    path = field.path_to(room.cell_of(3.7, 1.6))
    assert len(path) > 2 and check_path(room, path, 0.18).clear
    assert length(path) < 1.35 * 2.5


def test_a_gap_too_narrow_is_no_way() -> None:
    wide = drawn(ROOM, scale=10)
    assert Field(wide, Pose2(0.8, 1.0)).reachable(wide.cell_of(4.0, 1.0))
    narrow = wide.cells.copy()
    narrow[:, 45:50] = 100
    narrow[10:17, 45:50] = 0
    shut = type(wide)(narrow, wide.resolution_m, wide.origin)
    field = Field(shut, Pose2(0.8, 1.0))
    assert not field.reachable(shut.cell_of(4.0, 1.0)) and len(field.path_to(shut.cell_of(4.0, 1.0))) == 0
    narrow[10:19, 45:50] = 0
    assert Field(shut, Pose2(0.8, 1.0)).reachable(shut.cell_of(4.0, 1.0))


def test_diagonal_steps_never_pass_between_two_corners() -> None:
    room = drawn("....\n..#.\n.#..\n....", scale=1)
    free_of_size = PlanSettings(radius_m=0.0, known_near_m=0.0, narrow_weight=0.0)
    field = Field(room, Pose2(*room.centre_of(1, 2)), free_of_size)
    assert field.length[2, 1] > math.sqrt(2.0) * 0.05 + 1e-6


def test_unknown_ground_is_passed_only_near_the_start_or_when_allowed() -> None:
    room = drawn("????????\n????....\n????....\n????????", scale=5)
    field = Field(room, Pose2(0.8, 0.5))
    assert field.reachable(room.cell_of(1.5, 0.5)), "its own feet are no obstacle"
    far = Field(room, Pose2(0.2, 0.5))
    assert not far.reachable(room.cell_of(1.5, 0.5))
    assert Field(room, Pose2(0.2, 0.5), PlanSettings(unknown_passable=True)).reachable(room.cell_of(1.5, 0.5))


def test_a_start_at_a_wall_may_leave_it() -> None:
    room = drawn(ROOM, scale=10)
    start = Pose2(0.5 + 0.176, 1.5)
    field = Field(room, start)
    path = field.path_to(room.cell_of(1.5, 1.5))
    assert field.reason == "" and path[0] == pytest.approx([start.x, start.y])
    assert check_path(room, path, 0.18).clear


def test_an_enclosed_start_says_so() -> None:
    room = drawn("#####\n#.#.#\n#####", scale=4)
    field = Field(room, Pose2(0.3, 0.3))
    assert "enclosed" in field.reason and not np.isfinite(field.cost).any()
    assert "outside" in Field(room, Pose2(9.0, 0.0)).reason


def test_costs_are_never_below_lengths() -> None:
    room = cluttered(1)
    field = Field(room, Pose2(0.0, 0.0))
    reached = np.isfinite(field.cost)
    assert np.all(field.cost[reached] >= field.length[reached] - 1e-9)
    assert np.array_equal(reached, np.isfinite(field.length))


def test_sight_ends_where_ground_is_unknown() -> None:
    room = drawn("........\n........\n????????\n........", scale=5)
    field = Field(room, Pose2(1.0, 0.8), PlanSettings(known_near_m=0.0))
    assert field.sees(np.array([0.3, 0.8]), np.array([1.8, 0.8]))
    assert not field.sees(np.array([0.3, 0.8]), np.array([0.3, 0.1]))
    assert not field.sees(np.array([0.3, 0.8]), np.array([-0.3, 0.8]))


def test_places_on_the_way_lie_on_it_and_head_along_it() -> None:
    room = drawn(ROOM, scale=10)
    field = Field(room, Pose2(0.8, 0.75), PlanSettings(narrow_weight=0.0))
    places, headings = field.places_on_way(room.cell_of(4.1, 0.76), 0.5)
    centres = room.centres_of(places)
    assert len(places) == 6 and np.all(np.abs(centres[:, 1] - 0.75) < 0.1)
    assert np.diff(centres[:, 0]) == pytest.approx(np.full(5, 0.5), abs=1e-6)
    assert headings == pytest.approx(np.zeros(6), abs=0.3)
    for cell in (room.cell_of(0.8, 0.75), room.cell_of(0.1, 0.1)):
        assert len(field.places_on_way(cell, 0.5)[0]) == 0, "none at the start itself, none where there is no way"
