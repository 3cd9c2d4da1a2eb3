"""What a map says of where a disc can be and what ways cost there: made once a map, for searches from anywhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

import numpy as np
from scipy.sparse import csr_matrix

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.navigation.costs import Room, blocked, clearance, drive_cost, near
from yarm.navigation.grid_map import GridMap

SPARE_M = 0.004
"""Kept beside the disc's radius, so that rounding never makes a way unclear."""
STEPS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))
"""Rows and columns to the neighbours of a cell, in the order of their numbers."""


@dataclass(frozen=True)
class PlanSettings:
    """How ways are searched.

    Attributes:
        radius_m: of the disc that is kept clear, metres.
        unknown_passable: whether ways lead over unknown cells.
        known_near_m: unknown cells this near to the start may be passed in any case: the robot stands there and cannot
            see its own feet.
        comfort_m: clearance from which a way costs its length only.
        narrow_weight: what a metre costs more where the disc only just fits.
        decay_per_m: how fast that falls with the clearance, exponentially; 0: linearly.
        leave_m: how far the start may lie from the nearest place where the disc fits.
    """

    radius_m: float = 0.18
    unknown_passable: bool = False
    known_near_m: float = 0.6
    comfort_m: float = 0.40
    narrow_weight: float = 1.0
    decay_per_m: float = 0.0
    leave_m: float = 0.5

    @property
    def clear_m(self) -> float:
        """What has to be clear around the disc's centre."""
        return self.radius_m + SPARE_M


@dataclass(frozen=True, eq=False)
class Graph:
    """Ways between neighbouring cells.

    Attributes:
        nodes: (n,) flat numbers of the cells.
        costs: (n, n) metres, weighted where it is narrow.
    """

    nodes: IntArray
    costs: csr_matrix


class Ground:
    """One map, looked at for one disc.

    Attributes:
        grid_map: the map.
        settings: of the disc.
        standable: (rows, columns) where the disc's centre may be as far as the ground is known.
        touching: (rows, columns) where a disc on the cell's centre touches something.
        wide: (rows, columns) where it touches nothing wherever in the cell it is.
        tight: (rows, columns) where it touches something wherever in the cell it is.
        room: exact distances around single points.
        room_m: (rows, columns) clearance of every cell, metres.
        weights: (rows, columns) what a metre costs.
    """

    def __init__(
        self, grid_map: GridMap, settings: Optional[PlanSettings] = None, more: Optional[FloatArray] = None
    ) -> None:
        """Look at a map.

        Args:
            grid_map: the map.
            settings: of the disc.
            more: (rows, columns) what a metre costs more than the room there makes it.
        """
        self.grid_map = grid_map
        self.settings = settings or PlanSettings()
        s = self.settings
        self.standable: BoolArray = ~grid_map.occupied if s.unknown_passable else grid_map.free
        self.touching = self._touching(0.0)
        self.wide: BoolArray = ~self._touching(math.sqrt(0.5))
        self.tight = self._touching(-math.sqrt(0.5))
        self.room = Room(grid_map, s.clear_m + grid_map.resolution_m)
        self.room_m = clearance(grid_map)
        self.weights = drive_cost(self.room_m, s.radius_m, s.comfort_m, s.narrow_weight, s.decay_per_m)
        if more is not None:
            self.weights = self.weights + more
        self._graph: Optional[Graph] = None

    def standable_from(self, start: Pose2) -> BoolArray:
        """(rows, columns) where the disc's centre may be, obstacles apart, for a robot that stands here."""
        s = self.settings
        if not s.unknown_passable and s.known_near_m > 0.0:
            own = near(self.grid_map, start.x, start.y, s.known_near_m) & self.grid_map.unknown
            if own.any():
                return self.standable | own
        return self.standable

    def graph(self, standable: BoolArray) -> Graph:
        """The ways between standable cells (rows, columns) on which the disc touches nothing."""
        if standable is not self.standable:
            return self._graph_over(standable & ~self.touching)
        if self._graph is None:
            self._graph = self._graph_over(self.standable & ~self.touching)
        return self._graph

    def _touching(self, more_cells: float) -> BoolArray:
        """Where a disc on a cell's centre, this much larger, touches something."""
        radius = self.settings.clear_m / self.grid_map.resolution_m + more_cells
        return blocked(self.grid_map.occupied, max(radius, 0.0))

    def _graph_over(self, passable: BoolArray) -> Graph:
        return Graph(np.flatnonzero(passable), _ways(passable, self.weights, self.grid_map.resolution_m))


def _ways(passable: BoolArray, weight: FloatArray, resolution_m: float) -> csr_matrix:
    """(n, n) ways between neighbouring cells; a diagonal one needs both cells beside it, so that no corner is cut.

    The neighbours of a cell are taken in the order of their numbers, so the rows of the matrix come out sorted.
    """
    columns = passable.shape[1] + 2
    framed = np.pad(passable, 1).ravel()
    weights = np.pad(weight, 1).ravel()
    nodes = np.flatnonzero(framed)
    number = np.zeros(len(framed), np.int32)
    number[nodes] = np.arange(len(nodes), dtype=np.int32)
    offsets = np.array([dr * columns + dc for dr, dc in STEPS])
    ends = nodes[:, None] + offsets
    open_ways = framed[ends]
    for i, (dr, dc) in enumerate(STEPS):
        if dr and dc:
            open_ways[:, i] &= open_ways[:, STEPS.index((dr, 0))] & open_ways[:, STEPS.index((0, dc))]
    lengths = np.array([0.5 * resolution_m * float(np.hypot(dr, dc)) for dr, dc in STEPS])
    costs = (weights[nodes][:, None] + weights[ends]) * lengths
    first = np.concatenate([[0], np.cumsum(open_ways.sum(axis=1))]).astype(np.int32)
    return csr_matrix((costs[open_ways], number[ends[open_ways]], first), shape=(len(nodes), len(nodes)))
