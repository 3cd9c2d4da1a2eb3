"""A planning scene: a grid with boxes, robots somewhere in it and goals; what a planner is tried on."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Callable, Dict, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import BoolArray, GridSpec, IntArray, Mask, wrap_angle
from yarm.planning.model.types import Column, Goal, PlanRequest, Robot, without_robots
from yarm.robots.ankurbot import ankurbot_mask

SAME_YAW_RAD = math.radians(0.01)
"""Headings closer than this are the same for a robot given by its cells."""
Box = Tuple[int, int, int, int, int, int]
"""Occupied cells x0, x1, y0, y1, z0, z1, ends exclusive."""


@dataclass(frozen=True)
class Stand:
    """Where a robot stands: its end effector's column, in the middle of it, and its heading, rad, world."""

    column: Column
    yaw_rad: float


@dataclass(frozen=True, eq=False)
class SceneRobot:
    """A robot of a scene.

    Attributes:
        name: unique name.
        start: where it stands at first.
        cells: (n, 3) cells relative to the end effector's column as it stands at first; None for the ankurbot.
    """

    name: str
    start: Stand
    cells: Optional[IntArray] = None

    def mask(self, spec: GridSpec, yaw_rad: float) -> Mask:
        """Its cells at a heading, rad, world."""
        if self.cells is None:
            return ankurbot_mask(spec, yaw_rad)
        mask = Mask.from_cells(self.cells, (0, 0), self.start.yaw_rad)
        angle = wrap_angle(yaw_rad - self.start.yaw_rad)
        return mask if abs(angle) < SAME_YAW_RAD else mask.turned(angle, spec)

    def mask_at(self, spec: GridSpec) -> Optional[Callable[[float], Mask]]:
        """Its cells at any heading, rad, world, from its solids; None for a robot of which only its cells are known."""
        return partial(ankurbot_mask, spec) if self.cells is None else None

    def standing(self, spec: GridSpec, at: Stand) -> Robot:
        """The robot as a Commander would tell of it, standing there."""
        return Robot(self.name, at.column, at.yaw_rad, self.mask(spec, at.yaw_rad), mask_at=self.mask_at(spec))


@dataclass(frozen=True, eq=False)
class PlanScene:
    """What a planner is tried on.

    Attributes:
        spec: the grid.
        boxes: occupied boxes of cells.
        robots: the fleet.
        goals: goals by name.
        assignments: goal of each robot that has a fixed one.
        name: for reports.
    """

    spec: GridSpec
    boxes: Tuple[Box, ...]
    robots: Tuple[SceneRobot, ...]
    goals: Mapping[str, Goal]
    assignments: Mapping[str, str] = field(default_factory=dict)
    name: str = "scene"

    def starts(self) -> Dict[str, Stand]:
        """Where each robot stands at first."""
        return {robot.name: robot.start for robot in self.robots}

    def occupied(self) -> BoolArray:
        """(gx, gy, gz) cells of the boxes."""
        grid: BoolArray = np.zeros(self.spec.shape, dtype=bool)
        for x0, x1, y0, y1, z0, z1 in self.boxes:
            grid[x0:x1, y0:y1, z0:z1] = True
        return grid

    def request(
        self, stands: Optional[Mapping[str, Stand]] = None, assignments: Optional[Mapping[str, str]] = None
    ) -> PlanRequest:
        """The request a Commander would make with the robots standing there; at their starts unless told."""
        at = self.starts() if stands is None else stands
        fleet = tuple(robot.standing(self.spec, at[robot.name]) for robot in self.robots)
        standing = without_robots(self.spec, self.occupied(), fleet)
        objects = {f"boxes[{i}]": _cells_of(box) for i, box in enumerate(self.boxes)}
        given = self.assignments if assignments is None else assignments
        return PlanRequest(self.spec, standing, fleet, dict(self.goals), dict(given), objects)


def _cells_of(box: Box) -> IntArray:
    x0, x1, y0, y1, z0, z1 = box
    cells: IntArray = np.argwhere(np.ones((x1 - x0, y1 - y0, z1 - z0), dtype=bool)) + np.array([x0, y0, z0])
    return cells
