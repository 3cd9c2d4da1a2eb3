"""The published planner behaves as published, flaws and all; its waypoint counts are in experiments/test_study.py."""

from __future__ import annotations

from dataclasses import replace
from typing import List

import numpy as np

from python.planning.samples import block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.instances import make_instance
from yarm.planning.original_planner import OriginalPlanner
from yarm.planning.params import PlannerParams
from yarm.planning.types import Goal, PlanRequest, PlanStatus

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)


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


def goes(occupied: np.ndarray) -> bool:
    """Whether some path through the middle has a next step that it takes for free."""
    ask = ask_in_the_open((2, 12), occupied)
    plan = OriginalPlanner(PlannerParams(particles=720)).plan(ask, np.random.default_rng(0))
    return plan.robots["a"].step is not None


def test_it_keeps_two_cells_from_what_stands_there() -> None:
    assert goes(walls(SPEC, [(3, 30, 0, 10), (3, 30, 15, 24)]))
    assert not goes(walls(SPEC, [(3, 30, 0, 11), (3, 30, 14, 24)]))


def test_it_leaves_a_place_inside_the_margin() -> None:
    assert goes(walls(SPEC, [(0, 3, 14, 15)]))


def test_it_keeps_no_margin_between_robots() -> None:
    others = [robot("b", (14, 13), block(1, 1)), robot("c", (14, 11), block(1, 1))]
    ask = ask_in_the_open((14, 12))
    goals = (*ask.goals.values(), Goal("u", "Target", (2, 2)), Goal("v", "Target", (2, 22)))
    crowd = request(SPEC, OPEN, [*ask.robots, *others], goals)
    plan = OriginalPlanner(PlannerParams(particles=720)).plan(crowd, np.random.default_rng(0))
    assert plan.robots["a"].step is not None


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
