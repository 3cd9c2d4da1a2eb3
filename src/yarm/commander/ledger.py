"""The ledger of a mission: all that the Commander saw and decided, in order, in words that say everything decided.

It begins with the entry into a mode and goes on through CLEANUP. Nothing in it depends on wall time: in lock-step the
same scene and seed give the same entries. Whoever wants to prove a mission keeps what it says.
"""

from __future__ import annotations

import math
from typing import Dict, List, Sequence, Set

from yarm.commander.activity import Result
from yarm.commander.cell_state import CellState
from yarm.commander.events import (
    Action,
    CancelGoal,
    Decision,
    DecisionKind,
    DeleteObject,
    GoalDone,
    Hold,
    Outcome,
    SendGoal,
    ShowPlan,
    Target,
)
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.states import MISSION_STATES, State
from yarm.control.actions import MobileAction
from yarm.geometry import MappedObject
from yarm.planning.model.types import GoalKind, RobotPlan
from yarm.planning.tasks.task import Task

KIND_OF_SEND = {Purpose.HAND.value: DecisionKind.HAND, Purpose.SWITCH.value: DecisionKind.SWITCH}
"""Kinds of what is sent; everything else is SEND."""

POSE_GOALS = {
    MobileAction.ABOUT_TIP.value: "turning about the tip",
    MobileAction.ABOUT_BODY.value: "turning about the body",
}
"""Goals that are poses, in words."""


class Ledger:
    """Numbers what it is told of, from the entry into a mode on; outside of missions nothing is kept."""

    def __init__(self, cell: CellState) -> None:
        """Of a cell; nothing yet."""
        self._cell = cell
        self._open = False
        self._number = 0
        self._said: List[Decision] = []
        self._seen: Set[str] = set()
        self._assigned: Dict[str, Task] = {}

    def entered(self, state: State) -> None:
        """A state was entered; a mode after anything else begins anew, CLEANUP ends what is kept."""
        if state in MISSION_STATES and not self._open:
            self._open, self._number = True, 0
            self._said, self._seen, self._assigned = [], set(), {}
        self._say(DecisionKind.STATE, text=state.name)
        self._open = self._open and (state in MISSION_STATES or state is State.CLEANUP)

    def ended(self, result: Result) -> None:
        """The state's work has ended."""
        self._say(DecisionKind.END, text=f"{result.outcome.value} {result.reason}".rstrip())

    def goal_done(self, goal: ActiveGoal, event: GoalDone) -> None:
        """A goal has ended; that a manipulator was switched as it should goes without saying."""
        if goal.purpose is not Purpose.SWITCH or event.outcome is not Outcome.SUCCEEDED:
            said = f"{goal.action}: {event.outcome.value}"
            why = goal.why or (event.message if event.outcome is not Outcome.SUCCEEDED else "")
            self._say(DecisionKind.ENDED, event.robot, self._goal_of(event.robot), f"{said} {why}".rstrip())

    def hold(self, event: Hold) -> None:
        """The safety monitor holds a robot, or lets it go."""
        self._say(DecisionKind.HOLD, event.robot, text=f"held: {event.reason}" if event.held else "released")

    def entries(self, actions: Sequence[Action]) -> List[Decision]:
        """What was said since the last time, what the newest map and the tasks show, and these actions."""
        self._see()
        self._note_tasks()
        for action in actions:
            self._note(action)
        said, self._said = self._said, []
        return said

    def _say(self, kind: DecisionKind, robot: str = "", goal: str = "", text: str = "") -> None:
        if self._open:
            self._number += 1
            self._said.append(Decision(self._number, kind, robot, goal, text))

    def _see(self) -> None:
        """Debris that the cameras see for the first time, and targets that are known for the first time."""
        for kind in (GoalKind.DEBRIS, GoalKind.TARGET):
            for found in self._cell.of_kind(kind):
                if found.name not in self._seen and (found.piece is not None or kind is GoalKind.TARGET) and self._open:
                    self._seen.add(found.name)
                    self._say(DecisionKind.SEEN, goal=found.name, text=_sight(found))

    def _note_tasks(self) -> None:
        """Who was given what, has reached it, or has it no more."""
        queue, before = self._cell.queue, self._assigned
        now = {task.robot: task for task in queue.tasks if task.robot} if self._open else {}
        for robot, old in sorted(before.items()):
            new = now.get(robot)
            if new is None or new.goal.name != old.goal.name:
                reached = self._has_reached(robot, old)
                left = next((task for task in queue.tasks if task.goal.name == old.goal.name), None)
                why = "it is no goal any more" if left is None else left.reason
                kind = DecisionKind.REACHED if reached else DecisionKind.GIVEN_BACK
                self._say(kind, robot, old.goal.name, "" if reached else why)
        for robot, new in sorted(now.items()):
            if robot not in before or before[robot].goal.name != new.goal.name:
                self._say(DecisionKind.ASSIGN, robot, new.goal.name, new.why)
        self._assigned = now

    def _has_reached(self, robot: str, task: Task) -> bool:
        """Whether a robot's goal is done, or it stands there, as at a bin and where it was sent aside."""
        done = {(task.robot, task.goal.name) for task in self._cell.queue.finished}
        tracked = self._cell.robots.get(robot)
        gone = task.goal.name not in self._cell.queue.assignments.values()
        return (robot, task.goal.name) in done or (gone and tracked is not None and self._cell.at(tracked, task.goal))

    def _goal_of(self, robot: str) -> str:
        return self._assigned[robot].goal.name if robot in self._assigned else ""

    def _note(self, action: Action) -> None:
        if isinstance(action, ShowPlan):
            self._say(DecisionKind.PLAN, text=_plan(action))
        elif isinstance(action, SendGoal):
            kind = KIND_OF_SEND.get(action.purpose, DecisionKind.SEND)
            self._say(kind, action.robot, self._goal_of(action.robot), _order(action))
        elif isinstance(action, CancelGoal):
            self._say(DecisionKind.CANCEL, action.robot, self._goal_of(action.robot), action.why)
        elif isinstance(action, DeleteObject):
            self._say(DecisionKind.DELETE, goal=action.name)


