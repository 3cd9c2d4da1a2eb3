"""Every reachable cell is entered, those of whole blocks exactly once, and the round is closed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.geometry import BoolArray, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.coverage.floor import field_way, lay_floor, planned_way
from yarm.manipulation.coverage.spanning_tree import CoverageError, cover, visits
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.obstacles.waves import GridWaves


def check(free: BoolArray, start: tuple) -> None:
    """All that a way over a floor must be."""
    way = cover(free, start)
    entered = visits(way.cells, free.shape)
    lost = visits(way.unreachable, free.shape)
    assert not entered[~free].any()
    assert np.array_equal((entered > 0) | (lost > 0), free)
    assert not ((entered > 0) & (lost > 0)).any()
    once = visits(way.round, free.shape)
    assert once.max() <= 1
    steps = np.abs(np.diff(way.cells, axis=0)).sum(axis=1)
    assert np.all(steps == 1)
    if len(way.round):
        assert np.abs(way.round[0] - way.round[-1]).sum() == 1
        assert len(way.round) % 4 == 0
    loose = {tuple(cell) for cell in way.loose.tolist()}
    assert len(loose) == len(way.loose) == int((entered > 0).sum()) - len(way.round)


def test_a_whole_floor_is_one_closed_round() -> None:
    way = cover(np.ones((8, 6), dtype=bool), (3, 2))
    assert len(way.round) == 48
    assert tuple(way.round[0]) == (3, 2)
    assert len(way.after) == len(way.loose) == len(way.unreachable) == 0
    check(np.ones((8, 6), dtype=bool), (3, 2))


def test_cells_in_no_block_are_named_and_covered_after() -> None:
    way = cover(np.ones((5, 4), dtype=bool), (0, 0))
    assert len(way.round) == 16
    assert len(way.loose) == 4
    assert len(set(way.loose[:, 0].tolist())) == 1
    check(np.ones((5, 4), dtype=bool), (0, 0))


def test_a_corridor_of_one_cell_has_no_round() -> None:
    way = cover(np.ones((6, 1), dtype=bool), (2, 0))
    assert len(way.round) == 0
    assert len(way.loose) == 6
    check(np.ones((6, 1), dtype=bool), (2, 0))


def test_what_a_wall_cuts_off_is_named() -> None:
    free = np.ones((8, 8), dtype=bool)
    free[4] = False
    way = cover(free, (0, 0))
    assert len(way.unreachable) == 24
    check(free, (0, 0))


@settings(deadline=None, max_examples=150)
@given(st.integers(1, 9), st.integers(1, 9), st.floats(0.0, 0.5), st.integers(0, 10_000))
def test_any_floor_is_covered(wide: int, high: int, share: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((wide, high)) >= share
    cells = np.argwhere(free)
    if len(cells):
        check(free, tuple(cells[rng.integers(len(cells))].tolist()))


@pytest.mark.parametrize("start", [(0, 0), (-1, 2), (9, 1)])
def test_a_start_that_is_not_free_is_refused(start: tuple) -> None:
    free = np.ones((4, 4), dtype=bool)
    free[0, 0] = False
    with pytest.raises(CoverageError, match=r"is no free cell of a floor of 4 x 4"):
        cover(free, start)


def box(name: str, size: tuple, xyz: tuple) -> Obstacle:
    return Obstacle(name, Solid(Shape.BOX, size, transform_matrix(xyz, (0, 0, 0, 1))))


POCKET = (box("back", (0.2, 1.6, 0.5), (0.8, 0.0, 0.25)), box("left", (1.0, 0.2, 0.5), (0.4, 0.8, 0.25)),
          box("right", (1.0, 0.2, 0.5), (0.4, -0.8, 0.25)))  # fmt: skip
RADIUS_M = 0.25


def test_a_pocket_holds_the_field_and_not_the_planned_way() -> None:
    goals = [np.array([1.8, 0.0]), np.array([-1.5, 1.5])]
    start = np.array([-1.5, 0.0])
    caught = field_way(start, goals, POCKET, RADIUS_M)
    assert caught.reached == 0
    assert "a local minimum at" in caught.reason
    floor = lay_floor(2.5, 0.1, POCKET, RADIUS_M)
    planned = planned_way(start, goals, floor)
    assert planned.reached == 2
    assert planned.reason == ""
    assert all(floor.free[floor.cell(point)] for point in planned.points)
    assert np.min(np.linalg.norm(planned.points - goals[0], axis=1)) < 0.1


def test_the_field_goes_round_a_single_post_and_keeps_off_it() -> None:
    post = (Obstacle("post", Solid(Shape.CYLINDER, (0.1, 1.0), transform_matrix((0.0, 0.05, 0.5), (0, 0, 0, 1)))),)
    way = field_way(np.array([-1.5, 0.0]), [np.array([1.5, 0.0])], post, RADIUS_M)
    assert way.reached == 1
    assert np.min(np.linalg.norm(way.points - (0.0, 0.05), axis=1)) > RADIUS_M + 0.1


def test_goals_that_cannot_be_planned_to_say_why() -> None:
    floor = lay_floor(2.5, 0.1, POCKET, RADIUS_M)
    start = np.array([-1.5, 0.0])
    assert "not on the free floor" in planned_way(start, [np.array([0.8, 0.0])], floor).reason
    assert "not on the free floor" in planned_way(start, [np.array([9.0, 0.0])], floor).reason
    ring = [box("e", (0.2, 2.0, 1.0), (1.0, 0, 0.5)), box("w", (0.2, 2.0, 1.0), (-1.0, 0, 0.5)),
            box("n", (2.0, 0.2, 1.0), (0, 1.0, 0.5)), box("s", (2.0, 0.2, 1.0), (0, -1.0, 0.5))]  # fmt: skip
    assert "no way leads to" in planned_way(start, [np.zeros(2)], lay_floor(2.5, 0.1, ring, RADIUS_M)).reason


def test_waves_give_the_shortest_way_round_a_wall() -> None:
    free = np.ones((9, 9), dtype=bool)
    free[4, :8] = False
    waves = GridWaves(free, 0.5)
    path = waves.path((0, 0), (8, 0))
    assert tuple(path[0]) == (0, 0)
    assert tuple(path[-1]) == (8, 0)
    assert all(free[tuple(cell)] for cell in path)
    length = 0.5 * np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(waves.ways((8, 0))[0, 0])
    assert length == pytest.approx(0.5 * (2 * (4 * math.sqrt(2) + 4)))
    free[4, 8] = False
    assert len(GridWaves(free, 0.5).path((0, 0), (8, 0))) == 0
