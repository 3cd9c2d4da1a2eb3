"""Where the known part of a map ends: unknown cells beside free ones, in connected groups."""

from __future__ import annotations

from dataclasses import dataclass
from typing import List

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, FloatArray, IntArray
from yarm.navigation.grid_map import GridMap

EIGHT = np.ones((3, 3), bool)


@dataclass(frozen=True, eq=False)
class Frontier:
    """One connected group of frontier cells.

    Attributes:
        cells: (n, 2) rows and columns.
        x: centroid in the map frame, metres.
        y: centroid in the map frame, metres.
    """

    cells: IntArray
    x: float
    y: float


def frontier_cells(grid_map: GridMap) -> BoolArray:
    """(rows, columns) unknown cells that have a free 4-neighbour."""
    return grid_map.unknown & beside(grid_map.free)


def beside(cells: BoolArray) -> BoolArray:
    """(rows, columns) which cells have a 4-neighbour in a set."""
    found = np.zeros_like(cells)
    found[1:] |= cells[:-1]
    found[:-1] |= cells[1:]
    found[:, 1:] |= cells[:, :-1]
    found[:, :-1] |= cells[:, 1:]
    return found


def frontiers_of(grid_map: GridMap, cells: BoolArray) -> List[Frontier]:
    """The 8-connected groups of a set of cells (rows, columns), in the order of their first cells."""
    labels, count = ndimage.label(cells, structure=EIGHT)
    if count == 0:
        return []
    places = np.argwhere(labels > 0)
    owner = labels[places[:, 0], places[:, 1]]
    order = np.argsort(owner, kind="stable")
    sizes = np.bincount(owner)[1:]
    ends = np.cumsum(sizes)
    centres: FloatArray = grid_map.centres_of(places)
    x, y = (np.bincount(owner, centres[:, axis])[1:] / sizes for axis in (0, 1))
    groups = np.split(places[order], ends[:-1])
    return [Frontier(*frontier) for frontier in zip(groups, x.tolist(), y.tolist())]
