"""One contract that every planner passes, and what only ``yarm`` promises."""

from __future__ import annotations

import importlib.util
import math
import os
from dataclasses import replace

import numpy as np
import pytest

from yarm.geometry import Mask
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, PlanStatus
from yarm.planning.registry import PLANNER_NAMES, make_planner
from yarm.planning.verification.checker import check_step

POINT = [(0, 0, 0)]
ELL = [(0, 0, 0), (-1, 0, 0), (-1, 1, 0)]
NO_PATH = (PlanStatus.INFEASIBLE, PlanStatus.TIMEOUT)

_NO_OMPL = pytest.mark.skipif(importlib.util.find_spec("ompl") is None, reason="the ompl wheel is not installed")
NAMES = (*PLANNER_NAMES, *os.environ.get("YARM_PLANNERS", "").split())
PLANNERS = [pytest.param(n, marks=_NO_OMPL if n.startswith("ompl") else ()) for n in NAMES]
SAFE_PLANNERS = [p for p in PLANNERS if p.values[0] != "original"]


def plan_with(name, request, particles=30, seed=1):
    return make_planner(name, PlannerParams(particles=particles)).plan(request, np.random.default_rng(seed))


def free_columns(request_of, shape, box):
    """Columns of a one-cell robot clear of the box and its margin."""
    near = np.zeros(shape[:2], dtype=bool)
    near[max(box[0] - 1, 0) : box[0] + 2, max(box[1] - 1, 0) : box[1] + 2] = True
    return [(int(x), int(y)) for x, y in np.argwhere(~near)]


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_every_free_cell_to_every_other(request_of, name):
    shape, box = (5, 5, 1), (2, 0, 0)
    columns = free_columns(request_of, shape, box)
    pairs = [(a, b) for a in columns for b in columns if a != b]
    pairs = pairs if name == "yarm" else pairs[:: 5 if name == "ma_astar" else 31]
    planner = make_planner(name, PlannerParams(particles=12))
    for a, b in pairs:
        planner.reset()
        request = request_of(shape, {"a": (a, POINT)}, {"a": b}, {"crate": [box]})
        plan = planner.plan(request, np.random.default_rng(0))
        entry = plan.robots["a"]
        assert plan.status is PlanStatus.SOLVED, (a, b, plan.reason)
        assert entry.path[0].column == a and entry.path[-1].column == b
        assert entry.step == entry.path[1]
        assert entry.length_cells >= math.dist(a, b) - 1e-6
        assert check_step(request, plan).safe, (a, b)


@pytest.mark.parametrize("name", PLANNERS)
def test_start_is_goal(request_of, name):
    plan = plan_with(name, request_of((8, 8, 1), {"a": ((3, 3), ELL)}, {"a": (3, 3)}))
    assert plan.status is PlanStatus.SOLVED
    assert plan.robots["a"].step is None and plan.robots["a"].length_cells == 0.0


@pytest.mark.parametrize("name", PLANNERS)
def test_occupied_start_names_what_is_there(request_of, name):
    request = request_of((8, 8, 1), {"a": ((3, 3), POINT)}, {"a": (6, 6)}, {"crate": [(3, 3, 0)]})
    plan = plan_with(name, request)
    assert plan.status is PlanStatus.INVALID_START and "crate" in plan.reason and "a" in plan.reason
    assert plan.robots["a"].step is None


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_occupied_goal_names_what_is_there(request_of, name):
    plan = plan_with(name, request_of((8, 8, 1), {"a": ((1, 1), POINT)}, {"a": (5, 5)}, {"crate": [(5, 5, 0)]}))
    assert plan.status is PlanStatus.INVALID_GOAL and "crate" in plan.reason
    assert plan.robots["a"].step is None


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize("column", [(-1, 3), (3, 8), (100, 100)])
def test_goal_out_of_bounds(request_of, name, column):
    plan = plan_with(name, request_of((8, 8, 1), {"a": ((1, 1), POINT)}, {"a": column}))
    assert plan.status is PlanStatus.INVALID_GOAL and plan.reason


@pytest.mark.parametrize("name", PLANNERS)
@pytest.mark.parametrize("column", [(-1, 3), (3, 8)])
def test_start_out_of_bounds(request_of, name, column):
    plan = plan_with(name, request_of((8, 8, 1), {"a": (column, POINT)}, {"a": (5, 5)}))
    assert plan.status is PlanStatus.INVALID_START and plan.reason


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_no_path(request_of, name):
    wall = [(4, y, 0) for y in range(9)]
    plan = plan_with(name, request_of((9, 9, 1), {"a": ((1, 1), POINT)}, {"a": (7, 7)}, {"wall": wall}))
    expected = (PlanStatus.TIMEOUT,) if name.startswith("ompl") else (PlanStatus.INFEASIBLE,)
    assert plan.status in expected and "a" in plan.reason
    assert plan.robots["a"].step is None


