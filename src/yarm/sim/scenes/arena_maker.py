"""Makes arenas from a kind and a seed: the same for the same two, everywhere."""

from __future__ import annotations

import math
import re
from typing import Callable, Dict, List, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.checks.arena_check import arena_cells, is_sound
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, Block, BlockKind, load_arena

HALF_M = 3.0
"""Inside the outer walls an arena reaches so far from the origin along x and y."""
WALL_HIGH_M, WALL_THICK_M = 0.60, 0.05
PASSAGE_M = 0.72
"""Least gap that is left between two things that do not touch; a little more than the 0.70 m asked for."""
KINDS = ("rooms", "corridors", "clutter", "bricks")
SEEDS = 25
"""Of each kind; all of them together are the benchmark's arenas."""
AT_WALL_EVERY = 10
"""Every n-th of the benchmark's arenas starts in contact with something."""
TRIES = 400
NAME = re.compile(rf"({'|'.join(KINDS)})_(\d+)")

Line = Tuple[float, float, float, float]
"""A wall's middle line: x, y of one end, x, y of the other; along x or along y."""


def benchmark_names() -> Tuple[str, ...]:
    """Names of the benchmark's arenas; kinds alternate, so that a part of them is even."""
    return tuple(f"{kind}_{seed}" for seed in range(SEEDS) for kind in KINDS)


def find_arena(source: str) -> Arena:
    """An arena by a made one's name such as "rooms_7", a shipped one's, or a file.

    Raises:
        SceneError: there is none, or faults in it, all listed.
    """
    made = NAME.fullmatch(source)
    return make_arena(made.group(1), int(made.group(2))) if made else load_arena(source)


def make_arena(kind: str, seed: int) -> Arena:
    """The arena of a kind, one of KINDS, and a seed.

    Raises:
        ValueError: no such kind.
        RuntimeError: no draft keeps the rules.
    """
    if kind not in KINDS:
        raise ValueError(f"arena kind {kind!r} is not known; known: {', '.join(KINDS)}")
    number = KINDS.index(kind)
    at_wall = (number * SEEDS + seed) % AT_WALL_EVERY == 0
    for attempt in range(TRIES):
        draft = _Draft(np.random.default_rng([number, seed, attempt]))
        about = _FURNISH[kind](draft)
        start = draft.start(at_wall)
        blocks = tuple(draft.blocks)
        arena = Arena(f"{kind}_{seed}", kind, seed, (-HALF_M, -HALF_M), (HALF_M, HALF_M), blocks, start, about)
        if is_sound(arena_cells(arena)):
            return arena
    raise RuntimeError(f"arena {kind}_{seed}: none of {TRIES} drafts keeps the rules")


