"""Which results of actions a map finds, in lock-step: all of the ticks before it, however late they come."""

from __future__ import annotations

import threading
from typing import Optional, Tuple

TICK_S = 0.02
"""More than the time from one tick to the next, s."""
LIMIT_S = 5.0
"""Longest wall time that a map waits for results, s."""


class ResultCount:
    """Results that were sent, by the acknowledgements of who sent them, and those that have come. Thread-safe."""

    def __init__(self, limit_s: float = LIMIT_S) -> None:
        """Nothing sent yet."""
        self._limit_s = limit_s
        self._condition = threading.Condition()
        self._sent: Optional[Tuple[float, int]] = None
        self._come = 0

    def acknowledged(self, stamp_s: float, results_sent: int) -> None:
        """Whoever serves the actions is done with a tick, s, and has sent so many results in all; 0: it serves none."""
        if results_sent:
            with self._condition:
                self._sent = stamp_s, results_sent
                self._condition.notify_all()

    def came(self) -> None:
        """A result has come, and what follows from it was noted."""
        with self._condition:
            self._come += 1
            self._condition.notify_all()

    def take(self, map_s: float) -> bool:
        """Wait for every result that was sent in the ticks before a map of a time, s; False when one is missing."""
        with self._condition:
            if self._sent is None:
                return True
            return self._condition.wait_for(lambda: self._all_came(map_s), self._limit_s)

    def _all_came(self, map_s: float) -> bool:
        return self._sent is None or (self._sent[0] >= map_s - TICK_S and self._come >= self._sent[1])

    def forget(self) -> None:
        """A new run: counts begin at 0."""
        with self._condition:
            self._sent, self._come = None, 0
            self._condition.notify_all()
