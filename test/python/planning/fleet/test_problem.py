"""Where a robot can stand in the empty volume, and what is said of a goal where it cannot."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Optional, Tuple

import numpy as np
import pytest

from python.planning.samples import SMALL, arm, block, request, robot
from yarm.geometry import GridSpec
from yarm.planning.cspace.robot_space import ShapeCache, View
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, PlanStatus
from yarm.planning.roadmap.search import reachable
from yarm.robots.ankurbot import ankurbot_mask

CELL = GridSpec()
EMPTY = np.zeros(CELL.shape, dtype=bool)


def ankurbot(yaw_deg: float = 0.0):
    return robot("a", (25, 25), ankurbot_mask(CELL, math.radians(yaw_deg)), yaw_deg)


@pytest.mark.parametrize(
    ("yaw_deg", "turns_deg", "columns", "corner"),
    [
        (0.0, (0.0, 90.0, -90.0), 2464, 9),
        (0.0, (0.0, 45.0, -45.0), 2480, 5),
        (30.0, (0.0, 90.0, -90.0), 2500, 0),
    ],
)
def test_which_columns_of_the_empty_volume_can_be_reached(
    yaw_deg: float, turns_deg: Tuple[float, ...], columns: int, corner: int
) -> None:
    """The figures of docs/planning.md, "The corners of the volume"."""
    problem = PlanningProblem.of(request(CELL, EMPTY, [ankurbot(yaw_deg)]), turns_of(turns_deg), ShapeCache())
    assert problem is not None
    reached = np.zeros(CELL.shape[:2], dtype=bool)
    for column_set in reachable(View(problem.spaces[0], ()), problem.spaces[0].start).values():
        reached |= problem.layout.image_of_set(column_set)
    assert reached.sum() == columns
    for image in (reached, reached[::-1], reached[:, ::-1], reached[::-1, ::-1]):
        assert (~image[:3, :3]).sum() == corner


def test_the_robot_as_drawn_fits_into_every_corner_at_45_degrees() -> None:
    cells = ankurbot_mask(CELL, math.radians(45.0)).cells
    assert cells[:, :2].max() == 0, "with the tip in the corner (49, 49) nothing is outside"


def refusal(column: Tuple[int, int], forbidden: Optional[np.ndarray] = None, **walls: np.ndarray) -> str:
    occupied = EMPTY.copy()
    for cells in walls.values():
        occupied[tuple(cells.T)] = True
    ask = request(CELL, occupied, [ankurbot()], [Goal("debris_1", "Debris", column)], objects=walls)
    plan = YarmPlanner(PlannerParams()).plan(replace(ask, forbidden=forbidden), np.random.default_rng(0))
    assert plan.status is PlanStatus.INVALID_GOAL
    return plan.reason


def test_a_corner_goal_is_refused_with_what_would_make_it_possible() -> None:
    assert refusal((1, 1)) == (
        "a cannot stand with its end effector at debris_1 (1, 1) at any allowed heading: it would reach out of the "
        "mapped volume at -90, 0, 90, 180 deg; with turns of 45 deg (turns_deg) it could stand there at -135 deg"
    )
    assert refusal((0, 0)).endswith("out of the mapped volume at -90, 0, 90, 180 deg"), "no turn would do"


def test_with_turns_of_45_degrees_the_robot_goes_there() -> None:
    ask = request(CELL, EMPTY, [ankurbot()], [Goal("debris_1", "Debris", (1, 1))])
    planner = YarmPlanner(PlannerParams(turns_deg=(0.0, 45.0, -45.0)))
    plan = planner.plan(ask, np.random.default_rng(0))
    assert plan.status is PlanStatus.SOLVED
    assert math.degrees(plan.robots["a"].path[-1].yaw_rad) == pytest.approx(-135.0)


def test_who_is_in_the_way_at_any_heading_is_named() -> None:
    crate = np.argwhere(np.ones((1, 1, 20))) + np.array([2, 25, 0])
    reason = refusal((1, 25), crate=crate)
    assert "crate within its margin, and it would reach out of the mapped volume at -90, 0, 90 deg" in reason


def test_columns_that_may_not_be_entered_are_said() -> None:
    forbidden = np.zeros(CELL.shape[:2], dtype=bool)
    forbidden[15:35, 30:33] = True
    assert refusal((24, 31), forbidden).endswith("at any allowed heading: it would enter forbidden columns")


def test_the_world_of_one_robot_has_the_others_taken_away() -> None:
    both = [robot("a", (3, 3), block(2, 2)), robot("b", (8, 8), arm(3))]
    ask = request(SMALL, np.zeros(SMALL.shape, dtype=bool), both)
    turns, cache = turns_of((0.0,)), ShapeCache()
    alone, together = PlanningProblem.of(ask, turns, cache, "b"), PlanningProblem.of(ask, turns, cache)
    assert alone is not None and [r.name for r in alone.robots] == ["b"]
    assert together is not None and [r.name for r in together.robots] == ["a", "b"]
    assert not any(alone.obstacles) and not any(together.obstacles)
    assert PlanningProblem.of(ask, turns, cache, "c") is None


def test_a_robot_that_cannot_be_planned_for_stands_in_the_way_of_the_others() -> None:
    lost = replace(robot("lost", (3, 3), block(2, 2)), yaw_rad=math.nan)
    ask = request(SMALL, np.zeros(SMALL.shape, dtype=bool), [robot("a", (10, 8), block(1, 1)), lost])
    problem = PlanningProblem.of(ask, turns_of((0.0,)), ShapeCache())
    assert problem is not None and [r.name for r in problem.robots] == ["a"]
    assert np.argwhere(problem.layout.image_of_set(problem.obstacles[0])).tolist() == [[3, 3], [3, 4], [4, 3], [4, 4]]
