"""How near each robot came to anything, over time, kept small."""

from __future__ import annotations

import math
from array import array
from bisect import bisect_left
from dataclasses import dataclass, field
from typing import Dict, List, Tuple


@dataclass
class _Readings:
    times_s: array[float] = field(default_factory=lambda: array("d"))
    distances_m: array[float] = field(default_factory=lambda: array("d"))
    others: array[int] = field(default_factory=lambda: array("H"))


class Nearness:
    """Readings in the order they came; those beyond the simulator's range are not kept."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._names: List[str] = []
        self._of: Dict[str, _Readings] = {}

    def add(self, time_s: float, robot: str, nearest: str, distance_m: float) -> None:
        """What a robot is nearest to at a time, s, and how near, metres."""
        if not math.isfinite(distance_m):
            return
        if nearest not in self._names:
            self._names.append(nearest)
        own = self._of.setdefault(robot, _Readings())
        own.times_s.append(time_s)
        own.distances_m.append(distance_m)
        own.others.append(self._names.index(nearest))

    def least(self, robot: str, from_s: float = -math.inf, to_s: float = math.inf) -> Tuple[float, str]:
        """The least distance, metres, from one time to before another, s, and to what; inf and "" for nothing."""
        own = self._of.get(robot, _Readings())
        first, last = bisect_left(own.times_s, from_s), bisect_left(own.times_s, to_s)
        if first >= last:
            return math.inf, ""
        at = min(range(first, last), key=lambda i: own.distances_m[i])
        return float(own.distances_m[at]), self._names[own.others[at]]
