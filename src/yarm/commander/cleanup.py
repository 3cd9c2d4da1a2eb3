"""State CLEANUP: debris that is left to a bin, mobile robots back to where they started, manipulators to storage."""

from __future__ import annotations

from typing import List, Set

from yarm.commander.activity import Activity, Ending
from yarm.commander.assignment import HomeAssignments, QueuedAssignments
from yarm.commander.cell_state import CellState
from yarm.commander.continuous import mission_for
from yarm.commander.events import Action, DeleteDone, GoalDone, Level, Log, Outcome, TaskState, TaskView
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.mission import Mission
from yarm.commander.tools import Tools
from yarm.control.actions import ArmAction
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.why.causes import Circumstances


def home_goals(cell: CellState) -> List[Goal]:
    """Where each robot on the map started, ordered by robot."""
    goals = []
    for robot, home in sorted(cell.homes.items()):
        if robot in cell.robots and cell.map is not None:
            column = cell.map.spec.column_of((home.x, home.y))
            goals.append(Goal(f"home/{robot}", GoalKind.HOME, column, yaw_rad=home.yaw_rad, robot=robot))
    return goals


def something_left(cell: CellState) -> bool:
    """Whether debris that goes to a bin is still on the map or in a hand."""
    open_debris = any(goal.kind is GoalKind.DEBRIS for goal in cell.open_goals().values())
    return cell.params.bins_used and (open_debris or bool(cell.loads))


class Cleanup(Activity):
    """What is left to a bin, where debris goes to one; everybody home; every manipulator to storage."""

    def __init__(self, cell: CellState, tools: Tools) -> None:
        """Clean up."""
        super().__init__(cell)
        homes = HomeAssignments(cell.queue, home_goals(cell), lambda name, goal: cell.at(cell.robots[name], goal))
        self._ways: List[Mission] = [mission_for(cell, tools, homes)]
        if something_left(cell):
            self._ways.insert(0, mission_for(cell, tools, QueuedAssignments(cell.queue)))
        self._left_over = ""
        self._stored: Set[str] = set()
        self._retry_s = 0.0

    def start(self, now_s: float) -> List[Action]:
        """Start with what is left, or else the way home."""
        return self._ways[0].start(now_s)

    def advance(self, now_s: float) -> List[Action]:
        """First the mobile robots, then the manipulators."""
        way = self._ways[0]
        if way.result is None:
            actions = way.advance(now_s)
            self.reason = way.reason
            return actions
        failed = way.result.outcome is not Ending.SUCCEEDED
        if len(self._ways) > 1:
            self._left_over = way.result.reason if failed else ""
            self._ways = self._ways[1:]
            return self._ways[0].start(now_s)
        if failed:
            self.finish(Ending.FAILED, way.result.reason)
            return []
        return self._store(now_s)

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A step, a hand's work or a manipulator's way to storage has ended."""
        if goal.purpose in (Purpose.STEP, Purpose.HAND):
            return self._ways[0].goal_done(goal, event, now_s)
        if goal.purpose is not Purpose.CLEANUP:
            return []
        if event.outcome is Outcome.SUCCEEDED:
            self._stored.add(goal.robot)
            return []
        self._retry_s = now_s + self.cell.params.retry_s
        self.reason = f"{goal.robot} is not in storage: {event.outcome.value} {event.message}".rstrip()
        return [Log(Level.WARN, self.reason)]

    def circumstances(self) -> Circumstances:
        """What the newest map, the tasks and the newest plan are, for whoever asks why."""
        return self._ways[0].circumstances()

    def delete_done(self, event: DeleteDone) -> List[Action]:
        """Deletions of an earlier mission may still be answered."""
        return self._ways[0].delete_done(event)

    def tasks(self) -> List[TaskView]:
        """What is left, then the ways home and what is still carried."""
        views = self._ways[0].tasks()
        if len(self._ways) > 1:
            return views
        return [view for view in views if view.kind == GoalKind.HOME or view.status is TaskState.CARRYING]

    def _store(self, now_s: float) -> List[Action]:
        cell = self.cell
        missing = [name for name in cell.manipulators if name in cell.answers and name not in self._stored]
        if not missing:
            self.finish(Ending.FAILED if self._left_over else Ending.SUCCEEDED, self._left_over)
            return []
        actions: List[Action] = []
        for name in missing:
            goal = cell.goals.active.get(name)
            if goal is not None and goal.purpose is Purpose.CLEANUP:
                if now_s - goal.sent_s > cell.params.cleanup_timeout_s:
                    limit = cell.params.cleanup_timeout_s
                    actions += cell.goals.cancel(name, now_s, f"not in storage within {limit:g} s")
                    self.finish(Ending.FAILED, f"{name} is not in storage within {limit:g} s")
            elif name in cell.connected and now_s >= self._retry_s:
                actions.append(cell.goals.send(name, Purpose.CLEANUP, ArmAction.CLEANUP.value, now_s))
        return actions
