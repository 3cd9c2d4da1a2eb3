"""Seeded instances: they are what they claim, complete searches agree, and ``yarm`` keeps its promises on them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml

from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, Goal, PlanStatus, RobotPlan, Waypoint
from yarm.planning.registry import make_planner
from yarm.planning.scenes.instances import FAMILIES, make_instance
from yarm.planning.scenes.oracle import Node, Shape, Space, pair_solvable, shortest_length
from yarm.planning.scenes.scene_file import dump_scene, parse_scene
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.verification.bruteforce import touches
from yarm.planning.verification.checker import check_step

COUNT = 5
"""Instances of each family here; test/system/test_planning_families.py has a hundred of each."""


def scene_of(text):
    return parse_scene(yaml.safe_load(text))


def corridor(bay):
    """Two one-cell carts that must pass each other in a corridor two cells wide and its margins, with a bay or not."""
    bays = "[0, 6, 4, 6, 0, 1], [9, 16, 4, 6, 0, 1]" if bay else "[0, 16, 4, 6, 0, 1]"
    return scene_of(
        f"""
        grid: {{shape: [16, 6, 1], min: [0, 0, 0], max: [1.6, 0.6, 0.1]}}
        boxes: [[0, 16, 0, 1, 0, 1], {bays}]
        robots:
          - {{name: a, cell: [1, 2], cells: [[0, 0, 0]]}}
          - {{name: b, cell: [14, 2], cells: [[0, 0, 0]]}}
        goals:
          - {{cell: [14, 2], kind: Target, robot: a}}
          - {{cell: [1, 2], kind: Target, robot: b}}
        """
    )


def test_joint_search_tells_solvable_from_not():
    assert pair_solvable(corridor(bay=True))
    assert not pair_solvable(corridor(bay=False))


def test_shortest_length_goes_around_with_the_margin():
    text = """
    grid: {shape: [11, 11, 1], min: [0, 0, 0], max: [1.1, 1.1, 0.1]}
    boxes: [[5, 6, 0, 8, 0, 1]]
    robots: [{name: a, cell: [2, 2], cells: [[0, 0, 0]]}]
    goals: [{cell: [8, 2], kind: Target, robot: a}]
    """
    # One column aside and up to y 9, four across, and the same way down; the diagonal past the corner is not free.
    assert shortest_length(scene_of(text), "a", "goals[0]") == pytest.approx(2 * (6 + math.sqrt(2.0)) + 4)
    closed = text.replace("0, 8", "0, 10")
    assert shortest_length(scene_of(closed), "a", "goals[0]") == math.inf


@pytest.mark.parametrize("family", FAMILIES)
def test_instances_repeat_and_begin_clear(family):
    first, again = make_instance(family, 7), make_instance(family, 7)
    assert dump_scene(first.scene) == dump_scene(again.scene)
    assert dump_scene(make_instance(family, 8).scene) != dump_scene(first.scene)
    for robot in first.scene.robots:
        space = Space(Shape(robot, first.scene.spec, ()), first.scene.occupied())
        assert space.free[0][robot.start.column]
    request = first.scene.request()
    taken = np.concatenate([robot.cells for robot in request.robots])
    assert len(np.unique(taken, axis=0)) == len(taken), "robots overlap no robot"
    assert np.array_equal(request.occupied, first.scene.occupied()), "robots overlap nothing"
    assert set(first.scene.assignments) == {robot.name for robot in first.scene.robots}


def test_unknown_family_and_too_many_robots_are_named(monkeypatch):
    monkeypatch.setattr("yarm.planning.scenes.instances.TRIES", 3)
    with pytest.raises(KeyError):
        make_instance("moonwalk", 0)
    with pytest.raises(RuntimeError, match="30 robots"):
        make_instance("table_and_stand", 0, robots=30)


@pytest.mark.parametrize("family", FAMILIES)
def test_yarm_solves_every_instance_and_every_step_is_safe(family):
    planner = make_planner("yarm")
    for seed in range(COUNT):
        found = []

        def look(request, plan, verdict, found=found):
            if not verdict.safe:
                found.append(verdict.reason)
            found.extend(touches(request, plan))

        scene = make_instance(family, 500 + seed).scene
        run = step_to_end(scene, planner, np.random.default_rng(seed), observe=look)
        assert not found, (family, seed, found)
        assert run.status is PlanStatus.SOLVED, (family, seed, run.reason)
        assert run.min_clearance_cells is None or run.min_clearance_cells >= 1


@pytest.mark.parametrize("seed", range(8))
def test_infeasible_only_where_a_complete_search_agrees(seed):
    """One robot among random boxes, its goal anywhere it may stand: half of them cannot be reached."""
    rng = np.random.default_rng(seed)
    cells = [[0, 0, 0], [-1, 0, 0], [-2, 0, 0]] if seed % 2 else [[0, 0, 0]]
    boxes = [
        [x, x + 1, y, y + int(rng.integers(1, 7)), 0, 1] for x, y in rng.integers((0, 0), (20, 14), (14, 2)).tolist()
    ]
    text = {
        "grid": {"shape": [20, 20, 1], "min": [0, 0, 0], "max": [2.0, 2.0, 0.1]},
        "boxes": [box for box in boxes if not (box[0] <= 5 and box[2] <= 3)],
        "robots": [{"name": "a", "cell": [3, 1], "cells": cells}],
    }
    scene = parse_scene(text)
    space = Space(Shape(scene.robots[0], scene.spec), scene.occupied())
    lengths = space.lengths(Node(0, 3, 1))
    planner = make_planner("yarm", PlannerParams(particles=40))
    for column in rng.permutation(np.argwhere(space.free.any(axis=0)))[:12]:
        target = (int(column[0]), int(column[1]))
        goals = {"g": Goal("g", "Target", target)}
        planner.reset()
        request = replace(scene.request(), goals=goals, assignments={"a": "g"})
        plan = planner.plan(request, np.random.default_rng(seed))
        expected = PlanStatus.SOLVED if np.isfinite(lengths[target]) else PlanStatus.INFEASIBLE
        assert plan.status is expected, (seed, target, plan.reason)
        assert check_step(request, plan).safe
        if expected is PlanStatus.INFEASIBLE:
            assert "a" in plan.reason


def test_refused_steps_are_not_made_and_are_reported():
    class Reckless:
        """Sends its robot straight through whatever is there."""

        def reset(self):
            pass

        def plan(self, request, rng):
            del rng
            name, goal = next(iter(request.assignments.items()))
            step = Waypoint(request.goals[goal].column, request.robots[0].yaw_rad)
            entry = RobotPlan(name, goal, PlanStatus.SOLVED, step=step, path=(step,))
            return FleetPlan(PlanStatus.SOLVED, "", {name: entry})

    run = step_to_end(corridor(bay=True), Reckless(), np.random.default_rng(0))
    assert run.status is PlanStatus.TIMEOUT and run.steps == 0
    assert run.refused == len(run.ms) and "touch" in run.refusals[0] and "refused" in run.reason
    heedless = step_to_end(corridor(bay=True), Reckless(), np.random.default_rng(0), heed_checker=False, most_steps=3)
    assert heedless.steps > 0 and heedless.refused > 0
    assert heedless.trails["a"][-1].column == (14, 2), "the refused step is made"
