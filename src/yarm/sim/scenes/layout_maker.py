"""Makes layouts from a kind and a seed: ten boxes in a square room, every tag to be seen from somewhere."""

from __future__ import annotations

import math
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.checks.layout_check import LEAST_SHARE, sights
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, Block, BlockKind
from yarm.sim.scenes.layout import BLANK, Layout, walls

KINDS = ("open", "wall", "cluster", "corridor")
SEEDS = 25
"""Of each kind; all of them together are the benchmark's layouts."""
BENCHMARK = tuple((kind, seed) for seed in range(SEEDS) for kind in KINDS)
"""Kind and seed of each of them; kinds alternate, so that a part of them is even."""
BOXES, TAGS = 10, 15
HALF_M = 3.0
DEPTHS_M = (0.16, 0.32)
WIDTH_M, HEIGHT_M = 0.50, 0.40
APART_M = 0.45
"""Least gap between boxes that do not belong together: the robot's disc passes."""
TRIES = 300

Rng = np.random.Generator
Poses = List[Pose2]


def make_layout(kind: str, seed: int) -> Layout:
    """The layout of a kind, one of KINDS, and a seed.

    Raises:
        ValueError: no such kind.
        RuntimeError: no draft shows every tag.
    """
    if kind not in KINDS:
        raise ValueError(f"layout kind {kind!r} is not known; known: {', '.join(KINDS)}")
    for attempt in range(TRIES):
        draw = np.random.default_rng((KINDS.index(kind), seed, attempt))
        layout = _draft(kind, seed, draw)
        if layout is not None and min(sight.share for sight in sights(layout)) >= LEAST_SHARE:
            return layout
    raise RuntimeError(f"layout {kind}_{seed}: no draft of {TRIES} shows every tag")


def _draft(kind: str, seed: int, draw: Rng) -> Optional[Layout]:
    size = (float(draw.choice(DEPTHS_M)), WIDTH_M, HEIGHT_M)
    poses = _PLACERS[kind](draw, size)
    if len(poses) < BOXES:
        return None
    boxes = [Block(f"box_{i + 1}", BlockKind.BOX, pose, size) for i, pose in enumerate(poses[:BOXES])]
    lower, upper = (-HALF_M, -HALF_M), (HALF_M, HALF_M)
    blocks = (*walls(lower, upper), *boxes)
    start = _start(draw, blocks)
    if start is None:
        return None
    about = f"ten boxes, {kind}, {size[0]:g} m deep"
    arena = Arena(f"{kind}_{seed}", "custom", seed, lower, upper, blocks, start, about)
    return Layout(arena, _tags(draw))


def _tags(draw: Rng) -> Tuple[int, ...]:
    """One or two boxes are blank, one or two bear another box's tag, the rest are distinct."""
    blanks, doubles = int(draw.integers(1, 3)), int(draw.integers(1, 3))
    distinct = [int(tag) for tag in draw.permutation(TAGS)[: BOXES - blanks - doubles] + 1]
    again = [int(tag) for tag in draw.permutation(distinct)[:doubles]]
    return tuple(int(tag) for tag in draw.permutation([*distinct, *again, *[BLANK] * blanks]))


def _start(draw: Rng, blocks: Sequence[Block]) -> Optional[Pose2]:
    boxes = FlatBoxes(blocks)
    for _ in range(TRIES):
        x, y = (float(value) for value in draw.uniform(-HALF_M + 0.3, HALF_M - 0.3, 2))
        if boxes.distances(x, y).min() >= RADIUS_M + 0.10:
            return Pose2(x, y, float(draw.uniform(-math.pi, math.pi)))
    return None


def _gap(pose: Pose2, size: Tuple[float, float, float], others: Sequence[Pose2]) -> float:
    """Least gap, metres, of a box at a pose to boxes at others; negative when they overlap."""
    if not others:
        return math.inf
    one = FlatBoxes([Block("one", BlockKind.BOX, pose, size)])
    rest = FlatBoxes([Block(f"other_{i}", BlockKind.BOX, other, size) for i, other in enumerate(others)])
    there = rest.signed(_outline(pose, size)).min()
    back = min(float(one.signed(_outline(other, size)).min()) for other in others)
    return float(min(there, back))


def _outline(pose: Pose2, size: Tuple[float, float, float]) -> FloatArray:
    """(n, 2) points around a box."""
    x, y = 0.5 * size[0], 0.5 * size[1]
    sides = np.linspace(-1.0, 1.0, 9)
    local = [(sx * x, s * y) for sx in (-1.0, 1.0) for s in sides] + [
        (s * x, sy * y) for sy in (-1.0, 1.0) for s in sides
    ]
    return pose.moved(np.array(local))


