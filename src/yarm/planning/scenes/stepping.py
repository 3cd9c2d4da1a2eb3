"""Step a fleet to the end as the Commander would: plan, everybody moves one waypoint, plan again."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Callable, Dict, List, Mapping, Optional, Tuple

import numpy as np

from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest, PlanStatus, StepCheck, Waypoint
from yarm.planning.scenes.scene import PlanScene, Stand
from yarm.planning.verification.checker import check_step, chessboard_clearance, robotless_map, sweep_of

SAME_YAW_RAD = math.radians(1.0)
"""A goal's heading is reached within this."""
StepObserver = Callable[[PlanRequest, FleetPlan, StepCheck], None]


@dataclass
class SteppedRun:
    """What came of stepping a fleet to the end.

    Attributes:
        status: SOLVED when every robot with a goal stands on it, else how planning ended; TIMEOUT when nobody moves any
            more or the steps run out.
        reason: why it is not SOLVED.
        steps: steps in which somebody moved.
        refused: steps that the checker refused, so that nobody moved if it was heeded.
        refusals: the checker's reasons, in order.
        sum_of_costs: way travelled by all robots, cells.
        makespan: sum over the steps of the longest way of a robot in it, cells (all wait for the last).
        min_clearance_cells: least number of free cells between a moving robot and anything else.
        replans: plans that were not the rest of the plan before.
        ms: planning time of each call, ms.
        trails: every place of each robot, the first included.
        first: the first plan.
    """

    status: PlanStatus = PlanStatus.TIMEOUT
    reason: str = ""
    steps: int = 0
    refused: int = 0
    refusals: List[str] = field(default_factory=list)
    sum_of_costs: float = 0.0
    makespan: float = 0.0
    min_clearance_cells: Optional[int] = None
    replans: int = 0
    ms: List[float] = field(default_factory=list)
    trails: Dict[str, List[Stand]] = field(default_factory=dict)
    first: Optional[FleetPlan] = None

    def percentile_ms(self, percent: float) -> float:
        """Percentile of the planning times, ms; 0 when nothing was planned."""
        return float(np.percentile(self.ms, percent)) if self.ms else 0.0


def step_to_end(
    scene: PlanScene,
    planner: FleetPlanner,
    rng: np.random.Generator,
    assignments: Optional[Mapping[str, str]] = None,
    most_steps: int = 200,
    patience: int = 5,
    observe: Optional[StepObserver] = None,
    clearance: bool = True,
    heed_checker: bool = True,
) -> SteppedRun:
    """Step the scene's robots until all goals are reached or planning ends.

    Args:
        scene: where it happens.
        planner: asked before each step; reset first.
        rng: handed to the planner.
        assignments: goal of each robot; the scene's own unless given.
        most_steps: plans at most.
        patience: plans in a row without any motion before giving up.
        observe: called with every request, its plan and the checker's verdict, before anybody moves.
        clearance: also measure ``min_clearance_cells``.
        heed_checker: nobody moves in a step that the checker refuses; else the robots make it all the same.
    """
    planner.reset()
    given = dict(scene.assignments if assignments is None else assignments)
    stands = scene.starts()
    run = SteppedRun(trails={name: [stand] for name, stand in stands.items()})
    previous: Optional[FleetPlan] = None
    idle = 0
    for _ in range(most_steps):
        if has_arrived(scene, stands, given):
            run.status, run.reason = PlanStatus.SOLVED, ""
            return run
        request = scene.request(stands, given)
        plan = planner.plan(request, rng)
        run.ms.append(plan.planning_ms)
        run.first = run.first or plan
        run.replans += previous is not None and not _continues(previous, plan)
        verdict = check_step(request, plan)
        if observe is not None:
            observe(request, plan, verdict)
        moves = {name: r.step for name, r in plan.robots.items() if r.step is not None and _moves(stands[name], r.step)}
        if not verdict.safe:
            run.refused += 1
            run.refusals.append(verdict.reason)
            moves = {} if heed_checker else moves
        run.status, run.reason = plan.status, plan.reason
        if plan.status not in (PlanStatus.SOLVED, PlanStatus.TIMEOUT) and not moves:
            return run
        idle = 0 if moves else idle + 1
        if idle >= patience:
            break
        if clearance and moves:
            _note_clearance(run, request, plan)
        _make_moves(run, stands, moves)
        previous = plan
    _conclude(run, has_arrived(scene, stands, given), idle)
    return run


def _conclude(run: SteppedRun, arrived: bool, idle: int) -> None:
    """Status and reason of a run that has used up its steps or its patience."""
    if arrived:
        run.status, run.reason = PlanStatus.SOLVED, ""
        return
    blocked = f"; the last refused step: {run.refusals[-1]}" if run.refusals else ""
    run.status = PlanStatus.TIMEOUT
    run.reason = (
        run.reason or f"not all goals reached after {len(run.ms)} plans, {idle} in a row without motion{blocked}"
    )


def _make_moves(run: SteppedRun, stands: Dict[str, Stand], moves: Mapping[str, Waypoint]) -> None:
    longest = 0.0
    for name, step in moves.items():
        length = math.dist(stands[name].column, step.column)
        stands[name] = Stand(step.column, step.yaw_rad)
        run.trails[name].append(stands[name])
        run.sum_of_costs += length
        longest = max(longest, length)
    run.makespan += longest
    run.steps += bool(moves)


def _note_clearance(run: SteppedRun, request: PlanRequest, plan: FleetPlan) -> None:
    sweeps = [
        sweep_of(request, robot, plan.robots[robot.name].step if robot.name in plan.robots else None)
        for robot in request.robots
    ]
    least = chessboard_clearance(robotless_map(request), sweeps)
    run.min_clearance_cells = least if run.min_clearance_cells is None else min(run.min_clearance_cells, least)


def has_arrived(scene: PlanScene, stands: Mapping[str, Stand], assignments: Mapping[str, str]) -> bool:
    """Whether every robot with a goal stands on it, at its heading where it has one."""
    for robot, goal_name in assignments.items():
        goal, stand = scene.goals[goal_name], stands[robot]
        if stand.column != goal.column:
            return False
        if goal.yaw_rad is not None and abs(math.remainder(goal.yaw_rad - stand.yaw_rad, math.tau)) > SAME_YAW_RAD:
            return False
    return True


def _moves(stand: Stand, step: Waypoint) -> bool:
    return stand.column != step.column or abs(math.remainder(stand.yaw_rad - step.yaw_rad, math.tau)) > 1e-9


def _continues(previous: FleetPlan, plan: FleetPlan) -> bool:
    """Whether every robot's path is the rest of its path in the previous plan."""
    for name, entry in plan.robots.items():
        before = previous.robots.get(name)
        columns = _corners(entry.path)
        if before is None or _corners(before.path)[-len(columns) :] != columns:
            return False
    return True


def _corners(path: Tuple[Waypoint, ...]) -> List[Tuple[int, int]]:
    """Columns of a path behind its first waypoint."""
    return [waypoint.column for waypoint in path[1:]]
