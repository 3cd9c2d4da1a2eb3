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
            if task is not None and robot.column == task.goal.column:
                queue.pop(robot.name)                  # its task says DELETING where there is a body to delete
                                                       # ... queue.deleted(name) when it has been deleted, or
                                                       # queue.hold and laid_down when it is carried off

- ``update`` drops goals that are no longer shown (their robot is idle again), follows those that moved, adds new ones.
- ``process`` assigns idle robots: bins before debris before targets before homes, the sum of the travel distances,
  onward from debris to a bin too, least (the assignment problem of H. W. Kuhn, 1955, solved as in D. F. Crouse, "On
  implementing 2D rectangular assignment algorithms", IEEE Transactions on Aerospace and Electronic Systems 52, 2016).
  A goal no robot can reach is not assigned but listed in ``unreachable`` with the reason, and tried again when the map
  changes. Goals that cannot be held at the same time wait for each other.
- An idle robot that stands inside ``keep_clear`` is given a goal of kind CLEAR, named ``clear/<robot>``, made here: a
  place outside where it blocks nobody. Idle robots elsewhere are moved by the planner when they block somebody
  (``RobotPlan`` with an empty goal), without a task; one moved into ``keep_clear`` stays there until those it made way
  for are done.
- Who of ``hiding`` is idle, and hides what a goal that nobody can reach needs, is given such a goal too.
- ``reject(robot, reason)`` gives a goal back that the planner found INFEASIBLE.
- A goal of kind BIN is for the robot that carries something there; a robot that carries something serves no debris.
- Everything about a task stands in its one record, also when it is done: ``deleting`` is what somebody has still to
  delete, ``leaving`` what is done with its body on the map, ``start_over`` forgets the rest for the next mission.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Collection, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np
from scipy.optimize import linear_sum_assignment

from yarm.geometry import BoolArray, FloatArray
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, GoalKind, PlanRequest, Robot
from yarm.planning.tasks.aside import StoodAside
from yarm.planning.tasks.choice import chosen
from yarm.planning.tasks.patience import soon_free, ways_after
from yarm.planning.tasks.task import BODIES, Task, TaskStatus
from yarm.planning.tasks.travel import Travel
from yarm.planning.tasks.unhiding import Unhiding

KIND_ORDER = (GoalKind.CLEAR, GoalKind.BIN, GoalKind.DEBRIS, GoalKind.TARGET, GoalKind.HOME)
"""Kinds of goals, most urgent first."""

LEAVING_CELLS = 1e4
"""What taking a robot off a less urgent goal counts in the assignment: more than any way, so idle robots go first."""
NO_WAY_ON_CELLS = 1e3
"""What a goal counts there from which there is no way on, as when somebody stands at every bin: it is served last."""
NO_WAY_CELLS = 1e7
"""What a pair without a way counts there: more than any robot taken off its goal."""

PASSING = (GoalKind.CLEAR, GoalKind.BIN)
"""Kinds of goals that are forgotten when they are reached."""


class TaskQueue:
    """Open goals, idle robots, and who serves what. Not thread safe."""

    def __init__(self, params: Optional[PlannerParams] = None) -> None:
        """Empty.

        Args:
            params: those of the planner that will plan for the pairs; distances are measured with its turns.
        """
        self._params = params or PlannerParams()
        self._robots: Dict[str, Robot] = {}
        self._tasks: Dict[str, Task] = {}
        self._done: Dict[str, Task] = {}
        self._now_s = math.nan
        self._rejected: Dict[Tuple[str, str], Tuple[str, int]] = {}
        self._map_key = 0
        self._aside = StoodAside()
        self._unhiding = Unhiding()

    @property
    def tasks(self) -> Tuple[Task, ...]:
        """Every goal that is not done, in the order they came."""
        return tuple(self._tasks.values())

    @property
    def records(self) -> Tuple[Task, ...]:
        """Every task that somebody serves or has done: what ``take_up`` needs."""
        return (*(task for task in self._tasks.values() if task.robot), *self._done.values())

    def take_up(self, records: Sequence[Task]) -> None:
        """Go on from the ``records`` of a queue that is no more; whatever else is open, ``update`` will show."""
        self.start_over()
        serving = (TaskStatus.OPEN, TaskStatus.ASSIGNED, TaskStatus.UNREACHABLE)
        self._tasks = {task.goal.name: task for task in records if task.status in serving}
        self._done = {task.goal.name: task for task in records if task.status not in serving}

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
    def finished(self) -> Tuple[Task, ...]:
        """What robots have reached since the last ``start_over``, deleted or not, without what is only passed."""
        return tuple(task for task in self._done.values() if task.status is not TaskStatus.LEAVING)

    @property
    def deleting(self) -> Tuple[Task, ...]:
        """What was reached and has still to be deleted, by name."""
        return tuple(task for _, task in sorted(self._done.items()) if task.status is TaskStatus.DELETING)

    @property
    def leaving(self) -> Set[str]:
        """Names of what is done and whose body the map still shows: neither a goal any more nor in the way."""
        return {name for name, task in self._done.items() if task.on_map}

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

    def update(self, robots: Sequence[Robot], goals: Sequence[Goal], now_s: float = math.nan) -> Tuple[str, ...]:
        """Take over what the map shows now.

        Args:
            robots: every mobile robot; a goal of one that is no longer there is open again.
            goals: every goal not done, without those of kind CLEAR.
            now_s: time of the map, s; what ``process`` and ``reject`` change after it is written down with it.

        Returns:
            names of assigned goals that have vanished, or moved to another column.
        """
        self._now_s = now_s
        self._robots = {robot.name: robot for robot in robots}
        shown = {goal.name: goal for goal in goals}
        changed: List[str] = []
        for name, task in list(self._tasks.items()):
            goal = shown.get(name)
            if goal is None and not (task.kind is GoalKind.CLEAR and task.robot in self._robots):
                del self._tasks[name]
                if task.robot:
                    changed.append(name)
            elif goal is not None:
                if task.robot and goal.column != task.goal.column:
                    changed.append(name)
                self._tasks[name] = replace(task, goal=goal)
        for name, task in self._tasks.items():
            if task.robot and task.robot not in self._robots:
                self._tasks[name] = Task(task.goal, since_s=now_s)
        for name, goal in shown.items():
            if name not in self._tasks:
                self._tasks[name] = Task(goal, since_s=now_s)
        return tuple(changed)

    def process(
        self,
        request: PlanRequest,
        keep_clear: Optional[BoolArray] = None,
        hiding: Optional[Mapping[str, str]] = None,
        left: Optional[Mapping[str, float]] = None,
    ) -> Tuple[Task, ...]:
        """Assign idle robots to open goals.

        A robot on its way to a target leaves it for debris that no idle robot can serve; otherwise assigned pairs stay
        (a goal that can no longer be reached is for the planner to find out, see ``reject``).

        Args:
            request: map and robots; its goals and assignments are not read.
            keep_clear: (gx, gy) columns in which no idle robot may stand; None for none.
            hiding: for each robot that hides cells which count as occupied, their name among the request's objects.
            left: what robots have left of their moves under way to where the request has them, cells: a goal is left
                to one that is busy and comes there sooner, when it is done, than anybody who is idle. None: robots
                drive together, and all are idle again at the same time.

        Returns:
            tasks assigned now.
        """
        self._robots = {robot.name: robot for robot in request.robots}
        self._map_key = _map_key(request)
        before, records = dict(self.assignments), dict(self._tasks)
        travel = Travel(replace(request, goals=self.goals, assignments={}), self._params)
        self._open_again()
        self._assign(travel, left)
        if keep_clear is not None:
            self._clear(travel, np.asarray(keep_clear, dtype=np.bool_))
        if hiding:
            self._unhide(travel, request, hiding)
        for name, task in self._tasks.items():
            old = records.get(name)
            stays = old is not None and (old.status, old.robot) == (task.status, task.robot)
            self._tasks[name] = replace(task, since_s=old.since_s if old is not None and stays else self._now_s)
        return tuple(task for task in self.tasks if task.robot and before.get(task.robot) != task.goal.name)

    def claim(self, goals: Sequence[Goal]) -> None:
        """Give goals that are each for one robot to it, with no regard to the way.

        Raises:
            ValueError: a goal is for nobody, or its robot has another one.
        """
        for goal in goals:
            task = self.task_of(goal.robot)
            if not goal.robot:
                raise ValueError(f"{goal.name} is for no robot in particular: assign it with process")
            if task is not None and task.goal.name != goal.name:
                raise ValueError(f"{goal.name} cannot be given to {goal.robot}, which serves {task.goal.name}")
            self._done.pop(goal.name, None)
            self._tasks[goal.name] = Task(goal, TaskStatus.ASSIGNED, goal.robot, since_s=self._now_s, why="its own")

    def pop(self, robot: str, now_s: float = math.nan) -> Task:
        """Free a robot whose goal is done.

        Args:
            robot: its name.
            now_s: the time, s.

        Returns:
            the task as it is now: DELETING when it has a body, else REACHED. Of the kinds PASSING it is forgotten.

        Raises:
            KeyError: the robot has no goal.
        """
        task = self._assigned(robot)
        name = task.goal.name
        del self._tasks[name]
        body = task.kind in BODIES
        status = TaskStatus.DELETING if body else TaskStatus.REACHED
        task = replace(task, status=status, reason="", since_s=now_s, on_map=body)
        if task.kind not in PASSING:
            self._done[name] = task
        return task

    def hold(self, goal: Goal, robot: str, now_s: float = math.nan) -> None:
        """Something with a body is in a robot's hand, or about to be: it is no goal, and not in the way.

        Raises:
            KeyError: somebody is on the way to it.
        """
        task = self._tasks.get(goal.name)
        if task is not None and task.robot:
            raise KeyError(f"{goal.name} is a goal of {task.robot}")
        self._tasks.pop(goal.name, None)
        self._done[goal.name] = Task(goal, TaskStatus.HELD, robot, since_s=now_s)

    def laid_down(self, name: str, now_s: float = math.nan) -> None:
        """What a robot held lies where it was to go.

        Raises:
            KeyError: nobody holds it.
        """
        task = self._done.get(name)
        if task is None or task.status is not TaskStatus.HELD:
            raise KeyError(f"{name} is not held: it is {task.status.value if task else 'unknown'}")
        self._done[name] = replace(task, status=TaskStatus.REACHED, since_s=now_s)

    def undone(self, name: str) -> None:
        """Something is a goal again as soon as ``update`` shows it, whatever was done with it; nothing when unknown."""
        self._done.pop(name, None)

    def note(self, robot: str, reason: str) -> None:
        """Write down why a robot does not come nearer to its goal; empty when it does.

        Raises:
            KeyError: the robot has no goal.
        """
        task = self._assigned(robot)
        self._tasks[task.goal.name] = replace(task, reason=reason)

    def ask_again(self, name: str, now_s: float) -> None:
        """The deletion of something reached is asked for once more.

        Raises:
            KeyError: it is not being deleted.
        """
        self._done[name] = replace(self._being_deleted(name), since_s=now_s)

    def deleted(self, name: str, now_s: float = math.nan) -> None:
        """Something reached has been deleted; the map may show it a little longer.

        Raises:
            KeyError: it is not being deleted.
        """
        self._done[name] = replace(self._being_deleted(name), status=TaskStatus.REACHED, since_s=now_s)

    def see(self, names: Collection[str]) -> None:
        """Take over which objects the map shows: what is done and not among them has left it."""
        for name, task in list(self._done.items()):
            if name not in names and task.status is TaskStatus.LEAVING:
                del self._done[name]
            elif name not in names:
                self._done[name] = replace(task, on_map=False)

    def start_over(self) -> None:
        """Forget every task, for another mission, but what is done and still on the map: that stays no goal.

        A deletion that was not answered is not asked for again; what is held must be told again by ``hold``.
        """
        done = {name: task for name, task in self._done.items() if task.status is not TaskStatus.HELD}
        shown = {name: replace(task, status=TaskStatus.LEAVING) for name, task in done.items() if task.on_map}
        self._robots, self._tasks, self._done, self._rejected = {}, {}, shown, {}
        self._map_key, self._now_s, self._aside, self._unhiding = 0, math.nan, StoodAside(), Unhiding()

    def _assigned(self, robot: str) -> Task:
        task = self.task_of(robot) if robot else None
        if task is None:
            raise KeyError(f"robot {robot} has no goal")
        return task

    def _being_deleted(self, name: str) -> Task:
        task = self._done.get(name) or self._tasks.get(name)
        if task is None or task.status is not TaskStatus.DELETING:
            raise KeyError(f"{name} is not being deleted: it is {task.status.value if task else 'unknown'}")
        return task

    def reject(self, robot: str, reason: str) -> None:
        """Give back the goal of a robot that cannot reach it; the pair is not tried again before the map changes."""
        task = self.task_of(robot)
        if task is not None:
            self._rejected[robot, task.goal.name] = (reason, self._map_key)
            self._tasks[task.goal.name] = Task(task.goal, TaskStatus.OPEN, "", reason, since_s=self._now_s)
            if task.kind is GoalKind.CLEAR:
                del self._tasks[task.goal.name]

    def _open_again(self) -> None:
        """What was unreachable may not be any more, since the map may have changed."""
        for name, task in self._tasks.items():
            if task.status is TaskStatus.UNREACHABLE:
                self._tasks[name] = Task(task.goal)

    def _assign(self, travel: Travel, left: Optional[Mapping[str, float]]) -> None:
        """Kind after kind; a robot with a less urgent goal takes part when there are too few idle ones."""
        awaited: Dict[str, str] = {}
        self._rejected = {pair: entry for pair, entry in self._rejected.items() if entry[1] == self._map_key}
        for kind in KIND_ORDER[1:]:
            names = [n for n, task in self._tasks.items() if task.kind == kind and not task.robot]
            if names:
                awaited.update(self._assign_kind(travel, names, self._available(kind), left))
        for name, task in self._tasks.items():
            if not task.robot and task.status is TaskStatus.OPEN:
                self._tasks[name] = self._waiting(travel, task, awaited.get(name, ""))

    def _available(self, kind: GoalKind) -> List[str]:
        """Idle robots, and those that serve something less urgent."""
        rank = KIND_ORDER.index(kind)
        robots = []
        for name in sorted(self._robots):
            task = self.task_of(name)
            if task is None or KIND_ORDER.index(task.kind) > rank or task.kind is GoalKind.CLEAR:
                robots.append(name)
        return robots

    def _assign_kind(
        self, travel: Travel, names: List[str], robots: List[str], left: Optional[Mapping[str, float]]
    ) -> Dict[str, str]:
        """Assign goals of a kind; gives for each that is left to somebody who is busy his name."""
        lengths: FloatArray = np.array(
            [[self._distance(travel, robot, self._tasks[name].goal)[0] for robot in robots] for name in names]
        ).reshape(len(names), len(robots))
        busy = np.array([self._is_busy(robot) for robot in robots], dtype=np.bool_)
        onward: FloatArray = np.zeros_like(lengths)
        for i, j in np.argwhere(np.isfinite(lengths)):
            onward[i, j] = min(travel.onward(robots[j], self._tasks[names[i]].goal), NO_WAY_ON_CELLS)
        costs = np.where(np.isfinite(lengths), lengths + onward + LEAVING_CELLS * busy, NO_WAY_CELLS)
        later, after = self._later(travel, names, robots, left)
        rows, columns = linear_sum_assignment(np.hstack([costs, after]))
        busier = [(i, j - len(robots)) for i, j in zip(rows, columns) if j >= len(robots)]
        awaited = {names[i]: later[j] for i, j in busier if after[i, j] < NO_WAY_CELLS}
        pairs = [(i, j) for i, j in zip(rows, columns) if j < len(robots)]
        for i, j in sorted(pairs, key=lambda pair: (costs[pair[0], pair[1]], pair)):
            goal = self._tasks[names[i]].goal
            if math.isfinite(lengths[i, j]) and self._compatible(travel, robots[j], goal):
                why = chosen(robots, lengths[i].tolist(), int(j))
                self._give(names[i], robots[j], float(lengths[i, j]), why)
        return awaited

    def _later(
        self, travel: Travel, names: List[str], robots: List[str], left: Optional[Mapping[str, float]]
    ) -> Tuple[List[str], FloatArray]:
        """Robots that are busy and may be worth waiting for, and their ways (names, robots), cells."""
        goals = [self._tasks[name].goal for name in names]
        if left is None or all(self._is_busy(robot) for robot in robots):
            return [], np.zeros((len(names), 0))
        busy = soon_free([task for task in self._tasks.values() if task.robot not in robots])
        ways = ways_after(travel, goals, busy, left, self._rejected)
        return [task.robot for task in busy], np.where(np.isfinite(ways), ways, NO_WAY_CELLS)

    def _is_busy(self, robot: str) -> bool:
        """Whether a robot serves a goal of somebody's; making room is none."""
        task = self.task_of(robot)
        return task is not None and task.kind is not GoalKind.CLEAR

    def _give(self, name: str, robot: str, length: float, why: str) -> None:
        left = self.task_of(robot)
        if left is not None and left.kind is GoalKind.CLEAR:
            del self._tasks[left.goal.name]
        elif left is not None:
            self._tasks[left.goal.name] = Task(left.goal)
        self._tasks[name] = Task(self._tasks[name].goal, TaskStatus.ASSIGNED, robot, "", length, why=why)

    def _distance(self, travel: Travel, robot: str, goal: Goal) -> Tuple[float, str]:
        if goal.robot and goal.robot != robot:
            return math.inf, f"{goal.name} is for {goal.robot} only"
        load = self._robots[robot].carries
        if load and goal.kind in BODIES:
            return math.inf, f"{robot} carries {load}"
        if (robot, goal.name) in self._rejected:
            return math.inf, self._rejected[robot, goal.name][0]
        return travel.distance(robot, goal)

    def _compatible(self, travel: Travel, robot: str, goal: Goal) -> bool:
        """Whether a robot can hold a goal while the others hold theirs."""
        return all(
            task.robot == robot or not task.robot or travel.compatible(robot, goal, task.robot, task.goal)
            for task in self._tasks.values()
        )

    def _waiting(self, travel: Travel, task: Task, awaited: str) -> Task:
        """An open task with the reason why it waits or cannot be served."""
        reasons = []
        for robot in sorted(self._robots):
            length, reason = self._distance(travel, robot, task.goal)
            if math.isfinite(length):
                if awaited:
                    return replace(task, reason=f"waits for {awaited}, which is there sooner than who is idle")
                if self.task_of(robot) is None:
                    return replace(task, reason="waits until a goal beside it is done")
                reasons.append("")
            else:
                reasons.append(reason)
        if "" in reasons:
            return replace(task, reason="waits for a robot")
        return Task(task.goal, TaskStatus.UNREACHABLE, "", "; ".join(reasons) or "there is no mobile robot")

    def _clear(self, travel: Travel, keep_clear: BoolArray) -> None:
        inside = {name: travel.stands_in(name, keep_clear) for name in self.idle}
        served = [name for name, task in self._tasks.items() if task.robot and task.kind is not GoalKind.CLEAR]
        aside = self._aside.update(inside, served)
        for name in self.idle:
            if inside[name] and name not in aside:
                why = "it stands where a manipulator works, and has nothing to do there"
                self._send_aside(travel, name, keep_clear, why)

    def _unhide(self, travel: Travel, request: PlanRequest, hiding: Mapping[str, str]) -> None:
        unreachable = [task.goal for task in self._tasks.values() if task.status is TaskStatus.UNREACHABLE]
        for name in self.idle:
            if name in hiding and unreachable:
                seen = Travel(self._unhiding.without(request, hiding[name], self.goals), self._params)
                goal = self._unhiding.needing(name, [g for g in unreachable if self._has_way(seen, g)])
                if goal and self._send_aside(
                    travel, name, self._unhiding.columns(request, name, hiding[name]), f"it hides what {goal} needs"
                ):
                    self._unhiding.ask(name, goal)

    def _has_way(self, travel: Travel, goal: Goal) -> bool:
        return any(math.isfinite(self._distance(travel, robot, goal)[0]) for robot in sorted(self._robots))

    def _send_aside(self, travel: Travel, robot: str, columns: BoolArray, why: str) -> bool:
        """Give an idle robot the nearest place outside some columns, where there is one."""
        held = [(task.robot, task.goal) for task in self._tasks.values() if task.robot]
        waiting = [task.goal for task in self._tasks.values() if task.status is TaskStatus.OPEN]
        place = travel.place_outside(robot, columns, held, waiting)
        if place is None or (robot, f"clear/{robot}") in self._rejected:
            return False
        goal = Goal(f"clear/{robot}", GoalKind.CLEAR, place[0], robot=robot)
        self._tasks[goal.name] = Task(goal, TaskStatus.ASSIGNED, robot, "", place[1], why=why)
        return True


def _map_key(request: PlanRequest) -> int:
    """A number that changes when what stands in the map, or a robot, is elsewhere, or turns otherwise."""
    standing = np.asarray(request.occupied, dtype=np.bool_).tobytes()
    return hash((standing, tuple((r.name, *r.column, r.yaw_rad, r.turns_deg) for r in request.robots)))
