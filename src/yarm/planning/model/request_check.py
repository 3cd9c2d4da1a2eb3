"""What is wrong with a request, robot by robot, in sentences a person can act on."""

from __future__ import annotations

import math
from typing import Collection, Dict, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.planning.model.types import FleetPlan, Goal, PlanRequest, PlanStatus, Robot, RobotPlan

Fault = Tuple[PlanStatus, str]

_SEVERITY = {
    PlanStatus.SOLVED: 0,
    PlanStatus.TIMEOUT: 1,
    PlanStatus.INFEASIBLE: 2,
    PlanStatus.INVALID_GOAL: 3,
    PlanStatus.INVALID_START: 4,
}


def world_fault(request: PlanRequest) -> str:
    """What makes the whole request unusable; empty when nothing does."""
    shape = np.asarray(request.occupied).shape
    if shape != tuple(request.spec.shape):
        return f"map of shape {shape} does not have the {request.spec.shape} cells of its specification"
    if request.forbidden is not None and np.asarray(request.forbidden).shape != tuple(request.spec.shape[:2]):
        return f"forbidden columns of shape {np.asarray(request.forbidden).shape} must be {request.spec.shape[:2]}"
    names = [robot.name for robot in request.robots]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        return f"robot names must be unique; more than one is called {', '.join(doubled)}"
    unknown = sorted(set(request.assignments) - set(names))
    if unknown:
        return f"goals are assigned to robots that are not there: {', '.join(unknown)}"
    return ""


def robot_fault(robot: Robot, request: PlanRequest) -> Optional[Fault]:
    """What makes a robot unusable."""
    gx, gy, gz = request.spec.shape
    cells = np.asarray(robot.mask.cells)
    if cells.ndim != 2 or cells.shape[1:] != (3,) or len(cells) == 0:
        return PlanStatus.INVALID_START, f"{robot.name} has no cells (mask of shape {cells.shape}, not (n, 3))"
    low, high = cells.min(axis=0).tolist(), cells.max(axis=0).tolist()
    extent = tuple(b - a + 1 for a, b in zip(low, high))
    if any(n > most for n, most in zip(extent, (gx, gy, gz))) or max(-min(low[:2]), *high[:2]) > gx + gy:
        return PlanStatus.INVALID_START, f"{robot.name} is {extent} cells, larger than the grid"
    numbers = [robot.yaw_rad, *(robot.position_m or ()), *(float(value) for value in robot.column)]
    if not all(math.isfinite(number) for number in numbers):
        return PlanStatus.INVALID_START, f"{robot.name} has a pose that is not finite"
    if not (0 <= robot.column[0] < gx and 0 <= robot.column[1] < gy):
        where = f"({robot.column[0]}, {robot.column[1]})"
        return PlanStatus.INVALID_START, f"{robot.name} has its end effector in column {where}, outside the grid"
    return None


def start_collision(robot: Robot, request: PlanRequest) -> Optional[Fault]:
    """Which object a robot overlaps where it stands."""
    if all(name in request.goals for name in request.objects):
        return _map_collision(robot, request)
    mine = np.zeros(request.spec.shape, dtype=np.bool_)
    _set_cells(mine, robot.cells, request, True)
    for name, theirs in request.objects.items():
        if name in request.goals or len(theirs) == 0:
            continue
        inside = np.asarray(theirs)[request.spec.contains(theirs)]
        both = inside[mine[inside[:, 0], inside[:, 1], inside[:, 2]]]
        if len(both):
            cell = tuple(int(v) for v in both[0])
            return PlanStatus.INVALID_START, f"{robot.name} overlaps {name} in {len(both)} cells, one is {cell}"
    return _map_collision(robot, request)


def _map_collision(robot: Robot, request: PlanRequest) -> Optional[Fault]:
    """Whether a robot stands in cells that the map has as occupied, though it should hold no robots."""
    cells = robot.cells[request.spec.contains(robot.cells)]
    taken = cells[np.asarray(request.occupied, dtype=np.bool_)[tuple(cells.T)]]
    if not len(taken):
        return None
    goals = [np.asarray(goal.cells, dtype=np.int64).reshape(-1, 3) for goal in request.goals.values()]
    of_goals = {tuple(cell) for own in goals for cell in own.tolist()}
    taken_cells = sorted(tuple(cell) for cell in taken.tolist() if tuple(cell) not in of_goals)
    if not taken_cells:
        return None
    return PlanStatus.INVALID_START, (
        f"{robot.name} stands in {len(taken_cells)} cells that the map without robots has as occupied, "
        f"one is {taken_cells[0]}"
    )


