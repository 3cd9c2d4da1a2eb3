from __future__ import annotations

import math
from typing import List

import pytest
from hypothesis import given
from hypothesis import strategies as st

from yarm.planning.roadmap.cost_queue import CostQueue

COSTS = st.lists(st.floats(-1e6, 1e6), max_size=60)


@given(COSTS)
def test_items_come_out_cheapest_first_and_ties_in_order_of_pushing(costs: List[float]) -> None:
    queue: CostQueue[int] = CostQueue()
    for i, cost in enumerate(costs):
        queue.push(cost, i)
    popped = [queue.pop() for _ in range(len(queue))]
    assert popped == sorted(((cost, i) for i, cost in enumerate(costs)), key=lambda entry: entry)
    assert queue.is_empty


@given(COSTS)
def test_view_shows_what_pop_will_give_and_takes_nothing_out(costs: List[float]) -> None:
    queue: CostQueue[int] = CostQueue()
    for i, cost in enumerate(costs):
        queue.push(cost, i)
    seen = queue.view()
    assert len(queue) == len(costs)
    assert list(seen) == [queue.pop() for _ in costs]


def test_items_need_not_be_comparable() -> None:
    queue: CostQueue[object] = CostQueue()
    first, second = object(), object()
    queue.push(1.0, first)
    queue.push(1.0, second)
    assert queue.pop()[1] is first


def test_nan_is_refused_and_an_empty_queue_has_nothing_to_pop() -> None:
    queue: CostQueue[int] = CostQueue()
    with pytest.raises(ValueError, match="NaN"):
        queue.push(math.nan, 1)
    with pytest.raises(IndexError):
        queue.pop()
