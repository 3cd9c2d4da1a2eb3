"""The graph over the particles: their Delaunay triangulation."""

from __future__ import annotations

from typing import List, Tuple

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from yarm.geometry import IntArray

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
    lists: List[List[int]] = [[] for _ in range(n)]
    for a, b in edges.tolist():
        lists[a].append(b)
        lists[b].append(a)
    return tuple(tuple(sorted(entry)) for entry in lists)


def nearest(points: IntArray, column: Tuple[int, int], count: int) -> Tuple[int, ...]:
    """Indices of the particles nearest to a column, nearest first; equal distances in order of index."""
    squared = ((points - np.asarray(column)) ** 2).sum(axis=1)
    return tuple(int(i) for i in np.argsort(squared, kind="stable")[:count])


def nearest_edges(points: IntArray, first: int, count: int) -> IntArray:
    """Edges (m, 2), smaller index first, sorted, from each particle at or after ``first`` to its nearest ones."""
    added = len(points) - first
    if added <= 0 or len(points) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    count = min(count + 1, len(points))
    _, close = cKDTree(points).query(points[first:], k=count)
    pairs = np.stack([np.repeat(np.arange(first, len(points)), count), close.ravel()], axis=-1)
    pairs = np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1).astype(np.int64)
    keys = np.unique(pairs[:, 0] * len(points) + pairs[:, 1])
    return np.stack([keys // len(points), keys % len(points)], axis=-1)


def _chain(points: IntArray) -> IntArray:
    order = np.lexsort((points[:, 1], points[:, 0]))
    pairs = np.sort(np.stack([order[:-1], order[1:]], axis=-1), axis=1).astype(np.int64)
    ordered: IntArray = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    return ordered