def goal_fault(robot: Robot, request: PlanRequest) -> Optional[Fault]:
    """What makes the goal of a robot unusable, whatever the robot's way."""
    name = request.assignments[robot.name]
    goal = request.goals.get(name)
    if goal is None:
        return PlanStatus.INVALID_GOAL, f"{robot.name} is assigned to {name}, which is not among the goals"
    gx, gy, _ = request.spec.shape
    if not all(math.isfinite(float(value)) for value in goal.column):
        return PlanStatus.INVALID_GOAL, f"{name} has a column that is not finite"
    if not (0 <= goal.column[0] < gx and 0 <= goal.column[1] < gy):
        return PlanStatus.INVALID_GOAL, f"{name} is in column {tuple(goal.column)}, outside the {gx} x {gy} columns"
    if goal.yaw_rad is not None and not math.isfinite(goal.yaw_rad):
        return PlanStatus.INVALID_GOAL, f"{name} wants a heading that is not finite"
    return None


def assigned_goal(robot: Robot, request: PlanRequest) -> Optional[Goal]:
    """The goal of a robot; None when it has none."""
    name = request.assignments.get(robot.name)
    return None if name is None else request.goals.get(name)


def robotless_grid(request: PlanRequest, robots: Sequence[Robot]) -> BoolArray:
    """Where some robots must not be: the map (gx, gy, gz) without goals that are assigned, with all other robots."""
    occupied: BoolArray = np.array(request.occupied, dtype=np.bool_)
    others = [robot for robot in request.robots if not any(robot is one for one in robots)]
    for other in others:
        _set_cells(occupied, _cells_of(other), request, True)
    for robot in robots if others else ():
        _set_cells(occupied, robot.cells, request, False)
    for name in request.assignments.values():
        goal = request.goals.get(name)
        if goal is not None and len(goal.cells):
            _set_cells(occupied, np.asarray(goal.cells, dtype=np.int64).reshape(-1, 3), request, False)
    return occupied


def _set_cells(occupied: BoolArray, cells: IntArray, request: PlanRequest, value: bool) -> None:
    inside = cells[request.spec.contains(cells)]
    occupied[inside[:, 0], inside[:, 1], inside[:, 2]] = value


def _cells_of(robot: Robot) -> IntArray:
    """Absolute cells (n, 3) of a robot that may have a fault; none when it has no cells or no column."""
    cells = np.asarray(robot.mask.cells)
    usable = cells.ndim == 2 and cells.shape[1:] == (3,) and all(math.isfinite(value) for value in robot.column)
    return robot.cells if usable else np.zeros((0, 3), dtype=np.int64)


def objects_at(cells: IntArray, request: PlanRequest, limit: int = 3) -> str:
    """Names of the objects that own some of the cells (n, 3), for a reason; "the map" when none does."""
    if len(cells) == 0:
        return "the border of the volume"
    inside = cells[request.spec.contains(cells)]
    wanted = np.unique(request.spec.ravel(inside))
    names = []
    for name, theirs in request.objects.items():
        own = np.asarray(theirs).reshape(-1, 3)
        own = own[request.spec.contains(own)]
        if len(np.intersect1d(wanted, request.spec.ravel(own))):
            names.append(name)
    names += [f"robot {r.name}" for r in request.robots if _shares(r.cells, wanted, request)]
    return ", ".join(names[:limit]) or "something unknown"


def _shares(cells: IntArray, wanted: IntArray, request: PlanRequest) -> bool:
    inside = cells[request.spec.contains(cells)]
    return bool(len(np.intersect1d(wanted, request.spec.ravel(inside))))


def worst(plans: Mapping[str, RobotPlan]) -> Tuple[PlanStatus, str]:
    """Worst status of some plans and the reason that goes with it."""
    status, reason = PlanStatus.SOLVED, ""
    for plan in plans.values():
        if _SEVERITY[plan.status] > _SEVERITY[status]:
            status, reason = plan.status, plan.reason
    return status, reason


def faulty_plans(request: PlanRequest, usable: Collection[str] = ()) -> Dict[str, RobotPlan]:
    """Plans of the assigned robots whose start or goal is unusable; ``usable`` robots have passed ``robot_fault``."""
    plans = {}
    for robot in request.robots:
        goal = request.assignments.get(robot.name)
        if goal is None:
            continue
        fault = None if robot.name in usable else robot_fault(robot, request)
        fault = fault or start_collision(robot, request) or goal_fault(robot, request)
        if fault is not None:
            plans[robot.name] = RobotPlan(robot.name, goal, fault[0], fault[1])
    return plans


def refused(request: PlanRequest, reason: str) -> FleetPlan:
    """The answer to a request that cannot be used at all."""
    plans = {
        name: RobotPlan(name, goal, PlanStatus.INVALID_START, reason) for name, goal in request.assignments.items()
    }
    return FleetPlan(PlanStatus.INVALID_START, reason, plans)
