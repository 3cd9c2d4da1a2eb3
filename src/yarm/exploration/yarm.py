"""Explores by next best views: new ground for each second of driving and turning; ends with a list of what is left."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import List, Optional, Tuple

import numpy as np
from scipy import ndimage

from yarm.exploration.choice import Choice, ChoiceSettings, View
from yarm.exploration.driver import DISC_M, LOOK_PASSES, Driven, Driver, DriverSettings, Drives
from yarm.exploration.failed import FailedViews
from yarm.exploration.frontiers import frontier_cells, frontiers_of
from yarm.exploration.model import LOOP_S, Event, FrontierView, Intent, Observation, Step
from yarm.exploration.params import ExploreParams
from yarm.exploration.seen import SweptGround
from yarm.exploration.views import Views
from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.navigation.grid_map import GridMap
from yarm.navigation.planner import Field

DRIVING = DriverSettings(
    turn_radps=1.8,
    turn_up_radps2=6.0,
    turn_gain_per_s=4.0,
    speed_up_mps2=1.0,
    foresee_s=0.3,
    drive_below_rad=0.3,
    arrive_m=0.10,
    arrive_rad=0.15,
)
"""Views need no exact poses; a third of the time went into turns on the spot, so these are quick."""
BESIDE_M = 0.05
"""Ways that were searched for from this near are good enough to decide by."""
MOST_LATE_S = 1.0
"""Maps that come in every pass put a decision off by no more than this."""


@dataclass(frozen=True)
class YarmSettings:
    """How it decides.

    Attributes:
        switch: another goal must be this many times as good as the one that is driven to.
        look_s: so often what a goal is to show is looked at again.
        spent: a goal of which less than this share is left is no goal any more.
        map_lag_s: a map shows what was swept until this long before it came.
        near_change_m: what changes in the map brings back failed views within this.
        rounds: how often everything that failed is tried again with nothing else left.
        batch: places looked at in one pass when everything is searched.
        enclosed_s: nothing can be reached for so long: it ends.
        choice: how views are compared.
        driver: how goals are driven to.
    """

    switch: float = 1.5
    look_s: float = 0.3
    spent: float = 0.2
    map_lag_s: float = 1.0
    near_change_m: float = 0.3
    rounds: int = 1
    batch: int = 90
    enclosed_s: float = 3.0
    choice: ChoiceSettings = field(default_factory=ChoiceSettings)
    driver: DriverSettings = DRIVING


class YarmController:
    """The controller ``yarm``."""

    def __init__(self, params: ExploreParams, seed: int, settings: Optional[YarmSettings] = None) -> None:
        """Nothing is drawn by chance; the seed is not used."""
        self._params = params
        self._settings = settings or YarmSettings()
        self._driver = Driver(params, self._settings.driver)
        self._swept = SweptGround(self._settings.choice.view.near_m, self._settings.choice.view.range_m)
        self._failed = FailedViews(self._settings.near_change_m)
        self._goal: Optional[View] = None
        self._decided_s = -1e9
        self._looked_s = -1e9
        self._decided_version = -1
        self._map_came_s = 0.0
        self._map_count = -1
        self._map_is_new = False
        self._passes = 0
        self._search: List[FloatArray] = []
        self._round = 0
        self._known_m2 = 0.0
        self._enclosed_since: Optional[float] = None
        self._frontiers: Tuple[FrontierView, ...] = ()
        self._shown_from: Optional[int] = None
        self._end: Optional[Step] = None

    def step(self, observation: Observation) -> Step:
        """One pass of the loop."""
        if self._end is not None:
            return self._end
        grid_map = self._driver.sense(observation)
        pose = observation.pose
        if grid_map is None or pose is None:
            self._driver.stop()
            return Step(behaviour="wait", reason="there is no map yet" if grid_map is None else "the pose is not known")
        self._note(observation, grid_map, pose)
        driven = self._driver.step(observation)
        events = list(driven.events)
        if driven.state in (Drives.ARRIVED, Drives.FAILED):
            events += self._end_of_goal(driven, observation.now_s, pose)
        if driven.state is not Drives.BACKING and self._due(driven, observation.now_s, pose):
            events += self._decide(observation.now_s, pose)
            if self._end is not None:
                return replace(self._end, events=tuple(events))
            if driven.state is not Drives.DRIVING and self._goal is not None:
                driven = self._driver.step(observation)
                events += driven.events
                if driven.state in (Drives.ARRIVED, Drives.FAILED):
                    events += self._end_of_goal(driven, observation.now_s, pose)
        elif self._shown_from is not None:  # pictures can wait for a pass that decides nothing
            self._frontiers, self._shown_from = self._open(grid_map, self._shown_from), None
        elif driven.state is Drives.DRIVING and driven.command.v_mps == 0.0 and not self._map_is_new:
            self._driver.search_early(pose, BESIDE_M)  # while it turns there is time for the next choice's ways
        return Step(driven.command, self._behaviour(driven), tuple(events), intent=self._intent())

    def _note(self, observation: Observation, grid_map: GridMap, pose: Pose2) -> None:
        if observation.jumped:
            self._goal, self._search = None, []
        self._map_is_new = observation.map_count != self._map_count
        if self._map_is_new:
            self._map_count, self._map_came_s = observation.map_count, observation.now_s
            self._failed.map_changed(grid_map)
            known = grid_map.known_m2
            if known > self._known_m2 + 0.05:
                self._known_m2, self._round = known, 0
        self._passes += 1
        if observation.scan is not None and self._passes % LOOK_PASSES == 2:  # the driver looks in others
            self._swept.see(pose, observation.scan, observation.now_s)

    def _due(self, driven: Driven, now_s: float, pose: Pose2) -> bool:
        """Whether to decide in this pass; while it drives, the one with a new map only finds the ways."""
        if driven.state is not Drives.DRIVING or self._goal is None:
            return True
        waited_s = now_s - self._decided_s - 1.0 / self._params.planner_frequency
        if self._map_is_new and waited_s < MOST_LATE_S:
            if waited_s >= -LOOP_S:
                self._driver.field(pose, BESIDE_M).search()
            return False
        if waited_s >= -1e-6 and self._decided_version != self._driver.version:
            return True
        if now_s - self._looked_s < self._settings.look_s - 1e-6:
            return False
        self._looked_s = now_s
        return self._gone(self._goal, pose)

    def _gone(self, goal: View, pose: Pose2) -> bool:
        """Whether hardly anything is left of what the goal was to show."""
        field = self._driver.field(pose)
        left = Choice(field, pose, self._worth(field.grid_map), self._settings.choice).left(goal)
        return left < max(self._settings.choice.least_cells, self._settings.spent * goal.cells)

    def _end_of_goal(self, driven: Driven, now_s: float, pose: Pose2) -> List[Event]:
        """What was to be seen from the goal counts as tried: it comes back when the map near it changes, or last."""
        arrived = driven.state is Drives.ARRIVED
        events = [Event(now_s, "arrived" if arrived else "abort", () if arrived else (("reason", driven.reason),))]
        goal, self._goal = self._goal, None
        if goal is not None:
            self._fail(goal, self._driver.field(pose))
        return events

    def _fail(self, goal: View, field: Field) -> None:
        grid_map = field.grid_map
        views = Views(grid_map, self._worth(grid_map), field.room_m, self._settings.choice.view)
        turn = wrap_angle(goal.yaw_rad - goal.heading_rad)
        cell = grid_map.cell_of(goal.x, goal.y)
        if grid_map.inside(*cell):
            self._failed.add(grid_map, views.shown(cell, goal.heading_rad, turn))

    def _worth(self, grid_map: GridMap) -> FloatArray:
        since = self._map_came_s - self._settings.map_lag_s
        worth = grid_map.unknown & ~self._swept.over(grid_map, since) & ~self._failed.over(grid_map)
        return worth.astype(float)

    def _decide(self, now_s: float, pose: Pose2) -> List[Event]:
        self._decided_s, self._decided_version = now_s, self._driver.version
        field = self._driver.field(pose, BESIDE_M)
        if field.reason:
            return self._enclosed(now_s, field.reason)
        self._enclosed_since = None
        choice = Choice(field, pose, self._worth(field.grid_map), self._settings.choice)
        view = self._best(choice)
        if view is None and not self._search:
            return self._nothing_left(field, now_s)
        self._shown_from = 1 if view is None else int(self._settings.choice.least_cells)
        if view is None:
            return []
        if self._goal is not None:
            kept = choice.again(self._goal)
            least = self._settings.choice.least_cells
            if (
                kept is not None
                and kept.cells >= max(least, self._settings.spent * self._goal.cells)
                and view.rate < self._settings.switch * kept.rate
            ):
                return []
        return self._go(field, view, pose, now_s)

    def _best(self, choice: Choice) -> Optional[View]:
        """Among likely places at once; when none is left, among all, a batch a pass."""
        if not self._search:
            view = choice.best(choice.likely())
            if view is not None:
                return view
            points = choice.everywhere()
            count = max(1, -(-len(points) // self._settings.batch))
            self._search = [np.zeros((0, 2)), *np.array_split(points, count)]
        self._search.pop(0)
        if not self._search:
            return None
        view = choice.best(choice.reachable(self._search[0]))
        if view is not None:
            self._search = []
        return view

    def _go(self, field: Field, view: View, pose: Pose2, now_s: float) -> List[Event]:
        self._goal = view
        self._search = []
        own = field.grid_map.cell_of(pose.x, pose.y)
        cell = field.grid_map.cell_of(view.x, view.y)
        if cell == own:
            self._driver.turn(pose, view.yaw_rad)
            refused = ""
        else:
            refused = self._driver.go(field, cell, view.yaw_rad)
        details = (("x", view.x), ("y", view.y), ("yaw", view.yaw_rad), ("cells", view.cells), ("seconds", view.time_s))
        events = [Event(now_s, "goal", details)]
        if refused:
            events.append(Event(now_s, "abort", (("reason", refused),)))
            self._fail(view, field)
            self._goal = None
            self._driver.stop()
        return events

    def _enclosed(self, now_s: float, reason: str) -> List[Event]:
        self._driver.stop()
        if self._enclosed_since is None:
            self._enclosed_since = now_s
        if now_s - self._enclosed_since >= self._settings.enclosed_s:
            self._end = Step(behaviour="stand", done=True, reason=reason)
            return [Event(now_s, "done")]
        return []

    def _nothing_left(self, field: Field, now_s: float) -> List[Event]:
        """Tries what failed once more; then it is over."""
        if self._round < self._settings.rounds and self._failed.any():
            self._round += 1
            self._failed.clear()
            return [Event(now_s, "again", (("round", self._round),))]
        self._frontiers = self._left(field)
        text = "; ".join(f"({f.x:.2f}, {f.y:.2f}): {f.refused}" for f in self._frontiers)
        events = [Event(now_s, "left", (("x", f.x), ("y", f.y), ("reason", f.refused))) for f in self._frontiers]
        reason = "nothing is left to map" + (f" but what cannot be seen: {text}" if text else "")
        self._end = Step(behaviour="stand", done=True, reason=reason, intent=self._intent())
        return [*events, Event(now_s, "done", (("left", len(self._frontiers)),))]

    def _open(self, grid_map: GridMap, least: int) -> Tuple[FrontierView, ...]:
        """Frontiers of so many cells or more, for pictures; their score is their length in metres."""
        failed = self._failed.over(grid_map)
        views = []
        for frontier in frontiers_of(grid_map, frontier_cells(grid_map)):
            if len(frontier.cells) >= least:
                waits = failed[frontier.cells[:, 0], frontier.cells[:, 1]].any()
                score = len(frontier.cells) * grid_map.resolution_m
                refused = "looked at in vain; again when the map changes here, or last" if waits else ""
                views.append(FrontierView(frontier.x, frontier.y, score, refused))
        return tuple(views)

    def _left(self, field: Field) -> Tuple[FrontierView, ...]:
        """Every frontier that remains, and why."""
        grid_map = field.grid_map
        failed = self._failed.over(grid_map)
        reached = ndimage.binary_dilation(np.isfinite(field.cost), iterations=8)
        views = []
        for frontier in frontiers_of(grid_map, frontier_cells(grid_map)):
            rows, columns = frontier.cells[:, 0], frontier.cells[:, 1]
            if failed[rows, columns].any():
                why = "looked at from every place that shows it, and still not known"
            elif reached[rows, columns].any():
                why = f"{len(frontier.cells)} cells, fewer than a view must show"
            else:
                why = f"no place that a disc of {DISC_M:g} m can get to is near"
            views.append(FrontierView(frontier.x, frontier.y, 0.0, why))
        return tuple(views)

    def _behaviour(self, driven: Driven) -> str:
        if driven.state is Drives.BACKING:
            return "back off"
        if driven.state is not Drives.DRIVING:
            return "choose"
        return "drive" if driven.command.v_mps != 0.0 else "turn"

    def _intent(self) -> Intent:
        if self._goal is None:
            return Intent(frontiers=self._frontiers)
        return Intent(Pose2(self._goal.x, self._goal.y, self._goal.yaw_rad), self._driver.path, self._frontiers)
