"""What a state does in the background: what every kind of activity has in common."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import List, Optional

from yarm.commander.cell_state import CellState
from yarm.commander.events import Action, GoalDone, TaskView
from yarm.commander.goals import ActiveGoal, Purpose


class Ending(str, Enum):
    """How work ended, as CommanderStatus.msg writes it."""

    NONE = ""
    SUCCEEDED = "succeeded"
    FAILED = "failed"
    STOPPED = "stopped"


@dataclass(frozen=True)
class Result:
    """How work ended, and why."""

    outcome: Ending
    reason: str = ""


class Activity:
    """Background work of a state. ``result`` is None while it goes on; ``reason`` says what it waits for."""

    def __init__(self, cell: CellState) -> None:
        """In a cell as it is known; nothing is sent before ``start``."""
        self.cell = cell
        self.result: Optional[Result] = None
        self.reason = ""

    def start(self, now_s: float) -> List[Action]:
        """What to do at once."""
        return []

    def advance(self, now_s: float) -> List[Action]:
        """The world has changed: a new map, or a goal or deletion ended."""
        return []

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A goal has ended."""
        return []

    def tasks(self) -> List[TaskView]:
        """Its tasks, for the status."""
        return []

    def finish(self, outcome: Ending, reason: str = "") -> None:
        """End the work."""
        self.result = Result(outcome, reason)
        self.reason = reason


class Stopping(Activity):
    """Waits until every goal of a mission has ended: robots end at their present waypoint, hands are drawn up."""

    def start(self, now_s: float) -> List[Action]:
        """Nothing new is sent; what is under way was checked as a whole."""
        return self.advance(now_s)

    def advance(self, now_s: float) -> List[Action]:
        """Done when nobody moves any more."""
        moving = sorted(goal.robot for goal in stoppable(self.cell))
        self.reason = f"waiting for {', '.join(moving)} to reach the present waypoint" if moving else ""
        if not moving:
            self.finish(Ending.STOPPED)
        return []


def stoppable(cell: CellState) -> List[ActiveGoal]:
    """Active goals that belong to a state's work (switching a manipulator does not)."""
    return cell.goals.of(Purpose.STEP, Purpose.HAND, Purpose.CALIBRATION, Purpose.CLEANUP)


def cancel_all(cell: CellState, now_s: float, why: str) -> List[Action]:
    """Cancel every goal of the state's work."""
    actions: List[Action] = []
    for goal in stoppable(cell):
        actions += cell.goals.cancel(goal.robot, now_s, why)
    return actions
