"""Where things that nobody registered, people above all, will be in a moment if they go on as they do."""

from __future__ import annotations

import math
from typing import List

import numpy as np

from yarm.console.picture import Line
from yarm.geometry import CellMap, FloatArray
from yarm.safety.movers import Movers
from yarm.safety.params import SafetyParams

UNKNOWN = "unknown_"
"""Names of what nobody registered begin so."""
WINDOW_S = 0.6
"""Motion is measured over so long, s: several of the maps that a page gets."""
AHEAD_S = 1.0
"""So far ahead it is drawn, s."""
HEIGHT_M = 0.03
CORNERS = 24
LAYER = "predicted"


class Foresight:
    """Follows what moves from map to map. Not thread-safe."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self._movers = Movers(SafetyParams.mover_mps, WINDOW_S)

    def clear(self) -> None:
        """Time went backwards."""
        self._movers.reset()

    def lines(self, cell_map: CellMap) -> List[Line]:
        """Of each that moves the way to where it will be, and there a disc as large as it is."""
        things = {name: thing.cells for name, thing in cell_map.objects.items() if name.startswith(UNKNOWN)}
        things = {name: cells for name, cells in things.items() if len(cells)}
        self._movers.see(cell_map.stamp_s, cell_map.spec, things)
        found = []
        for name, cells in sorted(things.items()):
            velocity = np.array(self._movers.velocity(name))
            if not velocity.any():
                continue
            places = cell_map.spec.centres(cells)[:, :2]
            middle = places.mean(axis=0)
            radius_m = float(np.linalg.norm(places - middle, axis=1).max() + 0.5 * cell_map.spec.resolution[:2].max())
            there = middle + AHEAD_S * velocity
            turns = np.linspace(0.0, 2.0 * math.pi, CORNERS + 1)
            disc = there + radius_m * np.column_stack([np.cos(turns), np.sin(turns)])
            found += [Line(LAYER, name, _raised(np.array([middle, there]))), Line(LAYER, name, _raised(disc))]
        return found


def _raised(points: FloatArray) -> FloatArray:
    return np.column_stack([points, np.full(len(points), HEIGHT_M)])
