"""Pauses a manipulator while debris or a mobile robot is near its tool, and lets it go on when the way is clear."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, FrozenSet, List, Optional, Tuple

import numpy as np

from yarm.commander.cell_state import CellState, TrackedRobot
from yarm.commander.events import NOTHING, Action, GoalDone, KeepOff, Level, Log, Outcome
from yarm.commander.goals import Purpose
from yarm.control.actions import ArmAction
from yarm.control.sander.states import SanderState
from yarm.geometry import GridSpec, IntArray
from yarm.planning.model.types import Column, GoalKind

RETRY_S = 0.5
"""A switch that failed is sent again after this long, s."""
NEWS_S = 0.5
"""What a manipulator is to keep off is told again not before this, s."""
STAYS_ON_M, GOES_ON_M = 0.04, 0.01
"""Farther than where it is paused while it sands, and than where it is let go on while it is paused, metres."""


@dataclass(frozen=True)
class Near:
    """What is nearest to a manipulator's tip: its name, and the horizontal distance, metres (inf for nothing)."""

    name: str
    distance_m: float


@dataclass
class _Switch:
    """What was sent to one manipulator: ``wanted`` as sent last, ``applied`` as confirmed, None when unknown.

    ``columns`` are those it was told to keep off.
    """

    wanted: Optional[bool] = None
    applied: Optional[bool] = None
    sent_s: float = -math.inf
    columns: FrozenSet[Column] = frozenset()


def distance_to_cells(spec: GridSpec, point: Tuple[float, float], cells: IntArray) -> float:
    """Horizontal distance from a point, metres, to the nearest of the cells' squares; inf without cells."""
    if len(cells) == 0:
        return math.inf
    size = spec.resolution[:2]
    centres = np.asarray(spec.lower[:2]) + (cells[:, :2] + 0.5) * size
    gap = np.maximum(np.abs(centres - np.asarray(point)) - size / 2.0, 0.0)
    return float(np.hypot(gap[:, 0], gap[:, 1]).min())


def nearest(cell: CellState, tip: Tuple[float, float]) -> Near:
    """The debris or mobile robot nearest to a point, metres, by its known solids or else its cells on the map."""
    found = Near("", math.inf)
    if cell.map is None:
        return found
    candidates: List[Tuple[str, float]] = []
    for debris in cell.of_kind(GoalKind.DEBRIS):
        seed = math.hypot(debris.position_m[0] - tip[0], debris.position_m[1] - tip[1])
        candidates.append((debris.name, min(seed, distance_to_cells(cell.map.spec, tip, debris.cells))))
    for name, robot in sorted(cell.robots.items()):
        candidates.append((name, distance_to_cells(cell.map.spec, tip, robot.cells)))
    for name, distance in candidates:
        if distance < found.distance_m:
            found = Near(name, distance)
    return found


