"""Explores as the package explore_lite does over move_base: frontiers by size and distance, goals at centroids."""

from __future__ import annotations

from dataclasses import replace
from typing import List, Optional, Tuple

import numpy as np
from scipy import ndimage

from yarm.exploration.driver import Driver, DriverSettings, Drives
from yarm.exploration.frontiers import Frontier, beside, frontiers_of
from yarm.exploration.model import Event, FrontierView, Intent, Observation, Step
from yarm.exploration.move_base import MoveBase
from yarm.exploration.params import ExploreParams
from yarm.geometry import FloatArray, Pose2
from yarm.navigation.grid_map import GridMap

BLACKLIST_CELLS = 5
"""A frontier whose centroid is nearer than this to a blacklisted one, along both axes, is blacklisted."""
GOAL_YAW_RAD = 0.0
"""Goals have the map's own orientation."""
PLATFORM = DriverSettings(unknown_passable=True, cautious=False, arrive_m=0.15, arrive_rad=0.3, blocked_s=3.0)
"""Ways over unknown ground, and the platform's goal tolerances and controller_patience."""


class ExploreLiteController:
    """The controller ``explore_lite``."""

    def __init__(self, params: ExploreParams, seed: int) -> None:
        """Nothing is drawn by chance; the seed is not used."""
        self._params = params
        self._driver = Driver(params, PLATFORM)
        self._move_base = MoveBase(self._driver)
        self._blacklist: List[Tuple[float, float]] = []
        self._goal: Optional[Tuple[float, float]] = None
        self._distance_m = 0.0
        self._progress_s = 0.0
        self._planned_s = -1e9
        self._frontiers: Tuple[FrontierView, ...] = ()
        self._end: Optional[Step] = None

    def step(self, observation: Observation) -> Step:
        """One pass of the loop."""
        if self._end is not None:
            return self._end
        grid_map, pose, now_s = self._driver.sense(observation), observation.pose, observation.now_s
        if grid_map is None or pose is None:
            self._move_base.cancel()
            self._goal = None
            return Step(behaviour="wait", reason="there is no map or no pose yet")
        driven = self._move_base.step(observation)
        events = list(driven.events)
        ended = driven.state in (Drives.ARRIVED, Drives.FAILED)
        if ended:
            events.append(Event(now_s, "arrived" if driven.state is Drives.ARRIVED else "abort"))
            if driven.state is Drives.FAILED and self._goal is not None:
                self._blacklist.append(self._goal)
        due = now_s - self._planned_s >= 1.0 / self._params.planner_frequency - 1e-6
        if driven.state is not Drives.BACKING and (ended or due):
            self._planned_s = now_s
            events += self._make_plan(grid_map, pose, now_s)
            if self._end is not None:
                return replace(self._end, events=tuple(events))
        behaviour = "back off" if driven.state is Drives.BACKING else "drive"
        return Step(driven.command, behaviour, tuple(events), intent=self._intent())

    def _make_plan(self, grid_map: GridMap, pose: Pose2, now_s: float) -> List[Event]:
        """The cheapest frontier that is not blacklisted becomes the goal."""
        events: List[Event] = []
        while True:
            chosen = self._cheapest(grid_map, pose)
            if chosen is None:
                self._move_base.cancel()
                reason = f"no frontier is left; {len(self._blacklist)} blacklisted"
                self._end = Step(behaviour="stand", done=True, reason=reason, intent=self._intent())
                return [*events, Event(now_s, "done")]
            frontier, distance_m = chosen
            target = (frontier.x, frontier.y)
            same = target == self._goal
            if not same or distance_m < self._distance_m:
                self._distance_m, self._progress_s = distance_m, now_s
            if now_s - self._progress_s > self._params.progress_timeout:
                self._blacklist.append(target)
                events.append(Event(now_s, "blacklist", (("x", target[0]), ("y", target[1]))))
                self._progress_s = now_s
                continue
            if not same:
                self._goal = target
                self._move_base.send(Pose2(*target, GOAL_YAW_RAD))
                events.append(Event(now_s, "goal", (("x", target[0]), ("y", target[1]))))
            return events

    def _cheapest(self, grid_map: GridMap, pose: Pose2) -> Optional[Tuple[Frontier, float]]:
        """The frontier of least cost and its least distance, metres."""
        rated = []
        for frontier in self._reached(grid_map, pose):
            apart: FloatArray = grid_map.centres_of(frontier.cells) - (pose.x, pose.y)
            distance_m = float(np.hypot(apart[:, 0], apart[:, 1]).min())
            cost = self._params.potential_scale * distance_m * grid_map.resolution_m
            cost -= self._params.gain_scale * len(frontier.cells) * grid_map.resolution_m
            rated.append((cost, frontier, distance_m))
        rated.sort(key=lambda entry: entry[0])
        listed = [self._is_blacklisted(entry[1], grid_map) for entry in rated]
        self._frontiers = tuple(
            FrontierView(frontier.x, frontier.y, -cost, "blacklisted" if out else "")
            for (cost, frontier, _), out in zip(rated, listed)
        )
        return next(((frontier, d) for (_, frontier, d), out in zip(rated, listed) if not out), None)

    def _reached(self, grid_map: GridMap, pose: Pose2) -> List[Frontier]:
        """Frontiers beside the free ground that is connected to the robot, those long enough."""
        parts, _ = ndimage.label(grid_map.free)
        row, column = grid_map.cell_of(pose.x, pose.y)
        free = np.argwhere(parts > 0)
        if len(free) == 0:
            return []
        nearest = free[np.argmin(np.hypot(free[:, 0] - row, free[:, 1] - column))]
        connected = parts == parts[nearest[0], nearest[1]]
        frontiers = frontiers_of(grid_map, grid_map.unknown & beside(connected))
        least = self._params.min_frontier_size / grid_map.resolution_m
        return [frontier for frontier in frontiers if len(frontier.cells) >= least - 1e-9]

    def _is_blacklisted(self, frontier: Frontier, grid_map: GridMap) -> bool:
        reach = BLACKLIST_CELLS * grid_map.resolution_m
        return any(abs(frontier.x - x) < reach and abs(frontier.y - y) < reach for x, y in self._blacklist)

    def _intent(self) -> Intent:
        if self._goal is None:
            return Intent(frontiers=self._frontiers)
        return Intent(Pose2(*self._goal, GOAL_YAW_RAD), self._driver.path, self._frontiers)
