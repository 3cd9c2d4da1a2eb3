"""Robots that drive each for itself: a goal is left to one that is busy and comes there sooner."""

from __future__ import annotations

import math
from typing import Dict, Optional

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Column, Goal, GoalKind, Robot
from yarm.planning.tasks.task import TaskStatus
from yarm.planning.tasks.task_queue import TaskQueue
from yarm.planning.tasks.travel import Travel

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)
NEAR, IDLE = (6, 10), (26, 10)
"""Where the one who is busy stands, five cells from its goal, and where the idle one does."""


def debris(name: str, column: Column, **more: object) -> Goal:
    return Goal(name, GoalKind.DEBRIS, column, **more)  # type: ignore[arg-type]


def queue_in_which_one_is_busy(left: Optional[Dict[str, float]], hindered: str = "", **more: object) -> TaskQueue:
    """``busy`` is on its way to ``first``; then ``second`` comes, between it and ``idle``, 15 cells from that one."""
    queue = TaskQueue()
    robots = [robot("busy", NEAR, block(2, 2)), robot("idle", IDLE, block(2, 2))]
    ask = request(SPEC, OPEN, robots)
    first, second = debris("first", (6, 15)), debris("second", (11, 10), **more)
    queue.update(robots, [first])
    queue.process(ask)
    assert queue.assignments == {"busy": "first"}
    if hindered:
        queue.note("busy", hindered)
    queue.update(robots, [first, second])
    queue.process(ask, left=left)
    return queue


def reason(queue: TaskQueue) -> str:
    return next(task.reason for task in queue.tasks if task.goal.name == "second")


def test_a_goal_is_left_to_who_is_busy_and_comes_there_sooner() -> None:
    queue = queue_in_which_one_is_busy({})
    assert queue.assignments == {"busy": "first"}
    assert "waits for busy" in reason(queue) and not queue.unreachable and not queue.done


@pytest.mark.parametrize(
    ("left", "hindered", "more"),
    [
        (None, "", {}),
        ({"busy": 6.0}, "", {}),
        ({}, "TIMEOUT: too large to decide", {}),
        ({}, "", {"robot": "idle"}),
    ],
    ids=["driving together", "too much left", "hindered", "not for the busy one"],
)
def test_who_is_idle_gets_it(left: Optional[Dict[str, float]], hindered: str, more: Dict[str, object]) -> None:
    assert queue_in_which_one_is_busy(left, hindered, **more).assignments == {"busy": "first", "idle": "second"}


def test_who_is_busy_takes_it_as_soon_as_it_is_free() -> None:
    queue = queue_in_which_one_is_busy({})
    queue.pop("busy")
    robots = [robot("busy", (6, 15), block(2, 2)), robot("idle", IDLE, block(2, 2))]
    queue.update(robots, [debris("second", (11, 10))])
    queue.process(request(SPEC, OPEN, robots), left={})
    assert queue.assignments == {"busy": "second"}


def test_a_second_one_is_not_left_to_the_same_robot() -> None:
    queue = TaskQueue()
    robots = [robot("busy", NEAR, block(2, 2)), robot("idle", IDLE, block(2, 2))]
    ask = request(SPEC, OPEN, robots)
    goals = [debris("first", (6, 15)), debris("second", (11, 10)), debris("third", (11, 15))]
    queue.update(robots, goals[:1])
    queue.process(ask)
    queue.update(robots, goals)
    queue.process(ask, left={})
    assert len(queue.assignments) == 2 and queue.assignments["idle"] in ("second", "third")


def test_what_nobody_reaches_is_left_to_nobody() -> None:
    queue = TaskQueue()
    robots = [robot("busy", NEAR, block(2, 2)), robot("idle", IDLE, block(2, 2))]
    ask = request(SPEC, walls(SPEC, [(14, 18, 0, 6)]), robots)
    goals = [debris("first", (6, 15)), debris("inside", (16, 2))]
    queue.update(robots, goals)
    queue.process(ask, left={})
    queue.process(ask, left={})
    assert queue.assignments == {"busy": "first"}
    assert {task.goal.name for task in queue.tasks if task.status is TaskStatus.UNREACHABLE} == {"inside"}


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_way_after_a_goal_is_the_way_of_who_stands_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = walls(SPEC, [(14, 16, 0, 18)])
    places = [(int(x), int(y)) for x, y in rng.permutation(np.argwhere(~occupied[..., 0]))[:3]]

    def way(start: Robot) -> Travel:
        return Travel(request(SPEC, occupied, [start]), PlannerParams())

    first, second = (debris(f"d{i}", place) for i, place in enumerate(places[1:]))
    here = robot("a", places[0], block(1, 1))
    there = robot("a", places[1], block(1, 1))
    travel = way(here)
    after, direct = travel.distance_after("a", first, second), way(there).distance("a", second)[0]
    if not math.isfinite(travel.distance("a", first)[0]):
        direct = math.inf  # it cannot stand there: within the margin of a wall
    assert 0.95 * direct - 1.0 <= after <= 1.1 * direct + 1.0, seed  # one by flooding, one over particles and cells


def test_a_pair_that_the_planner_refused_is_not_waited_for() -> None:
    queue = queue_in_which_one_is_busy({})
    robots = [robot("busy", NEAR, block(2, 2)), robot("idle", IDLE, block(2, 2))]
    goals = [debris("first", (6, 15)), debris("second", (11, 10))]
    ask = request(SPEC, OPEN, robots)
    queue.pop("busy")
    queue.update(robots, goals[1:])
    queue.process(ask)
    assert queue.assignments == {"busy": "second"}
    queue.reject("busy", "there is no way")
    queue.claim([debris("third", (6, 15), robot="busy")])
    queue.update(robots, [goals[1], debris("third", (6, 15), robot="busy")])
    queue.process(ask, left={})
    assert queue.assignments == {"busy": "third", "idle": "second"}


def test_a_robot_goes_on_from_the_headings_in_which_it_can_stand_there() -> None:
    """In a corner the arm points out of it; in the opposite one it has turned by a quarter at least."""
    travel = Travel(request(SPEC, OPEN, [robot("a", (15, 12), arm(5))]), PlannerParams())
    way = travel.distance_after("a", debris("first", (1, 1)), debris("second", (28, 22)))
    straight = math.hypot(27.0, 21.0)
    assert way == pytest.approx(straight + 90.0 / 10.0)
