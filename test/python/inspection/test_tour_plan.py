"""Views and order together: the likely view is preferred, what cannot be reached is named."""

from __future__ import annotations

import math
from typing import Dict, Sequence

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.tour_plan import MOST_VIEWS, Planner
from yarm.inspection.viewpoints import Viewpoint

HOME = Pose2(0.0, 0.0)
ROW = tuple(Box(i + 1, Pose2(1.5 * i, 3.0, -math.pi / 2)) for i in range(4))


def straight(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
    return np.array([start.distance(goal) for goal in goals])


def frontal(box: Box, view: Viewpoint) -> float:
    return 0.99 if view.angle_deg == 0 else 0.5


def test_every_box_once_from_its_likeliest_view() -> None:
    plan = Planner(straight, frontal).plan(HOME, HOME, ROW, {})
    assert sorted(view.box for view in plan.views) == [1, 2, 3, 4] and plan.unreachable == ()
    assert all(view.angle_deg == 0 for view in plan.views)
    assert [view.box for view in plan.views] in ([1, 2, 3, 4], [4, 3, 2, 1])


def test_a_view_that_was_taken_is_not_taken_again() -> None:
    planner = Planner(straight, frontal)
    seen: Dict[int, list] = {}
    for _ in range(3):
        view = planner.plan(HOME, HOME, ROW[:1], seen).views[0]
        assert view not in seen.get(1, [])
        seen.setdefault(1, []).append(view)


def test_what_cannot_be_reached_is_named_and_the_rest_is_visited() -> None:
    def walled(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        ways = straight(start, goals)
        ways[[goal.x > 3.2 for goal in goals]] = np.inf
        return ways

    plan = Planner(walled, frontal).plan(HOME, HOME, ROW, {})
    assert plan.unreachable == (4,) and sorted(view.box for view in plan.views) == [1, 2, 3]


def test_a_box_has_at_most_so_many_candidates() -> None:
    found = Planner(straight, lambda box, view: 0.9).candidates(ROW[0], HOME)
    assert len(found) == MOST_VIEWS
    assert Planner(straight, lambda box, view: 0.01).candidates(ROW[0], HOME) == []


def test_a_flat_view_is_taken_where_no_other_can_be_reached() -> None:
    def along_a_wall(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        ways = straight(start, goals)
        ways[[goal.y < 2.78 for goal in goals]] = np.inf
        return ways

    planner = Planner(along_a_wall, lambda box, view: 0.1)
    found = planner.candidates(ROW[0], HOME)
    assert found and {abs(view.angle_deg) for view in found} <= {70, 75}
    assert planner.plan(HOME, HOME, ROW[:1], {}).unreachable == ()
    usual = Planner(straight, lambda box, view: 0.1).candidates(ROW[0], HOME)
    assert usual and max(abs(view.angle_deg) for view in usual) == 60
