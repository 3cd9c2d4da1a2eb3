"""Who waits for whom when a mission does not come to its end: said in the reason that it fails with."""

from __future__ import annotations

import threading
from typing import Callable, List, Optional

import rospy

from yarm.commander.events import TaskState
from yarm.msg import CommanderStatus, TaskStatus
from yarm.ros.commander.reports import task_text
from yarm.ros.common import names
from yarm.srv import Why

ANSWER_S = 20.0
"""Wall time the Commander has for all its answers, s."""
DONE = (TaskState.REACHED.value,)
AT_WORK = (TaskState.ASSIGNED.value, TaskState.MOVING.value, TaskState.CARRYING.value)
Ask = Callable[[str], str]
"""Why a goal is not served, or a robot stands, by its name."""


def who_waits(status: Optional[CommanderStatus], ask: Ask) -> str:
    """What the Commander does, and of each task that is left what it says and why nobody goes on with it.

    Args:
        status: its newest; None when it has said nothing.
        ask: see there; asked about robots that have something to do and goals that have nobody.
    """
    if status is None:
        return f"{names.COMMANDER_NODE} has said nothing"
    doing = f"{status.state_name} {'busy' if status.busy else status.outcome or 'idle'} {status.reason}".rstrip()
    return "; ".join([doing, *(_about(task, ask) for task in status.tasks if task.status not in DONE)])


def ask_commander(subject: str) -> str:
    """Its answer, or that there is none in time."""
    answers: List[str] = []

    def ask() -> None:
        try:
            answers.append(str(rospy.ServiceProxy(names.COMMANDER_WHY, Why)(subject).text))
        except (rospy.ServiceException, OSError) as error:
            answers.append(f"{names.COMMANDER_WHY} does not answer: {error}")

    asking = threading.Thread(target=ask, daemon=True)
    asking.start()
    asking.join(ANSWER_S)
    return answers[0] if answers else f"no answer from {names.COMMANDER_WHY} within {ANSWER_S:g} s"


def _about(task: TaskStatus, ask: Ask) -> str:
    words = task_text(task) + (f" ({task.reason})" if task.reason else "")
    if task.status in AT_WORK and task.robot:
        return f"{words}: {ask(task.robot)}"
    if task.status == TaskState.WAITING.value:
        return f"{words}: {ask(task.goal)}"
    return words
