"""Work a state does in the background: what every kind of it has in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List, Optional

from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.messages import Action, GoalDone, TaskView
from yarm.commander.world import World


@dataclass(frozen=True)
class Result:
    """How work ended: outcome "succeeded", "failed" or "stopped", and why."""

    outcome: str
    reason: str = ""


class Work:
    """Background work of a state. ``result`` is None while it goes on; ``reason`` says what it waits for."""

    def __init__(self, world: World) -> None:
        """Work on a world; nothing is sent before ``start``."""
        self.world = world
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

    def finish(self, outcome: str, reason: str = "") -> None:
        """End the work."""
        self.result = Result(outcome, reason)
        self.reason = reason


class Stopping(Work):
    """Waits until every goal of a mission has ended: robots end at their present waypoint."""

    def start(self, now_s: float) -> List[Action]:
        """Nothing new is sent; what is under way was checked as a whole."""
        return self.advance(now_s)

    def advance(self, now_s: float) -> List[Action]:
        """Done when nobody moves any more."""
        moving = sorted(goal.robot for goal in stoppable(self.world))
        self.reason = f"waiting for {', '.join(moving)} to reach the present waypoint" if moving else ""
        if not moving:
            self.finish("stopped")
        return []


def stoppable(world: World) -> List[ActiveGoal]:
    """Active goals that belong to a state's work (switching a manipulator does not)."""
    return world.goals.of(Purpose.STEP, Purpose.CALIBRATION, Purpose.CLEANUP)


def cancel_all(world: World, now_s: float, why: str) -> List[Action]:
    """Cancel every goal of the state's work."""
    actions: List[Action] = []
    for goal in stoppable(world):
        actions += world.goals.cancel(goal.robot, now_s, why)
    return actions
