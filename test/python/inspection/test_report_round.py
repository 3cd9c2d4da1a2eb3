"""The report's round, driven by hand: orders in turn, what fails, what is written."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Set, Tuple

import pytest

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.inputs import read_boxes
from yarm.inspection.model import (
    BLANK,
    ClearCostmaps,
    Drive,
    Look,
    Observation,
    Order,
    Outcome,
    Reading,
    Spin,
    Stage,
    Stand,
    Step,
)
from yarm.inspection.report_round import ReportRound, ReportRoundParams
from yarm.inspection.result_file import HEADER, PUBLISHED_WORD, result_lines, unmatched_lines
from yarm.resources import resource

HOME = Pose2(0.0, 0.0, 0.3)
ROW = tuple(Box(i + 1, Pose2(2.0 * i, 3.0, -math.pi / 2)) for i in range(3))


def drive(
    boxes: Tuple[Box, ...],
    tags: Dict[int, int],
    fails: Optional[Callable[[Order], bool]] = None,
    plannable: Callable[[Pose2, Pose2], bool] = lambda start, goal: True,
    params: Optional[ReportRoundParams] = None,
) -> Tuple[ReportRound, List[Step]]:
    """A round in which every order succeeds but those that fail."""
    tour = ReportRound(boxes, plannable, lambda x, y: 10.0, params)
    steps = [tour.step(Observation(0.0, HOME, True))]
    while not isinstance(steps[-1].order, Stand):
        assert len(steps) < 1000
        order = steps[-1].order
        failed = fails is not None and fails(order)
        reading = Reading(tags[order.box], 1.0) if isinstance(order, Look) else None
        outcome = Outcome.FAILED if failed else Outcome.DONE
        steps.append(tour.step(Observation(len(steps), HOME, True, outcome, "blocked" if failed else "", reading)))
    return tour, steps


def test_the_whole_round_in_order() -> None:
    tour, steps = drive(ROW, {1: 5, 2: 5, 3: BLANK})
    orders = [step.order for step in steps]
    assert orders[:2] == [Spin(2 * math.pi, 0.2)] * 2
    looks = [order for order in orders if isinstance(order, Look)]
    assert [look.box for look in looks] == [1, 1, 1, 2, 2, 2, 3, 3, 3] and {look.images for look in looks} == {7}
    assert orders[-2] == Drive(HOME, 60.0) and steps[-1].stage == Stage.DONE
    assert [(v.box, v.reading.tag, v.duplicate) for v in tour.verdicts] == [(1, 5, False), (2, 5, True), (3, 0, False)]


def test_three_headings_at_each_box() -> None:
    _, steps = drive(ROW[:1], {1: 5})
    goals = [step.order.goal for step in steps if isinstance(step.order, Drive) and step.stage == Stage.DRIVE]
    turns = [goal.yaw_rad - goals[0].yaw_rad for goal in goals]
    assert turns == pytest.approx([0.0, math.pi / 32, 0.0, -math.pi / 32])
    assert len({(goal.x, goal.y) for goal in goals}) == 1


def test_an_order_stands_while_it_is_being_done() -> None:
    tour = ReportRound(ROW, lambda start, goal: True, lambda x, y: 10.0)
    first = tour.step(Observation(0.0, HOME))
    assert tour.step(Observation(0.1, HOME, outcome=Outcome.BUSY)).order is first.order


def test_a_goal_that_fails_is_tried_again_after_clearing_and_turning() -> None:
    tries: List[Order] = []

    def first_fails(order: Order) -> bool:
        first = isinstance(order, Drive) and not tries
        tries.extend([order] if first else [])
        return first

    tour, steps = drive(ROW[:1], {1: 7}, first_fails)
    after = [type(step.order) for step in steps[steps.index(next(s for s in steps if s.stage == Stage.DRIVE)) :]]
    assert after[:4] == [Drive, ClearCostmaps, Spin, Drive] and tour.verdicts[0].reading.tag == 7


def test_a_box_that_cannot_be_reached_is_dropped_and_the_next_one_comes() -> None:
    def at_box_1(order: Order) -> bool:
        return isinstance(order, Drive) and order.goal.x < 0.5 and order.goal.y > 1.0

    tour, steps = drive(ROW, {2: 3, 3: 4}, at_box_1)
    assert [v.box for v in tour.verdicts] == [1, 2, 3] and "blocked" in tour.verdicts[0].reason
    assert unmatched_lines(tour.verdicts) == ["unmatched: 1"] and steps[-1].stage == Stage.DONE


def test_without_a_viewpoint_the_box_is_skipped_and_said_so() -> None:
    tour, _ = drive(ROW, {2: 3, 3: 4}, plannable=lambda start, goal: goal.x > 0.9)
    assert tour.verdicts[0].box == 1 and "no viewpoint" in tour.verdicts[0].reason


def test_home_missed_is_a_failure() -> None:
    _, steps = drive(ROW[:1], {1: 3}, lambda order: isinstance(order, Drive) and order.goal == HOME)
    assert steps[-1].stage == Stage.FAILED and "not home: blocked" in steps[-1].reason


def test_without_a_pose_after_the_turns_it_ends() -> None:
    tour = ReportRound(ROW, lambda start, goal: True, lambda x, y: 10.0)
    for t in range(3):
        last = tour.step(Observation(t, None, outcome=Outcome.DONE))
    assert last.stage == Stage.FAILED and "give one" in last.reason


@pytest.mark.parametrize("order, ends", [("greedy", {6, 5}), ("exact", {6, 9})])
def test_the_practice_world_is_visited_by_straight_distances(order: str, ends: Set[int]) -> None:
    boxes = read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))
    tour, _ = drive(boxes, {box.number: 1 for box in boxes}, params=ReportRoundParams(order=order))
    assert {tour.verdicts[0].box, tour.verdicts[-1].box} == ends and len(tour.verdicts) == 10


def test_lines_of_the_result_are_the_published_ones() -> None:
    boxes = read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))
    tags = {6: 14, 4: 8, 3: 10, 2: 11, 1: 5, 7: 5, 10: 2, 9: 11, 8: BLANK, 5: 15}
    tour, _ = drive(boxes, tags)
    lines = result_lines(tour.verdicts, PUBLISHED_WORD)
    assert lines[0] == HEADER
    seven = next(line for line in lines if line.startswith("boxNumnber: 7"))
    assert seven.startswith("boxNumnber: 7 tag is 5 x: 3.34926, y: -1.85018, phi: 2.39652")
    assert "boxNumnber: 8 tag is blank x: 2.74971, y: -0.897636, phi: 3.06048" in lines
    assert sum(line.endswith(" (duplicate)") for line in lines) == 2
