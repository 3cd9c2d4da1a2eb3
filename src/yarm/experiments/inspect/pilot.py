"""Stands in for the navigation: ways over the known map, followed on wheels; asked for lengths before."""

from __future__ import annotations

import math
from typing import Dict, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.navigation.costs import clearance
from yarm.navigation.follower import FollowSettings, PathFollower, room_ahead
from yarm.navigation.grid_map import GridMap
from yarm.navigation.ground import PlanSettings
from yarm.navigation.planner import Field
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena, BlockKind

CELL_M = 0.05
RADIUS_M = 0.20
"""Of the disc, as the platform's navigation has it."""
KEPT = 600
"""Searches that are kept; the map does not change."""
ARRIVE_M, ARRIVE_RAD = 0.04, 0.05
"""A goal is reached within these."""
BODY_M = 0.22
"""Half width of the strip ahead that is looked at for what is near."""


def known_map(arena: Arena, boxes: bool = True) -> GridMap:
    """The walls, and the boxes if wanted, as they are given, in cells."""
    margin = 0.1
    origin = Pose2(arena.lower[0] - margin, arena.lower[1] - margin)
    counts = [round((high - low + 2 * margin) / CELL_M) for low, high in zip(arena.lower, arena.upper)]
    cells = np.zeros((counts[1], counts[0]), np.int8)
    grid = GridMap(cells, CELL_M, origin)
    rows, columns = np.indices(cells.shape)
    centres = grid.centres_of(np.stack([rows.ravel(), columns.ravel()], axis=1))
    # A cell counts as a body's when its middle is within half a cell of it.
    near = (
        FlatBoxes([b for b in arena.blocks if boxes or b.kind != BlockKind.BOX]).signed(centres).min(axis=1)
        <= 0.5 * CELL_M
    )
    cells[near.reshape(cells.shape)] = 100
    return grid


class Ways:
    """Lengths of ways over a map that does not change."""

    def __init__(self, grid: GridMap) -> None:
        """Nothing searched yet."""
        self.grid = grid
        self._fields: Dict[Tuple[int, int], Field] = {}
        self._room_m = clearance(grid)

    def gap(self, x: float, y: float) -> float:
        """From a point to the nearest body, metres; 0 outside the map."""
        cell = self.grid.cell_of(x, y)
        return float(self._room_m[cell]) if self.grid.inside(*cell) else 0.0

    def field(self, start: Pose2) -> Field:
        """The search from a place; places in one cell share one."""
        cell = self.grid.cell_of(start.x, start.y)
        if cell not in self._fields:
            if len(self._fields) >= KEPT:
                self._fields.clear()
            self._fields[cell] = Field(self.grid, start, PlanSettings(radius_m=RADIUS_M))
        return self._fields[cell]

    def lengths(self, start: Pose2, goals: Sequence[Pose2]) -> FloatArray:
        """(n,) metres to each goal; inf without a way."""
        field = self.field(start)
        found = np.full(len(goals), math.inf)
        for i, goal in enumerate(goals):
            cell = self.grid.cell_of(goal.x, goal.y)
            if field.reachable(cell):
                found[i] = field.length[cell]
        return found


class Pilot:
    """Drives to one goal at a time."""

    def __init__(self, ways: Ways, tick_s: float, arrive_rad: float = ARRIVE_RAD) -> None:
        """Standing.

        Args:
            ways: over the known map.
            tick_s: from one step to the next.
            arrive_rad: a goal is reached within this of its heading.
        """
        self._ways = ways
        self._follower = PathFollower(FollowSettings(arrive_m=ARRIVE_M, arrive_rad=arrive_rad, tick_s=tick_s))

    def go(self, here: Pose2, goal: Pose2) -> str:
        """Set out; why not, or empty."""
        cell = self._ways.grid.cell_of(goal.x, goal.y)
        field = Field(self._ways.grid, here, PlanSettings(radius_m=RADIUS_M))
        path = field.path_to(cell) if field.reachable(cell) else np.zeros((0, 2))
        if len(path) == 0:
            return field.reason or f"no way to ({goal.x:.2f}, {goal.y:.2f}) for a disc of {RADIUS_M:g} m"
        path[-1] = (goal.x, goal.y)
        self._follower.follow(path, goal.yaw_rad)
        return ""

    def stop(self) -> None:
        """Drop the goal."""
        self._follower.stop()

    def step(self, believed: Pose2, world: KinematicWorld) -> Tuple[float, float, bool]:
        """Speeds ahead and of turning for this tick, and whether the goal is reached."""
        ahead = room_ahead(world.scan().points(), BODY_M)
        drive = self._follower.step(believed, ahead)
        return drive.v_mps, drive.w_radps, drive.arrived
