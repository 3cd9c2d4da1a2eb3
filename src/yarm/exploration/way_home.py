"""Back to where the run began: how much time the way needs, and driving it."""

from __future__ import annotations

import math
from typing import Optional, Tuple

from yarm.exploration.driver import SAME_PLACE_M, Driven, Driver, Drives
from yarm.exploration.model import Command, Intent, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import Pose2
from yarm.navigation.planner import Cell, Field

ESTIMATE_S = 5.0
"""Between two estimates of the way back."""
SPARE_S = 15.0
"""For turns, and for what comes between."""
ARRIVED_M = 0.10
BESIDE_M = 0.30
"""A start where the disc does not fit, as one against a wall, is come back to within this."""


class WayHome:
    """Drives as the explorers do: ways are checked before and on every new map, bumps are backed off from."""

    def __init__(self, params: ExploreParams) -> None:
        """Nothing planned."""
        self._params = params
        self._driver = Driver(params)
        self._estimated_s = -math.inf
        self._needed_s = 0.0
        self._beside_m = 0.0

    def must_leave(self, seen: Observation, start: Optional[Pose2], left_s: float) -> bool:
        """Whether the time left is only just what the way back needs; looked at every ``ESTIMATE_S``."""
        if seen.map is None or seen.pose is None or start is None:
            return False
        if seen.now_s - self._estimated_s >= ESTIMATE_S:
            self._estimated_s = seen.now_s
            field = Field(seen.map, seen.pose)
            cell, _ = _nearest(field, start)
            if cell is not None:
                self._needed_s = float(field.length[cell]) / self._params.near_speed + SPARE_S
        return left_s <= self._needed_s + ESTIMATE_S

    def step(self, seen: Observation, start: Pose2) -> Step:
        """One pass on the way back; done when there, or when there is no way, which the reason then says."""
        if seen.map is None or seen.pose is None:
            return Step(reason="no map or no pose")
        self._driver.sense(seen)
        driven = self._driver.step(seen)
        if driven.state is not Drives.BACKING and seen.pose.distance(start) <= ARRIVED_M:
            return self._told(driven, start, done=True)
        if driven.state is Drives.ARRIVED:
            return self._told(driven, start, f"{self._beside_m:.2f} m beside the start, as near as the disc gets", True)
        if driven.state in (Drives.IDLE, Drives.FAILED):
            reason = self._plan(seen.pose, start)
            return self._told(driven, start, reason, bool(reason))
        return self._told(driven, start)

    def _plan(self, pose: Pose2, start: Pose2) -> str:
        """Sets off; gives why not, or an empty text."""
        field = self._driver.field(pose, SAME_PLACE_M)
        cell, self._beside_m = _nearest(field, start)
        refused = "the disc cannot get there" if cell is None else self._driver.go(field, cell, None)
        return refused and f"no way back to the start ({start.x:.2f}, {start.y:.2f}): {field.reason or refused}"

    def _told(self, driven: Driven, start: Pose2, reason: str = "", done: bool = False) -> Step:
        command = Command() if done else driven.command
        return Step(command, "return", driven.events, done, reason, Intent(start, self._driver.path))


def _nearest(field: Field, start: Pose2) -> Tuple[Optional[Cell], float]:
    """The cell nearest to the start that the disc gets to and how far off its centre is, m; None beyond BESIDE_M."""
    row, column = field.grid_map.cell_of(start.x, start.y)
    if field.reachable((row, column)):
        return (row, column), 0.0
    reach = math.ceil(BESIDE_M / field.grid_map.resolution_m)
    found: Tuple[Optional[Cell], float] = (None, BESIDE_M)
    for cell in ((row + i, column + j) for i in range(-reach, reach + 1) for j in range(-reach, reach + 1)):
        x, y = field.grid_map.centre_of(*cell)
        away = math.hypot(x - start.x, y - start.y)
        if away < found[1] and field.reachable(cell):
            found = cell, away
    return found
