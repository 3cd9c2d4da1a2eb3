"""Next best view: of the poses that the robot can reach, the one that shows most new ground for its time."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Optional, Tuple

import numpy as np
from scipy import ndimage

from yarm.exploration.frontiers import beside
from yarm.exploration.views import Look, Views, ViewSettings, sweeps
from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.navigation.planner import Cell, Field


@dataclass(frozen=True)
class ChoiceSettings:
    """How views are compared.

    Attributes:
        candidates: places that are looked at closely in one pass.
        lattice: every so many cells a place is considered.
        around_m: places within about this of a frontier are considered.
        turns_deg: turns after arrival that are considered.
        speed_mps: that drives are reckoned with; a little below the greatest.
        turn_radps: that turns are reckoned with.
        settle_s: every goal costs so much more.
        least_cells: a view must show so many cells.
        weighed: of so many of the best places, and as many of those that show most, what is seen under way counts too.
        every_m: under way the robot looks ahead this often.
        view: the camera.
    """

    candidates: int = 64
    lattice: int = 3
    around_m: float = 1.0
    turns_deg: Tuple[float, ...] = (0.0, 30.0, -30.0, 60.0, -60.0, 90.0, -90.0, 120.0, -120.0, 150.0, -150.0)
    speed_mps: float = 0.27
    turn_radps: float = 1.6
    settle_s: float = 0.7
    least_cells: float = 6.0
    weighed: int = 4
    every_m: float = 0.5
    view: ViewSettings = field(default_factory=ViewSettings)


@dataclass(frozen=True)
class View:
    """A place to look from.

    Attributes:
        x: its place in the map, metres.
        y: its place in the map, metres.
        heading_rad: at arrival, map frame.
        yaw_rad: at the end, after the turn.
        cells: how many cells it would newly show.
        time_s: what it takes to be there and to have turned.
        rate: new cells a second, with what is seen under way.
    """

    x: float
    y: float
    heading_rad: float
    yaw_rad: float
    cells: float
    time_s: float
    rate: float


class Choice:
    """One comparison: a field of ways, what seeing each cell is worth, and where the robot is."""

    def __init__(self, field: Field, pose: Pose2, worth: FloatArray, settings: Optional[ChoiceSettings] = None) -> None:
        """Prepare.

        Args:
            field: ways from about the robot's pose.
            pose: of the robot in the map.
            worth: (rows, columns) 1 for each cell that is worth seeing, 0 elsewhere.
            settings: how.
        """
        self._settings = settings or ChoiceSettings()
        self._field, self._pose = field, pose
        self._own_cell = field.grid_map.cell_of(pose.x, pose.y)
        self._worth = worth
        self.views = Views(field.grid_map, worth, field.room_m, self._settings.view)
        self._turns = np.radians(self._settings.turns_deg)

    def likely(self) -> IntArray:
        """(n, 2) places near frontiers, the nearest and those with the longest frontiers first; the robot's own too."""
        s, grid_map = self._settings, self._field.grid_map
        frontier = grid_map.free & beside(self._worth > 0.0)
        width = 2 * int(s.around_m / grid_map.resolution_m) + 1
        density = ndimage.uniform_filter(frontier.astype(np.float32), width, mode="constant")
        cells = np.argwhere(self._on_lattice() & (density > 0.5 / width**2))
        if len(cells) > s.candidates:
            cost = self._field.cost[cells[:, 0], cells[:, 1]]
            rank = density[cells[:, 0], cells[:, 1]] / (cost / s.speed_mps + 4.0)
            cells = cells[np.argsort(-rank, kind="stable")[: s.candidates]]
        return np.concatenate([self._own(), cells])

    def everywhere(self) -> FloatArray:
        """(n, 2) all places of the lattice that the disc can get to, map frame, metres."""
        return self._field.grid_map.centres_of(np.concatenate([self._own(), np.argwhere(self._on_lattice())]))

    def reachable(self, points: FloatArray) -> IntArray:
        """(m, 2) cells of points (n, 2) of the map frame, metres, those that the disc can get to."""
        cells = self._field.grid_map.cells_of(points)
        kept: IntArray = cells[[self._field.reachable((int(row), int(column))) for row, column in cells]]
        return kept

    def best(self, cells: IntArray) -> Optional[View]:
        """The view of the highest rate from places (n, 2) that the disc can get to; None when none shows enough."""
        if len(cells) == 0:
            return None
        seen, times, heading = self._rated(cells)
        rates = np.where(seen >= self._settings.least_cells, seen / times, 0.0)
        turns = np.argmax(rates, axis=1)
        places = np.arange(len(cells))
        best = rates[places, turns]
        if best.max() <= 0.0:
            return None
        shown = np.where(best > 0.0, seen[places, turns], 0.0)
        count = self._settings.weighed
        kept = sorted({*np.argsort(-best, kind="stable")[:count], *np.argsort(-shown, kind="stable")[:count]})
        kept = [i for i in kept if best[i] > 0.0]
        views = self._views(cells[kept], heading[kept], self._turns[turns[kept]], shown[kept], times[kept, turns[kept]])
        return max(views, key=lambda view: view.rate)

    def _views(
        self, cells: IntArray, headings: FloatArray, turns: FloatArray, shown: FloatArray, times: FloatArray
    ) -> List[View]:
        """Views from cells (n, 2), each with all that is seen on the way to it.

        Args:
            cells: (n, 2) places.
            headings: (n,) at arrival, radians.
            turns: (n,) after it, radians.
            shown: (n,) cells that are seen by the turn.
            times: (n,) seconds until it is over.
        """
        tours: List[List[Look]] = []
        for cell, heading, turn in zip(cells, headings, turns):
            at = (int(cell[0]), int(cell[1]))
            places, ahead = self._field.places_on_way(at, self._settings.every_m)
            under_way = [((int(row), int(column)), float(yaw), 0.0) for (row, column), yaw in zip(places, ahead)]
            tours.append([(at, float(heading), float(turn)), *under_way])
        views = []
        for i, seen in enumerate(self.views.together(tours)):
            x, y = self._field.grid_map.centre_of(*tours[i][0][0])
            heading, time_s = float(headings[i]), float(times[i])
            views.append(View(x, y, heading, heading + float(turns[i]), float(shown[i]), time_s, float(seen) / time_s))
        return views

    def again(self, view: View) -> Optional[View]:
        """A view that was chosen before, as it is worth now; None when the robot can no longer get there."""
        cell = self._field.grid_map.cell_of(view.x, view.y)
        if not self._field.reachable(cell):
            return None
        headings, times = self._arrival(np.array([cell]))
        heading = float(headings[0])
        turn = math.remainder(view.yaw_rad - heading, 2.0 * math.pi)
        time_s = float(times[0]) + abs(turn) / self._settings.turn_radps
        shown = self._shown(cell, heading, turn)
        one = [np.array([value]) for value in (heading, turn, shown, time_s)]
        return self._views(np.array([cell]), *one)[0]

    def left(self, view: View) -> float:
        """How many cells a view would still show from its place; 0 where the disc touches something.

        Ways are not searched for, so the robot is taken to arrive there as it was to when the view was chosen.
        """
        cell = self._field.grid_map.cell_of(view.x, view.y)
        if not self._field.grid_map.inside(*cell) or not self._field.passable[cell]:
            return 0.0
        heading = self._pose.yaw_rad if cell == self._own_cell else view.heading_rad
        return self._shown(cell, heading, math.remainder(view.yaw_rad - heading, 2.0 * math.pi))

    def _shown(self, cell: Cell, heading: float, turn: float) -> float:
        gains = self.views.gains(np.array([cell]))
        seen = sweeps(gains, np.array([heading]), np.array([turn]), self._settings.view.fov_rad)
        return max(float(seen[0, 0]), 0.0)

    def _rated(self, cells: IntArray) -> Tuple[FloatArray, FloatArray, FloatArray]:
        """(n, turns) cells that are seen, (n, turns) seconds, (n,) heading at arrival."""
        gains = self.views.gains(cells)
        heading, times = self._arrival(cells)
        seen = sweeps(gains, heading, self._turns, self._settings.view.fov_rad)
        here = np.all(cells == self._own_cell, axis=1)
        seen[here] -= seen[here, :1]  # what it is looking at already
        whole = times[:, None] + np.abs(self._turns)[None, :] / self._settings.turn_radps
        return seen, whole, heading

    def _arrival(self, cells: IntArray) -> Tuple[FloatArray, FloatArray]:
        """(n,) heading at arrival and seconds until then, with the turn at the start."""
        s, yaw = self._settings, self._pose.yaw_rad
        first = self._field.first_bearings(cells)
        last = self._field.last_bearings(cells)
        here = np.isnan(first) | np.isnan(last)
        turn = np.remainder(np.where(here, yaw, first) - yaw + np.pi, 2.0 * np.pi) - np.pi
        cost = np.where(here, 0.0, self._field.cost[cells[:, 0], cells[:, 1]])
        times: FloatArray = np.abs(turn) / s.turn_radps + cost / s.speed_mps + s.settle_s
        return np.where(here, yaw, last), times

    def _on_lattice(self) -> BoolArray:
        chosen = np.zeros(self._field.cost.shape, bool)
        chosen[:: self._settings.lattice, :: self._settings.lattice] = True
        on_lattice: BoolArray = chosen & np.isfinite(self._field.cost)
        return on_lattice

    def _own(self) -> IntArray:
        own: List[Cell] = [self._own_cell] if self._field.reachable(self._own_cell) else []
        return np.array(own, np.int64).reshape(-1, 2)
