"""What a Commander must still know after its death, beyond what the next map and the latched topics say.

It is written to the journal whenever it changes (``yarm.safety.journal``), and taken up by the Commander that follows.
Robots are not in it: where they stand is seen, and whatever they were sent is cancelled before anything new.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Dict, Optional, Tuple

from yarm.commander.activity import Ending
from yarm.commander.answers import Answer
from yarm.commander.cell_state import CellState
from yarm.commander.events import Target, TaskView
from yarm.commander.goals import GoalBook, Purpose
from yarm.commander.handling import Job
from yarm.commander.pieces import Load, Refusal
from yarm.commander.states import State
from yarm.planning.model.types import Column, Goal, GoalKind, Waypoint
from yarm.planning.tasks.task import Task, TaskStatus


class Work(str, Enum):
    """What a state was doing."""

    NOTHING = "nothing"
    CALIBRATION = "calibration"
    MISSION = "mission"
    CLEANUP = "cleanup"


@dataclass(frozen=True)
class TaskRecord:
    """A task somebody serves or has done; fields as of ``Goal`` and ``Task``, ``only`` is the goal's own robot."""

    name: str
    kind: GoalKind
    column: Column
    yaw_rad: Optional[float]
    only: str
    status: TaskStatus
    robot: str
    on_map: bool

    @staticmethod
    def of(task: Task) -> TaskRecord:
        """The record of a task."""
        goal = task.goal
        return TaskRecord(
            goal.name, goal.kind, goal.column, goal.yaw_rad, goal.robot, task.status, task.robot, task.on_map
        )

    def task(self, now_s: float) -> Task:
        """The task again, as if it had come to its status at a time, s; a deletion is due to be asked for once more."""
        goal = Goal(self.name, self.kind, self.column, yaw_rad=self.yaw_rad, robot=self.only)
        since_s = -math.inf if self.status is TaskStatus.DELETING else now_s
        return Task(goal, self.status, self.robot, since_s=since_s, on_map=self.on_map)


@dataclass(frozen=True)
class Step:
    """A step that was checked as a whole and is under way: column and heading, rad, where it began; its target."""

    column: Column
    yaw_rad: float
    target: Target

    @property
    def start(self) -> Waypoint:
        """Where it began."""
        return Waypoint(self.column, self.yaw_rad)


@dataclass(frozen=True)
class Memory:
    """Everything that is remembered.

    Attributes:
        stamp_s: when it was so, simulated time.
        state: the state.
        work: what it was doing.
        resume: state of the mission that goes on after the present calibration; None for none.
        entered_s: when the state was entered.
        outcome: how its work ended.
        reason: why.
        association: perception's switch as set last; None before.
        off_since_s: since when it has been off, as calibration counts it.
        shown: tasks of the work that has ended.
        answers: what each robot answered in calibration.
        homes: where each mobile robot started.
        tasks: what robots serve and have done.
        loads: piece that hangs on each robot's hand.
        refused: pieces that no robot shall try again.
        full_bins: why a bin takes nothing more.
        jobs: what the hands of a mission were at.
        steps: what each robot of a mission was sent and has not ended.
        at_work: robots whose hands were moving.
    """

    stamp_s: float
    state: State
    work: Work = Work.NOTHING
    resume: Optional[State] = None
    entered_s: float = 0.0
    outcome: Ending = Ending.NONE
    reason: str = ""
    association: Optional[bool] = None
    off_since_s: Optional[float] = None
    shown: Tuple[TaskView, ...] = ()
    answers: Dict[str, Answer] = field(default_factory=dict)
    homes: Dict[str, Target] = field(default_factory=dict)
    tasks: Tuple[TaskRecord, ...] = ()
    loads: Dict[str, str] = field(default_factory=dict)
    refused: Dict[str, Refusal] = field(default_factory=dict)
    full_bins: Dict[str, str] = field(default_factory=dict)
    jobs: Tuple[Job, ...] = ()
    steps: Dict[str, Step] = field(default_factory=dict)
    at_work: Tuple[str, ...] = ()

    def same_as(self, other: Optional[Memory]) -> bool:
        """Whether two say the same, whenever."""
        return other is not None and replace(self, stamp_s=other.stamp_s) == other


def steps_of(goals: GoalBook) -> Dict[str, Step]:
    """The steps under way."""
    sent = [(goal.robot, goal.start, goal.target) for goal in goals.of(Purpose.STEP)]
    return {
        robot: Step(start.column, start.yaw_rad, target)
        for robot, start, target in sent
        if start is not None and target is not None
    }


def with_cell(memory: Memory, cell: CellState) -> Memory:
    """A memory with what is to be remembered of a cell."""
    return replace(
        memory,
        answers=dict(cell.answers),
        homes=dict(cell.homes),
        tasks=tuple(TaskRecord.of(task) for task in cell.queue.records),
        loads={robot: load.piece for robot, load in cell.loads.items()},
        refused=dict(cell.refused),
        full_bins=dict(cell.full_bins),
        steps={**memory.steps, **steps_of(cell.goals)},
        at_work=tuple(sorted(cell.at_work)),
    )


def restore(cell: CellState, memory: Memory, now_s: float) -> None:
    """Put back into a new cell what is remembered of the old one, at a time, s."""
    cell.answers, cell.homes = dict(memory.answers), dict(memory.homes)
    cell.loads = {robot: Load(piece) for robot, piece in memory.loads.items()}
    cell.refused, cell.full_bins = dict(memory.refused), dict(memory.full_bins)
    cell.at_work = set(memory.at_work)
    cell.queue.take_up([record.task(now_s) for record in memory.tasks])
    cell.hidden.begin_unwatched()
