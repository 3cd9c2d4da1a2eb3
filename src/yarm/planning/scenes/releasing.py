"""Carry a scene's joint plan out without a barrier: every robot goes on as soon as its next move is released."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.planning.fleet.release import ReleaseOrder, moves_of
from yarm.planning.model.types import (
    FleetPlan,
    FleetPlanner,
    PlannedMove,
    PlanRequest,
    PlanStatus,
    Robot,
    StepCheck,
)
from yarm.planning.scenes.scene import PlanScene, Stand
from yarm.planning.scenes.stepping import has_arrived
from yarm.planning.verification.checker import Way, check_release, sweep_of

Duration = Callable[[PlannedMove], float]
RAD_PER_CELL = math.radians(10.0)
"""A turn by this takes as long as one cell of way."""


def way_cells(move: PlannedMove) -> float:
    """How long a move takes at a cell a unit of time: its way, and a unit for each 10 degrees of its turn."""
    turn = abs(math.remainder(move.end.yaw_rad - move.start.yaw_rad, math.tau))
    return math.dist(move.start.column, move.end.column) + turn / RAD_PER_CELL


@dataclass(frozen=True, eq=False)
class MadeMove:
    """A move that was released, and from when until when it was made."""

    move: PlannedMove
    began: float
    ended: float


@dataclass(frozen=True, eq=False)
class Release:
    """What a release was checked with; see ``check_release``."""

    request: PlanRequest
    released: Mapping[str, Way]
    under_way: Mapping[str, Way]
    verdict: StepCheck


@dataclass
class ReleasedRun:
    """What came of it.

    Attributes:
        status: SOLVED when every robot with a goal stands on it; TIMEOUT when nobody moves any more.
        reason: why it is not SOLVED.
        time: when the last robot arrived, in units of ``duration``.
        made: every move, in the order of release.
        refusals: the checker's reasons for releases it refused, in order.
        plans: how many were made.
        first: the first of them.
    """

    status: PlanStatus = PlanStatus.TIMEOUT
    reason: str = ""
    time: float = 0.0
    made: List[MadeMove] = field(default_factory=list)
    refusals: List[str] = field(default_factory=list)
    plans: int = 0
    first: Optional[FleetPlan] = None


@dataclass(frozen=True, eq=False)
class _UnderWay:
    """A robot between two stands: as it stood when it was released, its move, and when that ends."""

    robot: Robot
    move: PlannedMove
    until: float


class _Execution:
    """One run; see ``release_to_end``."""

    def __init__(self, scene: PlanScene, assignments: Mapping[str, str], duration: Duration) -> None:
        self.scene = scene
        self.assignments = assignments
        self.duration = duration
        self.stands = scene.starts()
        self.busy: Dict[str, _UnderWay] = {}
        self.now = 0.0
        self.run = ReleasedRun()

    def ends(self) -> Dict[str, Stand]:
        """Where each robot stands when what is released has ended."""
        moved = {name: Stand(b.move.end.column, b.move.end.yaw_rad) for name, b in self.busy.items()}
        return {**self.stands, **moved}

    def plan_request(self) -> PlanRequest:
        """From the ends of what is released."""
        asked = self.scene.request(self.ends(), self.assignments)
        now = self.scene.request(self.stands, self.assignments)
        swept = {name: sweep_of(now, busy.robot, busy.move.end).cells for name, busy in self.busy.items()}
        return PlanRequest(
            asked.spec, now.occupied, asked.robots, asked.goals, asked.assignments, asked.objects, under_way=swept
        )

    def release(self, order: ReleaseOrder, observe: Optional[Callable[[Release], None]]) -> None:
        """Send everybody whose next move waits for nobody, if the checker agrees."""
        for index in order.ready():
            move = order.moves[index]
            request = self.scene.request(self.stands, self.assignments)
            under_way = {name: (busy.move.end,) for name, busy in self.busy.items()}
            verdict = check_release(request, {move.robot: (move.end,)}, under_way)
            if observe is not None:
                observe(Release(request, {move.robot: (move.end,)}, under_way, verdict))
            if not verdict.safe:
                self.run.refusals.append(verdict.reason)
                continue
            order.release(index)
            robot = next(robot for robot in request.robots if robot.name == move.robot)
            until = self.now + self.duration(move)
            self.busy[move.robot] = _UnderWay(robot, move, until)
            self.run.made.append(MadeMove(move, self.now, until))

    def go_on(self) -> List[str]:
        """Until the next moves end; whose they were."""
        self.now = min(busy.until for busy in self.busy.values())
        done = sorted(name for name, busy in self.busy.items() if busy.until <= self.now)
        for name in done:
            end = self.busy.pop(name).move.end
            self.stands[name] = Stand(end.column, end.yaw_rad)
        return done


def release_to_end(
    scene: PlanScene,
    planner: FleetPlanner,
    rng: np.random.Generator,
    assignments: Optional[Mapping[str, str]] = None,
    duration: Duration = way_cells,
    replans: bool = True,
    most_moves: int = 2000,
    observe: Optional[Callable[[Release], None]] = None,
) -> ReleasedRun:
    """Carry the scene out until all goals are reached or nobody moves any more.

    Args:
        scene: where it happens.
        planner: reset first; asked from the ends of what is released, whenever a move has ended.
        rng: handed to the planner.
        assignments: goal of each robot; the scene's own unless given.
        duration: how long a move takes; any positive number, however long, is safe.
        replans: false: only the first plan is carried out.
        most_moves: moves at most.
        observe: called with every release before it is made, also one that the checker refuses.
    """
    planner.reset()
    given = dict(scene.assignments if assignments is None else assignments)
    execution = _Execution(scene, given, duration)
    run, order = execution.run, None
    while len(run.made) < most_moves:
        if not execution.busy and has_arrived(scene, execution.stands, given):
            run.status, run.reason = PlanStatus.SOLVED, ""
            return run
        if order is None or replans:
            request = execution.plan_request()
            plan = planner.plan(request, rng)
            order = ReleaseOrder(moves_of(request, plan), execution.busy)
            run.plans, run.first, run.reason = run.plans + 1, run.first or plan, plan.reason
        execution.release(order, observe)
        if not execution.busy:
            break
        for name in execution.go_on():
            order.finish(name)
        run.time = execution.now
    run.reason = run.reason or f"nobody moves any more, or {most_moves} moves were made"
    return run


def waits(plan: FleetPlan) -> List[Tuple[PlannedMove, Tuple[str, ...]]]:
    """Every move of a joint plan in its order, with the moves of others it waits for, as ``robot.number`` from 1."""
    counts: Dict[str, int] = {}
    labels = []
    for move in plan.moves:
        counts[move.robot] = counts.get(move.robot, 0) + 1
        labels.append(f"{move.robot}.{counts[move.robot]}")
    return [(move, tuple(labels[k] for k in move.after)) for move in plan.moves]