@pytest.mark.parametrize("name", PLANNERS)
def test_wrong_shapes_are_answered_not_raised(request_of, name):
    good = request_of((8, 8, 2), {"a": ((1, 1), POINT)}, {"a": (5, 5)})
    robot = good.robots[0]
    wrong = [
        replace(good, occupied=np.zeros((8, 7, 2), dtype=bool)),
        replace(good, occupied=np.zeros((8, 8), dtype=bool)),
        replace(good, forbidden=np.zeros((7, 8), dtype=bool)),
        replace(good, robots=(replace(robot, mask=Mask(np.zeros((0, 3), dtype=np.int64))),)),
        replace(good, robots=(replace(robot, mask=Mask(np.zeros((4, 2), dtype=np.int64))),)),
        replace(good, robots=(robot, robot)),
        replace(good, robots=()),
    ]
    for request in wrong:
        plan = plan_with(name, request)
        assert plan.status is PlanStatus.INVALID_START and plan.reason, request


@pytest.mark.parametrize("name", PLANNERS)
def test_mask_larger_than_the_grid(request_of, name):
    long = [(-k, 0, 0) for k in range(12)]
    plan = plan_with(name, request_of((8, 8, 1), {"a": ((4, 4), long)}, {"a": (5, 5)}))
    assert plan.status is PlanStatus.INVALID_START and "a" in plan.reason


@pytest.mark.parametrize("name", PLANNERS)
def test_numbers_that_are_not_finite(request_of, name):
    good = request_of((8, 8, 1), {"a": ((1, 1), POINT)}, {"a": (5, 5)})
    robot = good.robots[0]
    for bad in (replace(robot, yaw_rad=float("nan")), replace(robot, position_m=(float("nan"), 0.1))):
        assert plan_with(name, replace(good, robots=(bad,))).status is PlanStatus.INVALID_START
    goal = replace(good.goals["goal_a"], yaw_rad=float("inf"))
    assert plan_with(name, replace(good, goals={"goal_a": goal})).status is PlanStatus.INVALID_GOAL


@pytest.mark.parametrize("name", PLANNERS)
def test_assignment_to_a_goal_that_is_not_there(request_of, name):
    good = request_of((8, 8, 1), {"a": ((1, 1), POINT)}, {"a": (5, 5)})
    plan = plan_with(name, replace(good, goals={}))
    assert plan.status is PlanStatus.INVALID_GOAL and "goal_a" in plan.reason


@pytest.mark.parametrize("name", PLANNERS)
def test_nothing_to_do(request_of, name):
    plan = plan_with(name, request_of((8, 8, 1), {"a": ((1, 1), POINT)}))
    assert plan.status is PlanStatus.SOLVED and all(entry.step is None for entry in plan.robots.values())


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_wanted_heading_is_reached(request_of, name):
    request = request_of((12, 12, 1), {"a": ((3, 3), ELL)}, {"a": (8, 8)})
    goal = Goal("goal_a", "Target", (8, 8), yaw_rad=math.pi / 2.0)
    plan = plan_with(name, replace(request, goals={"goal_a": goal}))
    assert plan.status is PlanStatus.SOLVED, plan.reason
    last = plan.robots["a"].path[-1]
    assert last.column == (8, 8) and abs(math.remainder(last.yaw_rad - math.pi / 2.0, math.tau)) < 1e-6


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_steps_of_a_fleet_are_safe(request_of, name):
    robots = {"a": ((2, 6), ELL), "b": ((10, 6), ELL), "c": ((6, 2), ELL)}
    request = request_of((14, 14, 1), robots, {"a": (10, 6), "b": (2, 6), "c": (6, 10)})
    plan = plan_with(name, request)
    assert check_step(request, plan).safe
    assert any(entry.step is not None for entry in plan.robots.values())


@pytest.mark.parametrize("name", [p for p in PLANNERS if not str(p.values[0]).startswith("ompl")])
def test_same_seed_same_plan(request_of, name):
    robots = {"a": ((2, 6), ELL), "b": ((10, 6), ELL)}
    request = request_of((14, 14, 1), robots, {"a": (10, 6), "b": (2, 6)}, {"crate": [(6, 9, 0)]})
    first, second = plan_with(name, request, seed=5), plan_with(name, request, seed=5)
    for robot in ("a", "b"):
        assert first.robots[robot].path == second.robots[robot].path
        assert first.robots[robot].step == second.robots[robot].step


@pytest.mark.parametrize("name", SAFE_PLANNERS)
def test_half_turn_is_planned_both_ways_round(request_of, name):
    """A crate stands where only one way round would sweep it; which way the robot takes is not the planner's choice."""
    bar = [(0, 0, 0), (-1, 0, 0), (-2, 0, 0), (-3, 0, 0)]
    for crate in ((10, 6, 0), (10, 14, 0)):
        request = request_of((20, 20, 1), {"a": ((10, 10), bar)}, {"a": (10, 10)}, {"crate": [crate]})
        goal = Goal("goal_a", "Target", (10, 10), yaw_rad=math.pi)
        params = PlannerParams(particles=30, turns_deg=(0.0, 180.0))
        plan = make_planner(name, params).plan(replace(request, goals={"goal_a": goal}), np.random.default_rng(1))
        assert check_step(request, plan).safe, check_step(request, plan).reason


def test_unknown_planner_is_named():
    with pytest.raises(KeyError, match="no_such"):
        make_planner("no_such")
