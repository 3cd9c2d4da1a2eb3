"""Explores by driving to the nearest frontier that the disc can get to, and looking at it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import List, Optional, Tuple

import numpy as np
from scipy import ndimage

from yarm.exploration.driver import SAME_PLACE_M, Driver, DriverSettings, Drives
from yarm.exploration.failed import FailedViews
from yarm.exploration.frontiers import Frontier, frontier_cells, frontiers_of
from yarm.exploration.model import Event, FrontierView, Intent, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.geometry import BoolArray, Pose2, wrap_angle
from yarm.navigation.grid_map import GridMap
from yarm.navigation.planner import Cell, Field

LEAST_CELLS = 4
"""Smaller frontiers are left."""
LOOK_M = 0.6
"""A frontier is looked at from this near, or from the nearest place that the disc can get to within it."""
TURNS = 4
"""A look around is so many turns in place; it is taken before giving up, again when the map has grown since."""
GROWN_M2 = 0.25
CAREFUL = DriverSettings()


class NearestController:
    """The controller ``nearest``."""

    def __init__(self, params: ExploreParams, seed: int) -> None:
        """Nothing is drawn by chance; the seed is not used."""
        self._params = params
        self._driver = Driver(params, CAREFUL)
        self._failed = FailedViews(near_change_m=0.3)
        self._goal: Optional[Tuple[Frontier, Pose2]] = None
        self._planned_s = -1e9
        self._map_count = -1
        self._known_m2 = 0.0
        self._turns = 0
        self._frontiers: Tuple[FrontierView, ...] = ()
        self._end: Optional[Step] = None

    def step(self, observation: Observation) -> Step:
        """One pass of the loop."""
        if self._end is not None:
            return self._end
        grid_map, pose, now_s = self._driver.sense(observation), observation.pose, observation.now_s
        if grid_map is None or pose is None:
            self._driver.stop()
            return Step(behaviour="wait", reason="there is no map or no pose yet")
        if observation.map_count != self._map_count:
            self._map_count = observation.map_count
            self._failed.map_changed(grid_map)
            if grid_map.known_m2 > self._known_m2 + GROWN_M2:
                self._known_m2, self._turns = grid_map.known_m2, 0
        driven = self._driver.step(observation)
        events = list(driven.events)
        ended = driven.state in (Drives.ARRIVED, Drives.FAILED)
        if ended and self._goal is not None:
            events.append(Event(now_s, driven.state.value))
            self._failed.add(grid_map, self._goal[0].cells)
            self._goal = None
        due = now_s - self._planned_s >= 1.0 / self._params.planner_frequency - 1e-6
        turning = self._goal is None and driven.state is Drives.DRIVING
        if driven.state is not Drives.BACKING and not turning and (ended or due):
            self._planned_s = now_s
            events += self._choose(pose, now_s)
            if self._end is not None:
                return replace(self._end, events=tuple(events))
        behaviour = "back off" if driven.state is Drives.BACKING else "drive"
        return Step(driven.command, behaviour, tuple(events), intent=self._intent())

    def _choose(self, pose: Pose2, now_s: float) -> List[Event]:
        field = self._driver.field(pose, SAME_PLACE_M)
        best = self._best(field)
        if best is None and not field.reason and self._turns < TURNS:
            return self._look_around(pose, now_s)
        if best is None:
            self._driver.stop()
            reason = field.reason or "no frontier is left that the disc can get to and that was not looked at"
            self._end = Step(behaviour="stand", done=True, reason=reason)
            return [Event(now_s, "done")]
        frontier, cell = best
        x, y = field.grid_map.centre_of(*cell)
        target = frontier.cells[np.argmin(np.hypot(*(frontier.cells - np.array(cell)).T))]
        at = field.grid_map.centre_of(int(target[0]), int(target[1]))
        pose_there = Pose2(x, y, math.atan2(at[1] - y, at[0] - x))
        if self._goal is not None and self._goal[1].distance(pose_there) < field.grid_map.resolution_m:
            return []
        self._goal = (frontier, pose_there)
        events = [Event(now_s, "goal", (("x", x), ("y", y)))]
        refused = self._driver.go(field, cell, pose_there.yaw_rad)
        if refused:
            self._failed.add(field.grid_map, frontier.cells)
            events.append(Event(now_s, "abort", (("reason", refused),)))
            self._goal = None
        return events

    def _look_around(self, pose: Pose2, now_s: float) -> List[Event]:
        """With nothing to drive to, a part of a full turn in place; what failed may be tried again after it."""
        self._turns += 1
        self._failed.clear()
        self._driver.turn(pose, wrap_angle(pose.yaw_rad + 2.0 * math.pi / TURNS))
        return [Event(now_s, "turn")]

    def _best(self, field: Field) -> Optional[Tuple[Frontier, Cell]]:
        """The frontier that the least drive leads to, and the cell to look at it from."""
        grid_map = field.grid_map
        best: Optional[Tuple[Frontier, Cell]] = None
        least = math.inf
        views = []
        for frontier in frontiers_of(grid_map, frontier_cells(grid_map) & ~self._failed.over(grid_map)):
            if len(frontier.cells) < LEAST_CELLS:
                continue
            near = self._around(frontier, grid_map)
            cost = np.where(near, field.cost, np.inf)
            cell = np.unravel_index(int(np.argmin(cost)), cost.shape)
            value = float(cost[cell])
            views.append(FrontierView(frontier.x, frontier.y, -value, "" if math.isfinite(value) else "out of reach"))
            if value < least:
                least, best = value, (frontier, (int(cell[0]), int(cell[1])))
        self._frontiers = tuple(views)
        return best

    @staticmethod
    def _around(frontier: Frontier, grid_map: GridMap) -> BoolArray:
        marked = np.zeros(grid_map.cells.shape, bool)
        marked[frontier.cells[:, 0], frontier.cells[:, 1]] = True
        reach = round(LOOK_M / grid_map.resolution_m)
        around: BoolArray = ndimage.maximum_filter(marked, 2 * reach + 1)
        return around

    def _intent(self) -> Intent:
        if self._goal is None:
            return Intent(frontiers=self._frontiers)
        return Intent(self._goal[1], self._driver.path, self._frontiers)
