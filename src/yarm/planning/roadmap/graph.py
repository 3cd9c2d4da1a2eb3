"""The graph over the particles: their Delaunay triangulation.

B. Delaunay, "Sur la sphere vide", 1934; made by Qhull (C. B. Barber, D. P. Dobkin, H. Huhdanpaa, "The quickhull
algorithm for convex hulls", ACM Transactions on Mathematical Software 22, 1996).
"""

from __future__ import annotations

from functools import cached_property
from typing import List, Tuple

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from yarm.geometry import BoolArray, IntArray

Neighbours = Tuple[Tuple[int, ...], ...]


def delaunay_edges(points: IntArray) -> IntArray:
    """Edges (m, 2) of the Delaunay triangulation of distinct columns (n, 2), each once, smaller index first, sorted.

    Fewer than three columns, or columns all on one line, have no triangulation: they are joined in a chain along
    the line.
    """
    if len(points) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    if len(points) < 3 or np.linalg.matrix_rank(points[1:] - points[0]) < 2:
        return _chain(points)
    try:
        triangles = Delaunay(points.astype(float)).simplices.astype(np.int64)
    except QhullError:
        return _chain(points)
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [0, 2]]])
    pairs.sort(axis=1)
    keys = np.unique(pairs[:, 0] * len(points) + pairs[:, 1])
    return np.stack([keys // len(points), keys % len(points)], axis=-1)


def neighbours_of(n: int, edges: IntArray) -> Neighbours:
    """For each of n particles, the particles it shares an edge with, ascending."""
    ends = np.concatenate([edges, edges[:, ::-1]])
    keys = np.sort(ends[:, 0] * n + ends[:, 1])
    others: List[int] = (keys % max(1, n)).tolist()
    bounds: List[int] = np.searchsorted(keys, np.arange(n + 1) * n).tolist()
    return tuple(tuple(others[low:high]) for low, high in zip(bounds, bounds[1:]))


def nearest(points: IntArray, column: Tuple[int, int], count: int) -> Tuple[int, ...]:
    """Indices of the particles nearest to a column, nearest first; equal distances in order of index."""
    dx, dy = points[:, 0] - column[0], points[:, 1] - column[1]
    ranked = (dx * dx + dy * dy) * len(points) + np.arange(len(points))
    if count < len(points):
        ranked = np.partition(ranked, count)[:count]
    ranked.sort()
    return tuple((ranked % max(1, len(points))).tolist())


class NearestTable:
    """The nearest of some columns to each of them, found when first asked for and kept."""

    def __init__(self, points: IntArray, count: int) -> None:
        """Of distinct columns (n, 2), the ``count`` nearest to each."""
        self._points = points
        self._rows = np.full((len(points), min(count + 1, len(points))), -1, dtype=np.int64)

    @cached_property
    def _tree(self) -> cKDTree:
        return cKDTree(self._points)

    def of(self, columns: IntArray) -> IntArray:
        """Indices (m, k) of the columns nearest to each of some (m,), nearest first; itself is among them."""
        missing = columns[self._rows[columns, 0] < 0]
        if len(missing):
            _, near = self._tree.query(self._points[missing], k=[*range(1, self._rows.shape[1] + 1)])
            self._rows[missing] = near
        return self._rows[columns]

    def edges(self, columns: IntArray, used: BoolArray) -> IntArray:
        """Edges (m, 2), smaller index first, sorted, from each of some columns to those of its nearest in use (n,)."""
        near = self.of(columns)
        pairs = np.stack([np.repeat(columns, near.shape[1]), near.ravel()], axis=-1)
        pairs = np.sort(pairs[(pairs[:, 0] != pairs[:, 1]) & used[pairs[:, 1]]], axis=1)
        keys = np.unique(pairs[:, 0] * len(self._points) + pairs[:, 1])
        return np.stack([keys // len(self._points), keys % len(self._points)], axis=-1)


def _chain(points: IntArray) -> IntArray:
    order = np.lexsort((points[:, 1], points[:, 0]))
    pairs = np.sort(np.stack([order[:-1], order[1:]], axis=-1), axis=1).astype(np.int64)
    ordered: IntArray = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return ordered
