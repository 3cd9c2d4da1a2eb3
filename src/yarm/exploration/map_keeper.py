"""When the map is saved, and which: every so often, when something happens, and the last good one of a lost mapping."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from yarm.navigation.grid_map import GridMap

EVERY_S = 30.0
LOST_SHARE = 0.5
"""A map that knows less than this share of what the best one knew, after the pose was lost, was begun anew."""


@dataclass(frozen=True, eq=False)
class SaveOrder:
    """A map that is to be written now.

    Attributes:
        map: the map.
        why: one clause: every 30 s, stop, end ...
        last_good: it is the last good one of a mapping that began anew, and gets a name of its own.
    """

    map: GridMap
    why: str
    last_good: bool = False


class MapKeeper:
    """Keeps the newest map; pure, on the session's seconds.

    Attributes:
        newest: the newest map; None before the first.
        count: how often it has changed, as its giver says.
    """

    def __init__(self) -> None:
        """No map yet."""
        self.newest: Optional[GridMap] = None
        self.count = -1
        self._best_m2 = 0.0
        self._doubted = False
        self._saved_s = math.inf
        self._saved_count = -1

    @property
    def known_m2(self) -> float:
        """Area that the newest map knows."""
        return 0.0 if self.newest is None else self._known_m2

    def doubt(self) -> None:
        """The pose is lost or has jumped: the next map may be another mapping's."""
        self._doubted = True

    def take(self, grid: Optional[GridMap], count: int, now_s: float) -> Optional[SaveOrder]:
        """Take in the newest map; an order when it has replaced a much better one, which is then kept.

        Args:
            grid: the newest; None before the first.
            count: how often it has changed.
            now_s: the present.
        """
        if grid is None or count == self.count:
            return None
        known_m2, before, lost = grid.known_m2, self.newest, self.is_lost(grid)
        self._saved_s = min(self._saved_s, now_s)
        self.newest, self.count, self._known_m2 = grid, count, known_m2
        self._doubted = False
        self._best_m2 = known_m2 if lost else max(self._best_m2, known_m2)
        if lost and before is not None:
            return SaveOrder(before, "the mapping began anew: the last good map is kept", last_good=True)
        return None

    def is_lost(self, grid: Optional[GridMap]) -> bool:
        """Whether a map can only come from a mapping that began anew, in another frame."""
        if grid is None or self.newest is None or not self._doubted:
            return False
        return grid.known_m2 < LOST_SHARE * self._best_m2

    def due(self, now_s: float) -> Optional[SaveOrder]:
        """An order every ``EVERY_S`` while maps come."""
        if now_s - self._saved_s < EVERY_S or self._saved_count == self.count:
            return None
        return self.order(now_s, f"every {EVERY_S:.0f} s")

    def order(self, now_s: float, why: str) -> Optional[SaveOrder]:
        """An order to write the newest map now; None before the first."""
        self._saved_s, self._saved_count = now_s, self.count
        return None if self.newest is None else SaveOrder(self.newest, why)
