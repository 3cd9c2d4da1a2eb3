"""Hands at work in a mission: pick up what was reached, let it go over a bin, and see that it lies in there.

A robot whose hand is at work stands still and is not planned for; the others go on meanwhile. Between its two works it
carries the piece to a bin like to any goal. What the map shows and what the hand says must agree: a piece counts as
done when it lies in a bin and no hand holds it, and one that has left the hand anywhere else is debris again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Optional, Sequence, Set, Tuple

from yarm.commander.cell_state import CellState
from yarm.commander.events import Action, GoalDone, Level, Log, Outcome, SendGoal, Target, TaskState, TaskView
from yarm.commander.goals import ActiveGoal, Purpose
from yarm.commander.pieces import Refusal, pieces_beside
from yarm.control.actions import MobileAction
from yarm.geometry import MappedObject, yaw_of_quaternion
from yarm.planning.model.types import Goal, GoalKind

ALIGN_M = 0.12
"""A hand is brought over something from at most so far, metres; what lies farther is driven to first."""
SEARCH_M = (0.0, 0.008, -0.008)
"""How far beside the middle of a piece, across it, each try goes, metres: where it is seen may be off."""


@dataclass
class Job:
    """A piece on its way into a bin.

    Attributes:
        robot: whose hand it is for.
        piece: its name.
        stage: PICKING, CARRYING or DROPPING.
        since_s: when it came to this stage, or when the hand begins again.
        tries: works of the hand in this stage that failed.
        reason: why the last of them did.
        bin: where it is let go.
    """

    robot: str
    piece: str
    stage: TaskState
    since_s: float
    tries: int = 0
    reason: str = ""
    bin: str = ""


class Handling:
    """What the hands of a mission's robots do."""

    def __init__(self, cell: CellState) -> None:
        """Nothing yet."""
        self._cell = cell
        self._jobs: Dict[str, Job] = {}
        self._named: Set[str] = set()

    @property
    def busy(self) -> str:
        """Whose hands are at work, for people; empty when none is."""
        jobs = [job for job in self._jobs.values() if job.stage is not TaskState.CARRYING]
        return ", ".join(f"{job.robot} is {job.stage.value} {job.piece}" for job in jobs)

    def start(self, now_s: float) -> None:
        """A mission starts: what hangs on hands goes on to a bin, and what was given back may be tried again."""
        cell = self._cell
        self._jobs, self._named = {}, set()
        cell.at_work, cell.refused, cell.full_bins = set(), {}, {}
        self._take_up(now_s)

    @property
    def jobs(self) -> Tuple[Job, ...]:
        """A copy of every piece's work, by piece: what ``resume`` needs."""
        return tuple(replace(job) for _, job in sorted(self._jobs.items()))

    def resume(self, jobs: Sequence[Job], now_s: float) -> None:
        """Go on from the ``jobs`` of hands that have been drawn up since, each with or without its piece.

        One that was to pick tries again, and finds out if it holds the piece already; one that was to let go is back
        to carrying until the piece is seen elsewhere.
        """
        cell = self._cell
        self._jobs = {job.piece: replace(job, since_s=now_s) for job in jobs}
        for job in self._jobs.values():
            if job.stage is TaskState.DROPPING:
                job.stage, job.since_s = TaskState.CARRYING, now_s + cell.params.fall_s
        cell.at_work = {job.robot for job in self._jobs.values() if job.stage is TaskState.PICKING}

    def waiting(self) -> str:
        """Why something that is carried, or was given back, gets into no bin; empty when nothing is left so."""
        cell = self._cell
        full = "; ".join(f"{found.name} is full: {cell.full(found)}" for found in cell.bins if cell.full(found))
        for job in sorted(self._jobs.values(), key=lambda job: job.robot):
            if job.stage is TaskState.CARRYING and all(cell.full(found) for found in cell.bins):
                return f"{job.robot} carries {job.piece} and waits for a bin: {full or 'there is none on the map'}"
        return next((f"{name}: {refusal.reason}" for name, refusal in sorted(cell.refused.items())), "")

    def reached(self, robot: str, goal: Goal, now_s: float) -> List[Action]:
        """A robot stands over a piece or a bin: its hand begins."""
        self._cell.at_work.add(robot)
        if goal.kind is GoalKind.DEBRIS:
            self._cell.queue.hold(goal, robot, now_s)
            self._jobs[goal.name] = Job(robot, goal.name, TaskState.PICKING, now_s)
            return self._pick(self._jobs[goal.name], now_s)
        job = self._jobs[self._cell.loads[robot].piece]
        job.stage, job.bin, job.since_s = TaskState.DROPPING, goal.name.split("/")[0], now_s
        return self._drop(job, now_s)

    def advance(self, now_s: float) -> List[Action]:
        """Take in a new map."""
        actions: List[Action] = []
        limit_s = self._cell.params.hand_timeout_s
        for goal in self._cell.goals.of(Purpose.HAND):
            if now_s - goal.sent_s > limit_s:
                actions += self._cell.goals.cancel(goal.robot, now_s, f"not done within {limit_s:g} s")
        for job in list(self._jobs.values()):
            if not self._working(job.robot) and now_s >= job.since_s:
                actions += self._go_on(job, now_s)
        self._take_up(now_s)
        return actions + self._taken_out() + self._full_bins()

    def goal_done(self, goal: ActiveGoal, event: GoalDone, now_s: float) -> List[Action]:
        """A pick or a drop has ended; what the hand holds now is known to the cell."""
        job = next((job for job in self._jobs.values() if job.robot == goal.robot and self._is_of(job, goal)), None)
        if job is None:
            self._cell.at_work.discard(goal.robot)
            return []
        holds = self._cell.loads.get(job.robot)
        done = (holds is not None) is (job.stage is TaskState.PICKING)
        job.since_s = now_s
        if done:
            return self._hand_done(job, event, now_s)
        job.reason = goal.why or f"{event.outcome.value} {event.message}".rstrip()
        job.tries += goal.cancelled_s is None
        if job.stage is TaskState.DROPPING:
            self._back_to_carrying(job)
        else:
            job.since_s += self._cell.params.retry_s
        return [Log(Level.WARN, f"{job.robot}: {goal.action} failed, try {job.tries}: {job.reason}")]

    def tasks(self) -> List[TaskView]:
        """Pieces on their way, and those that were given back."""
        jobs = sorted(self._jobs.values(), key=lambda job: job.robot)
        views = [TaskView(job.robot, job.piece, GoalKind.DEBRIS, job.stage, job.reason) for job in jobs]
        return views + [
            TaskView("", name, GoalKind.DEBRIS, TaskState.UNREACHABLE, refusal.reason)
            for name, refusal in sorted(self._cell.refused.items())
        ]

    def _go_on(self, job: Job, now_s: float) -> List[Action]:
        """The next thing for a piece whose robot's hand is not at work."""
        if job.stage is TaskState.PICKING:
            return self._try_again(job, now_s)
        if job.stage is TaskState.CARRYING:
            return [] if self._hangs(job) else self._left_hand(job, now_s)
        return self._look_into_bin(job, now_s)

    def _try_again(self, job: Job, now_s: float) -> List[Action]:
        if job.tries < self._cell.params.pick_tries:
            return self._pick(job, now_s)
        found = self._thing(job.piece)
        reason = f"not picked up in {job.tries} tries: {job.reason}"
        if found is not None:
            beside = pieces_beside(found, self._cell.map.objects) if self._cell.map is not None else ()
            self._cell.refused[job.piece] = Refusal(reason, (found.position_m[0], found.position_m[1]), beside)
        return self._lost(job, f"{job.piece} is given back: {reason}")

    def _pick(self, job: Job, now_s: float) -> List[Action]:
        found = self._thing(job.piece)
        place = None if found is None else self._target(job.robot, found, SEARCH_M[job.tries % len(SEARCH_M)])
        if place is None:
            return self._lost(job, f"{job.piece} is no longer where {job.robot} stands")
        return [self._send(job, MobileAction.PICK, job.piece, place, now_s)]

    def _drop(self, job: Job, now_s: float) -> List[Action]:
        found = self._thing(job.bin)
        place = None if found is None else self._target(job.robot, found)
        if place is None:
            self._back_to_carrying(job)
            return [Log(Level.WARN, f"{job.bin} is no longer where {job.robot} stands")]
        return [self._send(job, MobileAction.DROP, job.bin, place, now_s)]

    def _send(self, job: Job, action: MobileAction, name: str, place: Target, now_s: float) -> SendGoal:
        return self._cell.goals.send(job.robot, Purpose.HAND, f"{action.value} {name}", now_s, place)

    def _hand_done(self, job: Job, event: GoalDone, now_s: float) -> List[Action]:
        self._cell.at_work.discard(job.robot)
        job.tries, job.reason = 0, ""
        if job.stage is TaskState.PICKING:
            job.stage = TaskState.CARRYING
            return [Log(Level.INFO, f"{job.robot} has {job.piece}: {event.message}")]
        job.since_s = now_s + self._cell.params.fall_s
        if event.outcome is Outcome.SUCCEEDED:
            return [Log(Level.INFO, f"{job.robot} has let {job.piece} go over {job.bin}: {event.message}")]
        return [Log(Level.WARN, f"{job.robot} has no {job.piece} any more: {event.message}")]

    def _left_hand(self, job: Job, now_s: float) -> List[Action]:
        """What was carried hangs on the hand no more: it lies in a bin already, or is lost."""
        found = self._thing(job.piece)
        if found is not None and self._cell.bin_of(found):
            return self._look_into_bin(job, now_s)
        return self._lost(job, f"{job.robot} has lost {job.piece}")

    def _look_into_bin(self, job: Job, now_s: float) -> List[Action]:
        found = self._thing(job.piece)
        where = "" if found is None else self._cell.bin_of(found)
        if not where:
            return self._lost(job, f"{job.piece} was let go over {job.bin} and does not lie in it")
        self._cell.queue.laid_down(job.piece, now_s)
        del self._jobs[job.piece]
        return [Log(Level.INFO, f"{job.piece} lies in {where}")]

    def _back_to_carrying(self, job: Job) -> None:
        """The bin would not take it: it is tried again, and after some tries counts as full."""
        self._cell.at_work.discard(job.robot)
        job.stage = TaskState.CARRYING
        if job.tries >= self._cell.params.pick_tries:
            self._cell.full_bins[job.bin] = f"nothing was let go in {job.tries} tries: {job.reason}"
            job.tries = 0

    def _lost(self, job: Job, why: str) -> List[Action]:
        """A piece is a goal again, or nothing when it is gone."""
        self._cell.at_work.discard(job.robot)
        self._cell.queue.undone(job.piece)
        del self._jobs[job.piece]
        return [Log(Level.WARN, why)]

    def _hangs(self, job: Job) -> bool:
        """Whether a piece hangs on the hand that it is for."""
        load = self._cell.loads.get(job.robot)
        return load is not None and load.piece == job.piece

    def _take_up(self, now_s: float) -> None:
        """What hangs on a hand that is not at work goes on to a bin, whoever picked it up."""
        cell = self._cell
        sought = {task.goal.name for task in cell.queue.tasks if task.robot}
        for robot, load in sorted(cell.loads.items()):
            if cell.params.bins_used and robot not in cell.at_work and load.piece not in {*self._jobs, *sought}:
                self._jobs[load.piece] = Job(robot, load.piece, TaskState.CARRYING, now_s)
                cell.queue.hold(Goal(load.piece, GoalKind.DEBRIS, (0, 0)), robot, now_s)

    def _taken_out(self) -> List[Action]:
        """Pieces that were done and lie in no bin any more are goals again."""
        actions: List[Action] = []
        if not self._cell.params.bins_used:
            return actions
        known = set(self._jobs) | self._cell.carried
        for thing in self._cell.of_kind(GoalKind.DEBRIS):
            if thing.name in self._cell.queue.leaving - known and not self._cell.bin_of(thing):
                self._cell.queue.undone(thing.name)
                actions.append(Log(Level.WARN, f"{thing.name} is in no bin any more"))
        return actions

    def _full_bins(self) -> List[Action]:
        """Each bin is named when it is first found full, once a mission."""
        actions: List[Action] = []
        for found in self._cell.bins:
            why = self._cell.full(found)
            if why and found.name not in self._named:
                self._named.add(found.name)
                actions.append(Log(Level.WARN, f"{found.name} is full: {why}"))
        return actions

    def _working(self, robot: str) -> bool:
        goal = self._cell.goals.active.get(robot)
        return goal is not None and goal.purpose is Purpose.HAND

    def _is_of(self, job: Job, goal: ActiveGoal) -> bool:
        """Whether a hand's goal is a piece's present work."""
        picks = MobileAction.of(goal.action) is MobileAction.PICK
        name = goal.action.split(" ", 1)[1]
        if picks:
            return job.stage is TaskState.PICKING and job.piece == name
        return job.stage is TaskState.DROPPING and job.bin == name

    def _thing(self, name: str) -> Optional[MappedObject]:
        return self._cell.map.objects.get(name) if self._cell.map is not None else None

    def _target(self, robot: str, found: MappedObject, across_m: float = 0.0) -> Optional[Target]:
        """Where a robot's end effector goes for something, its heading kept; None when it is too far off for that.

        Args:
            robot: its name.
            found: what it goes for.
            across_m: so far beside the middle, across the longer side that is seen of it.
        """
        tracked = self._cell.robots.get(robot)
        x, y, _ = self._cell.place_of(found)
        axis_rad = found.piece.axis_rad if found.piece is not None else yaw_of_quaternion(found.quaternion)
        x, y = x - across_m * math.sin(axis_rad), y + across_m * math.cos(axis_rad)
        if tracked is None or math.hypot(x - tracked.x, y - tracked.y) > ALIGN_M:
            return None
        return Target(x, y, tracked.nominal_yaw_rad)
