"""The joint plan: valid as an order, safe when moves that do not touch are made at once."""

from __future__ import annotations

from typing import List, Sequence, Tuple

import numpy as np
import pytest

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.bitboard import dilated, overlap
from yarm.planning.cspace import ShapeCache, poses_touch
from yarm.planning.fleet import Fleet, Move
from yarm.planning.goal_headings import target_choices
from yarm.planning.joint_plan import StepChoice, path_of, valid
from yarm.planning.joint_search import JointSearch
from yarm.planning.particles import cell_order
from yarm.planning.search import Roadmap
from yarm.planning.types import Goal, Robot
from yarm.planning.world import World, turns_of

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def fleet_of(robots: Sequence[Robot], goals: Sequence[Goal], occupied: np.ndarray = OPEN) -> Fleet:
    ask = request(SPEC, occupied, robots, goals)
    world = World.of(ask, turns_of((0.0, 90.0, -90.0)), ShapeCache())
    assert world is not None
    return Fleet(world.spaces, world.targets, Roadmap(cell_order((30, 24))[:80].astype(np.int64)))


def blocks(*columns: Tuple[int, int]) -> List[Robot]:
    return [robot(f"r{i}", column, block(2, 2)) for i, column in enumerate(columns)]


def goals(*columns: Tuple[int, int]) -> List[Goal]:
    return [Goal(f"g{i}", "Target", column) for i, column in enumerate(columns)]


CASES = {
    "crossing": fleet_of(blocks((2, 12), (14, 2)), goals((26, 12), (14, 20))),
    "swap": fleet_of(blocks((2, 12), (26, 12)), goals((26, 12), (2, 12))),
    "ring": fleet_of(blocks((2, 2), (26, 2), (26, 20)), goals((26, 2), (26, 20), (2, 2))),
    "head_on": fleet_of(
        [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))],
        goals((27, 11), (2, 11)),
        walls(SPEC, [(5, 25, 0, 10), (5, 13, 13, 24), (18, 25, 13, 24), (13, 18, 17, 24)]),
    ),
}


@pytest.mark.parametrize("name", sorted(CASES))
def test_a_joint_plan_is_found_and_valid(name: str) -> None:
    fleet = CASES[name]
    moves = JointSearch(fleet, range(len(fleet.spaces)), 200).run(np.random.default_rng(0))
    assert moves is not None
    assert valid(fleet, moves, range(len(fleet.spaces)))
    for i in range(len(fleet.spaces)):
        assert path_of(fleet, moves, i)[0] == fleet.starts[i]


@pytest.mark.parametrize("name", sorted(CASES))
def test_moves_made_at_once_are_disjoint_with_a_margin(name: str) -> None:
    fleet = CASES[name]
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
    fleet = CASES["crossing"]
    moves = [Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (14, 2, 0), (14, 20, 0))]
    choice = StepChoice(fleet, moves, 3)
    ends = choice.choose()
    assert ends[0] == (26, 12, 0)
    assert 3 <= ends[1][1] - 2 <= 7
    assert len(choice.moves) == 3
    assert StepChoice(fleet, moves, 99).choose() == {0: (26, 12, 0)}


def test_robots_off_their_centres_keep_one_more_cell_apart() -> None:
    fleet = fleet_of(blocks((2, 10), (2, 13)), goals((20, 10), (20, 13)))
    moves = [Move(0, (2, 10, 0), (20, 10, 0)), Move(1, (2, 13, 0), (20, 13, 0))]
    assert len(StepChoice(fleet, moves, 3).choose()) == 2
    assert len(StepChoice(fleet, moves, 3, off_center=(0, 1)).choose()) == 1


def test_a_plan_that_touches_or_starts_elsewhere_is_not_valid() -> None:
    fleet = CASES["swap"]
    straight = [Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (26, 12, 0), (2, 12, 0))]
    assert not valid(fleet, straight, (0, 1))
    assert not valid(fleet, [Move(0, (3, 12, 0), (4, 12, 0))], ())
    assert not valid(fleet, [], (0, 1))
    assert valid(fleet, [], ())


def test_headings_are_chosen_so_that_robots_fit_on_goals_side_by_side() -> None:
    robots = [robot("a", (10, 4), arm(6)), robot("b", (10, 18), arm(6))]
    fleet = fleet_of(robots, goals((15, 11), (15, 13)))
    choices = target_choices(fleet, (0, 1))
    for targets in choices[1:]:
        poses = [(*targets[i].column, targets[i].heading or 0) for i in (0, 1)]
        assert not poses_touch(fleet.spaces[0], poses[0], fleet.spaces[1], poses[1])
    apart = fleet_of(robots, goals((8, 4), (25, 18)))
    assert [t.heading for t in target_choices(apart, (0, 1))[0].values()] == [None, None]
    moves = JointSearch(fleet, (0, 1), 100).run(np.random.default_rng(0))
    assert moves is not None
    assert valid(fleet, moves, (0, 1))
