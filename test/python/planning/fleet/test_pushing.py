"""Robots in the way step aside, push on others, and whoever cannot changes nothing."""

from __future__ import annotations

import numpy as np
import pytest

from python.planning.fleet_samples import CORRIDOR_WITH_BAY, SPEC, blocks, fleet_of, goals, head_on
from python.planning.samples import block, robot, walls
from yarm.planning.fleet.fleet import Fleet, Progress
from yarm.planning.fleet.joint_plan import valid
from yarm.planning.fleet.pushing import push_through, stroll


def pushed(fleet: Fleet, i: int, seed: int = -1) -> Progress:
    """Progress after a robot was let through; valid as an order of moves."""
    state, target = Progress(fleet.starts), fleet.targets[i]
    assert target is not None
    rng = None if seed < 0 else np.random.default_rng(seed)
    assert push_through(fleet, state, i, target, rng)
    assert valid(fleet, state.moves, [i])
    assert state.moves[-1].robot == i
    return state


def test_the_robot_in_the_way_goes_into_the_bay_first() -> None:
    state = pushed(head_on(), 0)
    assert state.poses[0][:2] == (27, 11)
    assert {move.robot for move in state.moves} == {0, 1}
    assert state.moves[0].robot == 1


def test_a_free_way_pushes_nobody() -> None:
    state = pushed(fleet_of(blocks((2, 12), (14, 2)), goals((26, 12), (14, 20))), 0)
    assert {move.robot for move in state.moves} == {0}


def test_who_steps_aside_goes_to_the_nearest_place_clear_of_the_way() -> None:
    fleet = fleet_of(blocks((2, 12), (14, 12)), goals((26, 12)))
    state = pushed(fleet, 0)
    x, y, _ = state.poses[1]
    assert abs(x - 14) + abs(y - 12) == 3, "the way is two rows high, the margin one"


@pytest.mark.parametrize("seed", range(5))
def test_with_chance_the_place_is_any_that_is_clear(seed: int) -> None:
    fleet = fleet_of(blocks((2, 12), (14, 12)), goals((26, 12)))
    assert pushed(fleet, 0, seed).poses[1] == pushed(fleet, 0, seed).poses[1]


def test_a_robot_that_steps_aside_pushes_on_whoever_stands_in_its_bay() -> None:
    one = block(1, 1)
    robots = [robot("a", (2, 11), one), robot("b", (15, 11), one), robot("c", (15, 14), one)]
    shallow = CORRIDOR_WITH_BAY | walls(SPEC, [(0, 30, 0, 10), (13, 18, 16, 24)])
    state = pushed(fleet_of(robots, goals((27, 11)), shallow), 0)
    assert {move.robot for move in state.moves} >= {0, 1}


def test_where_nobody_can_step_aside_nothing_is_changed() -> None:
    corridor = walls(SPEC, [(0, 30, 0, 10), (0, 30, 13, 24)])
    fleet = fleet_of([robot("a", (2, 11), block(1, 1)), robot("b", (20, 11), block(1, 1))], goals((29, 11)), corridor)
    state, target = Progress(fleet.starts), fleet.targets[0]
    assert target is not None
    assert not push_through(fleet, state, 0, target)
    assert state.poses == fleet.starts and state.moves == []


def test_no_way_at_all_is_no_push() -> None:
    fleet = fleet_of(blocks((2, 12), (6, 12)), goals((26, 12)), walls(SPEC, [(14, 16, 0, 24)]))
    target = fleet.targets[0]
    assert target is not None and not push_through(fleet, Progress(fleet.starts), 0, target)


@pytest.mark.parametrize("seed", range(5))
def test_a_stroll_ends_somewhere_free(seed: int) -> None:
    fleet = fleet_of(blocks((2, 12), (14, 2)), goals((26, 12), (14, 20)), walls(SPEC, [(10, 12, 0, 20)]))
    state = Progress(fleet.starts)
    stroll(fleet, state, 0, np.random.default_rng(seed))
    assert valid(fleet, state.moves, ())
    assert fleet.view(0, state.poses).stands(state.poses[0]) and state.poses[1] == fleet.starts[1]
