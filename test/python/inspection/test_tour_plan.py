"""Views and order together: the likely view is preferred, what cannot be reached is named."""

from __future__ import annotations

import math
from typing import Dict, Sequence

import numpy as np
import pytest

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.tour import MOST_EXACT
from yarm.inspection.tour_plan import (
    ALIKE_DEG,
    ALIKE_M,
    LEAST_NEW,
    MOST_VIEWS,
    ROOMY_M,
    TIGHT_M,
    TIGHT_S,
    Budget,
    Planner,
    novelty,
)
from yarm.inspection.viewpoints import Viewpoint, viewpoint

HOME = Pose2(0.0, 0.0)
ROW = tuple(Box(i + 1, Pose2(1.5 * i, 3.0, -math.pi / 2)) for i in range(4))
ALL = dict.fromkeys(ROW, 1.0)
FIRST = {ROW[0]: 1.0}
PLENTY = Budget(1e4, 1.5, 2.0)


def straight(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
    return np.array([start.distance(goal) for goal in goals])


def frontal(box: Box, view: Viewpoint) -> float:
    return 0.99 if view.angle_deg == 0 else 0.5


def test_every_box_once_from_its_likeliest_view() -> None:
    plan = Planner(straight, frontal).plan(HOME, HOME, ALL, {}, PLENTY)
    assert sorted(view.box for view in plan.views) == [1, 2, 3, 4] and plan.unreachable == ()
    assert all(view.angle_deg == 0 for view in plan.views)
    assert [view.box for view in plan.views] in ([1, 2, 3, 4], [4, 3, 2, 1])


def test_where_there_is_little_room_another_view_as_likely_is_taken() -> None:
    def one_wall(x: float, y: float) -> float:
        return max(x + 0.35, 0.0)

    def likely(box: Box, view: Viewpoint) -> float:
        return 0.9

    beside = Planner(straight, likely, one_wall).plan(HOME, HOME, FIRST, {}, PLENTY).views[0]
    west = Pose2(-2.0, 2.0)
    nearest = Planner(straight, likely).plan(west, west, FIRST, {}, PLENTY).views[0]
    roomiest = Planner(straight, likely, one_wall).plan(west, west, FIRST, {}, PLENTY).views[0]
    assert nearest.pose.x < -0.1 and roomiest.pose.x > nearest.pose.x
    assert one_wall(roomiest.pose.x, roomiest.pose.y) >= TIGHT_M and one_wall(beside.pose.x, beside.pose.y) >= TIGHT_M


def test_a_view_with_little_room_costs_more_and_is_taken_where_there_is_no_other() -> None:
    for room_m, tight_s in (
        (math.inf, 0.0),
        (ROOMY_M, 0.0),
        (0.5 * (ROOMY_M + TIGHT_M), 0.5 * TIGHT_S),
        (0.1, TIGHT_S),
    ):
        planner = Planner(straight, frontal, lambda x, y, room_m=room_m: room_m)
        view = planner.plan(HOME, HOME, FIRST, {}, PLENTY).views[0]
        plain = Planner(straight, frontal).price_s(ROW[0], view)
        assert planner.price_s(ROW[0], view) == pytest.approx(plain + tight_s)


def test_a_view_that_was_taken_is_not_taken_again() -> None:
    planner = Planner(straight, frontal)
    seen: Dict[int, list] = {}
    for _ in range(3):
        view = planner.plan(HOME, HOME, FIRST, seen, PLENTY).views[0]
        assert view not in seen.get(1, [])
        seen.setdefault(1, []).append(view)


def test_after_views_that_did_not_decide_one_unlike_them_is_taken() -> None:
    """From where the robot stands after a look, the nearest others would be much like it."""

    def likely(box: Box, view: Viewpoint) -> float:
        return 0.95 - 0.1 * view.distance_m - 0.001 * abs(view.angle_deg)

    planner, seen, here = Planner(straight, likely), [], HOME
    for _ in range(3):
        view = planner.plan(here, HOME, FIRST, {1: list(seen)}, PLENTY).views[0]
        for other in seen:
            aside = (view.angle_deg - other.angle_deg) / ALIKE_DEG
            assert math.hypot((view.distance_m - other.distance_m) / ALIKE_M, aside) > 1.2, (view, other)
        seen, here = [*seen, view], view.pose


def test_a_view_is_the_less_new_the_more_alike_it_is_to_one_before() -> None:
    views = [viewpoint(ROW[0], 0.45 + 0.1 * i, 0) for i in range(5)]
    shares = [novelty(view, views[:1]) for view in views]
    assert shares == sorted(shares) and shares[0] == LEAST_NEW and shares[-1] > 0.95
    assert novelty(views[1], ()) == 1.0
    assert novelty(views[2], views[:2]) < novelty(views[2], views[:1])
    aside = [novelty(viewpoint(ROW[0], 0.45, angle), views[:1]) for angle in (20, -20, 40, 60)]
    assert aside[0] == aside[1] < aside[2] < aside[3]


def test_what_cannot_be_reached_is_named_and_the_rest_is_visited() -> None:
    def walled(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        ways = straight(start, goals)
        ways[[goal.x > 3.2 for goal in goals]] = np.inf
        return ways

    plan = Planner(walled, frontal).plan(HOME, HOME, ALL, {}, PLENTY)
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
    assert planner.plan(HOME, HOME, FIRST, {}, PLENTY).unreachable == ()
    usual = Planner(straight, lambda box, view: 0.1).candidates(ROW[0], HOME)
    assert usual and max(abs(view.angle_deg) for view in usual) == 60


@pytest.mark.parametrize("count", [4, MOST_EXACT + 3])
def test_too_little_time_leaves_out_the_far_boxes_and_what_has_an_answer(count: int) -> None:
    boxes = [Box(i + 1, Pose2(0.7 * i, 2.0, -math.pi / 2)) for i in range(count)]
    planner = Planner(straight, frontal)
    whole = planner.plan(HOME, HOME, dict.fromkeys(boxes, 1.0), {}, PLENTY)
    some = planner.plan(HOME, HOME, dict.fromkeys(boxes, 1.0), {}, Budget(0.9 * whole.cost_s + 2.0 * count, 1.0, 2.0))
    assert 0 < len(some.views) < count == len(whole.views) and some.cost_s <= 0.9 * whole.cost_s + 2.0 * count
    answered = {box: 0.01 if box.number == 1 else 1.0 for box in boxes}
    tight = Budget(0.9 * whole.cost_s + 2.0 * count, 1.0, 2.0)
    assert 1 not in {view.box for view in planner.plan(HOME, HOME, answered, {}, tight).views}
    assert planner.plan(HOME, HOME, dict.fromkeys(boxes, 1.0), {}, Budget(3.0, 1.5, 2.0)).views == ()
