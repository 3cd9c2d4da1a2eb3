"""Our round in a world of straight ways: ten of ten, in time whatever fails, doubts looked at again, no guess."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.inputs import read_boxes
from yarm.inspection.model import UNSEEN, Drive, Look, Observation, Order, Outcome, Reading, Spin, Stage, Stand, Step
from yarm.inspection.round import Round, RoundParams
from yarm.inspection.times import DriveTimes
from yarm.inspection.viewpoints import Viewpoint
from yarm.resources import resource

PRACTICE = read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))
Read = Callable[[Look, int], Reading]


def straight(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
    return np.array([start.distance(goal) for goal in goals])


def likely(box: Box, view: Viewpoint) -> float:
    return 0.97 - 0.004 * abs(view.angle_deg)


class World:
    """Drives along straight lines at a seeded pace; what fails and what is read is given."""

    def __init__(
        self,
        tour: Round,
        seed: int = 1,
        fails: Optional[Callable[[Drive], bool]] = None,
        read: Optional[Read] = None,
        localised: bool = True,
    ) -> None:
        self.tour, self.localised = tour, localised
        self.rng = np.random.default_rng(seed)
        self.fails = fails or (lambda drive: False)
        self.read = read or (lambda look, n: Reading(look.box, 0.9995))
        self.pose, self.now_s = Pose2(0.0, 0.0, 0.3), 0.0
        self.steps: List[Step] = []
        self.looks: Dict[int, int] = {}
        self._driving: Tuple[Optional[Drive], Pose2, float, float] = (None, self.pose, 0.0, 0.0)

    def run(self) -> Step:
        seen = Observation(0.0, self.pose, self.localised)
        while not self.steps or not isinstance(self.steps[-1].order, Stand):
            assert len(self.steps) < 5000
            step = self.tour.step(seen)
            self.steps.append(step)
            outcome, reason, reading = self._carry_out(step.order)
            seen = Observation(self.now_s, self.pose, self.localised, outcome, reason, reading)
        return self.steps[-1]

    def _carry_out(self, order: Order) -> Tuple[Outcome, str, Optional[Reading]]:
        if isinstance(order, Drive):
            return (*self._drive(order), None)
        self.now_s += 2.0 * math.pi / order.rate_radps if isinstance(order, Spin) else 0.5
        if isinstance(order, Look):
            self.looks[order.box] = self.looks.get(order.box, 0) + 1
            return Outcome.DONE, "", self.read(order, self.looks[order.box])
        return Outcome.DONE, "", None

    def _drive(self, order: Drive) -> Tuple[Outcome, str]:
        """A second of the drive, so that the round may think again meanwhile."""
        if self.fails(order):
            self.now_s += 5.0
            return Outcome.FAILED, "blocked"
        if order is not self._driving[0]:
            whole = DriveTimes.undisturbed_s(self.pose.distance(order.goal), self.pose, order.goal)
            self._driving = (order, self.pose, self.now_s, self.now_s + whole * float(self.rng.uniform(1.0, 1.3)))
        _, start, began_s, end_s = self._driving
        self.now_s = min(self.now_s + 1.0, end_s)
        share = (self.now_s - began_s) / (end_s - began_s)
        if share >= 1.0:
            self.pose = order.goal
            return Outcome.DONE, ""
        x, y = start.x + share * (order.goal.x - start.x), start.y + share * (order.goal.y - start.y)
        self.pose = Pose2(x, y, order.goal.yaw_rad)
        return Outcome.BUSY, ""


@pytest.mark.parametrize("seed", range(5))
def test_ten_of_ten_and_home(seed: int) -> None:
    world = World(Round(PRACTICE, straight, likely), seed)
    end = world.run()
    assert end.stage == Stage.DONE and world.pose == world.tour.home and world.now_s < 300.0, f"seed {seed}"
    assert sorted((v.box, v.reading.tag) for v in world.tour.verdicts) == [(n, n) for n in range(1, 11)]


@pytest.mark.parametrize("count", [1, 17])
def test_one_box_and_more_than_are_ordered_exactly_are_all_read(count: int) -> None:
    """From straight ahead alone, for the sake of time."""
    boxes = [Box(i + 1, Pose2(2.0 * (i % 5), 2.0 * (i // 5) + 1.0, 0.7 * i)) for i in range(count)]
    world = World(Round(boxes, straight, lambda box, view: 0.97 if view.angle_deg == 0.0 else 0.0))
    end = world.run()
    assert end.stage == Stage.DONE and world.pose == world.tour.home and world.now_s < 300.0
    assert sorted((v.box, v.reading.tag) for v in world.tour.verdicts) == [(box.number, box.number) for box in boxes]


@pytest.mark.parametrize("limit_s", [60.0, 80.0, 100.0])
@pytest.mark.parametrize("seed", range(6))
def test_it_is_home_in_time_and_names_what_it_left_out(limit_s: float, seed: int) -> None:
    world = World(Round(PRACTICE, straight, likely, RoundParams(time_limit_s=limit_s)), seed)
    end = world.run()
    assert end.stage == Stage.DONE and world.now_s <= limit_s and world.pose == world.tour.home, f"seed {seed}"
    assert len(world.tour.verdicts) == 10
    left_out = [v for v in world.tour.verdicts if v.reading.tag == UNSEEN]
    assert left_out and all("time" in v.reason for v in left_out)
    assert "hopeless" in [event.kind for event in world.steps[0].events + world.steps[1].events]


def test_more_time_reads_more_boxes() -> None:
    read = []
    for limit_s in (60.0, 100.0, 200.0):
        world = World(Round(PRACTICE, straight, likely, RoundParams(time_limit_s=limit_s)))
        world.run()
        read.append(sum(v.reading.tag > 0 for v in world.tour.verdicts))
    assert read == sorted(read) and read[0] < read[-1]


def test_what_there_is_time_for_is_read_though_the_round_is_hopeless() -> None:
    """Of these four boxes the nearest takes longest: the robot has to turn round at it."""
    places = ((1.35, 0.2, 3.1), (0.3, 1.35, -1.4), (-1.4, 0.7, -0.5), (0.6, -1.4, 2.0))
    boxes = [Box(i + 1, Pose2(*place)) for i, place in enumerate(places)]
    read = {}
    for limit_s in range(32, 60, 4):
        world = World(Round(boxes, straight, likely, RoundParams(time_limit_s=float(limit_s))))
        world.pose = Pose2(-0.2, -0.3, math.radians(30.0))
        assert world.run().stage == Stage.DONE and world.now_s <= limit_s
        read[limit_s] = sum(verdict.reading.tag > 0 for verdict in world.tour.verdicts)
    assert read[32] >= 1 and read[40] >= 2 and read[48] >= 3, read


def test_a_blocked_view_is_answered_by_another_of_the_same_box() -> None:
    first = {}

    def fails(order: Drive) -> bool:
        near_5 = order.goal.distance(PRACTICE[4].pose) < 0.9
        if near_5:
            first.setdefault("goal", order.goal)
        return near_5 and order.goal == first["goal"]

    world = World(Round(PRACTICE, straight, likely), fails=fails)
    world.run()
    assert {v.box: v.reading.tag for v in world.tour.verdicts}[5] == 5


def test_a_box_that_is_blocked_from_everywhere_ends_with_the_reason() -> None:
    world = World(Round(PRACTICE, straight, likely), fails=lambda order: order.goal.distance(PRACTICE[4].pose) < 1.0)
    end = world.run()
    verdict = next(v for v in world.tour.verdicts if v.box == 5)
    assert end.stage == Stage.DONE and verdict.reading.tag == UNSEEN and "blocked" in verdict.reason


def test_from_an_enclosed_start_every_box_ends_at_once_with_its_reason() -> None:
    """There is a way to where the robot stands, and to nowhere else."""

    def enclosed(start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        return np.array([0.0 if start.distance(goal) < 0.01 else math.inf for goal in goals])

    world = World(Round(PRACTICE, enclosed, likely))
    end = world.run()
    assert end.stage == Stage.DONE and world.now_s < 10.0 and world.pose.distance(Pose2(0.0, 0.0)) < 0.01
    assert sorted(verdict.box for verdict in world.tour.verdicts) == list(range(1, 11))
    assert {verdict.reason for verdict in world.tour.verdicts} == {"no view of it that is left can be reached"}
    assert {verdict.reading.tag for verdict in world.tour.verdicts} == {UNSEEN}


def test_a_doubtful_box_is_looked_at_again_from_elsewhere() -> None:
    world = World(
        Round(PRACTICE, straight, likely),
        read=lambda look, n: Reading(look.box, 0.6 if look.box == 3 and n == 1 else 0.9995),
    )
    world.run()
    assert world.looks[3] == 2 and all(n == 1 for box, n in world.looks.items() if box != 3)
    views = [step.order.goal for step in world.steps if step.box == 3 and isinstance(step.order, Drive)]
    assert len({(goal.x, goal.y) for goal in views}) == 2


def test_a_doubt_that_stays_is_reported_as_one() -> None:
    world = World(Round(PRACTICE, straight, likely), read=lambda look, n: Reading(look.box, 0.6))
    world.run()
    assert all("in doubt" in v.reason and v.reading.probability == 0.6 for v in world.tour.verdicts)
    assert set(world.looks.values()) == {RoundParams().views}


def test_without_a_certain_place_it_turns_and_then_asks() -> None:
    world = World(Round(PRACTICE, straight, likely), localised=False)
    end = world.run()
    assert [type(step.order) for step in world.steps] == [Spin, Spin, Stand]
    assert end.stage == Stage.FAILED and "give a pose" in end.reason and world.tour.verdicts == []


def test_a_second_box_with_the_same_tag_is_a_duplicate() -> None:
    world = World(Round(PRACTICE, straight, likely), read=lambda look, n: Reading(7, 0.9995))
    world.run()
    assert [v.duplicate for v in world.tour.verdicts] == [False] + [True] * 9


def test_a_way_home_that_stays_blocked_is_a_failure_in_words() -> None:
    world = World(Round(PRACTICE, straight, likely), fails=lambda order: order.goal == Pose2(0.0, 0.0, 0.3))
    end = world.run()
    assert end.stage == Stage.FAILED and "not home in time: blocked" in end.reason
