"""Shortest ways of a disc over a flat map: one search from the robot gives the cost to everywhere."""

from __future__ import annotations

from typing import Dict, List, Optional, Tuple

import numpy as np
from scipy.sparse.csgraph import dijkstra

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.navigation.costs import near
from yarm.navigation.grid_map import GridMap
from yarm.navigation.ground import Ground, PlanSettings

Cell = Tuple[int, int]
SIGHT_STEP_M = 0.02
"""Between the points at which a straight piece is looked at."""


class Field:
    """Costs and ways from one start to every cell a disc can reach; searched for when they are first asked for.

    Attributes:
        grid_map: the map.
        start: pose from which ways lead.
        passable: (rows, columns) where the disc's centre may be.
        room_m: (rows, columns) clearance of every cell, metres.
        reason: why nothing can be reached; empty when the start is good.
    """

    def __init__(
        self, grid_map: GridMap, start: Pose2, settings: Optional[PlanSettings] = None, ground: Optional[Ground] = None
    ) -> None:
        """Ways over a map.

        Args:
            grid_map: the map.
            start: pose from which ways lead, map frame.
            settings: of the disc.
            ground: this map, looked at before for this disc; saves half of the time.
        """
        ground = ground or Ground(grid_map, settings)
        self.grid_map = grid_map
        self.reason = ""
        self.start = start
        self._ground, self._settings = ground, ground.settings
        self._standable = ground.standable_from(start)
        self.passable: BoolArray = self._standable & ~ground.touching
        self.room_m = ground.room_m
        shape = self.grid_map.cells.shape
        self._cost: FloatArray = np.full(shape, np.inf)
        self._length: FloatArray = np.full(shape, np.inf)
        self._before: IntArray = np.full(shape, -1, np.int64)
        self._parent: Optional[IntArray] = None
        self._lead_of: Dict[float, IntArray] = {}
        self._root = self._find_root()
        self._searched = False

    @property
    def cost(self) -> FloatArray:
        """(rows, columns) metres, weighted where it is narrow; inf where the disc cannot go."""
        self.search()
        return self._cost

    @property
    def length(self) -> FloatArray:
        """(rows, columns) metres along the cells, not weighted; inf where the disc cannot go."""
        self.search()
        return self._length

    def search(self) -> None:
        """Search now, and not when something is first asked for; once is enough."""
        if self._searched or self._root is None:
            return
        self._searched = True
        graph = self._ground.graph(self._standable)
        nodes, columns = graph.nodes, self._cost.shape[1]
        first = int(np.searchsorted(nodes, self._root[0] * columns + self._root[1]))
        cost, before = dijkstra(graph.costs, indices=first, return_predecessors=True)
        lead = float(np.hypot(*(np.array(self.grid_map.centre_of(*self._root)) - (self.start.x, self.start.y))))
        self._cost.ravel()[nodes] = cost + lead
        reached = before >= 0
        self._before.ravel()[nodes[reached]] = nodes[before[reached]]
        self._lengths(nodes, cost, before, lead)

    def reachable(self, cell: Cell) -> bool:
        """Whether the disc can get to a cell."""
        return self.grid_map.inside(*cell) and bool(np.isfinite(self.cost[cell]))

    def path_to(self, cell: Cell) -> FloatArray:
        """(n, 2) the way from the start to a cell's centre, map frame, metres, pulled tight; (0, 2) without one."""
        if not self.reachable(cell):
            return np.zeros((0, 2))
        cells = self._chain(cell)
        points = self.grid_map.centres_of(cells)
        start = np.array([[self.start.x, self.start.y]])
        return self._tight(np.concatenate([start, points]), cells)

    def places_on_way(self, cell: Cell, every_m: float) -> Tuple[IntArray, FloatArray]:
        """(n, 2) cells about every so many metres on the way to a cell, its ends left out, and (n,) headings there."""
        step = max(1, round(every_m / self.grid_map.resolution_m))
        cells = self._chain(cell) if self.reachable(cell) else np.zeros((0, 2), np.int64)
        at = np.arange(step, len(cells) - step // 2, step)
        centres = self.grid_map.centres_of(cells)
        ahead = centres[np.minimum(at + step // 2, len(cells) - 1)] - centres[at - step // 2]
        return cells[at], np.arctan2(ahead[:, 1], ahead[:, 0])

    def first_bearings(self, cells: IntArray, reach_m: float = 0.3) -> FloatArray:
        """(n,) heading, map frame, in which the way to each of cells (n, 2) sets out; NaN for a cell at the start."""
        lead = self._centres(self._leads(reach_m)[self._flat(cells)])
        apart = lead - (self.start.x, self.start.y)
        bearing: FloatArray = np.arctan2(apart[:, 1], apart[:, 0])
        bearing[np.hypot(apart[:, 0], apart[:, 1]) < self.grid_map.resolution_m] = np.nan
        return bearing

    def last_bearings(self, cells: IntArray, steps: int = 6) -> FloatArray:
        """(n,) heading, map frame, in which the way arrives at each of cells (n, 2); NaN for a cell at the start."""
        parent, flat = self._parents(), self._flat(cells)
        before = flat
        for _ in range(steps):
            before = parent[before]
        apart = self._centres(flat) - self._centres(before)
        bearing: FloatArray = np.arctan2(apart[:, 1], apart[:, 0])
        bearing[before == flat] = np.nan
        return bearing

    def sees(self, a: FloatArray, b: FloatArray) -> bool:
        """Whether the disc keeps clear and on passable ground straight from a (2,) to b (2,), map frame."""
        length = float(np.hypot(*(b - a)))
        count = int(np.ceil(length / SIGHT_STEP_M)) + 1
        points = a + np.linspace(0.0, 1.0, count)[:, None] * (b - a)
        cells = self.grid_map.cells_of(points)
        rows, columns = cells[:, 0], cells[:, 1]
        if rows.min() < 0 or columns.min() < 0 or not self.grid_map.inside(int(rows.max()), int(columns.max())):
            return False
        if not self._standable[rows, columns].all() or self._ground.tight[rows, columns].any():
            return False
        close = ~self._ground.wide[rows, columns]
        return bool(np.all(self._ground.room.distances(points[close]) >= self._settings.clear_m))

    def _chain(self, cell: Cell) -> IntArray:
        """(n, 2) cells from the one where the search began to a cell that it has reached."""
        flat = int(np.ravel_multi_index(cell, self.passable.shape))
        chain: List[int] = []
        before = self._before.ravel().data  # gives single numbers more quickly than an array
        while flat >= 0:
            chain.append(flat)
            flat = before[flat]
        cells: IntArray = np.stack(np.unravel_index(np.array(chain[::-1]), self.passable.shape), axis=1)
        return cells

    def _leads(self, reach_m: float) -> IntArray:
        """(cells,) for each flat cell the last one within a reach of the start on the way to it; kept."""
        if reach_m not in self._lead_of:
            parent = self._parents()
            jump = np.where(self.length.ravel() <= reach_m, np.arange(len(parent)), parent)
            while True:
                further = jump[jump]
                if np.array_equal(jump, further):
                    break
                jump = further
            self._lead_of[reach_m] = jump
        return self._lead_of[reach_m]

    def _parents(self) -> IntArray:
        """(cells,) the flat cell before each on the way from the start; its own where there is none."""
        self.search()
        if self._parent is None:
            before = self._before.ravel()
            self._parent = np.where(before >= 0, before, np.arange(len(before)))
        return self._parent

    def _flat(self, cells: IntArray) -> IntArray:
        flat: IntArray = cells[:, 0] * self.cost.shape[1] + cells[:, 1]
        return flat

    def _centres(self, flat: IntArray) -> FloatArray:
        columns = self.cost.shape[1]
        return self.grid_map.centres_of(np.stack([flat // columns, flat % columns], axis=1))

    def _find_root(self) -> Optional[Cell]:
        """The cell that the search begins at: the start's own, or the nearest from which the disc is clear."""
        cell = self.grid_map.cell_of(self.start.x, self.start.y)
        if not self.grid_map.inside(*cell):
            self.reason = f"the start ({self.start.x:.2f}, {self.start.y:.2f}) lies outside the map"
            return None
        if self.passable[cell]:
            return cell
        cells = np.argwhere(self.passable & near(self.grid_map, self.start.x, self.start.y, self._settings.leave_m))
        here = np.array([self.start.x, self.start.y])
        centres = self.grid_map.centres_of(cells)
        own = float(self._ground.room.distances(here[None, :])[0])
        for index in np.argsort(np.hypot(*(centres - here).T), kind="stable")[:60]:
            along = here + np.linspace(0.0, 1.0, 12)[:, None] * (centres[index] - here)
            if np.all(self._ground.room.distances(along) >= own - 1e-3):
                return int(cells[index, 0]), int(cells[index, 1])
        self.reason = (
            f"the start ({self.start.x:.2f}, {self.start.y:.2f}) is enclosed: no place within "
            f"{self._settings.leave_m:g} m where a disc of {self._settings.radius_m:g} m fits can be reached from it"
        )
        return None

    def _lengths(self, nodes: IntArray, cost: FloatArray, before: IntArray, lead: float) -> None:
        """Plain lengths along the ways of least cost, by doubling jumps up the tree."""
        columns = self._cost.shape[1]
        parent = np.where(before >= 0, before, np.arange(len(nodes)))
        rows, cols = nodes // columns, nodes % columns
        total = np.hypot(rows - rows[parent], cols - cols[parent]) * self.grid_map.resolution_m
        while True:
            grown = total + total[parent]
            further = parent[parent]
            if np.array_equal(further, parent):
                break
            total, parent = grown, further
        self._length.ravel()[nodes] = np.where(np.isfinite(cost), total + lead, np.inf)

    def _tight(self, points: FloatArray, cells: IntArray) -> FloatArray:
        """Leaves out the points between two that see each other and where going straight costs no more."""
        cost = np.concatenate([[0.0], self.cost[cells[:, 0], cells[:, 1]]])
        keep = [0]
        if not self._clear_start(points[0]):
            keep.append(1)
        while keep[-1] < len(points) - 1:
            keep.append(self._farthest(points, cost, keep[-1]))
        return points[keep]

    def _clear_start(self, start: FloatArray) -> bool:
        return bool(self._ground.room.distances(start[None, :])[0] >= self._settings.clear_m)

    def _farthest(self, points: FloatArray, cost: FloatArray, index: int) -> int:
        """The last point that the one at ``index`` sees, found by growing strides, then halving."""
        good, stride = index + 1, 2
        while index + stride < len(points) and self._shorter(points, cost, index, index + stride):
            good, stride = index + stride, stride * 2
        low, high = good, min(index + stride, len(points) - 1)
        if high > low and self._shorter(points, cost, index, high):
            return high
        while high - low > 1:
            middle = (low + high) // 2
            if self._shorter(points, cost, index, middle):
                low = middle
            else:
                high = middle
        return low

    def _shorter(self, points: FloatArray, cost: FloatArray, a: int, b: int) -> bool:
        dear = self._straight_cost(points[a], points[b]) > cost[b] - cost[a] + 0.03  # said sooner than what is seen
        return not dear and self.sees(points[a], points[b])

    def _straight_cost(self, a: FloatArray, b: FloatArray) -> float:
        length = float(np.hypot(*(b - a)))
        count = max(int(np.ceil(length / self.grid_map.resolution_m)), 1)
        points = a + ((np.arange(count) + 0.5) / count)[:, None] * (b - a)
        cells = self.grid_map.cells_of(points)
        return float(self._ground.weights[cells[:, 0], cells[:, 1]].mean()) * length
