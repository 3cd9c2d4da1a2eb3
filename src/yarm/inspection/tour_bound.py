"""How much cheaper than a tour that was found any other can be, where there are too many boxes to solve it exactly.

Every tour goes into and out of each box. If it need not leave a box from the viewpoint at which it came, its least cost
is that of a travelling salesman over boxes, which is a lower bound. Prices on the viewpoints, paid on arrival and given
back on departure, change the cost of no true tour but raise the bound (Lagrange); they are found by subgradient steps,
in which the library's assignment stands in for the salesman, and the library solves the salesman in the end.
"""

from __future__ import annotations

from typing import Sequence, Tuple

import numpy as np
from ortools.sat.python import cp_model
from scipy.optimize import linear_sum_assignment

from yarm.geometry import FloatArray, IntArray

STEPS = 200
PATIENCE, SHRINK = 10, 0.6
"""After so many steps without a better bound the steps get shorter by this factor."""
SCALE = 1000.0
"""The library's costs are whole numbers: thousandths."""
EFFORT = 5.0
"""The library's measure of work spent on the salesman at most; about seconds, but the same on every machine."""
NEVER = 1e9


def lower_bound(costs: FloatArray, box_of: Sequence[int], found: float) -> float:
    """What no closed tour over one viewpoint of every box can cost less than.

    Args:
        costs: (n + 1, n + 1) from row to column; inf where there is no way. The last row and column are home.
        box_of: box of each of the n viewpoints.
        found: cost of a tour that was found, which sets the length of the steps.
    """
    table = _Boxes(np.minimum(costs, NEVER), box_of)
    prices = best_prices = np.zeros(len(costs))
    best, step, stale = -np.inf, 1.0, 0
    for _ in range(STEPS):
        arcs, bound, slopes = table.assigned(prices)
        if bound > best + 1e-9:
            best, best_prices, stale = bound, prices, 0
        else:
            stale += 1
        if stale >= PATIENCE:
            prices, step, stale = best_prices, SHRINK * step, 0
            continue
        length = float(slopes @ slopes)
        if length == 0.0 or not arcs:
            break
        prices = prices + step * (found - bound) / length * slopes
    return min(found, max(best, _salesman(table.cheapest(best_prices)[0])))


class _Boxes:
    """Costs between boxes, home being one more, of costs between viewpoints."""

    def __init__(self, costs: FloatArray, box_of: Sequence[int]) -> None:
        order = [*sorted(range(len(box_of)), key=lambda i: box_of[i]), len(box_of)]
        labels = [*sorted(box_of), None]
        self._costs = costs[np.ix_(order, order)]
        self._starts = np.array([i for i, label in enumerate(labels) if i == 0 or label != labels[i - 1]])
        self._ends = np.append(self._starts[1:], len(labels))
        self._order = np.array(order)

    def cheapest(self, prices: FloatArray) -> Tuple[FloatArray, FloatArray]:
        """Of all ways between two boxes the least cost (b, b), and all costs (n + 1, n + 1) in the order of boxes."""
        priced = prices[self._order]
        costs = self._costs + priced[None, :] - priced[:, None]
        least = np.minimum.reduceat(np.minimum.reduceat(costs, self._starts, axis=0), self._starts, axis=1)
        return least, costs

    def assigned(self, prices: FloatArray) -> Tuple[int, float, FloatArray]:
        """Number of boxes, cost of the best assignment of successors, and how it grows with each price (n + 1,)."""
        least, costs = self.cheapest(prices)
        np.fill_diagonal(least, NEVER)
        rows, columns = linear_sum_assignment(least)
        slopes = np.zeros(len(costs))
        for a, b in zip(rows, columns):
            leave, arrive = self._cheapest_way(costs, int(a), int(b))
            slopes[self._order[arrive]] += 1.0
            slopes[self._order[leave]] -= 1.0
        return len(rows), float(least[rows, columns].sum()), slopes

    def _cheapest_way(self, costs: FloatArray, a: int, b: int) -> Tuple[int, int]:
        block = costs[self._starts[a] : self._ends[a], self._starts[b] : self._ends[b]]
        leave, arrive = np.unravel_index(int(np.argmin(block)), block.shape)
        return int(self._starts[a] + leave), int(self._starts[b] + arrive)


def _salesman(costs: FloatArray) -> float:
    """Least cost of a round over all rows, or as much as the library has proved of it."""
    count = len(costs)
    model = cp_model.CpModel()
    whole: IntArray = np.floor(np.minimum(costs, NEVER) * SCALE).astype(np.int64)
    arcs = [(i, j, model.NewBoolVar("")) for i in range(count) for j in range(count) if i != j]
    model.AddCircuit(arcs)
    model.Minimize(sum(int(whole[i, j]) * taken for i, j, taken in arcs))
    solver = cp_model.CpSolver()
    solver.parameters.num_workers = 1
    solver.parameters.max_deterministic_time = EFFORT
    solver.Solve(model)
    return float(solver.BestObjectiveBound()) / SCALE
