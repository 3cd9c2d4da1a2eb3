"""Who serves which goal: idle robots, open goals, and the pairs assigned (docs/planning.md, "Tasks").

The Commander's loop around it::

    queue = TaskQueue()
    while True:
        queue.update(robots, goals)                    # what the map shows now: every mobile robot, every open goal
        queue.process(request, keep_clear=part_area)   # assigns; request.goals and request.assignments are not read
        if queue.done:
            break
        request = replace(request, goals=queue.goals, assignments=queue.assignments)
        plan = planner.plan(request, rng)              # ... send the steps, wait for arrival ...
        for robot in robots:
            task = queue.task_of(robot.name)
            if task is not None and arrived(robot, task.goal, spec):
                queue.pop(robot.name)                  # a task of kind "Clear" has no body: nothing to delete

- ``update`` drops goals that are no longer shown (their robot is idle again), follows those that moved, adds new ones.
- ``process`` assigns idle robots: debris before targets before homes, the sum of the travel distances least. A goal no
  robot can reach is not assigned but listed in ``unreachable`` with the reason, and tried again when the map changes.
  Goals that cannot be held at the same time wait for each other.
- An idle robot that stands inside ``keep_clear`` is given a goal of kind "Clear", named ``clear/<robot>``, made here: a
  place outside where it blocks nobody. Idle robots elsewhere are moved by the planner when they block somebody
  (``RobotPlan`` with an empty goal), without a task.
- ``reject(robot, reason)`` gives a goal back that the planner found INFEASIBLE.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from yarm.geometry import BoolArray, FloatArray, GridSpec, wrap_angle
from yarm.planning.params import TaskParams
from yarm.planning.travel import Travel
from yarm.planning.types import Goal, PlanRequest, Robot

KIND_ORDER = ("Clear", "Debris", "Target", "Home")
"""Kinds of goals, most urgent first."""

_FAR = 1e7


class TaskStatus(Enum):
    """What has become of a goal."""

    OPEN = "OPEN"
    ASSIGNED = "ASSIGNED"
    UNREACHABLE = "UNREACHABLE"


@dataclass(frozen=True, eq=False)
class Task:
    """A goal and who serves it.

    Attributes:
        goal: the goal as the map shows it now.
        status: OPEN while it waits.
        robot: name of its robot; empty while it has none.
        reason: why it waits or is unreachable; empty when it is served.
        distance_cells: travel distance of its robot when it was assigned, cells.
    """

    goal: Goal
    status: TaskStatus = TaskStatus.OPEN
    robot: str = ""
    reason: str = ""
    distance_cells: float = math.nan

    @property
    def kind(self) -> str:
        """Kind of the goal."""
        return self.goal.kind


class TaskQueue:
    """Open goals, idle robots, and who serves what. Not thread safe."""

    def __init__(self, params: Optional[TaskParams] = None) -> None:
        """Empty."""
        self._params = params or TaskParams()
        self._robots: Dict[str, Robot] = {}
        self._tasks: Dict[str, Task] = {}
        self._rejected: Dict[Tuple[str, str], Tuple[str, int]] = {}
        self._map_key = 0
        self._must_clear: Set[str] = set()

    @property
    def tasks(self) -> Tuple[Task, ...]:
        """Every goal that is not done, in the order they came."""
        return tuple(self._tasks.values())

    @property
    def goals(self) -> Mapping[str, Goal]:
        """Goals by name, those made here too."""
        return {name: task.goal for name, task in self._tasks.items()}

    @property
    def assignments(self) -> Mapping[str, str]:
        """Name of the goal of each robot that has one."""
        return {task.robot: name for name, task in self._tasks.items() if task.robot}

    @property
    def unreachable(self) -> Mapping[str, str]:
        """Reason by goal that no robot can reach in the map as it is."""
        return {n: task.reason for n, task in self._tasks.items() if task.status is TaskStatus.UNREACHABLE}

    @property
    def idle(self) -> Tuple[str, ...]:
        """Robots without a goal, by name."""
        busy = self.assignments
        return tuple(sorted(name for name in self._robots if name not in busy))

    @property
    def done(self) -> bool:
        """Whether nothing is left that could be served: no goal open or assigned (unreachable ones may be left)."""
        return all(task.status is TaskStatus.UNREACHABLE for task in self._tasks.values())

    def task_of(self, robot: str) -> Optional[Task]:
        """Task of a robot; None when it has none."""
        return next((task for task in self._tasks.values() if task.robot == robot), None)

    def update(self, robots: Sequence[Robot], goals: Sequence[Goal]) -> Tuple[str, ...]:
        """Take over what the map shows now.

        Args:
            robots: every mobile robot; a goal of one that is no longer there is open again.
            goals: every goal not done, without those of kind "Clear".

        Returns:
            names of assigned goals that have vanished, or moved to another column.
        """
        self._robots = {robot.name: robot for robot in robots}
        shown = {goal.name: goal for goal in goals}
        changed: List[str] = []
        for name, task in list(self._tasks.items()):
            goal = shown.get(name)
            if goal is None and not (task.kind == "Clear" and task.robot in self._robots):
                del self._tasks[name]
                changed += [name] * bool(task.robot)
            elif goal is not None:
                moved = goal.column != task.goal.column
                changed += [name] * (moved and bool(task.robot))
                self._tasks[name] = replace(task, goal=goal)
        for name, task in self._tasks.items():
            if task.robot and task.robot not in self._robots:
                self._tasks[name] = Task(task.goal)
        for name, goal in shown.items():
            if name not in self._tasks:
                self._tasks[name] = Task(goal)
        return tuple(changed)

    def process(self, request: PlanRequest, keep_clear: Optional[BoolArray] = None) -> Tuple[Task, ...]:
        """Assign idle robots to open goals.

        A robot on its way to a target leaves it for debris that no idle robot can serve; otherwise assigned pairs stay
        (a goal that can no longer be reached is for the planner to find out, see ``reject``).

        Args:
            request: map and robots; its goals and assignments are not read.
            keep_clear: (gx, gy) columns in which no idle robot may stand; None for none.

        Returns:
            tasks assigned now.
        """
        self._robots = {robot.name: robot for robot in request.robots}
        self._map_key = hash((np.asarray(request.grid) != 0).tobytes())
        before = dict(self.assignments)
        travel = Travel(replace(request, goals=self.goals, assignments={}), self._params.turns_deg)
        self._open_again()
        self._assign(travel)
        if keep_clear is not None:
            self._clear(travel, np.asarray(keep_clear, dtype=np.bool_))
        return tuple(task for task in self.tasks if task.robot and before.get(task.robot) != task.goal.name)

    def pop(self, robot: str) -> Task:
        """Free a robot whose goal is done, and forget the goal.

        Raises:
            KeyError: the robot has no goal.
        """
        task = self.task_of(robot)
        if task is None:
            raise KeyError(f"robot {robot} has no goal")
        del self._tasks[task.goal.name]
        return task

    def reject(self, robot: str, reason: str) -> None:
        """Give back the goal of a robot that cannot reach it; the pair is not tried again before the map changes."""
        task = self.task_of(robot)
        if task is not None:
            self._rejected[robot, task.goal.name] = (reason, self._map_key)
            self._tasks[task.goal.name] = Task(task.goal, TaskStatus.OPEN, "", reason)
            if task.kind == "Clear":
                del self._tasks[task.goal.name]

    def _open_again(self) -> None:
        """What was unreachable may not be any more, since the map may have changed."""
        for name, task in self._tasks.items():
            if task.status is TaskStatus.UNREACHABLE:
                self._tasks[name] = Task(task.goal)

    def _assign(self, travel: Travel) -> None:
        """Kind after kind; a robot with a less urgent goal takes part when there are too few idle ones."""
        self._rejected = {pair: entry for pair, entry in self._rejected.items() if entry[1] == self._map_key}
        for kind in KIND_ORDER[1:]:
            names = [n for n, task in self._tasks.items() if task.kind == kind and not task.robot]
            if names:
                self._assign_kind(travel, names, self._available(kind))
        for name, task in self._tasks.items():
            if not task.robot and task.status is TaskStatus.OPEN:
                self._tasks[name] = self._waiting(travel, task)

    def _available(self, kind: str) -> List[str]:
        """Idle robots, and those that serve something less urgent."""
        rank = KIND_ORDER.index(kind)
        robots = []
        for name in sorted(self._robots):
            task = self.task_of(name)
            if task is None or KIND_ORDER.index(task.kind) > rank or task.kind == "Clear":
                robots.append(name)
        return robots

    def _assign_kind(self, travel: Travel, names: List[str], robots: List[str]) -> None:
        costs: FloatArray = np.full((len(names), len(robots)), _FAR)
        for i, name in enumerate(names):
            for j, robot in enumerate(robots):
                length, _ = self._distance(travel, robot, self._tasks[name].goal)
                if math.isfinite(length):
                    busy = self.task_of(robot)
                    costs[i, j] = length + (1e4 if busy is not None and busy.kind != "Clear" else 0.0)
        rows, columns = linear_sum_assignment(costs)
        for i, j in sorted(zip(rows, columns), key=lambda pair: (costs[pair[0], pair[1]], pair)):
            if costs[i, j] < _FAR and self._compatible(travel, robots[j], self._tasks[names[i]].goal):
                self._give(names[i], robots[j], float(costs[i, j]) % 1e4)

    def _give(self, name: str, robot: str, length: float) -> None:
        left = self.task_of(robot)
        if left is not None and left.kind == "Clear":
            del self._tasks[left.goal.name]
        elif left is not None:
            self._tasks[left.goal.name] = Task(left.goal)
        self._tasks[name] = Task(self._tasks[name].goal, TaskStatus.ASSIGNED, robot, "", length)

    def _distance(self, travel: Travel, robot: str, goal: Goal) -> Tuple[float, str]:
        if goal.robot and goal.robot != robot:
            return math.inf, f"{goal.name} is for {goal.robot} only"
        if (robot, goal.name) in self._rejected:
            return math.inf, self._rejected[robot, goal.name][0]
        return travel.distance(robot, goal)

    def _compatible(self, travel: Travel, robot: str, goal: Goal) -> bool:
        """Whether a robot can hold a goal while the others hold theirs."""
        return all(
            task.robot == robot or not task.robot or travel.compatible(robot, goal, task.robot, task.goal)
            for task in self._tasks.values()
        )

    def _waiting(self, travel: Travel, task: Task) -> Task:
        """An open task with the reason why it waits or cannot be served."""
        reasons = []
        for robot in sorted(self._robots):
            length, reason = self._distance(travel, robot, task.goal)
            if math.isfinite(length):
                if self.task_of(robot) is None:
                    return replace(task, reason="waits until a goal beside it is done")
                reasons.append("")
            else:
                reasons.append(reason)
        if "" in reasons:
            return replace(task, reason="waits for a robot")
        return Task(task.goal, TaskStatus.UNREACHABLE, "", "; ".join(reasons) or "there is no mobile robot")

    def _clear(self, travel: Travel, keep_clear: BoolArray) -> None:
        for name in self.idle:
            if travel.stands_in(name, keep_clear):
                held = [(task.robot, task.goal) for task in self._tasks.values() if task.robot]
                waiting = [task.goal for task in self._tasks.values() if task.status is TaskStatus.OPEN]
                place = travel.place_outside(name, keep_clear, held, waiting)
                if place is not None and (name, f"clear/{name}") not in self._rejected:
                    goal = Goal(f"clear/{name}", "Clear", place[0], robot=name)
                    self._tasks[goal.name] = Task(goal, TaskStatus.ASSIGNED, name, "", place[1])


def arrived(robot: Robot, goal: Goal, spec: GridSpec, was_there: bool = False, reach_m: float = 0.06) -> bool:
    """Whether a robot is at its goal.

    Args:
        robot: where it is.
        goal: where it should be.
        spec: the grid.
        was_there: it was there before; then it may be as far as 1.5 cells from the centre before it is not any more, so
            that a robot on the border of two cells does not dither.
        reach_m: distance to the goal column's centre that is near enough even from the next cell, m.

    Returns:
        true when its end effector is in the goal's column, or near enough to its centre, at the wanted heading (1 deg).
    """
    most = math.radians(2.0 if was_there else 1.0)
    if goal.yaw_rad is not None and abs(wrap_angle(robot.yaw_rad - goal.yaw_rad)) > most:
        return False
    if robot.column == goal.column:
        return True
    center = spec.column_center(goal.column)
    position = robot.position_m or spec.column_center(robot.column)
    limit = 1.5 * float(spec.resolution[:2].max()) if was_there else reach_m
    return math.dist(position, center) <= limit


__all__ = ["KIND_ORDER", "Task", "TaskQueue", "TaskStatus", "arrived"]
