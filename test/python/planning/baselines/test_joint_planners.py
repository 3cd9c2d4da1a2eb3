"""The peers that plan all robots together: what they find, what they say when they find nothing."""

from __future__ import annotations

import importlib.util
import math
from collections import deque
from typing import Dict, List, Tuple

import numpy as np
import pytest

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.baselines.joint import Standing, tightened
from yarm.planning.baselines.lacam import CostToGo, LacamPlanner, Ways, goal_configurations
from yarm.planning.cspace.robot_space import Pose, ShapeCache, poses_touch
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.fleet.joint_plan import valid
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.model.types import Goal, PlanRequest, PlanStatus
from yarm.planning.registry import make_planner
from yarm.planning.roadmap.roadmap import Roadmap
from yarm.planning.roadmap.search import Target
from yarm.planning.scenes.instances import make_instance
from yarm.planning.scenes.scene_file import load_scene
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.verification.bruteforce import touches
from yarm.planning.verification.checker import check_step
from yarm.resources import resource

SPEC = GridSpec((16, 12, 4), (0.0, 0.0, 0.0), (1.6, 1.2, 0.4))
JOINT = [
    "lacam",
    pytest.param(
        "ompl_joint_rrtconnect",
        marks=pytest.mark.skipif(importlib.util.find_spec("ompl") is None, reason="the ompl wheel is not installed"),
    ),
]


def fleet_of(ask: PlanRequest, turns: Tuple[float, ...] = (0.0, 90.0, -90.0)) -> Fleet:
    problem = PlanningProblem.of(ask, turns_of(turns), ShapeCache())
    assert problem is not None
    return Fleet(problem.spaces, problem.targets, Roadmap.of(np.zeros((0, 2), dtype=np.int64)))


def test_cost_to_go_is_that_of_a_plain_search() -> None:
    ask = request(SPEC, walls(SPEC, [(8, 9, 0, 5)]), [robot("a", (4, 6), arm(3))], [Goal("g", "Target", (13, 3))])
    fleet = fleet_of(ask)
    view = Standing(fleet).alone[0]
    target = fleet.targets[0]
    assert target is not None
    costs: Dict[Pose, int] = {}
    fronts: List[List[Pose]] = [[(13, 3, h) for h in range(4) if view.stands((13, 3, h))]]
    while any(fronts[-9:]):
        for pose in fronts[-1]:
            costs[pose] = len(fronts) - 1
        beside = [(x + dx, y + dy, h) for x, y, h in fronts[-1] for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))]
        turned = [
            (x, y, k)
            for x, y, h in (fronts[-9] if len(fronts) >= 9 else [])
            for k in range(4)
            if view.turns(x, y, k, h) and k != h
        ]
        new = {pose for pose in [*beside, *turned] if pose not in costs and view.stands(pose)}
        fronts.append(sorted(new))
    found = CostToGo(view, target)
    everywhere = [(x, y, h) for x in range(16) for y in range(12) for h in range(4)]
    assert all(found.cost(pose) == costs.get(pose, float("inf")) for pose in everywhere)
    assert len(costs) > 100


@pytest.mark.parametrize("name", JOINT)
@pytest.mark.parametrize("seed", range(3))
def test_robots_that_meet_head_on_pass_each_other(name: str, seed: int) -> None:
    """In an open cell, where each stands on the other's goal: no order of going straight there exists."""
    ask = request(
        SPEC,
        walls(SPEC, []),
        [robot("a", (3, 5), block(2, 2)), robot("b", (12, 5), block(2, 2))],
        [Goal("g", "Target", (12, 5)), Goal("f", "Target", (3, 5))],
    )
    plan = make_planner(name).plan(ask, np.random.default_rng(seed))
    assert plan.status is PlanStatus.SOLVED, plan.reason
    assert [entry.path[-1].column for entry in plan.robots.values()] == [(12, 5), (3, 5)]
    assert check_step(ask, plan).safe
    assert any(entry.step is not None for entry in plan.robots.values())


