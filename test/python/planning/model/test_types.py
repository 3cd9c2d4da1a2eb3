"""What planners are given: robots, goals and the map without robots."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from python.planning.samples import SMALL, arm, block, robot
from yarm.planning.model.types import Goal, GoalKind, without_robots, without_things

FULL = np.ones(SMALL.shape, dtype=bool)


def test_a_robot_has_its_cells_where_its_end_effector_is() -> None:
    cart = robot("cart", (5, 7), block(2, 1, 1))
    assert cart.cells.tolist() == [[5, 7, 0], [6, 7, 0]]
    assert replace(cart, column=(-1, 0)).cells.tolist() == [[-1, 0, 0], [0, 0, 0]], "outside the grid too"


@given(st.integers(-3, 18), st.integers(-3, 14), st.integers(0, 4))
def test_the_map_without_robots_is_free_in_their_cells_and_as_it_was_elsewhere(x: int, y: int, reach: int) -> None:
    robots = [robot("a", (x, y), block(2, 3)), robot("b", (8, 6), arm(reach))]
    left = without_robots(SMALL, FULL, robots)
    taken = {tuple(cell) for one in robots for cell in one.cells[SMALL.contains(one.cells)].tolist()}
    assert {tuple(cell) for cell in np.argwhere(~left).tolist()} == taken
    assert FULL.all(), "the map handed in is not written to"
    assert not without_robots(SMALL, ~FULL, robots).any()


@pytest.mark.parametrize("kind", list(GoalKind))
def test_a_kind_is_the_word_of_the_registry(kind: GoalKind) -> None:
    assert kind == kind.value and f"{kind}" == kind.value and {kind.value: 1}[kind] == 1
    assert GoalKind(kind.value) is kind


def test_a_goal_has_no_cells_unless_they_are_given() -> None:
    first, second = Goal("a", GoalKind.TARGET, (1, 2)), Goal("b", GoalKind.TARGET, (1, 2))
    assert first.cells.shape == (0, 3) and first.cells is not second.cells


def test_a_map_without_a_thing_keeps_what_it_shares_with_another() -> None:
    things = {"a": np.array([[1, 1, 0], [2, 1, 0], [99, 1, 0]]), "b": np.array([[2, 1, 0], [3, 1, 0]])}
    occupied = np.zeros(SMALL.shape, dtype=bool)
    occupied[1:3, 1, 0] = True
    left = without_things(SMALL, occupied, things, ("a",))
    assert np.argwhere(left).tolist() == [[2, 1, 0]], "nor does it get what the map did not show"
    assert not without_things(SMALL, occupied, things, ("a", "b")).any()
    assert occupied.sum() == 2, "the map handed in is not written to"
