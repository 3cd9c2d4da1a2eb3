"""Arenas: flat rooms of walls and blocks that a TurtleBot is put into. YAML in, checked dataclasses out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Tuple, Union

from yarm.geometry import Pose2
from yarm.resources import resource
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

KINDS = ("practice", "rooms", "corridors", "clutter", "bricks", "custom")
MOST_BLOCKS = 300
HALF_M = 20.0
"""Coordinates lie within this of the origin."""


class BlockKind(str, Enum):
    """What a block is, by the word of arena files: all but what is low is seen by the scan, and a box carries a tag."""

    WALL = "wall"
    BLOCK = "block"
    LOW = "low"
    BOX = "box"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


@dataclass(frozen=True)
class Block:
    """A box that stands on the floor.

    Attributes:
        name: unique name.
        kind: what it is.
        pose: its centre and heading, world.
        size: along its own x, y and up, metres.
    """

    name: str
    kind: BlockKind
    pose: Pose2
    size: Tuple[float, float, float]


@dataclass(frozen=True)
class Arena:
    """A room and where the robot starts in it.

    Attributes:
        name: unique name.
        kind: one of KINDS.
        seed: that it was made from; of the sensors' noise as well.
        lower: least x, y of what is inside the outer walls, metres.
        upper: greatest x, y of it.
        blocks: walls and everything else.
        start: the robot's base at the start, world.
        about: one sentence.
    """

    name: str
    kind: str
    seed: int
    lower: Tuple[float, float]
    upper: Tuple[float, float]
    blocks: Tuple[Block, ...]
    start: Pose2
    about: str = ""


def arena_path(name: str) -> Path:
    """File of an arena: a path ending in .yaml, or the name of a shipped one such as "practice"."""
    return Path(name) if name.endswith(".yaml") else resource("scenes", "exploration", f"{name}.yaml")


def shipped_arenas() -> Tuple[str, ...]:
    """Names of the arenas that come with the package."""
    return tuple(sorted(path.stem for path in resource("scenes", "exploration").glob("*.yaml")))


def load_arena(source: Union[str, Path]) -> Arena:
    """An arena by name or file.

    Raises:
        SceneError: faults, all listed: file, key, value, what was expected.
    """
    path = arena_path(str(source))
    if not path.is_file():
        raise SceneError(f"{path}: no such arena; shipped: {', '.join(shipped_arenas())}")
    return arena_from(load_yaml(path), str(path))


def arena_from(raw: object, file: str) -> Arena:
    """An arena from plain values; ``file`` is named in messages.

    Raises:
        SceneError: faults, all listed.
    """
    faults = Faults(file)
    top = Fields(raw, "", faults)
    lower = top.numbers("lower", 2, -HALF_M, HALF_M)
    upper = top.numbers("upper", 2, -HALF_M, HALF_M)
    start = top.section("start")
    arena = Arena(
        name=top.text("name"),
        kind=top.text("kind", choices=KINDS),
        seed=top.whole("seed", 0, 2**31 - 1, 0),
        lower=(lower[0], lower[1]),
        upper=(upper[0], upper[1]),
        blocks=tuple(_block(entry) for entry in top.entries("blocks", MOST_BLOCKS)),
        start=_pose(start),
        about=top.text("about", "-"),
    )
    start.finish()
    top.finish()
    _check(arena, faults)
    faults.raise_if_any()
    return arena


def _pose(fields: Fields) -> Pose2:
    return Pose2(
        fields.number("x", -HALF_M, HALF_M, "m"),
        fields.number("y", -HALF_M, HALF_M, "m"),
        math.radians(fields.number("yaw_deg", -360.0, 360.0, "deg", 0.0)),
    )


def _block(fields: Fields) -> Block:
    pose = _pose(fields)
    size = fields.numbers("size", 3, 0.01, 2.0 * HALF_M)
    word = fields.text("kind", choices=tuple(str(kind) for kind in BlockKind))
    kind = BlockKind(word) if word else BlockKind.BLOCK  # a wrong word is a fault already
    block = Block(fields.text("name"), kind, pose, (size[0], size[1], size[2]))
    fields.finish()
    return block


def _check(arena: Arena, faults: Faults) -> None:
    names = [block.name for block in arena.blocks]
    for i, name in enumerate(names):
        if name in names[:i]:
            faults.add(f"blocks[{i}].name", name, "a name that no other block has")
    for axis in range(2):
        if arena.lower[axis] >= arena.upper[axis]:
            faults.add("upper", list(arena.upper), f"more than lower, {list(arena.lower)}, along both axes")
            break
    if not (arena.lower[0] < arena.start.x < arena.upper[0] and arena.lower[1] < arena.start.y < arena.upper[1]):
        faults.add("start", (arena.start.x, arena.start.y), f"a place within {arena.lower} and {arena.upper}")
