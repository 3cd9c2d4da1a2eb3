"""The one record of a task: what leads to which status, what is refused, and how long it has been so."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Callable, Dict, Tuple

import numpy as np
import pytest

from python.planning.samples import block, request, walls
from python.planning.samples import robot as robot_at
from yarm.geometry import GridSpec
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.tasks.task import Task, TaskStatus
from yarm.planning.tasks.task_queue import TaskQueue

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
OPEN = np.zeros(SPEC.shape, dtype=bool)
CLOSED = walls(SPEC, [(18, 20, 0, 24)])
ROBOT = robot_at("a", (2, 10), block(2, 2))
DEBRIS = Goal("d", GoalKind.DEBRIS, (26, 10))


def look(queue: TaskQueue, now_s: float, occupied: np.ndarray = OPEN, goal: Goal = DEBRIS) -> Task:
    queue.update([ROBOT], [goal], now_s)
    queue.process(request(SPEC, occupied, [ROBOT]))
    return next(task for task in queue.tasks if task.goal.name == goal.name)


def queue_in(status: TaskStatus) -> TaskQueue:
    """A queue with one goal in a status, made so by the calls that lead there."""
    queue = TaskQueue()
    look(queue, 1.0, CLOSED if status is TaskStatus.UNREACHABLE else OPEN)
    if status is TaskStatus.OPEN:
        queue.reject("a", "no way")
    if status in (TaskStatus.DELETING, TaskStatus.HELD, TaskStatus.REACHED, TaskStatus.LEAVING):
        queue.pop("a", 2.0)
    if status is TaskStatus.HELD:
        queue.hold(DEBRIS, "a", 2.0)
    if status is TaskStatus.REACHED:
        queue.deleted("d", 3.0)
    if status is TaskStatus.LEAVING:
        queue.start_over()
    return queue


def status_of(queue: TaskQueue) -> TaskStatus:
    known = [task.status for task in (*queue.tasks, *queue.finished)]
    assert len(known) <= 1
    return known[0] if known else TaskStatus.LEAVING


Change = Callable[[TaskQueue], object]
CHANGES: Dict[str, Tuple[Change, Dict[TaskStatus, TaskStatus]]] = {
    "pop": (lambda queue: queue.pop("a", 4.0), {TaskStatus.ASSIGNED: TaskStatus.DELETING}),
    "note": (lambda queue: queue.note("a", "held"), {TaskStatus.ASSIGNED: TaskStatus.ASSIGNED}),
    "ask_again": (lambda queue: queue.ask_again("d", 4.0), {TaskStatus.DELETING: TaskStatus.DELETING}),
    "deleted": (lambda queue: queue.deleted("d", 4.0), {TaskStatus.DELETING: TaskStatus.REACHED}),
    "hold": (
        lambda queue: queue.hold(DEBRIS, "a", 4.0),
        {status: TaskStatus.HELD for status in TaskStatus if status is not TaskStatus.ASSIGNED},
    ),
    "laid_down": (lambda queue: queue.laid_down("d", 4.0), {TaskStatus.HELD: TaskStatus.REACHED}),
}


@pytest.mark.parametrize("status", list(TaskStatus))
@pytest.mark.parametrize("change", sorted(CHANGES))
def test_a_change_leads_where_the_status_allows_and_is_refused_elsewhere(change: str, status: TaskStatus) -> None:
    queue = queue_in(status)
    assert status_of(queue) is status
    make, leads_to = CHANGES[change]
    if status in leads_to:
        make(queue)
        assert status_of(queue) is leads_to[status]
        return
    before = (queue.tasks, queue.finished, queue.leaving)
    with pytest.raises(KeyError, match=r"robot a has no goal|d is not (being deleted|held): it is (\w+)|a goal of a"):
        make(queue)
    assert (queue.tasks, queue.finished, queue.leaving) == before


def test_reached_debris_keeps_its_robot_and_is_shown_until_the_map_has_lost_it() -> None:
    queue = queue_in(TaskStatus.ASSIGNED)
    queue.note("a", "ABORTED")
    task = queue.pop("a", 4.0)
    assert (task.robot, task.status, task.reason, task.since_s) == ("a", TaskStatus.DELETING, "", 4.0)
    assert queue.finished == (task,) and queue.deleting == (task,) and queue.leaving == {"d"}
    assert queue.idle == ("a",) and queue.tasks == () and queue.done
    queue.deleted("d", 5.0)
    queue.see(["d"])
    assert queue.deleting == () and queue.leaving == {"d"}
    queue.see([])
    assert queue.leaving == set()
    assert [(task.status, task.robot) for task in queue.finished] == [(TaskStatus.REACHED, "a")]


def test_a_body_that_the_map_has_lost_is_still_being_deleted_until_somebody_answers() -> None:
    queue = queue_in(TaskStatus.DELETING)
    queue.see([])
    assert queue.leaving == set() and [task.goal.name for task in queue.deleting] == ["d"]
    queue.ask_again("d", 7.0)
    assert [task.since_s for task in queue.deleting] == [7.0]


def test_a_home_is_reached_without_a_deletion_and_a_place_outside_is_forgotten() -> None:
    queue = TaskQueue()
    queue.claim([Goal("home/a", GoalKind.HOME, (4, 4), robot="a"), Goal("clear/b", GoalKind.CLEAR, (8, 8), robot="b")])
    assert (queue.pop("a").status, queue.pop("b").status) == (TaskStatus.REACHED, TaskStatus.REACHED)
    assert [task.goal.name for task in queue.finished] == ["home/a"]
    assert queue.leaving == set() and queue.deleting == ()


def test_what_is_claimed_is_for_one_robot_that_serves_nothing_else() -> None:
    queue = queue_in(TaskStatus.ASSIGNED)
    with pytest.raises(ValueError, match="home/a cannot be given to a, which serves d"):
        queue.claim([Goal("home/a", GoalKind.HOME, (4, 4), robot="a")])
    with pytest.raises(ValueError, match="t is for no robot in particular"):
        queue.claim([Goal("t", GoalKind.TARGET, (4, 4))])
    assert queue.assignments == {"a": "d"}


@pytest.mark.parametrize("status", [TaskStatus.DELETING, TaskStatus.REACHED])
def test_the_next_mission_knows_only_what_the_map_still_shows(status: TaskStatus) -> None:
    queue = queue_in(status)
    queue.start_over()
    assert queue.leaving == {"d"}
    assert queue.finished == () and queue.deleting == () and queue.tasks == ()
    queue.see([])
    assert queue.leaving == set()


def test_a_new_mission_may_try_a_rejected_pair_at_once() -> None:
    queue = queue_in(TaskStatus.ASSIGNED)
    queue.reject("a", "no way")
    assert look(queue, 2.0).status is TaskStatus.UNREACHABLE
    queue.start_over()
    assert look(queue, 3.0).status is TaskStatus.ASSIGNED


def test_since_is_when_the_status_or_the_robot_last_changed() -> None:
    queue = TaskQueue()
    assert look(queue, 1.0, CLOSED).since_s == 1.0
    assert look(queue, 2.0, CLOSED).since_s == 1.0
    assert (look(queue, 3.0).status, look(queue, 4.0).since_s) == (TaskStatus.ASSIGNED, 3.0)
    queue.note("a", "held")
    moved = look(queue, 5.0, goal=replace(DEBRIS, column=(25, 9)))
    assert (moved.reason, moved.since_s, moved.goal.column) == ("held", 3.0, (25, 9))
    queue.reject("a", "no way")
    assert queue.tasks[0].since_s == 5.0
    assert math.isnan(look(TaskQueue(), math.nan).since_s)


def test_a_goal_shown_again_is_a_new_task_beside_the_one_that_is_done() -> None:
    queue = queue_in(TaskStatus.REACHED)
    queue.see([])
    assert look(queue, 6.0).status is TaskStatus.ASSIGNED
    assert [task.status for task in queue.finished] == [TaskStatus.REACHED]
    queue.pop("a", 7.0)
    assert [(task.status, task.since_s) for task in queue.finished] == [(TaskStatus.DELETING, 7.0)]