def _within(pose: Pose2, size: Tuple[float, float, float]) -> bool:
    return bool(np.abs(_outline(pose, size)).max() <= HALF_M)


def _scattered(
    draw: Rng, size: Tuple[float, float, float], count: int, taken: Poses, place: Callable[[], Pose2]
) -> Poses:
    """Boxes one by one, each apart from what is there."""
    poses = list(taken)
    for _ in range(TRIES):
        if len(poses) >= len(taken) + count:
            break
        pose = place()
        if _within(pose, size) and _gap(pose, size, poses) >= APART_M:
            poses.append(pose)
    return poses


def _anywhere(draw: Rng) -> Pose2:
    x, y = (float(value) for value in draw.uniform(-HALF_M + 0.3, HALF_M - 0.3, 2))
    return Pose2(x, y, float(draw.uniform(-math.pi, math.pi)))


def _open(draw: Rng, size: Tuple[float, float, float]) -> Poses:
    return _scattered(draw, size, BOXES, [], lambda: _anywhere(draw))


def _facing_wall(draw: Rng, size: Tuple[float, float, float]) -> Pose2:
    """A tag 0.45 to 0.6 m from a wall that it faces."""
    turn = math.pi / 2 * int(draw.integers(4))
    away = HALF_M - float(draw.uniform(0.45, 0.60)) - 0.5 * size[0]
    along = float(draw.uniform(-HALF_M + 0.9, HALF_M - 0.9))
    placed = Pose2(0.0, 0.0, turn).compose(Pose2(away, along))
    return Pose2(placed.x, placed.y, turn)


def _wall(draw: Rng, size: Tuple[float, float, float]) -> Poses:
    poses = _scattered(draw, size, 5, [], lambda: _facing_wall(draw, size))
    return _scattered(draw, size, BOXES - len(poses), poses, lambda: _anywhere(draw))


def _cluster(draw: Rng, size: Tuple[float, float, float]) -> Poses:
    """Three groups of three, tags side by side or at right angles, 0.35 to 0.7 m between middles; one alone."""
    poses: Poses = []
    for _ in range(TRIES):
        if len(poses) >= 9:
            break
        group = _group(draw, size)
        fits = all(_within(pose, size) for pose in group)
        if fits and all(_gap(pose, size, poses) >= APART_M for pose in group):
            poses += group
    return _scattered(draw, size, BOXES - len(poses), poses, lambda: _anywhere(draw))


def _group(draw: Rng, size: Tuple[float, float, float]) -> Poses:
    """A box, one beside it facing the same way, one at a right angle."""
    first = _anywhere(draw)
    beside = first.compose(Pose2(0.0, float(draw.uniform(WIDTH_M + 0.02, 0.70))))
    corner = 0.5 * (WIDTH_M + size[0]) + 0.02
    across = first.compose(Pose2(float(draw.uniform(0.0, 0.1)), -float(draw.uniform(corner, 0.70)), math.pi / 2))
    group = [first, beside, across]
    apart = all(_gap(pose, size, [o for o in group if o is not pose]) > 0.0 for pose in group)
    return group if apart else [Pose2(10.0, 10.0)]


def _corridor(draw: Rng, size: Tuple[float, float, float]) -> Poses:
    """Two rows that face each other, 0.6 to 0.9 m between the faces."""
    wide = float(draw.uniform(0.60, 0.90))
    middle = Pose2(float(draw.uniform(-0.8, 0.8)), float(draw.uniform(-0.3, 0.3)), float(draw.uniform(-0.2, 0.2)))
    turn = Pose2(0.0, 0.0, math.pi / 2 * int(draw.integers(2)))
    off = 0.5 * (wide + size[0])
    poses = []
    for row, facing in ((-1.0, 0.0), (1.0, math.pi)):
        pitch = float(draw.uniform(0.62, 0.80))
        shift = float(draw.uniform(-0.2, 0.2))
        for i in range(BOXES // 2):
            local = Pose2(row * off, (i - 2) * pitch + shift, facing)
            poses.append(turn.compose(middle).compose(local))
    return poses if all(_within(pose, size) for pose in poses) else []


_PLACERS: Dict[str, Callable[[Rng, Tuple[float, float, float]], Poses]] = {
    "open": _open,
    "wall": _wall,
    "cluster": _cluster,
    "corridor": _corridor,
}
