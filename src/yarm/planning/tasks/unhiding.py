"""Idle robots that hide what a goal needs are sent aside, so that the cameras see it.

Where a robot would hide nothing cannot be told without the cameras: it leaves the place it has and the cells it hides,
and the next map shows what came of it (docs/planning.md, "What no camera sees").
"""

from __future__ import annotations

from dataclasses import replace
from typing import Dict, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.planning.model.types import Goal, PlanRequest, without_things

MOST_ASKED = 3
"""Times that a robot is sent aside for one goal: it may hide the same cells from its new place."""
AWAY_COLUMNS = 2
"""So many columns a robot leaves about itself and what it hides, besides."""


class Unhiding:
    """Who was sent aside for which goal."""

    def __init__(self) -> None:
        """Nobody."""
        self._asked: Dict[Tuple[str, str], int] = {}

    @staticmethod
    def without(request: PlanRequest, hidden: str, goals: Mapping[str, Goal]) -> PlanRequest:
        """A request with some goals as if the cells that one of its objects names were seen, and nothing in them."""
        things = request.objects
        occupied = without_things(request.spec, request.occupied, things, [hidden] if hidden in things else [])
        left = {name: cells for name, cells in things.items() if name != hidden}
        return replace(request, occupied=occupied, objects=left, goals=goals, assignments={})

    def needing(self, robot: str, goals: Sequence[Goal]) -> Optional[str]:
        """The first of some goals that a robot has not been sent aside for too often; None when there is none."""
        return next((goal.name for goal in goals if self._asked.get((robot, goal.name), 0) < MOST_ASKED), None)

    def ask(self, robot: str, goal: str) -> None:
        """The robot is sent aside for a goal."""
        self._asked[robot, goal] = self._asked.get((robot, goal), 0) + 1

    @staticmethod
    def columns(request: PlanRequest, robot: str, hidden: str) -> BoolArray:
        """(gx, gy) columns that a robot is to leave: where it stands, what it hides, and some about them."""
        own = next(one.cells for one in request.robots if one.name == robot)
        cells: IntArray = np.concatenate([own, request.objects.get(hidden, own)])
        inside = cells[request.spec.contains(cells)]
        columns = np.zeros(request.spec.shape[:2], dtype=np.bool_)
        for x, y in np.unique(inside[:, :2], axis=0):
            low_x, low_y = max(0, x - AWAY_COLUMNS), max(0, y - AWAY_COLUMNS)
            columns[low_x : x + AWAY_COLUMNS + 1, low_y : y + AWAY_COLUMNS + 1] = True
        return columns