class _Draft:
    """An arena in the making."""

    def __init__(self, draw: np.random.Generator) -> None:
        self.draw = draw
        self.blocks: List[Block] = []
        self._lines: List[Line] = []
        reach = HALF_M + 0.5 * WALL_THICK_M
        for line in (
            (-reach, -reach, reach, -reach),
            (reach, -reach, reach, reach),
            (reach, reach, -reach, reach),
            (-reach, reach, -reach, -reach),
        ):
            self.wall(line)

    def wall(self, line: Line) -> None:
        """A wall along a line, its ends covered."""
        x0, y0, x1, y1 = line
        length = math.hypot(x1 - x0, y1 - y0) + WALL_THICK_M
        along_x = abs(x1 - x0) > abs(y1 - y0)
        size = (length, WALL_THICK_M, WALL_HIGH_M) if along_x else (WALL_THICK_M, length, WALL_HIGH_M)
        self._lines.append(line)
        self._put(BlockKind.WALL, Pose2(0.5 * (x0 + x1), 0.5 * (y0 + y1)), size)

    def wall_with_door(self, line: Line, door_m: float, at: float) -> None:
        """A wall with an opening; ``at`` in 0 to 1 says where along what is left."""
        x0, y0, x1, y1 = line
        length = math.hypot(x1 - x0, y1 - y0)
        first = 0.1 + at * (length - door_m - 0.2)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        cuts = ((0.0, first), (first + door_m, length))
        for start, end in cuts:
            if end - start > 0.12:
                self.wall((x0 + ux * start, y0 + uy * start, x0 + ux * end, y0 + uy * end))

    def scatter(
        self, kind: BlockKind, count: int, sizes: Callable[[], Tuple[float, float, float]], at_wall: float
    ) -> int:
        """Things at random places, every gap wide enough; a share of them stands against a wall.

        Returns:
            How many found a place.
        """
        placed = 0
        for _ in range(TRIES):
            if placed == count:
                break
            size = sizes()
            flush = self.draw.random() < at_wall
            pose = self._flush_pose(size) if flush else self._free_pose(size)
            block = Block("candidate", kind, pose, size)
            if self._fits(block, flush):
                self._put(kind, pose, size)
                placed += 1
        return placed

    def bumps_on_walls(self, count: int, deepest_m: float) -> None:
        """Blocks on walls that make the sides of a corridor uneven; the way past them stays wide enough."""
        self.scatter(BlockKind.BLOCK, count, lambda: self._pillar(deepest_m), 1.0)

    def start(self, at_wall: bool) -> Pose2:
        """A free place for the robot, or one in contact.

        Raises:
            RuntimeError: none was found.
        """
        boxes = FlatBoxes(self.blocks)
        for _ in range(TRIES):
            x, y = self.draw.uniform(-HALF_M + 0.3, HALF_M - 0.3, 2)
            yaw = float(self.draw.uniform(-math.pi, math.pi))
            distances = boxes.distances(x, y)
            if not at_wall and distances.min() >= RADIUS_M + 0.10:
                return Pose2(float(x), float(y), yaw)
            nearest = int(np.argmin(distances))
            if at_wall and RADIUS_M + 0.02 < distances[nearest] < 1.0:
                px, py = boxes.nearest_point(nearest, x, y)
                share = (RADIUS_M + 0.0005) / distances[nearest]
                touching = Pose2(float(px + share * (x - px)), float(py + share * (y - py)), yaw)
                others = np.delete(boxes.distances(touching.x, touching.y), nearest)
                if others.min() > RADIUS_M + 0.05:
                    return touching
        raise RuntimeError("no place for the robot")

    def _put(self, kind: BlockKind, pose: Pose2, size: Tuple[float, float, float]) -> None:
        number = 1 + sum(block.kind == kind for block in self.blocks)
        self.blocks.append(Block(f"{kind}_{number}", kind, pose, size))

    def _pillar(self, deepest_m: float) -> Tuple[float, float, float]:
        return (float(self.draw.uniform(0.15, 0.6)), float(self.draw.uniform(0.05, deepest_m)), WALL_HIGH_M)

    def _free_pose(self, size: Tuple[float, float, float]) -> Pose2:
        reach = HALF_M - 0.5 * math.hypot(size[0], size[1])
        x, y = self.draw.uniform(-reach, reach, 2)
        return Pose2(float(x), float(y), float(self.draw.uniform(-math.pi, math.pi)))

    def _flush_pose(self, size: Tuple[float, float, float]) -> Pose2:
        """Long side against a side of a random wall."""
        x0, y0, x1, y1 = self._lines[int(self.draw.integers(len(self._lines)))]
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        along = float(self.draw.uniform(0.0, length))
        side = 1.0 if self.draw.random() < 0.5 else -1.0
        off = side * 0.5 * (WALL_THICK_M + size[1])
        return Pose2(x0 + ux * along - uy * off, y0 + uy * along + ux * off, math.atan2(uy, ux))

    def _fits(self, block: Block, flush: bool) -> bool:
        """Within the room, and every gap to others none (only with walls, when flush) or wide enough."""
        outline = outline_of(block, 0.05)
        if np.abs(outline).max() > HALF_M + 1e-6:
            return False
        others = FlatBoxes(self.blocks)
        gaps = others.signed(outline).min(axis=0)
        back = FlatBoxes([block]).signed(others.corners().reshape(-1, 2)).reshape(-1, 4).min(axis=1)
        gaps = np.minimum(gaps, back)
        is_wall = np.array([other.kind == BlockKind.WALL for other in self.blocks])
        touching = gaps < 1e-6
        if np.any(touching & ~(is_wall & flush)):
            return False
        # A flush block may end near a corner of its own wall: the pocket behind it is no passage.
        return bool(np.all(gaps[~touching] >= PASSAGE_M))