@pytest.mark.parametrize("name", JOINT)
def test_scenes_are_stepped_to_the_end_and_nobody_touches(name: str) -> None:
    solved = 0
    for family, seed in (("open", 1), ("table_and_stand", 2), ("crossing", 3), ("crossing", 4)):
        found: List[str] = []
        scene = make_instance(family, seed, 2).scene
        run = step_to_end(
            scene,
            make_planner(name),
            np.random.default_rng(seed),
            clearance=False,
            observe=lambda ask, plan, verdict, found=found: found.extend(touches(ask, plan)),
        )
        assert run.refused == 0, (family, seed, run.refusals)
        assert not found, (family, seed, found)
        solved += run.status is PlanStatus.SOLVED
    assert solved >= 3


def test_a_corridor_with_a_bay_is_solved() -> None:
    for seed in range(4):
        run = step_to_end(
            make_instance("corridors_head_on", seed).scene,
            LacamPlanner(),
            np.random.default_rng(seed),
            clearance=False,
        )
        assert run.status is PlanStatus.SOLVED, (seed, run.reason)
        assert run.refused == 0


def test_goals_that_only_some_headings_allow_are_chosen_before_the_search() -> None:
    """Two long arms with goals so near each other that only some of their headings go together."""
    robots = [robot("a", (3, 6), arm(3)), robot("b", (12, 6), arm(3))]
    goals = [Goal("g", "Target", (7, 6)), Goal("f", "Target", (9, 6))]
    fleet = fleet_of(request(SPEC, walls(SPEC, []), robots, goals))
    standing = Standing(fleet)
    targets = {i: target for i, target in enumerate(fleet.targets) if target is not None}
    ways = Ways(standing)
    choices = goal_configurations(fleet, targets, ways)
    poses = [tuple((*choice[i].column, choice[i].heading) for i in (0, 1)) for choice in choices]
    everything = [((7, 6, h), (9, 6, k)) for h in range(4) for k in range(4)]
    apart = [(a, b) for a, b in everything if not poses_touch(fleet.spaces[0], a, fleet.spaces[1], b)]
    assert 0 < len(apart) < 16
    assert sorted(poses) == sorted(apart)
    costs = [sum(ways.to(i, choice[i]).cost(fleet.starts[i]) for i in (0, 1)) for choice in choices]
    assert costs == sorted(costs)
    far = {0: Target((2, 6)), 1: Target((13, 6))}
    assert goal_configurations(fleet, far, Ways(standing)) == [far], "where every heading does, it stays open"


def test_others_make_room_for_a_turn_over_several_rounds() -> None:
    """A turn sweeps more than one cell's way clears, and its robot stands at its goal's column already."""
    robots = [robot("a", (8, 6), arm(5)), robot("b", (9, 9), block(1, 1))]
    goal = Goal("g", "Target", (8, 6), yaw_rad=math.pi / 2)
    plan = LacamPlanner().plan(request(SPEC, walls(SPEC, []), robots, [goal], {"a": "g"}), np.random.default_rng(0))
    assert plan.status is PlanStatus.SOLVED, plan.reason
    assert plan.robots["b"].goal == ""
    assert plan.iterations < 40


@pytest.mark.parametrize(("family", "seed"), [("crossing", 200004), ("open", 200005)])
def test_three_robots_that_must_make_room_for_each_other(family: str, seed: int) -> None:
    scene = make_instance(family, seed).scene
    run = step_to_end(scene, LacamPlanner(), np.random.default_rng(seed), clearance=False)
    assert (run.status, run.refused) == (PlanStatus.SOLVED, 0), run.reason


def test_the_shipped_scene_of_three_robots_is_solved() -> None:
    scene = load_scene(resource("scenes/planning/three_robots.yaml"))
    run = step_to_end(scene, LacamPlanner(), np.random.default_rng(0), clearance=False)
    assert (run.status, run.refused) == (PlanStatus.SOLVED, 0), run.reason


def test_a_robot_without_a_goal_is_moved_out_of_the_way() -> None:
    narrow = walls(SPEC, [(0, 16, 0, 3), (0, 6, 8, 12), (11, 16, 8, 12)])
    robots = [robot("a", (2, 5), block(1, 1)), robot("idle", (8, 5), block(1, 1))]
    ask = request(SPEC, narrow, robots, [Goal("g", "Target", (13, 5))], {"a": "g"})
    plan = LacamPlanner().plan(ask, np.random.default_rng(0))
    assert plan.status is PlanStatus.SOLVED, plan.reason
    assert plan.robots["idle"].goal == ""
    assert check_step(ask, plan).safe


