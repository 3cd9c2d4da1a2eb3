"""How goals are given to robots: over travel distances in the modes, each robot its own home in CLEANUP."""

from __future__ import annotations

from typing import Callable, Mapping, Optional, Protocol, Sequence

from yarm.geometry import BoolArray
from yarm.planning.model.types import Goal, PlanRequest
from yarm.planning.tasks.task_queue import TaskQueue


class Assignments(Protocol):
    """What a mission has the task queue do; who serves what, and all else about the tasks, stands in the queue."""

    def start(self) -> None:
        """A mission starts: forget the tasks of the last one."""

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal], now_s: float) -> None:
        """What the map shows at a time, s; the request's own goals are not read."""

    def process(
        self,
        request: PlanRequest,
        keep_clear: Optional[BoolArray],
        hiding: Mapping[str, str],
        left: Optional[Mapping[str, float]] = None,
    ) -> None:
        """Assign. Idle robots that stand in the columns (gx, gy) of ``keep_clear`` are sent out of them.

        Those of ``hiding`` hide cells that count as occupied, so named among the request's objects: they are sent aside
        when a goal needs these cells. ``left`` is what each robot under way has left, cells, where robots drive each
        for itself.
        """

    def reject(self, robot: str, reason: str) -> None:
        """The planner found the robot's task impossible for now."""


class QueuedAssignments:
    """Every open goal to whom it is nearest."""

    def __init__(self, queue: TaskQueue) -> None:
        """Assign in a queue whose parameters are those of the mission's planner."""
        self._queue = queue

    def start(self) -> None:
        """Nobody has a goal."""
        self._queue.start_over()

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal], now_s: float) -> None:
        """Take in who is there and what is open."""
        self._queue.update(request.robots, tuple(open_goals.values()), now_s)

    def process(
        self,
        request: PlanRequest,
        keep_clear: Optional[BoolArray],
        hiding: Mapping[str, str],
        left: Optional[Mapping[str, float]] = None,
    ) -> None:
        """Assign over travel distances."""
        self._queue.process(request, keep_clear, hiding, left)

    def reject(self, robot: str, reason: str) -> None:
        """Give the goal back with the reason."""
        self._queue.reject(robot, reason)


class HomeAssignments:
    """Every robot has its own goal from the start, and nobody else's."""

    def __init__(self, queue: TaskQueue, homes: Sequence[Goal], at: Callable[[str, Goal], bool]) -> None:
        """One home a robot; ``at`` says whether a robot is at a goal now."""
        self._queue = queue
        self._homes = tuple(homes)
        self._at = at

    def start(self) -> None:
        """Everybody is on its way home."""
        self._queue.start_over()
        self._queue.claim(self._homes)

    def update(self, request: PlanRequest, open_goals: Mapping[str, Goal], now_s: float) -> None:
        """Robots that have left the cell need no home until they are back."""
        self._queue.update(request.robots, tuple(self._queue.goals.values()), now_s)

    def process(
        self,
        request: PlanRequest,
        keep_clear: Optional[BoolArray],
        hiding: Mapping[str, str],
        left: Optional[Mapping[str, float]] = None,
    ) -> None:
        """The homes of robots that are back; when nobody is on its way, of those that have left theirs for others."""
        present = {robot.name for robot in request.robots}
        self._queue.claim([task.goal for task in self._queue.tasks if not task.robot and task.goal.robot in present])
        if not self._queue.assignments:
            self._queue.claim(
                [goal for goal in self._homes if goal.robot in present and not self._at(goal.robot, goal)]
            )

    def reject(self, robot: str, reason: str) -> None:
        """A home stays a home; it is tried again."""
