"""Small arenas for tests."""

from __future__ import annotations

import math
from typing import Tuple

from yarm.geometry import Pose2
from yarm.sim.scenes.arena import Arena, Block

WALL_M = 0.05
MIDDLE = Pose2(0.0, 0.0)


def room(*blocks: Block, start: Pose2 = MIDDLE, half_m: float = 2.0, seed: int = 5) -> Arena:
    """A square room about the origin, 2 ``half_m`` wide inside, with blocks in it."""
    middle, length = half_m + 0.5 * WALL_M, 2.0 * (half_m + WALL_M)
    walls: Tuple[Block, ...] = tuple(
        Block(name, "wall", Pose2(x * middle, y * middle, math.atan2(x, -y)), (length, WALL_M, 0.6))
        for name, x, y in (("east", 1, 0), ("north", 0, 1), ("west", -1, 0), ("south", 0, -1))
    )
    return Arena("test", "custom", seed, (-half_m, -half_m), (half_m, half_m), (*walls, *blocks), start)


def block(name: str, x: float, y: float, size: Tuple[float, float, float], kind: str = "block") -> Block:
    """A block along the axes, x, y and full size in metres."""
    return Block(name, kind, Pose2(x, y), size)
