"""The search for a joint plan: found, valid, the same for the same seed, and given up within its limit."""

from __future__ import annotations

import numpy as np
import pytest

from python.planning.fleet_samples import FLEETS, SPEC, blocks, fleet_of, goals, head_on
from python.planning.samples import block, robot, walls
from yarm.planning.fleet.joint_plan import path_of, valid
from yarm.planning.fleet.joint_search import JointSearch


@pytest.mark.parametrize("name", sorted(FLEETS))
def test_a_joint_plan_is_found_and_valid(name: str) -> None:
    fleet = FLEETS[name]
    moves = JointSearch(fleet, range(len(fleet.spaces)), 200).run(np.random.default_rng(0))
    assert moves is not None
    assert valid(fleet, moves, range(len(fleet.spaces)))
    for i in range(len(fleet.spaces)):
        assert path_of(fleet, moves, i)[0] == fleet.starts[i]
    again = JointSearch(fleet, range(len(fleet.spaces)), 200).run(np.random.default_rng(0))
    assert again == moves


def test_the_robot_that_others_stand_in_the_way_of_goes_last() -> None:
    """Robot 0 must pass where robot 1 stands, which has a way of its own: 1 first, and nobody steps aside."""
    corridor = walls(SPEC, [(0, 30, 0, 8), (0, 30, 12, 24)])
    one = [robot("a", (2, 9), block(1, 1)), robot("b", (10, 9), block(1, 1))]
    fleet = fleet_of(one, goals((20, 9), (27, 9)), corridor)
    search = JointSearch(fleet, (0, 1), 50)
    moves = search.quick()
    assert moves is not None and valid(fleet, moves, (0, 1))
    assert [move.robot for move in moves] == [1, 0] and search.rounds == 2


def test_quick_does_not_push() -> None:
    fleet = head_on()
    assert JointSearch(fleet, (0, 1), 50).quick() is None
    assert JointSearch(fleet, (0, 1), 50).run(np.random.default_rng(0)) is not None


def test_what_has_no_solution_is_given_up_at_the_limit() -> None:
    """Two robots that would swap in a corridor without a bay."""
    corridor = walls(SPEC, [(0, 30, 0, 10), (0, 30, 13, 24)])
    fleet = fleet_of(
        [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))], goals((27, 11), (2, 11)), corridor
    )
    search = JointSearch(fleet, (0, 1), 12)
    assert search.run(np.random.default_rng(0)) is None
    assert 12 <= search.rounds <= 13


def test_robots_on_their_goals_need_no_move() -> None:
    fleet = fleet_of(blocks((2, 12), (14, 2)), goals((2, 12), (14, 2)))
    assert JointSearch(fleet, (0, 1), 10).run(np.random.default_rng(0)) == []
