"""The way back in for a robot whose end effector is outside the mapped volume: straight, without a turn, and checked.

The planner knows only poses on the grid. Outside it nothing is seen, so no way is looked for there: the robot comes
straight in, and what it sweeps inside must be free with the margin of every step: one cell, all 26 neighbours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional

import numpy as np
from scipy import ndimage

from yarm.commander.cell_state import TrackedRobot
from yarm.commander.events import Target
from yarm.geometry import BoolArray, GridSpec, IntArray
from yarm.planning.model.types import Column

CANDIDATES = 40
"""Columns tried as the end of the way in, nearest first."""
SAMPLES_PER_CELL = 4


@dataclass(frozen=True, eq=False)
class WayIn:
    """Where a robot may come in.

    Attributes:
        target: pose of its end effector, heading as it is; None when no way is free.
        cells: (n, 3) what it sweeps inside the grid.
        reason: why there is no way, and what a person should do; empty when there is one.
    """

    target: Optional[Target]
    cells: IntArray
    reason: str = ""


def way_in(robot: TrackedRobot, spec: GridSpec, occupied: BoolArray) -> WayIn:
    """The shortest straight way that brings a robot's end effector over the grid.

    Args:
        robot: whose end effector is outside.
        spec: the grid.
        occupied: (gx, gy, gz) everything but this robot, other robots included.
    """
    taken = ndimage.binary_dilation(occupied, np.ones((3, 3, 3), dtype=bool))
    here = _inside(spec, robot.mask.at(spec.column_of((robot.x, robot.y))))
    for column in _nearest_columns(robot, spec):
        swept = _swept(robot, spec, column)
        cells = swept[~np.isin(spec.ravel(swept), spec.ravel(here))] if len(here) else swept
        if not taken[tuple(cells.T)].any():
            x, y = spec.column_centre(column)
            return WayIn(Target(x, y, robot.yaw_rad), swept)
    return WayIn(None, np.zeros((0, 3), dtype=np.int64), _refusal(robot))


def _refusal(robot: TrackedRobot) -> str:
    return (
        f"{robot.name} has its end effector at ({robot.x:.2f}, {robot.y:.2f}) m, outside the mapped volume, "
        "and no straight way in is free: clear the border before it, or drive it in by hand"
    )


def _nearest_columns(robot: TrackedRobot, spec: GridSpec) -> List[Column]:
    columns = np.stack(np.meshgrid(np.arange(spec.shape[0]), np.arange(spec.shape[1]), indexing="ij"), axis=-1)
    flat = columns.reshape(-1, 2)
    centres = np.asarray(spec.lower[:2]) + (flat + 0.5) * spec.resolution[:2]
    distances = np.hypot(centres[:, 0] - robot.x, centres[:, 1] - robot.y)
    order = np.argsort(distances, kind="stable")[:CANDIDATES]
    return [(int(x), int(y)) for x, y in flat[order]]


def _swept(robot: TrackedRobot, spec: GridSpec, column: Column) -> IntArray:
    """Cells inside the grid that a robot fills on a straight line to a column, its heading kept."""
    x, y = spec.column_centre(column)
    length = math.hypot(x - robot.x, y - robot.y) / float(spec.resolution[:2].min())
    shares = np.linspace(0.0, 1.0, max(2, math.ceil(SAMPLES_PER_CELL * length) + 1))
    points = np.column_stack([robot.x + shares * (x - robot.x), robot.y + shares * (y - robot.y)])
    columns = np.unique(np.floor((points - spec.lower[:2]) / spec.resolution[:2]).astype(np.int64), axis=0)
    cells = np.concatenate([robot.mask.at((int(cx), int(cy))) for cx, cy in columns])
    return np.unique(_inside(spec, cells), axis=0)


def _inside(spec: GridSpec, cells: IntArray) -> IntArray:
    kept: IntArray = np.asarray(cells, dtype=np.int64)[spec.contains(cells)]
    return kept
