"""One way from a pose to a pose, checked, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.navigation.grid_map import GridMap
from yarm.navigation.ground import PlanSettings
from yarm.navigation.path_check import check_path
from yarm.navigation.planner import Cell, Field


@dataclass(frozen=True, eq=False)
class Way:
    """What planning came to.

    Attributes:
        path: (n, 2) from start to goal, map frame, metres; (0, 2) without a way.
        reason: why there is none; empty when there is.
        field: the search; None when the goal was refused before it.
    """

    path: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    reason: str = ""
    field: Optional[Field] = None

    @property
    def length_m(self) -> float:
        """Of the path."""
        return float(np.hypot(*np.diff(self.path, axis=0).T).sum())


def find_way(grid: GridMap, start: Pose2, goal: Pose2, settings: PlanSettings, tolerance_m: float = 0.0) -> Way:
    """The cheapest way of the disc; it ends at the goal, or where the disc fits within a tolerance of it.

    Args:
        grid: the map with everything that is in the way.
        start: of the disc's centre.
        goal: of the disc's centre; its heading is nobody's concern here.
        settings: the disc and its comfort.
        tolerance_m: the way may end so far from the goal, metres.
    """
    cell = grid.cell_of(goal.x, goal.y)
    if not grid.inside(*cell):
        return Way(reason=f"the goal ({goal.x:.2f}, {goal.y:.2f}) lies outside the map")
    search = Field(grid, start, settings)
    if search.reason:
        return Way(reason=search.reason, field=search)
    end = cell if search.reachable(cell) else _nearest(search, goal, tolerance_m)
    if end is None:
        return Way(reason=_why(search, cell, goal, settings), field=search)
    path = _ended(search, search.path_to(end), goal, end == cell)
    verdict = check_path(grid, path, settings.radius_m)
    if not verdict.clear:
        return Way(reason=f"the way was refused: {verdict.reason}", field=search)
    return Way(path, field=search)


def _nearest(search: Field, goal: Pose2, tolerance_m: float) -> Optional[Cell]:
    """The reachable cell nearest to the goal within the tolerance."""
    cells = np.argwhere(np.isfinite(search.cost))
    if len(cells) == 0 or tolerance_m <= 0.0:
        return None
    away = np.hypot(*(search.grid_map.centres_of(cells) - (goal.x, goal.y)).T)
    best = int(np.argmin(away))
    return (int(cells[best, 0]), int(cells[best, 1])) if away[best] <= tolerance_m else None


def _ended(search: Field, path: FloatArray, goal: Pose2, same_cell: bool) -> FloatArray:
    """The path with its end moved from the cell's middle to the goal itself, where that is as clear."""
    end = np.array([goal.x, goal.y])
    if not same_cell or (len(path) > 1 and not search.sees(path[-2], end)):
        return path
    return np.concatenate([path[:-1], end[None, :]]) if len(path) > 1 else path


def _why(search: Field, cell: Tuple[int, int], goal: Pose2, settings: PlanSettings) -> str:
    place = f"the goal ({goal.x:.2f}, {goal.y:.2f})"
    if search.grid_map.occupied[cell]:
        return f"{place} lies inside an obstacle"
    if not search.passable[cell]:
        if search.grid_map.unknown[cell]:
            return f"{place} lies where the map is not known"
        room = search.room_m[cell]
        return f"{place} is {room:.2f} m from an obstacle, the disc needs {settings.radius_m:g} m to the cell's edge"
    return f"there is no way to {place} for a disc of {settings.radius_m:g} m"
