"""Steps on their way: only what the independent checker finds safe is sent, and it is watched until it ends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Tuple

import numpy as np

from yarm.commander.params import CheckSteps
from yarm.geometry import BoolArray, IntArray
from yarm.planning.model.types import FleetPlan, PlanRequest, Robot, StepCheck, Waypoint
from yarm.planning.verification.checker import check_step, sweep_of

Checker = Callable[[PlanRequest, FleetPlan], StepCheck]


@dataclass(frozen=True)
class CheckedSteps:
    """What may be sent of a plan.

    Attributes:
        steps: waypoint by robot.
        refused: why the checker does not pass the whole plan; empty when it does, or was not asked.
    """

    steps: Dict[str, Waypoint]
    refused: str = ""


def steps_of(plan: FleetPlan) -> Dict[str, Waypoint]:
    """The waypoints a plan wants sent, by robot, ordered by name."""
    return {name: p.step for name, p in sorted(plan.robots.items()) if p.step is not None}


def starts_alike(asked: PlanRequest, now: PlanRequest, plan: FleetPlan) -> bool:
    """Whether all robots that a plan moves still stand where they stood when it was asked for."""
    stood, stand = ({robot.name: (robot.column, robot.yaw_rad) for robot in one.robots} for one in (asked, now))
    return all(name in stand and stand[name] == stood[name] for name in steps_of(plan))


def safe_part(request: PlanRequest, plan: FleetPlan, check: Checker = check_step) -> CheckedSteps:
    """The whole plan when it is safe, else as many robots' steps as are safe together, the others staying."""
    wanted = steps_of(plan)
    if not wanted:
        return CheckedSteps({})
    verdict = check(request, plan)
    if verdict.safe:
        return CheckedSteps(wanted)
    kept: Dict[str, Waypoint] = {}
    if len(wanted) > 1:
        for name in wanted:
            if check(request, _only(plan, [*kept, name])).safe:
                kept[name] = wanted[name]
    return CheckedSteps(kept, verdict.reason)


def _only(plan: FleetPlan, robots: List[str]) -> FleetPlan:
    kept = {name: p if name in robots else replace(p, step=None) for name, p in plan.robots.items()}
    return replace(plan, robots=kept)


def sendable(request: PlanRequest, plan: FleetPlan, mode: CheckSteps) -> CheckedSteps:
    """What is sent of a plan, by ``check_steps``.

    Args:
        request: what was asked.
        plan: the answer.
        mode: the safe part, everything, or everything and what the checker has against it.
    """
    if mode is CheckSteps.SEND_SAFE:
        return safe_part(request, plan)
    steps = steps_of(plan)
    refused = check_step(request, plan).reason if mode is CheckSteps.REPORT and steps else ""
    return CheckedSteps(steps, refused)


class StepGuard:
    """Holds the cells a step sweeps against every new map until the step ends.

    The step was sent with a margin of one cell; here only a cell that is really taken counts, several maps in a row,
    so that noise at an object's edge stops nobody.
    """

    def __init__(self, count: int) -> None:
        """Alarm after ``count`` failing checks in a row."""
        self._count = count
        self._sweeps: Dict[str, IntArray] = {}
        self._failures: Dict[str, int] = {}

    def watch(self, request: PlanRequest, robot: Robot, step: Waypoint) -> None:
        """Watch a step that is being sent."""
        cells = sweep_of(request, robot, step).cells
        self.watch_cells(robot.name, cells[request.spec.contains(cells)])

    def watch_cells(self, robot: str, cells: IntArray) -> None:
        """Watch a way that is being sent, by the cells (n, 3) it sweeps, all inside the grid."""
        self._sweeps[robot] = cells
        self._failures[robot] = 0

    def forget(self, robot: str) -> None:
        """The robot's step has ended."""
        self._sweeps.pop(robot, None)
        self._failures.pop(robot, None)

    def alarms(self, occupied: BoolArray) -> List[Tuple[str, IntArray]]:
        """Robots whose way is blocked for good, with the cells in dispute.

        Args:
            occupied: (gx, gy, gz) the map without robots and without their goals.
        """
        found = []
        for robot, cells in sorted(self._sweeps.items()):
            blocked = cells[occupied[tuple(cells.T)]] if len(cells) else np.zeros((0, 3), dtype=np.int64)
            self._failures[robot] = self._failures[robot] + 1 if len(blocked) else 0
            if self._failures[robot] >= self._count:
                found.append((robot, blocked))
        return found
