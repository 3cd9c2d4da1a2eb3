"""When a robot came into contact with what: the truth of bumps."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from typing import Deque, Dict, List, Mapping, Tuple

from yarm.geometry import Pose2, wrap_angle

APART_S = 0.3
"""A contact with a block that was not touched for so long is a new one."""


@dataclass(frozen=True)
class Touch:
    """The robot came into contact with a block.

    Attributes:
        t_s: when.
        block: its name.
        height_m: of the block.
        x: where, world, metres.
        y: where, world, metres.
        bearing_rad: of the contact from ahead, + = left.
        speed_mps: true speed of the robot just before.
    """

    t_s: float
    block: str
    height_m: float
    x: float
    y: float
    bearing_rad: float
    speed_mps: float


class TouchLog:
    """Touches out of contacts that last, and of the way that the robot really took; fed in the order of time.

    Attributes:
        touches: so far, in order.
    """

    def __init__(self, heights_m: Mapping[str, float]) -> None:
        """Nothing touched.

        Args:
            heights_m: of the blocks, by name.
        """
        self.touches: List[Touch] = []
        self._heights_m = heights_m
        self._touched_s: Dict[str, float] = {}
        self._way: Deque[Tuple[float, Pose2]] = deque()

    def moved(self, t_s: float, pose: Pose2) -> None:
        """Where the base really is, world."""
        self._way.append((t_s, pose))
        while t_s - self._way[0][0] > APART_S:
            self._way.popleft()

    def contact(self, t_s: float, block: str, x: float, y: float) -> None:
        """The robot and a block are in contact at a point of the world; before it was seen to move, nothing counts."""
        since_s = t_s - self._touched_s.get(block, -math.inf)
        self._touched_s[block] = t_s
        if since_s <= APART_S or not self._way:
            return
        base = self._way[-1][1]
        bearing = wrap_angle(math.atan2(y - base.y, x - base.x) - base.yaw_rad)
        height_m = self._heights_m.get(block, math.inf)
        self.touches.append(Touch(t_s, block, height_m, x, y, bearing, self._speed()))

    def _speed(self) -> float:
        """Greatest over the ground just before, m/s: the contact itself has already slowed the robot down."""
        way = list(self._way)
        steps = [a[1].distance(b[1]) / (b[0] - a[0]) for a, b in zip(way, way[1:])]
        return max(steps, default=0.0)
