"""The published planner shows what was published: waypoints by number of particles, and its flaws."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List

import numpy as np
import pytest

from python.planning.samples import block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.instances import make_instance
from yarm.planning.original_planner import OriginalPlanner
from yarm.planning.params import PlannerParams
from yarm.planning.shapes import ankurbot_mask
from yarm.planning.types import FleetPlan, Goal, PlanRequest, PlanStatus, Robot

CELL = GridSpec()
SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


def single(particles: int, seed: int) -> FleetPlan:
    """The particle study's scene: end effector from beside (0.7, 2.0) m to (-2, -2) m past the table."""
    table = np.zeros(CELL.shape, dtype=bool)
    table[20:30, 19:31, :11] = True
    one = Robot("a", (32, 45), math.pi, ankurbot_mask(CELL, math.pi))
    ask = request(CELL, table, [one], [Goal("t", "Target", (5, 5))])
    return OriginalPlanner(PlannerParams(particles=particles)).plan(ask, np.random.default_rng(seed))


@pytest.mark.parametrize(("particles", "low", "high"), [(20, 3, 8), (100, 7, 15), (333, 13, 25), (2496, 28, 44)])
def test_the_number_of_waypoints_grows_with_the_particles_as_published(particles: int, low: int, high: int) -> None:
    plans = [single(particles, seed) for seed in range(3)]
    solved = [len(plan.robots["a"].path) - 1 for plan in plans if plan.status is PlanStatus.SOLVED]
    assert solved
    assert low <= np.median(solved) <= high


def ask_in_the_open(column: tuple, occupied: np.ndarray = OPEN) -> PlanRequest:
    return request(SPEC, occupied, [robot("a", column, block(1, 1))], [Goal("t", "Target", (26, 12))])


def test_it_walks_to_the_goal_in_the_open() -> None:
    planner, rng, column = OriginalPlanner(PlannerParams(particles=60)), np.random.default_rng(1), (2, 12)
    for _ in range(60):
        plan = planner.plan(ask_in_the_open(column), rng)
        step = plan.robots["a"].step
        if step is None:
            break
        column = step.column
    assert column == (26, 12)


def goes_into_a_new_wall(seed: int) -> bool:
    planner, rng = OriginalPlanner(PlannerParams(particles=100)), np.random.default_rng(seed)
    first = planner.plan(ask_in_the_open((2, 12)), rng).robots["a"]
    assert first.step is not None
    x = first.step.column[0]
    again = planner.plan(ask_in_the_open((2, 12), walls(SPEC, [(x, x + 1, 0, 24)])), rng).robots["a"]
    return again.step is not None and again.step.column[0] >= x


def test_a_remembered_path_is_followed_into_what_stands_there_now() -> None:
    assert any(goes_into_a_new_wall(seed) for seed in range(10))


def test_it_keeps_no_margin() -> None:
    corridor = walls(SPEC, [(8, 20, 0, 12), (8, 20, 13, 24)])
    plan = OriginalPlanner(PlannerParams(particles=720)).plan(
        ask_in_the_open((2, 12), corridor), np.random.default_rng(0)
    )
    assert plan.status is PlanStatus.SOLVED


def test_it_stays_when_every_next_step_touches() -> None:
    closed = walls(SPEC, [(1, 4, 11, 12), (1, 4, 13, 14), (1, 2, 12, 13), (3, 4, 12, 13)])
    plan = OriginalPlanner().plan(ask_in_the_open((2, 12), closed), np.random.default_rng(0))
    assert plan.status is PlanStatus.TIMEOUT
    assert plan.robots["a"].step is None
    assert "stays" in plan.reason


def test_same_seed_same_plan_and_faults_have_reasons() -> None:
    ask = make_instance("crossing", 1).scene
    request_ = ask.request(ask.starts(), dict(ask.assignments))
    paths: List[object] = []
    for _ in range(2):
        plan = OriginalPlanner().plan(request_, np.random.default_rng(5))
        paths.append({name: entry.path for name, entry in plan.robots.items()})
    assert paths[0] == paths[1]
    broken = replace(request_, grid=np.zeros((2, 2, 2), dtype=np.int8))
    assert OriginalPlanner().plan(broken, np.random.default_rng(0)).status is PlanStatus.INVALID_START
