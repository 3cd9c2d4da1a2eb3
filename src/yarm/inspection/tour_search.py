"""Tours over more boxes than can be solved exactly, by the library's routing: guided local search.

A vehicle leaves home and comes back; of each box's viewpoints it visits one. The search ends after a number of
solutions, not seconds, so that it is the same on every machine. Where there is no time for all boxes, those least
worth go first, and the order of the others is solved again.
"""

from __future__ import annotations

from typing import Mapping, Sequence, Tuple

import numpy as np
from ortools.constraint_solver import pywrapcp, routing_enums_pb2

from yarm.geometry import FloatArray, IntArray
from yarm.inspection.tour import MOST_EXACT, Fits, Tour, exact_tour, way_cost
from yarm.inspection.tour_bound import lower_bound

SOLUTIONS = 300
"""Looked at in one search: about 2 s for 30 boxes with 12 viewpoints each."""
LIMIT_S = 60
"""Of a search on a machine on which so many solutions take longer."""
SCALE = 1000.0
"""The library's costs are whole numbers: thousandths."""
NO_WAY = 10**9
LEFT_OUT = NO_WAY // 2
"""Price of leaving out a box: more than any round, less than a way that there is not."""


def searched_tour(costs: FloatArray, box_of: Sequence[int], fits: Fits, worth: Mapping[int, float]) -> Tour:
    """A cheap closed tour that fits, over boxes that are worth much together; with its gap.

    Args:
        costs: (n + 1, n + 1) from row to column, not negative, s; the last row and column are home.
        box_of: box of each of the n viewpoints.
        fits: whether a tour is short enough; more never fits better than less.
        worth: of a visit to each box, not negative.
    """
    stops = routed_stops(costs, box_of)
    kept = thinned(costs, box_of, stops, fits, worth)
    if not kept:
        return Tour((), float(costs[-1, -1]))
    boxes = {box_of[i] for i in kept}
    views = [i for i, box in enumerate(box_of) if box in boxes]
    rows = np.ix_([*views, len(box_of)], [*views, len(box_of)])
    table, of = costs[rows], [box_of[i] for i in views]
    if len(boxes) <= MOST_EXACT:
        solved = exact_tour(table, of)
        return Tour(tuple(views[i] for i in solved.stops), solved.cost)
    if len(kept) < len(stops):
        again = tuple(views[i] for i in routed_stops(table, of))
        kept = min(kept, again, key=lambda tour: way_cost(costs, tour))
    cost = way_cost(costs, kept)
    bound = lower_bound(table, of, cost)
    return Tour(kept, cost, cost / bound - 1.0 if bound > 0.0 else np.inf)


def thinned(
    costs: FloatArray, box_of: Sequence[int], stops: Sequence[int], fits: Fits, worth: Mapping[int, float]
) -> Tuple[int, ...]:
    """Stops of a tour without those that had to go until it fits: the least worth first, then the dearest."""
    home, kept = len(costs) - 1, list(stops)
    while kept and not fits(way_cost(costs, kept), len(kept)):
        places = [home, *kept, home]
        saved = [
            costs[before, at] + costs[at, after] - costs[before, after]
            for before, at, after in zip(places, places[1:], places[2:])
        ]
        del kept[min(range(len(kept)), key=lambda i: (worth[box_of[kept[i]]], -saved[i]))]
    return tuple(kept)


def routed_stops(costs: FloatArray, box_of: Sequence[int]) -> Tuple[int, ...]:
    """Stops of the best solution, over all boxes to which there is a way."""
    home = len(box_of)
    manager = pywrapcp.RoutingIndexManager(home + 1, 1, home)
    model = pywrapcp.RoutingModel(manager)
    model.SetArcCostEvaluatorOfAllVehicles(model.RegisterTransitMatrix(_whole(costs).tolist()))
    for box in sorted(set(box_of)):
        model.AddDisjunction([manager.NodeToIndex(i) for i, number in enumerate(box_of) if number == box], LEFT_OUT, 1)
    settings = pywrapcp.DefaultRoutingSearchParameters()
    settings.first_solution_strategy = routing_enums_pb2.FirstSolutionStrategy.PATH_CHEAPEST_ARC
    settings.local_search_metaheuristic = routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    settings.solution_limit = SOLUTIONS
    settings.time_limit.seconds = LIMIT_S
    found = model.SolveWithParameters(settings)
    stops, at = [], found.Value(model.NextVar(model.Start(0)))
    while not model.IsEnd(at):
        stops.append(manager.IndexToNode(at))
        at = found.Value(model.NextVar(at))
    return tuple(stops)


def _whole(values: FloatArray) -> IntArray:
    """Thousandths; where there is no way, more than any round takes."""
    whole: IntArray = np.round(np.minimum(values * SCALE, NO_WAY)).astype(np.int64)
    return whole
