"""The Commander's status and plans as messages that ROS takes."""

from __future__ import annotations

from io import BytesIO

from yarm.msg import CommanderStatus, TaskStatus

from yarm.commander.activity import Ending
from yarm.commander.events import TaskState, TaskView
from yarm.commander.machine import Status
from yarm.commander.states import State
from yarm.planning.model.types import GoalKind
from yarm.ros.commander.reports import status_message, task_text


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


def test_a_task_says_its_distance_only_when_there_is_one() -> None:
    assert task_text(TaskStatus("r", "debris_1", "Debris", "moving", "", 1.5)) == "r -> debris_1 moving 1.50 m"
    assert task_text(TaskStatus("", "debris_1", "Debris", "waiting", "", float("nan"))) == "nobody -> debris_1 waiting"
