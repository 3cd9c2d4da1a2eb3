"""Particles and the graph that a search goes along, kept from step to step while the map changes."""

from __future__ import annotations

import math
from collections import defaultdict
from functools import cached_property, lru_cache
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.planning.model.types import Column
from yarm.planning.roadmap.graph import NearestTable, Neighbours, delaunay_edges, nearest, neighbours_of
from yarm.planning.roadmap.particles import cell_order, moved_order

NEAR = 12
"""Nearest columns that a further column is joined with, in use or not."""
OFFSETS = 16
"""Number of equally even sets of particles that a seed chooses from."""


class Tables:
    """What the columns of a roadmap alone determine, made when first asked for."""

    def __init__(self, make: Callable[[], Tuple[IntArray, IntArray]]) -> None:
        """Of particles (n, 2) and further columns (m, 2), all distinct, that ``make`` gives."""
        self._make = make

    @cached_property
    def _made(self) -> Tuple[IntArray, IntArray]:
        return self._make()

    @cached_property
    def count(self) -> int:
        """How many columns are always in use."""
        return len(self._made[0])

    @cached_property
    def all(self) -> IntArray:
        """Every column, the further ones last."""
        return np.concatenate(self._made)

    @cached_property
    def columns(self) -> Tuple[Column, ...]:
        """The same as pairs."""
        return tuple(zip(self.all[:, 0].tolist(), self.all[:, 1].tolist()))

    @cached_property
    def edges(self) -> IntArray:
        """Edges (m, 2) of the triangulation of the first ``count``."""
        return delaunay_edges(self.all[: self.count])

    @cached_property
    def neighbours(self) -> Neighbours:
        """For each of the first ``count``, those it shares an edge with."""
        return neighbours_of(self.count, self.edges)

    @cached_property
    def near(self) -> NearestTable:
        """The nearest to each column."""
        return NearestTable(self.all, NEAR)


class Roadmap:
    """Particles and their graph, made when a search first needs it.

    The particles are triangulated. Further columns may be added to them where a map asks for it (``denser``); those are
    joined with their nearest instead, so that all tables stay the same from step to step while the map changes. A
    search that these do not lead to its goal may add some of its own (``admits``), which end with it.
    """

    def __init__(
        self, tables: Tables, choose: Optional[Callable[[IntArray], BoolArray]] = None, ceiling: Optional[int] = None
    ) -> None:
        """A roadmap over tables.

        Args:
            tables: of all its columns.
            choose: see ``denser``; without it no further column is in use.
            ceiling: most columns that a search may use, those it adds counted; None: any number.
        """
        self._tables, self._choose, self._ceiling = tables, choose, ceiling
        self._added = 0

    @staticmethod
    def of(particles: IntArray, further: Optional[IntArray] = None) -> Roadmap:
        """The roadmap of particles (n, 2) and further columns (m, 2), all distinct; the further ones are not in use."""
        return Roadmap(Tables(lambda: (particles, particles[:0] if further is None else further)))

    def denser(self, choose: Callable[[IntArray], BoolArray]) -> Roadmap:
        """This roadmap with some of its further columns in use.

        Args:
            choose: gives for columns (m, 2) which (m,) are wanted; asked when a search first needs them.
        """
        return Roadmap(self._tables, choose, self._ceiling)

    def admits(self, count: int) -> bool:
        """Whether a search may add so many columns to those in use; if so they count as used."""
        if self._ceiling is not None and int(self._used.sum()) + count > self._ceiling:
            return False
        self._added = max(self._added, count)
        return True

    @property
    def used(self) -> int:
        """How many columns the searches needed so far: those in use and the most that one added; 0 without a search."""
        return int(self._used.sum()) + self._added if "_used" in self.__dict__ else 0

    @cached_property
    def _used(self) -> BoolArray:
        """Which of all columns are in use."""
        tables = self._tables
        used = np.ones(len(tables.all), dtype=np.bool_)
        further = tables.all[tables.count :]
        used[tables.count :] = self._choose(further) if self._choose is not None and len(further) else False
        return used

    @cached_property
    def _joined_edges(self) -> IntArray:
        """Edges (m, 2) between each further column in use and those of its nearest in use."""
        first = self._tables.count
        return self._tables.near.edges(first + np.flatnonzero(self._used[first:]), self._used)

    @cached_property
    def _joined(self) -> Dict[int, List[int]]:
        joined: Dict[int, List[int]] = defaultdict(list)
        for a, b in self._joined_edges.tolist():
            joined[a].append(b)
            joined[b].append(a)
        return {i: sorted(others) for i, others in joined.items()}

    @property
    def columns(self) -> Tuple[Column, ...]:
        """Every column, those not in use too."""
        return self._tables.columns

    def neighbours(self, i: int) -> Sequence[int]:
        """Indices of the columns that one in use shares an edge with."""
        tables = self._tables
        own: Sequence[int] = tables.neighbours[i] if i < tables.count else ()
        others = self._joined.get(i)
        return [*own, *others] if others else own

    def nearest(self, column: Column, count: int) -> Tuple[int, ...]:
        """Indices of the columns in use nearest to a column, nearest first."""
        used = np.flatnonzero(self._used)
        return tuple(used[list(nearest(self._tables.all[used], column, count))].tolist())

    @property
    def particles(self) -> IntArray:
        """Columns (n, 2) in use, for display: without further ones while no search has needed them."""
        return self._tables.all[self._used] if "_used" in self.__dict__ else self._tables.all[: self._tables.count]

    @property
    def edges(self) -> IntArray:
        """Edges (m, 2) of the graph, pairs of indices into ``particles``, for display."""
        tables = self._tables
        if "_used" not in self.__dict__ or not self._used[tables.count :].any():
            return tables.edges
        number = np.cumsum(self._used) - 1
        return np.concatenate([tables.edges, number[self._joined_edges]])


@lru_cache(maxsize=32)
def even_roadmap(
    shape: Tuple[int, int], count: int, offset: int, factor: float = 1.0, ceiling: Optional[int] = None
) -> Roadmap:
    """The roadmap over the first columns of an even order of all columns of a grid, kept.

    Args:
        shape: columns along x and y.
        count: number of particles; no more than there are columns.
        offset: one of ``OFFSETS`` equally even sets.
        factor: how many times ``count`` columns there are with the further ones.
        ceiling: most columns that a search may use, and that there are; None: any number.
    """
    most = math.inf if ceiling is None else ceiling
    first = int(min(count, most))

    def make() -> Tuple[IntArray, IntArray]:
        order = moved_order(cell_order(shape), shape, offset)
        return order[:first], order[first : int(min(math.ceil(min(first, len(order)) * factor), most))]

    return Roadmap(Tables(make), None, ceiling)
