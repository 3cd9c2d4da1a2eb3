"""Brute force: move every robot in small steps, point by point, and look which cells its points fall into.

The oracle of tests and benchmarks; shares no code with planners or with the checker. It knows no margin: it finds
touches, cells that a robot enters and that somebody else has or enters during the same step.
"""

from __future__ import annotations

import math
from typing import Dict, List, Set, Tuple

import numpy as np

from yarm.planning.model.types import FleetPlan, PlanRequest, Robot, Waypoint

Cell = Tuple[int, int, int]
STEP_CELLS = 0.2
"""Way of a robot's outermost point between two looks, cells."""
_CODE = 1 << 20
_POINTS = np.array([-0.49, 0.0, 0.49])


def touches(request: PlanRequest, plan: FleetPlan) -> List[str]:
    """A sentence for each touch of a step, and for each robot that leaves the grid; empty when there is none."""
    start: Dict[str, Set[Cell]] = {robot.name: _cells(robot) for robot in request.robots}
    entered: Dict[str, Set[Cell]] = {}
    for robot in request.robots:
        entry = plan.robots.get(robot.name)
        step = None if entry is None else entry.step
        entered[robot.name] = start[robot.name] | (set() if step is None else _simulate(request, robot, step))
    taken = _taken(request)
    found = []
    for i, robot in enumerate(request.robots):
        name = robot.name
        new = entered[name] - start[name]
        outside = [cell for cell in new if not _is_inside(cell, request.spec.shape)]
        if outside and all(_is_inside(cell, request.spec.shape) for cell in start[name]):
            found.append(f"{name} leaves the grid at {min(outside)}")
        hit = new & taken
        if hit:
            found.append(f"{name} touches the map at {min(hit)}")
        for other in request.robots[i + 1 :]:
            common = (entered[name] & entered[other.name]) - (start[name] & start[other.name])
            if common:
                found.append(f"{name} and {other.name} touch at {min(common)}")
    return found


def _cells(robot: Robot) -> Set[Cell]:
    return {(int(x), int(y), int(z)) for x, y, z in robot.cells}


def _taken(request: PlanRequest) -> Set[Cell]:
    taken = {(int(x), int(y), int(z)) for x, y, z in np.argwhere(request.occupied)}
    for name in request.assignments.values():
        if name in request.goals:
            taken -= {(int(x), int(y), int(z)) for x, y, z in request.goals[name].cells}
    return taken


def _is_inside(cell: Cell, shape: Tuple[int, int, int]) -> bool:
    return all(0 <= cell[axis] < shape[axis] for axis in (0, 1))


def _simulate(request: PlanRequest, robot: Robot, step: Waypoint) -> Set[Cell]:
    """Cells the robot's points fall into: the turn first, then the straight way."""
    size_x, size_y = float(request.spec.resolution[0]), float(request.spec.resolution[1])
    u, v = np.meshgrid(_POINTS, _POINTS)
    columns: Dict[Tuple[int, int], List[int]] = {}
    for x, y, z in robot.mask.cells:
        columns.setdefault((int(x), int(y)), []).append(int(z))
    angle = math.remainder(step.yaw_rad - robot.yaw_rad, 2.0 * math.pi)
    way = (step.column[0] - robot.column[0], step.column[1] - robot.column[1])
    entered: Set[Cell] = set()
    for (dx, dy), heights in columns.items():
        x, y = (dx + u.ravel()) * size_x, (dy + v.ravel()) * size_y
        reach = max(abs(dx), abs(dy)) + 1.0
        angles = np.linspace(0.0, angle, max(2, math.ceil(abs(angle) * reach * 1.5 / STEP_CELLS)))[:, None]
        turned_x, turned_y = np.cos(angles) * x - np.sin(angles) * y, np.sin(angles) * x + np.cos(angles) * y
        part = np.linspace(0.0, 1.0, max(2, math.ceil(math.hypot(*way) / STEP_CELLS)))[:, None]
        all_x = np.concatenate([turned_x, turned_x[-1] + part * way[0] * size_x]).ravel() / size_x + robot.column[0]
        all_y = np.concatenate([turned_y, turned_y[-1] + part * way[1] * size_y]).ravel() / size_y + robot.column[1]
        codes = np.unique(np.rint(all_x).astype(np.int64) * _CODE + np.rint(all_y).astype(np.int64) + _CODE // 2)
        for code in codes.tolist():
            cx, cy = divmod(code, _CODE)
            entered.update((cx, cy - _CODE // 2, z) for z in heights)
    return entered
