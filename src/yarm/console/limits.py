"""How often something may happen: a bucket that fills at a steady rate and is emptied by use."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from typing import Callable

Clock = Callable[[], float]
MOST_PEERS = 256
"""Peers that are remembered; the one heard of longest ago is forgotten first."""


@dataclass(frozen=True)
class Rate:
    """How often: ``per_s`` in the long run, ``burst`` at once."""

    per_s: float
    burst: float


class Bucket:
    """Lets things through at a rate. Not thread-safe."""

    def __init__(self, rate: Rate, clock: Clock) -> None:
        """Full.

        Args:
            rate: how often.
            clock: seconds that never go backwards.
        """
        self._rate, self._clock = rate, clock
        self._left, self._at_s = rate.burst, clock()

    def take(self) -> bool:
        """Whether one more may happen now; it counts when it may."""
        now_s = self._clock()
        self._left = min(self._rate.burst, self._left + (now_s - self._at_s) * self._rate.per_s)
        self._at_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class PeerBuckets:
    """A bucket for each peer, by its address. Not thread-safe."""

    def __init__(self, rate: Rate, clock: Clock) -> None:
        """Nobody known; arguments as of a bucket."""
        self._rate, self._clock = rate, clock
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()

    def take(self, peer: str) -> bool:
        """Whether one more of a peer may happen now."""
        if peer not in self._buckets:
            self._buckets[peer] = Bucket(self._rate, self._clock)
            if len(self._buckets) > MOST_PEERS:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(peer)
        return self._buckets[peer].take()
