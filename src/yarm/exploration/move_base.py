"""Goals as move_base drives to them in the field: patience, recovery behaviours, and only then an abort."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import List, Optional, Tuple

from yarm.exploration.driver import SAME_PLACE_M, Driven, Driver, Drives
from yarm.exploration.model import Event, Observation
from yarm.geometry import Pose2, wrap_angle

QUARTERS = 4
"""A turn all around is driven in so many pieces."""


@dataclass(frozen=True)
class Patience:
    """Parameters of move_base by their names there, values of the platform.

    Attributes:
        planner_frequency: Hz; so often a way is searched while there is none.
        planner_patience: s; without a way for longer than this a recovery behaviour comes.
        recovery_behaviors: one after the other, until one helps: clear (costmaps; what is seen is marked again from the
            map at once, so it takes one search) or turn (all around).
        oscillation_distance: m; after moving so far from the last recovery behaviour the first one is next again.
    """

    planner_frequency: float = 1.0
    planner_patience: float = 5.0
    recovery_behaviors: Tuple[str, ...] = ("clear", "turn", "clear", "turn")
    oscillation_distance: float = 0.2


class MoveBase:
    """Owns one goal at a time.

    What the local planner's patience is there, is here the driver's: ``DriverSettings.blocked_s``.
    """

    def __init__(self, driver: Driver, patience: Optional[Patience] = None) -> None:
        """Without a goal.

        Args:
            driver: that drives; its ``sense`` comes before every step.
            patience: how long what is tried.
        """
        self._driver = driver
        self._patience = patience or Patience()
        self._goal: Optional[Pose2] = None
        self._next: Optional[Pose2] = None
        self._recoveries = 0
        self._recovered_at = Pose2(0.0, 0.0)
        self._quarters = 0
        self._way_s = -math.inf
        self._searched_s = -math.inf
        self._events: List[Event] = []

    def send(self, goal: Pose2) -> None:
        """A goal in the map; it replaces the last one, after a turn that has begun."""
        self._next = goal

    def cancel(self) -> None:
        """Stand, without a goal."""
        self._goal = self._next = None
        self._quarters = 0
        self._driver.stop()

    def step(self, observation: Observation) -> Driven:
        """One pass; ARRIVED and FAILED (aborted) end the goal."""
        self._events = []
        driven = self._driver.step(observation)
        if driven.state is Drives.BACKING or observation.pose is None:
            return driven
        driven = self._go_on(driven, observation, observation.pose)
        return replace(driven, events=(*driven.events, *self._events))

    def _go_on(self, driven: Driven, observation: Observation, pose: Pose2) -> Driven:
        if self._quarters:
            return self._turn_on(driven, observation, pose)
        if self._next is not None:
            self._goal, self._next = self._next, None
            self._recoveries = 0
            self._way_s = observation.now_s
            return self._search(driven, observation, pose)
        if self._goal is None or driven.state in (Drives.DRIVING, Drives.ARRIVED):
            self._note(driven, observation.now_s, pose)
            return driven
        if driven.blocked:
            return self._recover(driven.reason, driven, observation.now_s, pose)
        if observation.now_s - self._searched_s < 1.0 / self._patience.planner_frequency - 1e-6:
            return Driven(Drives.DRIVING, events=driven.events)
        return self._search(driven, observation, pose)

    def _note(self, driven: Driven, now_s: float, pose: Pose2) -> None:
        if driven.state is Drives.ARRIVED:
            self._goal = None
        elif driven.state is Drives.DRIVING:
            self._way_s = now_s
            if pose.distance(self._recovered_at) > self._patience.oscillation_distance:
                self._recoveries = 0

    def _search(self, driven: Driven, observation: Observation, pose: Pose2) -> Driven:
        """Looks for a way; the goal is kept without one until the patience is over."""
        assert self._goal is not None
        self._searched_s = observation.now_s
        field = self._driver.field(pose, SAME_PLACE_M)
        cell = field.grid_map.cell_of(self._goal.x, self._goal.y)
        refused = field.reason or self._driver.go(field, cell, self._goal.yaw_rad)
        if not refused and driven.state is Drives.DRIVING:
            return driven
        if not refused:
            again = self._driver.step(observation)
            if again.state is Drives.ARRIVED:
                self._goal = None
            return replace(again, events=(*driven.events, *again.events))
        self._driver.stop()
        if observation.now_s - self._way_s < self._patience.planner_patience - 1e-6:
            return Driven(Drives.DRIVING, events=driven.events)
        return self._recover(refused, driven, observation.now_s, pose)

    def _recover(self, reason: str, driven: Driven, now_s: float, pose: Pose2) -> Driven:
        """The next recovery behaviour; after the last one the abort."""
        if self._recoveries == len(self._patience.recovery_behaviors):
            self._goal = None
            return Driven(Drives.FAILED, reason=reason, events=driven.events)
        behaviour = self._patience.recovery_behaviors[self._recoveries]
        self._events.append(Event(now_s, "recovery", (("behaviour", behaviour), ("reason", reason))))
        self._recoveries += 1
        self._recovered_at, self._way_s = pose, now_s
        if behaviour == "turn":
            self._quarters = QUARTERS
            self._turn(pose)
        return Driven(Drives.DRIVING, events=driven.events)

    def _turn_on(self, driven: Driven, observation: Observation, pose: Pose2) -> Driven:
        """A turn is driven to its end, whatever is sent meanwhile."""
        if driven.state is Drives.DRIVING:
            return driven
        self._quarters -= 1
        self._way_s = observation.now_s
        if self._quarters:
            self._turn(pose)
        return Driven(Drives.DRIVING, events=driven.events)

    def _turn(self, pose: Pose2) -> None:
        self._driver.turn(pose, wrap_angle(pose.yaw_rad + 2.0 * math.pi / QUARTERS))
