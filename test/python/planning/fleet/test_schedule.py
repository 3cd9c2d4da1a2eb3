"""How long joint plans take, and the one that takes least."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from python.planning.fleet_samples import CORRIDOR_WITH_BAY, FLEETS, SPEC, blocks, fleet_of, goals
from python.planning.samples import block, request, robot
from yarm.planning.fleet.fleet import Move
from yarm.planning.fleet.joint_plan import Conflicts, valid
from yarm.planning.fleet.joint_search import JointSearch
from yarm.planning.fleet.schedule import Duration, Pace, alone_s, duration, soonest
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams

PACE = Pace(speed_mps=1.0, start_s=1.0, turn_radps=1.0, turn_start_s=0.5)


def takes(fleet, moves):
    return duration(fleet, moves, PACE, Conflicts(fleet))


def test_moves_that_are_apart_are_made_at_once_and_the_last_counts():
    fleet = fleet_of(blocks((2, 2), (2, 20)), goals((12, 2), (22, 20)))
    moves = [Move(0, (2, 2, 0), (12, 2, 0)), Move(1, (2, 20, 0), (22, 20, 0))]
    assert takes(fleet, moves) == Duration(pytest.approx(3.0), pytest.approx(2.0 + 3.0))


def test_whoever_must_wait_counts_from_when_it_may_go():
    """Both go through the same place: the second leaves its last piece until the first one's has ended."""
    fleet = fleet_of(blocks((2, 12), (14, 2)), goals((26, 12), (14, 20)))
    first, second = Move(0, (2, 12, 0), (26, 12, 0)), Move(1, (14, 2, 0), (14, 20, 0))
    alone = takes(fleet, [second]).last_s
    assert takes(fleet, [first, second]).last_s > alone + 0.5
    assert takes(fleet, [first, second]).last_s < takes(fleet, [first]).last_s + alone


def test_a_turn_takes_its_time_and_a_straight_way_in_two_moves_no_more_than_in_one():
    fleet = fleet_of(blocks((2, 12)), goals((26, 12)))
    one = [Move(0, (2, 12, 0), (22, 12, 0))]
    two = [Move(0, (2, 12, 0), (12, 12, 0)), Move(0, (12, 12, 0), (22, 12, 0))]
    assert takes(fleet, two).last_s == pytest.approx(takes(fleet, one).last_s)
    turning = [Move(0, (2, 12, 0), (2, 12, 1)), Move(0, (2, 12, 1), (22, 12, 1))]
    assert takes(fleet, turning).last_s == pytest.approx(takes(fleet, one).last_s + 0.5 + math.pi / 2)


@pytest.mark.parametrize("name", sorted(FLEETS))
def test_the_soonest_plan_is_valid_no_later_than_the_first_and_the_same_again(name):
    fleet = FLEETS[name]
    robots = range(len(fleet.spaces))

    def found():
        return soonest([fleet], robots, 200, 60, PACE, Conflicts(fleet), np.random.default_rng(0))

    best = found()
    assert best.moves is not None and valid(fleet, best.moves, robots)
    first = JointSearch(fleet, robots, 200).run(np.random.default_rng(0))
    assert best.takes.last_s <= takes(fleet, first).last_s + 1e-9
    assert best.takes.last_s >= alone_s(fleet, robots, PACE) - 1e-9
    assert found() == best


def test_a_better_order_than_the_first_is_found_where_there_is_one():
    """Two robots change sides through a corridor with a bay: it matters which of them waits there."""
    shorter = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        columns = [tuple(int(v) for v in rng.integers((1, 1), (4, 22))) for _ in range(1)]
        columns += [tuple(int(v) for v in rng.integers((26, 1), (29, 22))) for _ in range(1)]
        ends = goals(*(tuple(int(v) for v in rng.integers((26, 1), (29, 22))), (2, int(rng.integers(1, 22)))))
        fleet = fleet_of([robot(f"r{i}", at, block(1, 1)) for i, at in enumerate(columns)], ends, CORRIDOR_WITH_BAY)
        first = JointSearch(fleet, (0, 1), 100).run(np.random.default_rng(0))
        best = soonest([fleet], (0, 1), 100, 60, PACE, Conflicts(fleet), np.random.default_rng(0))
        shorter.append(best.takes.last_s / takes(fleet, first).last_s)
    assert max(shorter) <= 1.0 + 1e-9 and min(shorter) < 0.95


def test_nothing_is_found_where_nothing_is_and_nobody_need_move_where_all_are_there():
    corridor = fleet_of(
        [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))],
        goals((27, 11), (2, 11)),
        np.pad(np.zeros((30, 3, 4), dtype=bool), ((0, 0), (10, 11), (0, 0)), constant_values=True),
    )
    found = soonest([corridor], (0, 1), 12, 60, PACE, Conflicts(corridor), np.random.default_rng(0))
    assert found.moves is None and 12 <= found.rounds <= 14
    there = fleet_of(blocks((2, 12), (14, 2)), goals((2, 12), (14, 2)))
    assert soonest([there], (0, 1), 12, 60, PACE, Conflicts(there), np.random.default_rng(0)).moves == []


def test_the_planner_looks_for_the_soonest_only_when_robots_do_not_wait_for_all():
    robots = [robot("a", (2, 11), block(1, 1)), robot("b", (27, 11), block(1, 1))]
    asked = request(SPEC, CORRIDOR_WITH_BAY, robots, goals((27, 11), (2, 11)))
    together, apart = (
        YarmPlanner(PlannerParams()).plan(replace(asked, under_way=under_way), np.random.default_rng(0)).iterations
        for under_way in (None, {})
    )
    assert apart > together
