"""Layouts: an arena with boxes in it that bear tags, for a robot that is to read them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.geometry import Pose2
from yarm.sim.scenes.arena import Arena, Block, BlockKind

BLANK = 0
"""The tag number of a box without a picture."""
WALL_HIGH_M, WALL_THICK_M = 0.60, 0.05


@dataclass(frozen=True)
class Layout:
    """Boxes in a room.

    Attributes:
        arena: walls, then the boxes, in the order of their numbers from 1; each box's own x points out of its tag.
        tags: number of each box's tag from 1, or BLANK.
    """

    arena: Arena
    tags: Tuple[int, ...]

    @property
    def boxes(self) -> Tuple[Block, ...]:
        """The boxes; number n is at index n - 1."""
        return tuple(block for block in self.arena.blocks if block.kind == BlockKind.BOX)

    @property
    def start(self) -> Pose2:
        """The robot's base at the start, world."""
        return self.arena.start


def walls(lower: Tuple[float, float], upper: Tuple[float, float]) -> Tuple[Block, ...]:
    """The four walls of a room whose inside reaches from lower to upper (x, y), metres."""
    middle_x, middle_y = 0.5 * (lower[0] + upper[0]), 0.5 * (lower[1] + upper[1])
    wide, long = (high - low + 2.0 * WALL_THICK_M for low, high in zip(lower, upper))
    half = 0.5 * WALL_THICK_M
    return (
        Block("wall_1", BlockKind.WALL, Pose2(middle_x, lower[1] - half), (wide, WALL_THICK_M, WALL_HIGH_M)),
        Block("wall_2", BlockKind.WALL, Pose2(upper[0] + half, middle_y), (WALL_THICK_M, long, WALL_HIGH_M)),
        Block("wall_3", BlockKind.WALL, Pose2(middle_x, upper[1] + half), (wide, WALL_THICK_M, WALL_HIGH_M)),
        Block("wall_4", BlockKind.WALL, Pose2(lower[0] - half, middle_y), (WALL_THICK_M, long, WALL_HIGH_M)),
    )
