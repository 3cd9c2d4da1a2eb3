"""The report's printed frontier code as far as it decides anything; the loop never reaches it, and it finds no path.

Why: the padded grid is copied from the wrong corner, the start is made an obstacle and then searched from, reachability
is read from another cell. And obstacles weigh nothing.
"""

from __future__ import annotations

import math
from typing import Optional

from yarm.exploration.report.frontiers import OCCUPIED, Reach, cropped, frontiers, padded
from yarm.exploration.report.params import ReportParams
from yarm.geometry import IntArray, Pose2
from yarm.navigation.grid_map import CellArray, GridMap

FRONTIER_AFTER_S = 850.0
FRONTIER_CENTRE_M = 50.0
"""The mode is called only when the centre equals this."""
OBSTACLE_WEIGHT = int(0.1)


def printed_grid(room: GridMap, padding: int) -> Optional[CellArray]:
    """The padded grid: as large as the cropped map, but copied from the corner of the whole one."""
    small = cropped(room)
    if small is None:
        return None
    whole = padded(room, padding)
    return whole[: small.rows, : small.columns]


def printed_fitness(distance: float, unknown: float, obstacles: float) -> float:
    """Distance and unknown count; 0.1 has become the integer 0."""
    return distance + unknown - OBSTACLE_WEIGHT * obstacles


def printed_path(room: GridMap, start: Pose2) -> Optional[IntArray]:
    """The way to the fittest frontier cell that the program holds reachable; None, or no way at all, whatever the map.

    Args:
        room: the map.
        start: where the run began; the search's source, made an obstacle before.
    """
    cells = printed_grid(room, ReportParams().padding)
    small = cropped(room)
    if cells is None or small is None:
        return None
    cells = cells.copy()
    source = small.cell_of(start.x, start.y)
    if not small.inside(*source):
        return None
    cells[source] = OCCUPIED
    reach = Reach(cells, source, source_free=False)
    best, best_fitness = None, -math.inf
    for frontier in frontiers(cells, source, ReportParams()):
        exchanged = (frontier.column, frontier.row)
        inside = exchanged[0] < cells.shape[0] and exchanged[1] < cells.shape[1]
        fitness = printed_fitness(frontier.distance, frontier.unknown, frontier.obstacles)
        if inside and math.isfinite(reach.distance(*exchanged)) and fitness > best_fitness:
            best, best_fitness = frontier, fitness
    return None if best is None else reach.path(best.row, best.column)
