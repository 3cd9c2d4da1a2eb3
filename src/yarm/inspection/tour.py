"""In which order to visit: one of several viewpoints a box, from home and back.

The exact tour is Held and Karp's dynamic programme over sets of boxes (*A dynamic programming approach to sequencing
problems*, 1962), with the viewpoints of a box as its states.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Callable, List, Mapping, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, IntArray

SmallIntArray = npt.NDArray[np.int16]

MOST_EXACT = 15
"""Boxes up to which the tour is exact."""
Fits = Callable[[float, int], bool]
"""Whether a closed way of this cost over so many stops is short enough."""


@dataclass(frozen=True)
class Tour:
    """A closed way.

    Attributes:
        stops: indices of the viewpoints, in visiting order.
        cost: of the whole way, home to home, in the unit of the costs; inf when some box cannot be visited.
        gap: how much more than the cheapest over the same boxes it costs at most, as a share; 0 when solved exactly.
    """

    stops: Tuple[int, ...]
    cost: float
    gap: float = 0.0


def way_cost(costs: FloatArray, stops: Sequence[int], home_last: bool = True) -> float:
    """Cost of a way from home over the stops, and back home.

    Args:
        costs: (n + 1, n + 1) from row to column; the last row and column are home.
        stops: indices of viewpoints.
        home_last: whether it ends at home.
    """
    home = len(costs) - 1
    places = [home, *stops, home] if home_last else [home, *stops]
    return float(sum(costs[a, b] for a, b in zip(places, places[1:])))


def greedy_tour(costs: FloatArray, box_of: Sequence[int]) -> Tour:
    """Always to the nearest viewpoint of a box not yet visited; the way home is not looked at."""
    home, at = len(costs) - 1, len(costs) - 1
    stops: List[int] = []
    left = set(box_of)
    while left:
        open_stops = [i for i, box in enumerate(box_of) if box in left]
        at = min(open_stops, key=lambda i: (costs[at, i], i))
        stops.append(at)
        left.discard(box_of[at])
    return Tour(tuple(stops), way_cost(costs, stops) if stops else float(costs[home, home]))


def brute_force_tour(costs: FloatArray, box_of: Sequence[int]) -> Tour:
    """Every order and every choice; for few boxes, and to check the exact tour."""
    groups = [[i for i, box in enumerate(box_of) if box == number] for number in sorted(set(box_of))]
    best = Tour((), np.inf)
    for chosen in itertools.product(*groups):
        for order in itertools.permutations(chosen):
            cost = way_cost(costs, order)
            if cost < best.cost:
                best = Tour(tuple(order), cost)
    return best


def exact_tour(costs: FloatArray, box_of: Sequence[int]) -> Tour:
    """The cheapest closed tour over one viewpoint of every box.

    Args:
        costs: (n + 1, n + 1) from row to column, not negative; the last row and column are home.
        box_of: box of each of the n viewpoints.

    Raises:
        ValueError: more boxes than MOST_EXACT.
    """
    solved = _Solved(costs, box_of)
    return solved.tour(len(solved.totals) - 1)


def largest_tour(costs: FloatArray, box_of: Sequence[int], fits: Fits, worth: Mapping[int, float]) -> Tour:
    """The closed tour that fits over the boxes that are worth most together; the cheapest among equals.

    Args:
        costs: as for :func:`exact_tour`.
        box_of: box of each of the n viewpoints.
        fits: whether a tour is short enough; more never fits better than less.
        worth: of a visit to each box, not negative.

    Raises:
        ValueError: more boxes than MOST_EXACT.
    """
    solved = _Solved(costs, box_of)
    inside = np.arange(len(solved.totals))[:, None] >> np.arange(len(solved.numbers)) & 1
    value = inside @ np.array([worth[number] for number in solved.numbers], dtype=float)
    order = np.lexsort((solved.totals, -value))
    for chosen in order:
        cost = float(solved.totals[chosen])
        if np.isfinite(cost) and fits(cost, int(inside[chosen].sum())):
            return solved.tour(int(chosen))
    return Tour((), float(costs[-1, -1]))


class _Solved:
    """The cheapest tour over every set of boxes; a set's bits follow the order of the boxes' numbers."""

    def __init__(self, costs: FloatArray, box_of: Sequence[int]) -> None:
        self.numbers = sorted(set(box_of))
        if len(self.numbers) > MOST_EXACT:
            raise ValueError(f"{len(self.numbers)} boxes; an exact tour is solved for at most {MOST_EXACT}")
        self._groups = [np.array([i for i, box in enumerate(box_of) if box == number]) for number in self.numbers]
        self.totals: FloatArray = np.full(1 << len(self._groups), np.inf)
        self.totals[0] = costs[-1, -1]
        self._last: Optional[IntArray] = None
        if self._groups:
            best, self._before = _tables(costs[:-1, :-1], costs[-1, :-1], self._groups)
            ends = best[1:] + costs[:-1, -1]
            self._last = np.argmin(ends, axis=1)
            self.totals[1:] = ends[np.arange(len(ends)), self._last]

    def tour(self, chosen: int) -> Tour:
        """Over a set of boxes; without stops when it has none or no way."""
        cost = float(self.totals[chosen])
        if chosen == 0 or self._last is None or not np.isfinite(cost):
            return Tour((), cost)
        return Tour(_trace(self._before, self._groups, chosen, int(self._last[chosen - 1])), cost)


def _tables(between: FloatArray, from_home: FloatArray, groups: Sequence[IntArray]) -> Tuple[FloatArray, SmallIntArray]:
    """For every set of boxes and last viewpoint in it: least cost from home, and the viewpoint before."""
    n_sets, n = 1 << len(groups), len(between)
    best = np.full((n_sets, n), np.inf)
    before = np.full((n_sets, n), -1, np.int16)
    for g, group in enumerate(groups):
        best[1 << g, group] = from_home[group]
    sizes = np.array([bin(s).count("1") for s in range(n_sets)])
    for size in range(1, len(groups)):
        sets = np.flatnonzero(sizes == size)
        for g, group in enumerate(groups):
            open_sets = sets[(sets >> g) & 1 == 0]
            _extend(best, before, open_sets, 1 << g, group, between)
    return best, before


def _extend(
    best: FloatArray, before: SmallIntArray, sets: IntArray, bit: int, group: IntArray, between: FloatArray
) -> None:
    """Every one of the sets grows by the box with this bit."""
    for stop in group:
        totals = best[sets] + between[:, stop]
        last = np.argmin(totals, axis=1)
        best[sets | bit, stop] = totals[np.arange(len(sets)), last]
        before[sets | bit, stop] = last


def _trace(before: SmallIntArray, groups: Sequence[IntArray], everything: int, last: int) -> Tuple[int, ...]:
    stops, at, left = [last], last, everything
    while before[left, at] >= 0:
        previous = int(before[left, at])
        left &= ~(1 << next(g for g, group in enumerate(groups) if at in group))
        at = previous
        stops.append(at)
    return tuple(reversed(stops))