def _sight(found: MappedObject) -> str:
    """Where something is seen, and by whom."""
    if found.piece is None:
        x, y, z = found.position_m
        return f"known at ({x:.3f}, {y:.3f}, {z:.3f}) m"
    x, y, z = found.piece.top_m
    cameras = ", ".join(map(str, found.piece.cameras)) or "not told which"
    return f"cameras {cameras}; its top at ({x:.3f}, {y:.3f}, {z:.3f}) m, {found.piece.points} points"


def _plan(shown: ShowPlan) -> str:
    """A planning step: each robot's way, who is sent a step, and what the checker says."""
    robots = "; ".join(_way(name, entry) for name, entry in sorted(shown.plan.robots.items()))
    sent = ", ".join(shown.sent) or "nobody"
    return f"{robots}; sent: {sent}; checker: {shown.refused or 'nothing against it'}"


def _way(name: str, plan: RobotPlan) -> str:
    columns = " ".join(f"{x},{y}" for x, y in (place.column for place in plan.path))
    reason = f" ({plan.reason})" if plan.reason else ""
    found = f"{plan.status.value}{reason}, {plan.length_cells:.2f} cells [{columns}]"
    return f"{name} to {plan.goal or 'make way'}: {found}"


def _order(action: SendGoal) -> str:
    """What a robot is told, and why."""
    places = [*action.via, *([action.target] if action.target is not None else [])]
    way = " by way of ".join(_place(place) for place in reversed(places))
    order = POSE_GOALS.get(action.action, action.action)
    said = f"{order} to {way}" if way else order
    return f"{said}; {action.why}" if action.why else said


def _place(target: Target) -> str:
    return f"({target.x:.4f}, {target.y:.4f}) m, {math.degrees(target.yaw_rad):.2f} deg"
