"""The Commander's status and plans as messages that ROS takes."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from yarm.msg import CommanderStatus, TaskStatus
from yarm.srv import WhyResponse

from yarm.commander.activity import Ending
from yarm.commander.events import TaskState, TaskView
from yarm.commander.machine import Status
from yarm.commander.states import State
from yarm.geometry import GridSpec
from yarm.planning.model.types import GoalKind
from yarm.planning.why.causes import Answer, Cause
from yarm.planning.why.changes import Change, ChangeKind
from yarm.ros.commander.markers import state_marker
from yarm.ros.commander.reports import status_message, task_text, why_response


def test_a_status_goes_through_ros_with_the_word_of_its_tasks_kind() -> None:
    tasks = tuple(TaskView("r", f"g_{kind}", kind, TaskState.MOVING, "", 1.5) for kind in GoalKind)
    message = status_message(Status(State.BOUNDED, True, tasks, Ending.NONE, "", 3.0), 12.5)
    message._check_types()
    wire, received = BytesIO(), CommanderStatus()
    message.serialize(wire)
    received.deserialize(wire.getvalue())
    assert [task.kind for task in received.tasks] == ["Clear", "Bin", "Debris", "Target", "Home"]
    assert {task.status for task in received.tasks} == {"moving"} and received.outcome == ""
    assert received.state_name == "BOUNDED" and received.header.stamp.to_sec() == 12.5


def test_the_words_of_the_picture_are_those_of_the_message() -> None:
    tasks = (TaskView("r", "debris_1", GoalKind.DEBRIS, TaskState.CARRYING, "", 1.5),)
    shown = state_marker(Status(State.BOUNDLESS, False, tasks, Ending.SUCCEEDED, "", 3.0))
    assert shown.text == "5 BOUNDLESS succeeded\nr > debris_1: carrying"


def test_an_answer_to_why_goes_through_ros_with_its_moves_in_metres() -> None:
    move = Change(ChangeKind.MOVE, "box_1", (2, -1), 0.25)
    cause = Cause("unreachable", "r cannot", "r", ("b",), (move,), np.array([[1, 2, 3]]), 4.5)
    message = why_response(Answer("g", (cause,)), GridSpec((10, 10, 4), (0.0, 0.0, 0.0), (1.0, 2.0, 0.4)))
    message._check_types()
    wire, received = BytesIO(), WhyResponse()
    message.serialize(wire)
    received.deserialize(wire.getvalue())
    (change,) = received.causes[0].changes
    assert (change.kind, change.thing, round(change.dx, 6), round(change.dy, 6)) == ("move", "box_1", 0.2, -0.2)
    assert received.success and received.text == "r cannot" and received.causes[0].others == ["b"]
    assert (received.causes[0].cells[0].y, received.causes[0].cost_cells) == (2, 4.5)


def test_a_task_says_its_distance_only_when_there_is_one() -> None:
    assert task_text(TaskStatus("r", "debris_1", "Debris", "moving", "", 1.5)) == "r -> debris_1 moving 1.50 m"
    assert task_text(TaskStatus("", "debris_1", "Debris", "waiting", "", float("nan"))) == "nobody -> debris_1 waiting"
