"""The printed program's round: each of its faults, and what it writes."""

from __future__ import annotations

import math
from typing import List, Tuple

import pytest

from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.model import PRINTED, UNSEEN, Drive, Look, Observation, Outcome, Reading, Spin, Stage, Stand, Step
from yarm.inspection.printed_round import HEADING_STEP_RAD, PAUSE_S, UNCHECKED_M, PrintedRound
from yarm.inspection.report_round import Plannable
from yarm.inspection.result_file import lines_of
from yarm.inspection.viewpoints import viewpoint

HOME = Pose2(0.4, -0.2, 0.3)
BOX = Box(1, Pose2(2.0, 0.0, math.pi))


def anywhere(start: Pose2, goal: Pose2) -> bool:
    return True


def drive(
    boxes: Tuple[Box, ...], plannable: Plannable = anywhere, outcome: Outcome = Outcome.DONE, tag: int = 5
) -> Tuple[PrintedRound, List[Step]]:
    """A round in which every goal ends like this, and every look reads this tag."""
    tour = PrintedRound(boxes, plannable)
    steps = [tour.step(Observation(0.0, HOME))]
    while not isinstance(steps[-1].order, Stand):
        assert len(steps) < 500
        order = steps[-1].order
        ended = outcome if isinstance(order, Drive) else Outcome.DONE
        reading = Reading(tag, 1.0) if isinstance(order, Look) else None
        steps.append(tour.step(Observation(len(steps), HOME, True, ended, "", reading)))
    return tour, steps


def test_it_turns_34_degrees_and_takes_home_wherever_it_believes_to_be() -> None:
    tour, steps = drive((BOX,))
    assert [step.order for step in steps if isinstance(step.order, Spin)] == [Spin(pytest.approx(0.6), 0.2)]
    assert tour.home == HOME and steps[-2].order == Drive(HOME, math.inf)
    lost = PrintedRound((BOX,), anywhere)
    lost.step(Observation(0.0))
    lost.step(Observation(3.0, outcome=Outcome.DONE))
    assert lost.home == Pose2(0.0, 0.0)


def test_a_navigation_that_never_answers_is_waited_for_for_ever() -> None:
    tour = PrintedRound((BOX,), anywhere)
    tour.step(Observation(0.0, HOME))
    going = tour.step(Observation(3.0, HOME, True, Outcome.DONE)).order
    assert isinstance(going, Drive) and going.limit_s == math.inf
    assert tour.step(Observation(1e6, HOME, True, Outcome.BUSY)).order is going


def test_ways_are_asked_from_the_origin_and_the_last_distance_not_at_all() -> None:
    asked: List[Pose2] = []

    def never(start: Pose2, goal: Pose2) -> bool:
        asked.append(start)
        return False

    _, steps = drive((BOX,), never)
    assert set(asked) == {Pose2(0.0, 0.0)} and len(asked) == 6 * 5
    goals = [step.order.goal for step in steps if isinstance(step.order, Drive)]
    assert goals[0] == viewpoint(BOX, UNCHECKED_M, 0).pose


def test_a_failed_goal_is_not_noticed_and_what_is_seen_counts_for_the_box() -> None:
    tour, steps = drive((BOX,), outcome=Outcome.FAILED)
    looks = [step.order for step in steps if isinstance(step.order, Look)]
    assert [(look.images, look.pause_s) for look in looks] == [(7, PAUSE_S)] * 3
    assert [(v.box, v.reading.tag, v.reason) for v in tour.verdicts] == [(1, 5, "")]
    assert steps[-1].stage == Stage.FAILED and len([step for step in steps if isinstance(step.order, Drive)]) == 5


def test_its_headings_lie_closer_together_than_the_texts() -> None:
    _, steps = drive((BOX,))
    yaws = [step.order.goal.yaw_rad for step in steps if isinstance(step.order, Drive)][:4]
    assert [yaw - yaws[0] for yaw in yaws] == pytest.approx([0.0, HEADING_STEP_RAD, 0.0, -HEADING_STEP_RAD])


@pytest.mark.parametrize("aside_m, angle_deg", [(0.0, 30), (0.2, 0)])
def test_a_neighbour_counts_only_where_its_centre_is(aside_m: float, angle_deg: float) -> None:
    """Another one stands 0.7 m before the box; more than 0.15 m aside it is not seen, though it is in the way."""
    other = Box(2, Pose2(1.3, aside_m, 0.0))
    _, steps = drive((BOX, other))
    first = next(dict(event.details) for step in steps for event in step.events if event.kind == "viewpoint")
    assert (first["box"], float(first["angle_deg"])) == ("1", angle_deg)


def test_its_file_has_no_header_no_poses_and_no_duplicates() -> None:
    tour, _ = drive((BOX, Box(2, Pose2(-2.0, 0.0, 0.0))))
    assert sorted(lines_of(PRINTED, tour.verdicts)) == ["boxNumnber: 1 tag is 5", "boxNumnber: 2 tag is 5"]
    tour, _ = drive((BOX,), tag=UNSEEN)
    assert lines_of(PRINTED, tour.verdicts) == ["unmatched: 1"]
