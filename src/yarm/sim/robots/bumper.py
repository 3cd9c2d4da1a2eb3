"""The bumper's logic: contacts to sectors, changes to events."""

from __future__ import annotations

import math
from typing import AbstractSet, FrozenSet, Iterable, Optional, Tuple

from yarm.geometry import Pose2
from yarm.robots.turtlebot import BUMPER_HIGH_M, BUMPER_LOW_M, Bumper, BumperEvent, bumper_at

Point = Tuple[float, float, float]


def pressed_sectors(base: Pose2, contacts: Iterable[Point]) -> FrozenSet[Bumper]:
    """Sectors that contacts press.

    Args:
        base: the robot's base, world.
        contacts: points on its body, world, metres above the floor.
    """
    found = set()
    for x, y, z in contacts:
        if BUMPER_LOW_M <= z <= BUMPER_HIGH_M:
            bearing = math.atan2(y - base.y, x - base.x) - base.yaw_rad
            found.add(bumper_at(math.remainder(bearing, 2.0 * math.pi)))
    return frozenset(sector for sector in found if sector is not None)


class BumperLogic:
    """Events of changes only. What is pressed when it is first asked is nobody's event until it is let go."""

    def __init__(self) -> None:
        """Nothing known."""
        self._pressed: Optional[FrozenSet[Bumper]] = None

    @property
    def pressed(self) -> FrozenSet[Bumper]:
        """The sectors pressed at the last look."""
        return self._pressed or frozenset()

    def look(self, pressed: AbstractSet[Bumper]) -> Tuple[BumperEvent, ...]:
        """Take the sectors pressed now; the changes since the last look, in the order of the sectors."""
        before = pressed if self._pressed is None else self._pressed
        self._pressed = frozenset(pressed)
        return tuple(
            BumperEvent(sector, sector in pressed) for sector in Bumper if (sector in pressed) != (sector in before)
        )
