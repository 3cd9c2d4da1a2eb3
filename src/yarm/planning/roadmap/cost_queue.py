"""The queue of YARM's search: the cheapest list of waypoints first."""

from __future__ import annotations

import heapq
import math
from typing import Generic, List, Tuple, TypeVar

T = TypeVar("T")


class CostQueue(Generic[T]):
    """Priority queue of (cost, item). Equal costs come out in the order they were pushed, every time."""

    def __init__(self) -> None:
        """Empty."""
        self._heap: List[Tuple[float, int, T]] = []
        self._pushed = 0

    def push(self, cost: float, item: T) -> None:
        """Add an item; O(log n).

        Raises:
            ValueError: the cost is not a number.
        """
        if math.isnan(cost):
            raise ValueError("the cost of an item must be a number, got NaN")
        heapq.heappush(self._heap, (cost, self._pushed, item))
        self._pushed += 1

    def pop(self) -> Tuple[float, T]:
        """Take the cheapest item out; O(log n).

        Raises:
            IndexError: the queue is empty.
        """
        cost, _, item = heapq.heappop(self._heap)
        return cost, item

    def view(self) -> Tuple[Tuple[float, T], ...]:
        """Every (cost, item), cheapest first, left where they are; O(n log n)."""
        return tuple((cost, item) for cost, _, item in sorted(self._heap, key=lambda entry: entry[:2]))

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left."""
        return not self._heap

    def __len__(self) -> int:
        """Number of items."""
        return len(self._heap)
