"""A goal and what has become of it: the one record that the task queue keeps of each."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from yarm.planning.model.types import Goal, GoalKind

BODIES = (GoalKind.DEBRIS, GoalKind.TARGET)
"""Kinds of goals with a body on the map, which is deleted, or carried off, when it is reached."""


class TaskStatus(Enum):
    """What has become of a goal.

    OPEN, ASSIGNED and UNREACHABLE lead to one another; ASSIGNED ends in DELETING, HELD or REACHED, DELETING and HELD
    (in a robot's hand, or about to be) in REACHED.
    LEAVING is what an earlier mission has reached and the map still shows; it ends with the body.
    """

    OPEN = "OPEN"
    ASSIGNED = "ASSIGNED"
    UNREACHABLE = "UNREACHABLE"
    DELETING = "DELETING"
    HELD = "HELD"
    REACHED = "REACHED"
    LEAVING = "LEAVING"


@dataclass(frozen=True, eq=False)
class Task:
    """A goal and who serves it.

    Attributes:
        goal: the goal as the map shows it now.
        status: OPEN while it waits.
        robot: name of its robot, also of the one that has reached it; empty while it has none.
        reason: why it waits, is unreachable, or its robot does not come nearer; empty when all is well.
        distance_cells: travel distance of its robot when it was assigned, cells.
        since_s: when it came to this status and robot, or its deletion was last asked for, s; NaN when nobody said.
        on_map: the map shows its body; kept up to date by ``see`` once the task is done.
        why: why its robot was given it, and no other; empty while it has none.
    """

    goal: Goal
    status: TaskStatus = TaskStatus.OPEN
    robot: str = ""
    reason: str = ""
    distance_cells: float = math.nan
    since_s: float = math.nan
    on_map: bool = True
    why: str = ""

    @property
    def kind(self) -> GoalKind:
        """Kind of the goal."""
        return self.goal.kind