def outline_of(block: Block, step_m: float) -> FloatArray:
    """(n, 2) points along the sides of a block, at most so far apart, metres."""
    corners = FlatBoxes([block]).corners()[0]
    parts = []
    for first, second in zip(corners, np.roll(corners, -1, axis=0)):
        count = max(2, math.ceil(float(np.hypot(*(second - first))) / step_m) + 1)
        parts.append(first + np.linspace(0.0, 1.0, count)[:-1, None] * (second - first))
    outline: FloatArray = np.concatenate(parts)
    return outline


def _block_size(draw: np.random.Generator) -> Tuple[float, float, float]:
    return (float(draw.uniform(0.2, 0.7)), float(draw.uniform(0.2, 0.5)), WALL_HIGH_M)


def _brick_size(draw: np.random.Generator) -> Tuple[float, float, float]:
    return (float(draw.uniform(0.25, 0.9)), float(draw.uniform(0.10, 0.22)), float(draw.uniform(0.05, 0.20)))


def _rooms(draft: _Draft) -> str:
    """Halves of halves, each cut with a door."""
    draw = draft.draw
    todo: List[Tuple[float, float, float, float, int]] = [(-HALF_M, -HALF_M, HALF_M, HALF_M, 0)]
    while todo:
        x0, y0, x1, y1, depth = todo.pop()
        wide, high = x1 - x0, y1 - y0
        if max(wide, high) < 3.2 or depth == 3 or (depth == 2 and draw.random() < 0.4):
            continue
        door = float(draw.uniform(0.80, 1.05))
        at = float(draw.random())
        if wide >= high:
            x = float(draw.uniform(x0 + 1.4, x1 - 1.4))
            draft.wall_with_door((x, y0, x, y1), door, at)
            todo += [(x0, y0, x, y1, depth + 1), (x, y0, x1, y1, depth + 1)]
        else:
            y = float(draw.uniform(y0 + 1.4, y1 - 1.4))
            draft.wall_with_door((x0, y, x1, y), door, at)
            todo += [(x0, y0, x1, y, depth + 1), (x0, y, x1, y1, depth + 1)]
    draft.scatter(BlockKind.BLOCK, int(draw.integers(3, 7)), lambda: _block_size(draw), 0.7)
    draft.scatter(BlockKind.LOW, int(draw.integers(0, 4)), lambda: _brick_size(draw), 0.5)
    return "rooms with doors, some of them dead ends"


def _corridors(draft: _Draft) -> str:
    """A maze of corridors on a coarse grid: a random tree of cells, so it has dead ends, and a few more openings."""
    draw = draft.draw
    count = int(draw.integers(5, 7))
    edge = 2.0 * HALF_M / count
    open_sides = _tree(draw, count)
    for x in range(count):
        for y in range(count):
            for dx, dy in ((1, 0), (0, 1)):
                if x + dx >= count or y + dy >= count:
                    continue
                if ((x, y), (x + dx, y + dy)) in open_sides or draw.random() < 0.12:
                    continue
                left, low = -HALF_M + (x + dx) * edge, -HALF_M + (y + dy) * edge
                draft.wall((left, low, left, low + edge) if dx else (left, low, left + edge, low))
    draft.bumps_on_walls(int(draw.integers(8, 14)), edge - WALL_THICK_M - PASSAGE_M - 0.01)
    draft.scatter(BlockKind.LOW, int(draw.integers(0, 3)), lambda: _low_pillar(draw, edge), 1.0)
    return "long corridors with uneven sides and dead ends"


