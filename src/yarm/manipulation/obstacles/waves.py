"""Shortest ways over a grid of free cells to a goal, from everywhere at once: a wave that runs out from the goal."""

from __future__ import annotations

import math
from itertools import product
from typing import List

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra

from yarm.geometry import BoolArray, FloatArray, IntArray


class GridWaves:
    """Cells in two or three dimensions, each joined to all its neighbours, diagonal ones too."""

    def __init__(self, free: BoolArray, cell_m: float) -> None:
        """Join the free cells.

        Args:
            free: (gx, gy) or (gx, gy, gz), which cells may be entered.
            cell_m: size of a cell, metres.
        """
        self.free = free
        self._cell = cell_m
        self._graph = self._edges()

    def ways(self, goal: npt.ArrayLike) -> FloatArray:
        """Length of the shortest way from each cell to the free cell nearest to a goal cell, metres; inf without."""
        source = int(np.ravel_multi_index(tuple(self.nearest_free(goal)), self.free.shape))
        return np.asarray(dijkstra(self._graph, directed=False, indices=source).reshape(self.free.shape))

    def path(self, start: npt.ArrayLike, goal: npt.ArrayLike) -> IntArray:
        """Cells (n, d) of a shortest way between two cells; (0, d) where there is none."""
        lengths = self.ways(goal)
        cell = np.asarray(start, dtype=np.int64)
        if not math.isfinite(lengths[tuple(cell)]):
            return np.zeros((0, self.free.ndim), dtype=np.int64)
        cells = [cell]
        while lengths[tuple(cell)] > 0.0:
            low = np.maximum(cell - 1, 0)
            around = lengths[tuple(slice(a, b + 2) for a, b in zip(low, cell))]
            steps = np.linalg.norm(np.indices(around.shape).T - (cell - low), axis=-1).T * self._cell
            best = np.unravel_index(int(np.argmin(np.where(steps > 0.0, around + steps, np.inf))), around.shape)
            cell = low + np.array(best)
            cells.append(cell)
        return np.array(cells)

    def nearest_free(self, cell: npt.ArrayLike) -> IntArray:
        """The free cell nearest to a cell."""
        cells = np.argwhere(self.free)
        return np.asarray(cells[int(np.argmin(np.linalg.norm(cells - np.asarray(cell), axis=1)))])

    def _edges(self) -> csr_matrix:
        free, shape = self.free, self.free.shape
        index = np.arange(free.size).reshape(shape)
        rows: List[IntArray] = []
        columns: List[IntArray] = []
        lengths: List[FloatArray] = []
        for step in product((-1, 0, 1), repeat=free.ndim):
            if step <= (0,) * free.ndim:
                continue
            here = tuple(slice(max(0, -s), size - max(0, s)) for s, size in zip(step, shape))
            there = tuple(slice(max(0, s), size - max(0, -s)) for s, size in zip(step, shape))
            both = free[here] & free[there]
            rows.append(index[here][both])
            columns.append(index[there][both])
            lengths.append(np.full(int(both.sum()), self._cell * math.sqrt(sum(s * s for s in step))))
        data = (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns)))
        return coo_matrix(data, shape=(free.size, free.size)).tocsr()
