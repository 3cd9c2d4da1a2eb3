"""Tours by search: as cheap as the exact ones, 30 boxes with a proven gap, never longer than there is time."""

from __future__ import annotations

import math
from typing import List, Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray, Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.times import DriveTimes
from yarm.inspection.tour import MOST_EXACT, brute_force_tour, exact_tour, greedy_tour, way_cost
from yarm.inspection.tour_bound import lower_bound
from yarm.inspection.tour_plan import ANGLES_DEG, DISTANCES_M, Budget
from yarm.inspection.tour_search import routed_stops, searched_tour
from yarm.inspection.viewpoints import viewpoint

PLENTY = Budget(1e5, 1.0, 2.0).fits
VIEWS = 12


def drawn(boxes: int, views: int, seed: int) -> Tuple[FloatArray, List[int]]:
    """Drive times among views of boxes drawn at random, as in a round without walls, and the box of each view."""
    rng = np.random.default_rng(seed)
    poses, box_of = [], []
    for number in range(1, boxes + 1):
        box = Box(number, Pose2(*rng.uniform(-3.0, 3.0, 2), rng.uniform(-math.pi, math.pi)))
        for pick in rng.choice(len(DISTANCES_M) * len(ANGLES_DEG), views, replace=False):
            found = viewpoint(box, DISTANCES_M[pick % len(DISTANCES_M)], ANGLES_DEG[pick // len(DISTANCES_M)])
            poses.append(found.pose)
            box_of.append(number)
    places = [*poses, Pose2(0.0, 0.0)]
    times = [[DriveTimes.undisturbed_s(a.distance(b), a, b) for b in places] for a in places]
    return np.array(times), box_of


@pytest.mark.parametrize(("boxes", "seed"), [(4, 0), (8, 1), (10, 2), (12, 3)])
def test_it_is_as_cheap_as_the_exact_tour_within_its_gap(boxes: int, seed: int) -> None:
    costs, box_of = drawn(boxes, 6, seed)
    exact = exact_tour(costs, box_of).cost
    stops = routed_stops(costs, box_of)
    cost = way_cost(costs, stops)
    assert sorted(box_of[i] for i in stops) == sorted(set(box_of))
    assert exact - 1e-6 <= cost <= 1.02 * exact
    bound = lower_bound(costs, box_of, cost)
    assert 0.7 * exact < bound <= exact + 1e-6, "what the gap is reported by"
    assert searched_tour(costs, box_of, PLENTY, dict.fromkeys(box_of, 1.0)).cost == pytest.approx(exact)


def test_thirty_boxes_with_twelve_views_each() -> None:
    costs, box_of = drawn(2 * MOST_EXACT, VIEWS, 0)
    worth = dict.fromkeys(box_of, 1.0)
    found = searched_tour(costs, box_of, PLENTY, worth)
    assert sorted(box_of[i] for i in found.stops) == sorted(set(box_of))
    assert found.cost < 0.95 * greedy_tour(costs, box_of).cost
    assert 0.0 < found.gap < 0.3
    assert searched_tour(costs, box_of, PLENTY, worth) == found, "the same again"


@pytest.mark.parametrize("seed", range(8))
def test_no_tour_is_cheaper_than_the_bound(seed: int) -> None:
    rng = np.random.default_rng(seed)
    box_of = sorted(int(number) for number in rng.integers(0, 5, 9))
    costs = rng.random((10, 10)) * 10.0
    best = brute_force_tour(costs, box_of).cost
    shuffled = rng.permutation(9)
    rows = np.ix_([*shuffled, 9], [*shuffled, 9])
    for table, boxes in ((costs, box_of), (costs[rows], [box_of[i] for i in shuffled])):
        for found in (best, 2.0 * best):
            assert 0.5 * best < lower_bound(table, boxes, found) <= best + 1e-3


def test_the_bound_of_one_view_a_box_is_the_salesmans_way() -> None:
    costs, box_of = drawn(9, 1, 5)
    exact = exact_tour(costs, box_of).cost
    assert lower_bound(costs, box_of, 1.5 * exact) == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_it_fits_the_time_and_leaves_out_what_is_worth_least(share: float) -> None:
    costs, box_of = drawn(20, 3, 7)
    worth = {number: 0.01 if number <= 4 else 1.0 for number in set(box_of)}
    whole = searched_tour(costs, box_of, PLENTY, worth)
    budget = Budget(share * (1.2 * whole.cost + 2.0 * 20), 1.2, 2.0)
    found = searched_tour(costs, box_of, budget.fits, worth)
    assert budget.fits(found.cost, len(found.stops)) and 0 < len(found.stops) < 20
    left_out = set(box_of) - {box_of[i] for i in found.stops}
    assert sum(number <= 4 for number in left_out) == min(4, len(left_out))
    assert (found.gap == 0.0) == (len(found.stops) <= MOST_EXACT)


def test_without_time_it_stays() -> None:
    costs, box_of = drawn(16, 2, 8)
    worth = dict.fromkeys(box_of, 1.0)
    for left_s in (-5.0, 0.5 * float(costs[-1, -1]), float(costs[-1, -1]) + 0.1):
        assert searched_tour(costs, box_of, Budget(left_s, 1.0, 2.0).fits, worth).stops == ()


def test_a_box_without_a_way_is_left_out() -> None:
    costs, box_of = drawn(18, 2, 9)
    for i, box in enumerate(box_of):
        if box == 3:
            costs[:, i] = np.inf
    found = searched_tour(costs, box_of, PLENTY, dict.fromkeys(box_of, 1.0))
    assert {box_of[i] for i in found.stops} == set(range(1, 19)) - {3} and math.isfinite(found.cost)
