"""The report's frontier mode: when the map hardly grows it draws a frontier cell and drives there."""

from __future__ import annotations

from typing import List, Optional, Tuple

import numpy as np

from yarm.exploration.model import Command, Detail, Event, FrontierView, Intent
from yarm.exploration.report.follow import CellFollower
from yarm.exploration.report.frontiers import Frontier, Reach, cropped, frontiers, padded, with_probabilities
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import View
from yarm.geometry import FloatArray
from yarm.navigation.grid_map import GridMap

Details = Tuple[Tuple[str, Detail], ...]


class FrontierMode:
    """Due when the known area has grown too little over a window; ends at the frontier, or after too many aborts."""

    name = "frontier"

    def __init__(self, params: ReportParams, rng: np.random.Generator, events: List[Event]) -> None:
        """Draw from ``rng``; write frontiers and aborts to ``events``."""
        self._params = params
        self._rng = rng
        self._events = events
        self._checked_s = 0.0
        self._known_m2 = 0.0
        self._due = False
        self._retry_s = 0.0
        self._target: Optional[FloatArray] = None
        self._follower: Optional[CellFollower] = None
        self._aborts = 0
        self._began_s = 0.0
        self.intent = Intent()

    def step(self, view: View) -> Optional[Command]:
        """Drive to the frontier, or None when none is due or reachable."""
        self._look_at_growth(view)
        pose = view.observation.pose
        if not self._due or pose is None or view.observation.map is None:
            return None
        if self._follower is not None and self._must_abort(view):
            self._abort(view)
        if not self._due or (self._follower is None and not self._plan(view)):
            return None
        if self._follower is None:
            return None
        command = self._follower.step(pose)
        if command is None:
            self._note(view, "reached")
            self._end()
        return command

    def bumped(self, view: View) -> None:
        """The bumper was hit on the way: that is an abort."""
        if self._follower is not None:
            self._abort(view)

    def _look_at_growth(self, view: View) -> None:
        if view.now_s - self._checked_s < self._params.growth_window - 1e-6 or view.observation.map is None:
            return
        known = view.observation.map.known_m2
        if not self._due and known - self._known_m2 < self._params.growth_least:
            self._due, self._retry_s = True, view.now_s
        self._checked_s, self._known_m2 = view.now_s, known

    def _must_abort(self, view: View) -> bool:
        late = view.now_s - self._began_s > self._params.attempt
        return late or view.room.centre < self._params.stop_distance

    def _abort(self, view: View) -> None:
        self._follower = None
        self._aborts += 1
        self._note(view, "abort")
        if self._aborts > self._params.aborts:
            self._note(view, "false")
            self._end()

    def _end(self) -> None:
        self._due, self._target, self._follower, self._aborts = False, None, None, 0
        self.intent = Intent()

    def _note(self, view: View, what: str) -> None:
        self._events.append(Event(view.now_s, "frontier", (("what", what), ("aborts", self._aborts))))

    def _plan(self, view: View) -> bool:
        """Find a way to the target, or draw a target; False when there is none."""
        if view.now_s < self._retry_s - 1e-6:
            return False
        pose, room = view.observation.pose, view.observation.map
        small = None if room is None else cropped(room, self._params.border)
        if pose is None or small is None:
            return False
        robot = small.cell_of(pose.x, pose.y)
        if not small.inside(*robot):
            self._retry_s = view.now_s + self._params.retry
            return False
        cells = padded(small, self._params.padding, self._params.speck, self._params.speck_window)
        reach = Reach(cells, robot)
        if self._target is not None:
            row, column = small.cell_of(float(self._target[0]), float(self._target[1]))
        else:
            every = frontiers(cells, robot, self._params)
            found = [f for f in every if np.isfinite(reach.distance(f.row, f.column))]
            found = with_probabilities(found, self._params.draw_least)
            chosen = self._draw(view, found)
            if chosen is None:
                self._retry_s = view.now_s + self._params.retry
                return False
            self._list(view, small, every, found)
            row, column = chosen.row, chosen.column
            self._target = np.array(small.centre_of(row, column))
            self.intent = Intent(
                frontiers=tuple(FrontierView(*small.centre_of(f.row, f.column), f.fitness) for f in found)
            )
        if not small.inside(row, column) or not np.isfinite(reach.distance(row, column)):
            self._abort(view)
            return False
        path = small.centres_of(reach.path(row, column))
        self._follower = CellFollower(path, small.resolution_m, self._params)
        self._began_s = view.now_s
        self.intent = Intent(path=path, frontiers=self.intent.frontiers)
        return True

    def _draw(self, view: View, candidates: List[Frontier]) -> Optional[Frontier]:
        if not candidates:
            return None
        chosen = candidates[int(self._rng.choice(len(candidates), p=[f.probability for f in candidates]))]
        drawn: Details = (("what", "drawn"), ("of", len(candidates)))
        self._events.append(Event(view.now_s, "frontier", drawn + _numbers(chosen)))
        return chosen

    def _list(self, view: View, room: GridMap, every: List[Frontier], reachable: List[Frontier]) -> None:
        """Note what there was to draw from; the probability is 0 of those that no way leads to."""
        share = {(f.row, f.column): f for f in reachable}
        for frontier in every:
            x, y = room.centre_of(frontier.row, frontier.column)
            place: Details = (("x", round(x, 3)), ("y", round(y, 3)))
            numbers = _numbers(share.get((frontier.row, frontier.column), frontier))
            self._events.append(Event(view.now_s, "candidate", place + numbers))


def _numbers(frontier: Frontier) -> Details:
    """Distance, information, obstacles, fitness and probability by the report's letters."""
    return (
        ("d", round(frontier.distance, 3)),
        ("I", frontier.unknown),
        ("W", frontier.obstacles),
        ("R", round(frontier.fitness, 3)),
        ("P", round(frontier.probability, 6)),
    )
