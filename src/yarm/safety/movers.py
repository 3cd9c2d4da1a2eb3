"""How fast things move that only the grid knows: people, and whatever else nobody registered."""

from __future__ import annotations

import math
from collections import deque
from typing import Deque, Dict, Mapping, Tuple

import numpy as np

from yarm.geometry import GridSpec, IntArray

WINDOW_S = 0.22
"""Motion is measured over the maps of this time, s: seven at 30 Hz."""
LEAST_MAPS = 4
"""Fewer maps tell no motion."""
STEADY = 0.75
"""The fewest cells over the most within the window: below, a thing comes into view or out of it, and seems to move."""
FASTEST_MPS = 2.0
"""Nobody is taken to move faster."""


class Movers:
    """Follows the middle of each thing's cells from map to map. Not thread-safe; simulated seconds throughout."""

    def __init__(self, slowest_mps: float, window_s: float = WINDOW_S) -> None:
        """Nothing seen yet.

        Args:
            slowest_mps: what seems to move slower stands: noise at its edge moves its middle, too.
            window_s: motion is measured over the maps of this time, s; at least four of them.
        """
        self._slowest_mps, self._window_s = slowest_mps, window_s
        self._seen: Dict[str, Deque[Tuple[float, float, float, int]]] = {}
        self._stamp_s = -math.inf

    def see(self, stamp_s: float, spec: GridSpec, things: Mapping[str, IntArray]) -> None:
        """Take in a map; one that is not newer than the last is left out.

        Args:
            stamp_s: of the map.
            spec: its grid.
            things: cells (n, 3) of each, by name.
        """
        if stamp_s <= self._stamp_s:
            return
        self._stamp_s = stamp_s
        for name in set(self._seen) - set(things):
            del self._seen[name]
        for name, cells in things.items():
            history = self._seen.setdefault(name, deque())
            x, y, _ = spec.centres(cells).mean(axis=0)
            history.append((stamp_s, float(x), float(y), len(cells)))
            while stamp_s - history[0][0] > self._window_s:
                history.popleft()

    def velocity(self, name: str) -> Tuple[float, float]:
        """Velocity of a thing, m/s, world: the slope of its middle over time; (0, 0) of one that stands or is new."""
        seen = np.array(self._seen.get(name, ()))
        if len(seen) < LEAST_MAPS or seen[:, 3].min() < STEADY * seen[:, 3].max():
            return 0.0, 0.0
        t_s = seen[:, 0] - seen[:, 0].mean()
        vx, vy = (float(t_s @ seen[:, axis] / (t_s @ t_s)) for axis in (1, 2))
        speed = math.hypot(vx, vy)
        if speed < self._slowest_mps:
            return 0.0, 0.0
        share = min(1.0, FASTEST_MPS / speed)
        return share * vx, share * vy

    def reset(self) -> None:
        """Time went backwards."""
        self._seen.clear()
        self._stamp_s = -math.inf
