"""A planning scene and the request made of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.geometry import GridSpec
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind, PlanStatus
from yarm.planning.scenes.scene import PlanScene, SceneRobot, Stand
from yarm.planning.scenes.stepping import step_to_end
from yarm.robots.ankurbot import ankurbot_mask

SPEC = GridSpec((12, 10, 4), (0.0, 0.0, 0.0), (1.2, 1.0, 0.4))
BAR = np.array([(0, 0, 0), (-1, 0, 0), (-2, 0, 0)])


def bar(yaw_rad: float = 0.0) -> SceneRobot:
    return SceneRobot("bar", Stand((5, 5), yaw_rad), BAR)


@pytest.mark.parametrize(
    ("yaw_deg", "cells"),
    [(0.0, [[-2, 0], [-1, 0], [0, 0]]), (90.0, [[0, -2], [0, -1], [0, 0]]), (180.0, [[0, 0], [1, 0], [2, 0]])],
)
def test_cells_turn_with_the_heading(yaw_deg: float, cells: list) -> None:
    assert sorted(bar().mask(SPEC, math.radians(yaw_deg)).cells[:, :2].tolist()) == cells


def test_cells_hold_at_the_first_heading_whatever_it_is() -> None:
    assert sorted(bar(1.0).mask(SPEC, 1.0).cells.tolist()) == sorted(BAR.tolist())


def test_a_robot_without_cells_is_the_ankurbot() -> None:
    spec = GridSpec()
    robot = SceneRobot("r", Stand((20, 20), 0.5))
    assert np.array_equal(robot.mask(spec, 0.5).cells, ankurbot_mask(spec, 0.5).cells)


def test_a_request_is_made_for_where_the_robots_stand_by_then() -> None:
    goals = {"g": Goal("g", GoalKind.TARGET, (9, 9))}
    scene = PlanScene(SPEC, ((4, 6, 5, 6, 0, 4), (0, 1, 0, 1, 0, 1)), (bar(),), goals, {"bar": "g"})
    first = scene.request()
    assert first.assignments == {"bar": "g"} and first.occupied.sum() == 8 + 1 - 2, (
        "two of the bar's cells are taken out"
    )
    later = scene.request({"bar": Stand((9, 2), math.pi / 2)}, {})
    assert later.assignments == {} and later.occupied.sum() == 9
    assert sorted(later.robots[0].cells.tolist()) == [[9, 0, 0], [9, 1, 0], [9, 2, 0]]
    assert {name: len(cells) for name, cells in later.objects.items()} == {"boxes[0]": 8, "boxes[1]": 1}


def test_the_ankurbot_turns_by_its_solids_as_for_a_commander_and_a_robot_of_cells_by_these() -> None:
    spec, start, end = GridSpec(), math.radians(10.0), math.radians(55.0)
    scene = PlanScene(spec, (), (SceneRobot("r", Stand((30, 25), start)), bar()), {})
    drawn, cells = scene.request().robots
    assert drawn.mask_at is not None and cells.mask_at is None
    assert np.array_equal(
        drawn.mask_at(end).cells, scene.request({"r": Stand((30, 25), end), "bar": bar().start}).robots[0].mask.cells
    )


def test_an_eighth_turn_is_planned_and_checked_with_the_cells_the_robot_will_have() -> None:
    """With its squares turned outwards it would be said to reach out of the volume, where it then stands inside."""
    spec, yaw = GridSpec(), math.radians(55.0)
    column = (-int(ankurbot_mask(spec, yaw).cells[:, 0].min()), 25)
    goals = {"home": Goal("home", GoalKind.HOME, column, yaw_rad=yaw)}
    scene = PlanScene(spec, (), (SceneRobot("r", Stand((30, 25), math.radians(10.0))),), goals, {"r": "home"})
    planner = YarmPlanner(PlannerParams(turns_deg=(0.0, 90.0, -90.0, 45.0, -45.0)))
    run = step_to_end(scene, planner, np.random.default_rng(0))
    assert (run.status, run.refused) == (PlanStatus.SOLVED, 0), run.reason
    assert run.trails["r"][-1].column == column
