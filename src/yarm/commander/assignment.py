"""Who serves which goal: the task queue in the modes, fixed homes in CLEANUP."""

from __future__ import annotations

from typing import Dict, Mapping, Optional, Protocol

from yarm.geometry import BoolArray
from yarm.planning.task_queue import TaskQueue
from yarm.planning.types import Goal, PlanRequest


class Assignments(Protocol):
    """Pairs of robots and goals, kept up to date by the mission."""

    @property
    def pairs(self) -> Mapping[str, str]:
        """Name of the goal of each robot that has one."""

    @property
    def goals(self) -> Mapping[str, Goal]:
        """The goals of the pairs, at least, by name."""

    @property
    def unreachable(self) -> Mapping[str, str]:
        """Reason by name of each goal nobody can reach now."""

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal]) -> None:
        """What the map shows now; the request's own goals are not read."""

    def process(self, request: PlanRequest, keep_clear: Optional[BoolArray]) -> None:
        """Assign. Idle robots that stand in the columns (gx, gy) of ``keep_clear`` are sent out of them."""

    def pop(self, robot: str) -> None:
        """The robot's task is done."""

    def reject(self, robot: str, reason: str) -> None:
        """The planner found the robot's task impossible for now."""


class QueuedAssignments:
    """The task queue behind the mission's interface."""

    def __init__(self) -> None:
        """An empty queue."""
        self._queue = TaskQueue()

    @property
    def pairs(self) -> Mapping[str, str]:
        """Name of the goal of each robot that has one."""
        return self._queue.assignments

    @property
    def goals(self) -> Mapping[str, Goal]:
        """Every goal the queue knows, by name."""
        return self._queue.goals

    @property
    def unreachable(self) -> Mapping[str, str]:
        """Reason by name of each goal nobody can reach now."""
        return self._queue.unreachable

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal]) -> None:
        """Take in who is there and what is open."""
        self._queue.update(request.robots, tuple(open_goals.values()))

    def process(self, request: PlanRequest, keep_clear: Optional[BoolArray]) -> None:
        """Assign over travel distances."""
        self._queue.process(request, keep_clear=keep_clear)

    def pop(self, robot: str) -> None:
        """The robot is idle again."""
        self._queue.pop(robot)

    def reject(self, robot: str, reason: str) -> None:
        """Give the goal back with the reason."""
        self._queue.reject(robot, reason)


class HomeAssignments:
    """Every robot has its own goal from the start, and nobody else's."""

    def __init__(self, homes: Mapping[str, Goal]) -> None:
        """One home a robot, by robot name."""
        self._homes = dict(homes)
        self._done: Dict[str, Goal] = {}
        self._present = set(homes)

    @property
    def pairs(self) -> Mapping[str, str]:
        """Robots that are not home."""
        return {robot: goal.name for robot, goal in self._homes.items() if robot in self._present}

    @property
    def goals(self) -> Mapping[str, Goal]:
        """The homes not reached, by name of the goal."""
        return {goal.name: goal for goal in self._homes.values()}

    @property
    def unreachable(self) -> Mapping[str, str]:
        """Nothing is ever given up here; the plan's reason says what is in the way."""
        return {}

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal]) -> None:
        """Robots that have left the cell need no home."""
        self._present = {robot.name for robot in request.robots}

    def process(self, request: PlanRequest, keep_clear: Optional[BoolArray]) -> None:
        """Nothing to assign."""

    def pop(self, robot: str) -> None:
        """The robot is home."""
        self._done[robot] = self._homes.pop(robot)

    def reject(self, robot: str, reason: str) -> None:
        """A home stays a home; it is tried again."""
