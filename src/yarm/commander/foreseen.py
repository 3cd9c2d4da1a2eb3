"""Where people may be by the time a robot that is sent off now stands again: kept out of what is planned.

The map shows where they are. Whoever moves may be anywhere in the safety monitor's disc (``yarm.safety.people``) before
a robot has braked, so no step is planned through it; the monitor holds a robot whose way somebody enters after that.
"""

from __future__ import annotations

from typing import Collection, Dict, Sequence

import numpy as np

from yarm.geometry import GridSpec, IntArray
from yarm.safety.people import Tracked, Walking, disc_of


def where_they_may_be(
    spec: GridSpec, tracks: Sequence[Tracked], shown: Collection[str], now_s: float, ahead_s: float
) -> Dict[str, IntArray]:
    """Cells (n, 3) in which each may be after a time, by a name that says whose they are.

    Args:
        spec: the grid.
        tracks: what is followed.
        shown: names of what the map shows; of these only who moves is foreseen, the map has the others.
        now_s: time, s.
        ahead_s: from now, s.
    """
    walking = Walking()
    moving = [(seen, disc_of(seen, walking)) for seen in tracks]
    moving = [(seen, disc) for seen, disc in moving if disc.speed_mps > 0.0 or seen.name not in shown]
    if not moving:
        return {}
    found: Dict[str, IntArray] = {}
    columns = np.stack(np.meshgrid(*map(np.arange, spec.shape[:2]), indexing="ij"), axis=-1).reshape(-1, 2)
    levels = np.arange(spec.shape[2])
    places = spec.centres(np.column_stack([columns, np.zeros(len(columns))]))
    for seen, disc in moving:
        reach_m = disc.radius_m + disc.speed_mps * (now_s - seen.stamp_s + ahead_s)
        within = columns[np.hypot(places[:, 0] - disc.x, places[:, 1] - disc.y) <= reach_m]
        low = levels[spec.lower[2] + levels * spec.resolution[2] < disc.top_m]
        cells = np.column_stack([np.repeat(within, len(low), axis=0), np.tile(low, len(within))])
        if len(cells):
            found[f"where {seen.name} may be in {ahead_s:g} s"] = cells.astype(np.int64)
    return found
