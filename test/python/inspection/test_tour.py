"""Orders of visiting: the practice world's lengths, and the exact tour against every order there is."""

from __future__ import annotations

import itertools
from typing import List, Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray
from yarm.inspection.inputs import read_boxes
from yarm.inspection.tour import brute_force_tour, exact_tour, greedy_tour, largest_tour, way_cost
from yarm.inspection.tour_search import thinned
from yarm.inspection.viewpoints import viewpoint
from yarm.resources import resource

PUBLISHED = (6, 4, 3, 2, 1, 7, 10, 9, 8, 5)


def practice() -> Tuple[FloatArray, List[int]]:
    views = [viewpoint(box, 0.5, 0) for box in read_boxes(resource("scenes", "inspection", "practice_boxes.yaml"))]
    places = np.array([(view.pose.x, view.pose.y) for view in views] + [(0.0, 0.0)])
    return np.linalg.norm(places[:, None] - places[None], axis=2), [view.box for view in views]


def test_lengths_in_the_practice_world() -> None:
    costs, box_of = practice()
    exact, greedy = exact_tour(costs, box_of), greedy_tour(costs, box_of)
    assert [box_of[i] for i in exact.stops] == [6, 5, 4, 3, 2, 1, 7, 10, 8, 9]
    assert [box_of[i] for i in greedy.stops] == [6, 9, 10, 8, 7, 1, 3, 2, 4, 5]
    published = way_cost(costs, [box_of.index(number) for number in PUBLISHED])
    assert (exact.cost, greedy.cost, published) == pytest.approx((15.763, 16.430, 18.664), abs=1e-3)


@pytest.mark.parametrize("seed", range(12))
def test_exact_is_as_cheap_as_every_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    box_of = sorted(int(number) for number in rng.integers(0, 5, 9))
    costs = rng.random((10, 10)) * 10.0
    exact, brute = exact_tour(costs, box_of), brute_force_tour(costs, box_of)
    assert exact.cost == pytest.approx(brute.cost), f"seed {seed}"
    assert way_cost(costs, exact.stops) == pytest.approx(exact.cost), f"seed {seed}"
    assert sorted({box_of[i] for i in exact.stops}) == sorted(set(box_of)) and len(exact.stops) == len(set(box_of))
    assert greedy_tour(costs, box_of).cost >= exact.cost - 1e-9


def test_a_box_without_a_way_has_no_tour() -> None:
    costs = np.full((3, 3), np.inf)
    costs[0, 2] = costs[2, 0] = 1.0
    assert exact_tour(costs, [1, 2]).cost == np.inf and exact_tour(costs, [1, 2]).stops == ()


def test_without_boxes_it_stays_at_home() -> None:
    assert exact_tour(np.zeros((1, 1)), []).stops == ()


def test_too_many_boxes_are_refused() -> None:
    with pytest.raises(ValueError, match="16 boxes"):
        exact_tour(np.zeros((17, 17)), list(range(16)))


@pytest.mark.parametrize("seed", range(12))
def test_the_largest_tour_is_the_best_of_all_subsets_that_fit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    box_of = sorted(int(number) for number in rng.integers(0, 5, 9))
    costs = rng.random((10, 10)) * 10.0
    worth = {number: float(rng.choice([1.0, 0.01])) for number in set(box_of)}
    limit = 0.6 * exact_tour(costs, box_of).cost
    best = (0.0, 0.0)
    for size in range(1, len(worth) + 1):
        for chosen in itertools.combinations(sorted(worth), size):
            kept = [i for i, number in enumerate(box_of) if number in chosen]
            rows = np.ix_([*kept, 9], [*kept, 9])
            cost = brute_force_tour(costs[rows], [box_of[i] for i in kept]).cost
            if cost + 0.1 * size <= limit:
                best = max(best, (sum(worth[number] for number in chosen), -cost))
    tour = largest_tour(costs, box_of, lambda cost, stops: cost + 0.1 * stops <= limit, worth)
    value = sum(worth[box_of[i]] for i in tour.stops)
    assert value == pytest.approx(best[0]), f"seed {seed}"
    assert not tour.stops or tour.cost == pytest.approx(-best[1]), f"seed {seed}"
    kept = thinned(
        costs, box_of, greedy_tour(costs, box_of).stops, lambda cost, stops: cost + 0.1 * stops <= limit, worth
    )
    assert not kept or way_cost(costs, kept) + 0.1 * len(kept) <= limit, f"seed {seed}"
    assert sum(worth[box_of[i]] for i in kept) <= value + 1e-9, f"seed {seed}"


def test_with_time_enough_the_largest_tour_is_the_exact_one() -> None:
    costs, box_of = practice()
    assert largest_tour(costs, box_of, lambda cost, stops: True, dict.fromkeys(box_of, 1.0)) == exact_tour(
        costs, box_of
    )