def test_a_robot_that_is_walled_in_is_named_and_the_other_still_goes() -> None:
    wall = walls(SPEC, [(7, 8, 0, 12)])
    robots = [robot("a", (3, 3), block(1, 1)), robot("b", (12, 3), block(1, 1))]
    ask = request(SPEC, wall, robots, [Goal("g", "Target", (12, 9)), Goal("f", "Target", (12, 6))])
    plan = LacamPlanner().plan(ask, np.random.default_rng(0))
    assert plan.robots["a"].status is PlanStatus.INFEASIBLE
    assert "a" in plan.robots["a"].reason
    assert plan.robots["b"].status is PlanStatus.SOLVED
    assert plan.robots["b"].step is not None


@pytest.mark.parametrize("name", JOINT)
def test_two_robots_that_cannot_pass_are_told_to_wait(name: str) -> None:
    lane = walls(SPEC, [(0, 16, 0, 4), (0, 16, 7, 12)])
    robots = [robot("a", (2, 5), block(1, 1)), robot("b", (13, 5), block(1, 1))]
    ask = request(SPEC, lane, robots, [Goal("g", "Target", (13, 5)), Goal("f", "Target", (2, 5))])
    plan = make_planner(name).plan(ask, np.random.default_rng(0))
    assert plan.status is PlanStatus.TIMEOUT
    assert "no joint plan" in plan.reason
    assert all(entry.step is None for entry in plan.robots.values())


def test_tight_plans_are_as_valid_and_shorter() -> None:
    robots = [robot("a", (2, 2), block(1, 1)), robot("b", (2, 8), block(1, 1))]
    ask = request(SPEC, walls(SPEC, []), robots, [Goal("g", "Target", (12, 6)), Goal("f", "Target", (12, 9))])
    fleet = fleet_of(ask, (0.0,))
    moves: List[Move] = []
    at: Dict[int, Pose] = {0: (2, 2, 0), 1: (2, 8, 0)}
    steps = deque([(0, 1, 0)] * 10 + [(0, 0, 1)] * 4 + [(1, 1, 0)] * 10 + [(1, 0, 1)])
    while steps:
        i, dx, dy = steps.popleft()
        end = (at[i][0] + dx, at[i][1] + dy, 0)
        moves.append(Move(i, at[i], end))
        at[i] = end
        steps.rotate(-7)
    assert valid(fleet, moves, (0, 1))
    tight = tightened(fleet, Standing(fleet), moves)
    assert valid(fleet, tight, (0, 1))
    assert len(tight) == 2
    assert fleet.cost(tight) < fleet.cost(moves) - 3.0


def test_the_plan_is_kept_until_reset() -> None:
    robots = [robot("a", (3, 5), block(2, 2)), robot("b", (12, 5), block(2, 2))]
    ask = request(SPEC, walls(SPEC, []), robots, [Goal("g", "Target", (12, 5)), Goal("f", "Target", (3, 5))])
    planner = LacamPlanner()
    first = planner.plan(ask, np.random.default_rng(0))
    again = planner.plan(ask, np.random.default_rng(99))
    assert first.iterations > 0
    assert again.iterations == 0, "nothing is searched for while the plan is free"
    assert {n: p.path for n, p in first.robots.items()} == {n: p.path for n, p in again.robots.items()}
    planner.reset()
    assert planner.plan(ask, np.random.default_rng(99)).iterations > 0


def test_a_wanted_heading_is_what_cost_to_go_leads_to() -> None:
    ask = request(SPEC, walls(SPEC, []), [robot("a", (8, 6), arm(3))])
    view = Standing(fleet_of(ask)).alone[0]
    costs = CostToGo(view, Target((8, 6), 2))
    assert costs.cost((8, 6, 2)) == 0.0
    assert costs.cost((8, 6, 0)) > 0.0
