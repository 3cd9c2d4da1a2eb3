"""From an order of moves to what is made at once: disjoint, and the rest of the plan stays valid."""

from __future__ import annotations

import numpy as np
import pytest

from python.planning.fleet_samples import FLEETS, blocks, fleet_of, goals
from yarm.planning.cspace.cell_sets import dilated, overlap
from yarm.planning.fleet.fleet import Move
from yarm.planning.fleet.joint_plan import Conflicts, StepChoice, path_of, valid
from yarm.planning.fleet.joint_search import JointSearch


@pytest.mark.parametrize("name", sorted(FLEETS))
def test_moves_made_at_once_are_disjoint_with_a_margin(name: str) -> None:
    fleet = FLEETS[name]
    moves = JointSearch(fleet, range(len(fleet.spaces)), 200).run(np.random.default_rng(0))
    assert moves is not None
    choice = StepChoice(fleet, moves, 3)
    ends = choice.choose()
    assert ends
    assert valid(fleet, choice.moves, range(len(fleet.spaces)))
    swept = {i: fleet.spaces[i].swept(fleet.starts[i], ends.get(i, fleet.starts[i])) for i in range(len(fleet.spaces))}
    for i, mine in swept.items():
        for j in range(i):
            assert not overlap(dilated(mine, fleet.spaces[i].layout.stride), swept[j])


def test_the_first_in_order_goes_and_the_second_moves_up_to_the_conflict() -> None:
    fleet = FLEETS["crossing"]
    moves = [Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (14, 2, 0), (14, 20, 0))]
    choice = StepChoice(fleet, moves, 3)
    ends = choice.choose()
    assert ends[0] == (26, 12, 0)
    assert 3 <= ends[1][1] - 2 <= 7
    assert len(choice.moves) == 3
    assert StepChoice(fleet, moves, 99).choose() == {0: (26, 12, 0)}


def test_a_move_that_turns_is_not_made_in_part() -> None:
    fleet = FLEETS["crossing"]
    moves = [Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (14, 2, 0), (14, 20, 1))]
    assert StepChoice(fleet, moves, 3).choose() == {0: (26, 12, 0)}


def test_only_the_first_move_of_a_robot_is_made_now() -> None:
    fleet = FLEETS["crossing"]
    moves = [Move(0, (2, 12, 0), (6, 12, 0)), Move(0, (6, 12, 0), (26, 12, 0)), Move(1, (14, 2, 0), (14, 6, 0))]
    choice = StepChoice(fleet, moves, 3)
    assert choice.choose() == {0: (6, 12, 0), 1: (14, 6, 0)} and choice.moves == moves


def test_robots_off_their_centres_keep_one_more_cell_apart() -> None:
    fleet = fleet_of(blocks((2, 10), (2, 13)), goals((20, 10), (20, 13)))
    moves = [Move(0, (2, 10, 0), (20, 10, 0)), Move(1, (2, 13, 0), (20, 13, 0))]
    assert len(StepChoice(fleet, moves, 3).choose()) == 2
    assert len(StepChoice(fleet, moves, 3, Conflicts(fleet, (0, 1))).choose()) == 1


def test_a_plan_that_touches_or_starts_elsewhere_is_not_valid() -> None:
    fleet = FLEETS["swap"]
    straight = [Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (26, 12, 0), (2, 12, 0))]
    assert not valid(fleet, straight, (0, 1))
    assert not valid(fleet, [Move(0, (3, 12, 0), (4, 12, 0))], ())
    assert not valid(fleet, [], (0, 1))
    assert valid(fleet, [], ())


def test_the_path_of_a_robot_begins_where_it_stands() -> None:
    fleet = FLEETS["swap"]
    moves = [Move(0, (2, 12, 0), (2, 5, 0)), Move(1, (26, 12, 0), (2, 12, 0)), Move(0, (2, 5, 0), (26, 12, 0))]
    assert path_of(fleet, moves, 0) == ((2, 12, 0), (2, 5, 0), (26, 12, 0))
    assert path_of(fleet, [], 1) == ((26, 12, 0),)
