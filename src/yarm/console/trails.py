"""Where things have been: a point every few centimetres."""

from __future__ import annotations

import math
from collections import deque
from typing import Deque, Dict, List, Tuple

import numpy as np

from yarm.console.picture import Line

STEP_M = 0.05
"""Distance between two points of a trail, metres."""
POINTS = 600
"""Points of a trail at most; the oldest go."""


class Trails:
    """The way behind each robot. Not thread-safe."""

    def __init__(self) -> None:
        """Nobody has moved yet."""
        self._ways: Dict[str, Deque[Tuple[float, float]]] = {}

    def follow(self, name: str, x: float, y: float) -> None:
        """Somebody is at a place, metres, world."""
        way = self._ways.setdefault(name, deque(maxlen=POINTS))
        if not way or math.hypot(x - way[-1][0], y - way[-1][1]) >= STEP_M:
            way.append((x, y))

    def clear(self) -> None:
        """Forget all (time went backwards)."""
        self._ways.clear()

    def lines(self, height_m: float) -> List[Line]:
        """The ways behind, at a height above the floor, metres."""
        return [
            Line("driven", name, np.column_stack([np.array(way), np.full(len(way), height_m)]))
            for name, way in sorted(self._ways.items())
            if len(way) > 1
        ]
