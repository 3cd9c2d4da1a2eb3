"""Small robots and requests for the planner's tests."""

from __future__ import annotations

import math
from typing import Dict, Iterable, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import GridSpec, IntArray, Mask
from yarm.planning.model.types import Column, Goal, PlanRequest, Robot, without_robots

SMALL = GridSpec((16, 12, 4), (0.0, 0.0, 0.0), (1.6, 1.2, 0.4))


def block(width: int, depth: int, height: int = 2) -> Mask:
    """A robot of width x depth x height cells, the end effector at its lowest corner."""
    return Mask(np.array([(x, y, z) for x in range(width) for y in range(depth) for z in range(height)]))


def arm(reach: int) -> Mask:
    """A body of 3 x 3 cells behind an arm of ``reach`` cells; the end effector at the arm's tip, heading +x."""
    cells = [(-reach + x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (0, 1)]
    return Mask(np.array(cells + [(-k, 0, 2) for k in range(reach + 1)]))


def robot(name: str, column: Column, mask: Mask, yaw_deg: float = 0.0) -> Robot:
    return Robot(name, column, math.radians(yaw_deg), mask)


def walls(spec: GridSpec, boxes: Iterable[Tuple[int, int, int, int]]) -> np.ndarray:
    """Boolean grid with full-height boxes x0, x1, y0, y1, ends exclusive."""
    grid = np.zeros(spec.shape, dtype=bool)
    for x0, x1, y0, y1 in boxes:
        grid[x0:x1, y0:y1] = True
    return grid


def request(
    spec: GridSpec,
    occupied: np.ndarray,
    robots: Sequence[Robot],
    goals: Sequence[Goal] = (),
    assignments: Optional[Mapping[str, str]] = None,
    objects: Optional[Mapping[str, IntArray]] = None,
    forbidden: Optional[np.ndarray] = None,
) -> PlanRequest:
    """A request; the goals go to the robots in order unless told otherwise."""
    given: Dict[str, str] = {r.name: g.name for r, g in zip(robots, goals)}
    return PlanRequest(
        spec,
        without_robots(spec, occupied, robots),
        tuple(robots),
        {goal.name: goal for goal in goals},
        given if assignments is None else assignments,
        dict(objects or {}),
        forbidden,
    )
