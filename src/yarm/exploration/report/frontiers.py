"""The report's frontier cells: crop, speckle, padding, merging, fitness, draw, and the path to one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from yarm.exploration.report.params import ReportParams
from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.navigation.grid_map import CellArray, GridMap

DEFAULTS = ReportParams()
OCCUPIED = 100
_STEPS = ((0, 1), (1, -1), (1, 0), (1, 1))


@dataclass(frozen=True)
class Frontier:
    """A merged frontier cell.

    Attributes:
        row: in the cropped map.
        column: in the cropped map.
        distance: straight, from the robot, cells.
        unknown: the unknown neighbours of the cells it stands for, each as much as ``ReportParams.unknown``.
        obstacles: sum of the obstacles in its window, each as much as ``ReportParams.obstacle``.
        fitness: greater is better.
        probability: of being drawn.
    """

    row: int
    column: int
    distance: float
    unknown: float
    obstacles: float
    fitness: float
    probability: float = 0.0


def cropped(room: GridMap, border: int = DEFAULTS.border) -> Optional[GridMap]:
    """The known cells and a border where it fits; None when nothing is known."""
    rows, columns = np.nonzero(~room.unknown)
    if not rows.size:
        return None
    top, bottom = max(int(rows.min()) - border, 0), min(int(rows.max()) + border + 1, room.rows)
    left, right = max(int(columns.min()) - border, 0), min(int(columns.max()) + border + 1, room.columns)
    corner = room.origin.compose(Pose2(left * room.resolution_m, top * room.resolution_m))
    return GridMap(room.cells[top:bottom, left:right], room.resolution_m, corner)


def padded(room: GridMap, padding: int, speck: int = DEFAULTS.speck, window: int = DEFAULTS.speck_window) -> CellArray:
    """Cells -1, 0, 100: occupied specks taken out, everything within ``padding`` cells of the rest occupied."""
    side = 2 * padding + 1
    occupied = room.occupied.astype(np.int32)
    in_window = ndimage.convolve(occupied, np.ones((window, window), np.int32), mode="constant")
    kept: BoolArray = room.occupied & (in_window > speck)
    cells = np.where(room.unknown, -1, 0).astype(np.int8)
    near: BoolArray = ndimage.binary_dilation(kept, np.ones((side, side), bool))
    cells[near] = OCCUPIED
    return cells


def frontier_cells(cells: CellArray) -> BoolArray:
    """Free cells of a padded map beside an unknown one, not on the outermost row or column."""
    unknown = ndimage.binary_dilation(cells == -1, np.ones((3, 3), bool))
    frontier: BoolArray = (cells == 0) & unknown
    frontier[[0, -1], :] = False
    frontier[:, [0, -1]] = False
    return frontier


def frontiers(cells: CellArray, robot: Tuple[int, int], params: ReportParams) -> List[Frontier]:
    """Merged frontier cells of a padded map, in the order of their rows.

    The first unused cell takes the sum of its window (``merging``) and uses the others up.
    """
    mask = frontier_cells(cells)
    half = params.merging // 2
    neighbours = ndimage.convolve((cells == -1).astype(np.int32), np.ones((3, 3), np.int32), mode="constant")
    information = np.where(mask, params.unknown * neighbours, 0.0)
    obstacles = ndimage.convolve(
        (cells == OCCUPIED).astype(np.int64),
        np.ones((2 * half + 1, 2 * half + 1), np.int64),
        mode="constant",
    )
    unused = mask.copy()
    found = []
    for row, column in np.argwhere(mask):
        if not unused[row, column]:
            continue
        window = (
            slice(max(row - half, 0), row + half + 1),
            slice(max(column - half, 0), column + half + 1),
        )
        gain = float(information[window][unused[window]].sum())
        unused[window] = False
        distance = math.hypot(row - robot[0], column - robot[1])
        walls = params.obstacle * float(obstacles[row, column])
        fitness = params.weight_distance * distance + params.weight_unknown * gain - params.weight_obstacles * walls
        found.append(Frontier(int(row), int(column), distance, gain, walls, fitness))
    return found


class Reach:
    """Shortest ways over the free cells of a padded map from the robot's cell, 8-connected, corners cut."""

    def __init__(self, cells: CellArray, robot: Tuple[int, int], source_free: bool = True) -> None:
        """Search from the robot's cell, which counts as free whatever it is, unless ``source_free`` is false."""
        self._columns = cells.shape[1]
        free = cells == 0
        free[robot] |= source_free
        graph = _graph(free)
        self._distances, self._before = dijkstra(
            graph, directed=False, indices=robot[0] * self._columns + robot[1], return_predecessors=True
        )

    def distance(self, row: int, column: int) -> float:
        """Length of the way to a cell, cells; inf without one."""
        return float(self._distances[row * self._columns + column])

    def path(self, row: int, column: int) -> IntArray:
        """(n, 2) rows and columns from the robot's cell to this one, both included."""
        at = row * self._columns + column
        cells = [at]
        while self._before[at] >= 0:
            at = int(self._before[at])
            cells.append(at)
        backwards: IntArray = np.array(cells[::-1], dtype=np.int64)
        return np.stack([backwards // self._columns, backwards % self._columns], axis=1)


def _graph(free: BoolArray) -> coo_matrix:
    index = np.arange(free.size).reshape(free.shape)
    rows, columns = free.shape
    tails, heads, lengths = [], [], []
    for down, right in _STEPS:
        here = (slice(0, rows - down), slice(max(-right, 0), columns - max(right, 0)))
        there = (slice(down, rows), slice(max(right, 0), columns + min(right, 0)))
        both = free[here] & free[there]
        tails.append(index[here][both])
        heads.append(index[there][both])
        lengths.append(np.full(len(tails[-1]), math.hypot(down, right)))
    return coo_matrix(
        (np.concatenate(lengths), (np.concatenate(tails), np.concatenate(heads))), shape=(free.size, free.size)
    ).tocsr()


def with_probabilities(reachable: List[Frontier], least_share: float = DEFAULTS.draw_least) -> List[Frontier]:
    """The frontiers with their shares of the draw, proportional to the fitness above the least, and ``least_share``."""
    if not reachable:
        return []
    least = min(f.fitness for f in reachable)
    weights: FloatArray = np.array([f.fitness - least + least_share for f in reachable])
    shares = weights / weights.sum()
    return [
        Frontier(f.row, f.column, f.distance, f.unknown, f.obstacles, f.fitness, float(share))
        for f, share in zip(reachable, shares)
    ]