def _low_pillar(draw: np.random.Generator, edge: float) -> Tuple[float, float, float]:
    deepest = edge - WALL_THICK_M - PASSAGE_M - 0.01
    return (float(draw.uniform(0.2, 0.5)), float(draw.uniform(0.10, deepest)), float(draw.uniform(0.05, 0.20)))


def _tree(draw: np.random.Generator, count: int) -> Sequence[Tuple[Tuple[int, int], Tuple[int, int]]]:
    """Pairs of neighbouring cells with an opening between them, the smaller cell first: a tree by depth-first walk."""
    seen = {(0, 0)}
    trail = [(0, 0)]
    pairs = []
    while trail:
        x, y = trail[-1]
        around = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)]
        fresh = [c for c in around if 0 <= c[0] < count and 0 <= c[1] < count and c not in seen]
        if not fresh:
            trail.pop()
            continue
        straight = (2 * x - trail[-2][0], 2 * y - trail[-2][1]) if len(trail) > 1 else None
        chosen = straight if straight in fresh and draw.random() < 0.6 else fresh[int(draw.integers(len(fresh)))]
        assert chosen is not None
        pairs.append((min((x, y), chosen), max((x, y), chosen)))
        seen.add(chosen)
        trail.append(chosen)
    return pairs


def _niches(draft: _Draft, count: int) -> None:
    """Pairs of stubs on the outer walls: dead ends a little wider than the robot's way."""
    draw = draft.draw
    for _ in range(count):
        width, depth = float(draw.uniform(0.85, 1.1)), float(draw.uniform(0.8, 1.4))
        at = float(draw.uniform(-HALF_M + PASSAGE_M + 0.1, HALF_M - width - PASSAGE_M - 0.1))
        side = int(draw.integers(4))
        for offset in (at, at + width):
            ends = ((offset, -HALF_M), (offset, -HALF_M + depth))
            lines: Tuple[Line, ...] = (
                (*ends[0], *ends[1]),
                (offset, HALF_M, offset, HALF_M - depth),
                (-HALF_M, offset, -HALF_M + depth, offset),
                (HALF_M, offset, HALF_M - depth, offset),
            )
            stub = lines[side]
            wall = _as_block(stub)
            others = FlatBoxes(draft.blocks[4:])
            if not len(others) or others.signed(outline_of(wall, 0.1)).min() >= PASSAGE_M:
                draft.wall(stub)


def _as_block(line: Line) -> Block:
    draft = _Draft(np.random.default_rng(0))
    draft.wall(line)
    return draft.blocks[-1]


def _clutter(draft: _Draft) -> str:
    """Blocks everywhere."""
    draw = draft.draw
    _niches(draft, int(draw.integers(1, 3)))
    draft.scatter(BlockKind.BLOCK, int(draw.integers(10, 17)), lambda: _block_size(draw), 0.3)
    draft.scatter(BlockKind.LOW, int(draw.integers(0, 4)), lambda: _brick_size(draw), 0.3)
    return "an open room full of blocks, with niches"


def _bricks(draft: _Draft) -> str:
    """Low brick walls, a few blocks, a room."""
    draw = draft.draw
    if draw.random() < 0.5:
        x = float(draw.uniform(-0.8, 0.8))
        draft.wall_with_door((x, -HALF_M, x, HALF_M), float(draw.uniform(0.9, 1.2)), float(draw.random()))
    _niches(draft, 1)
    draft.scatter(BlockKind.LOW, int(draw.integers(4, 7)), lambda: _brick_size(draw), 0.3)
    draft.scatter(BlockKind.BLOCK, int(draw.integers(2, 6)), lambda: _block_size(draw), 0.5)
    return "low brick walls that the scan does not see"


_FURNISH: Dict[str, Callable[[_Draft], str]] = {
    "rooms": _rooms,
    "corridors": _corridors,
    "clutter": _clutter,
    "bricks": _bricks,
}