class Supervisor:
    """Sends ON and OFF to every manipulator that is at work, whatever the Commander's state."""

    def __init__(self, cell: CellState) -> None:
        """Supervise the manipulators of a world."""
        self._cell = cell
        self._switches: Dict[str, _Switch] = {}

    def reset(self) -> None:
        """Forget what was sent."""
        self._switches = {}

    def paused(self, manipulator: str) -> bool:
        """The manipulator has confirmed that it is off."""
        return self._switches.get(manipulator, _Switch()).applied is False

    def on_map(self, now_s: float) -> List[Action]:
        """Decide for each manipulator on the newest map."""
        actions: List[Action] = []
        for name in self._cell.manipulators:
            if self._cell.sander.get(name) is not SanderState.SCAN_TO_PATH or name not in self._cell.answers:
                self._switches.pop(name, None)
            else:
                actions += self._decide(name, now_s)
        return actions

    def on_done(self, event: GoalDone) -> List[Action]:
        """A switch goal has ended."""
        switch = self._switches.get(event.robot)
        if switch is None:
            return []
        if event.outcome is Outcome.SUCCEEDED:
            switch.applied = switch.wanted
            return []
        switch.applied = None
        return [Log(Level.WARN, f"{event.robot} was not switched: {event.outcome.value} {event.message}".rstrip())]

    def _decide(self, name: str, now_s: float) -> List[Action]:
        cell = self._cell
        goal = cell.goals.active.get(name)
        seed = cell.map.objects.get(name) if cell.map is not None else None
        if seed is None or not cell.connected & {name} or (goal is not None and goal.purpose is not Purpose.SWITCH):
            return []
        near = nearest(cell, (seed.position_m[0], seed.position_m[1]))
        switch = self._switches.setdefault(name, _Switch())
        if near.distance_m < cell.params.pause_distance_m:
            wanted = False
        elif near.distance_m > cell.params.resume_distance_m:
            wanted = True
        else:
            wanted = bool(switch.wanted)
        settled = switch.applied is wanted or (goal is not None and switch.wanted is wanted)
        columns = self._columns_near(name)
        news = columns != switch.columns and now_s - switch.sent_s >= NEWS_S
        if not news and (settled or (switch.wanted is wanted and now_s - switch.sent_s < RETRY_S)):
            return []
        changed = switch.wanted is not wanted
        switch.wanted, switch.sent_s, switch.columns = wanted, now_s, columns
        what = "nothing near" if not near.name else f"{near.name} at {near.distance_m:.2f} m"
        what = f"{what}; keeps off {len(columns)} columns" if columns else what
        action = ArmAction.ON if wanted else ArmAction.OFF
        order = cell.goals.send(
            name, Purpose.SWITCH, action.value, now_s, why=what, keep_off=self._keep_off(columns, wanted)
        )
        return [Log(Level.INFO, f"{name} {action.value}: {what}"), order] if changed else [order]

    def _columns_near(self, name: str) -> FrozenSet[Column]:
        """Columns about a manipulator's area in which debris or a robot is, or will be when its step ends."""
        cell = self._cell
        if not cell.params.sand_elsewhere or cell.map is None:
            return frozenset()
        spec, debris = cell.map.spec, cell.of_kind(GoalKind.DEBRIS)
        cells = [piece.cells for piece in debris]
        cells += [_on_its_way(cell, robot) for _, robot in sorted(cell.robots.items())]
        seeds = np.array([spec.column_of(piece.position_m) for piece in debris], dtype=np.int64).reshape(-1, 2)
        columns = np.concatenate([seeds, *(found[:, :2] for found in cells)])
        margin = math.ceil(cell.params.resume_distance_m / float(min(spec.resolution[:2])))
        area = cell.private_areas(margin).get(name)
        inside = np.all((columns >= 0) & (columns < np.array(spec.shape[:2])), axis=1)
        columns = columns[inside]
        if area is not None:
            columns = columns[area[tuple(columns.T)]]
        return frozenset((int(x), int(y)) for x, y in columns)

    def _keep_off(self, columns: FrozenSet[Column], is_on: bool) -> KeepOff:
        """Places along the columns' edges; so far from them it is not paused, or once it is, is let go on."""
        if not columns or self._cell.map is None:
            return NOTHING
        spec, params = self._cell.map.spec, self._cell.params
        halves = {(2 * x + i, 2 * y + j) for x, y in columns for i in range(3) for j in range(3)}
        places = np.asarray(spec.lower[:2]) + 0.5 * np.array(sorted(halves)) * spec.resolution[:2]
        distance_m = params.pause_distance_m + STAYS_ON_M if is_on else params.resume_distance_m + GOES_ON_M
        return KeepOff(tuple((float(x), float(y)) for x, y in places), distance_m)


def _on_its_way(cell: CellState, robot: TrackedRobot) -> IntArray:
    """Cells (n, 3) of a robot where it is, and as it is or as it will be turned on its straight way to its target."""
    goal = cell.goals.active.get(robot.name)
    if goal is None or goal.target is None or cell.map is None:
        return robot.cells
    end = cell.map.spec.column_of((goal.target.x, goal.target.y))
    masks = [robot.mask] if robot.mask_at is None else [robot.mask, robot.mask_at(goal.target.yaw_rad)]
    steps = max(abs(end[0] - robot.column[0]), abs(end[1] - robot.column[1]), 1)
    ways = np.rint(np.linspace(robot.column, end, steps + 1)).astype(int).tolist()
    return np.concatenate([mask.at((x, y)) for mask in masks for x, y in ways])
