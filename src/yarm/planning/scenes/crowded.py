"""Seeded instances with hardly room to move, beside those of ``coordination``, and crowds in large maps.

``HARD`` and ``CROWDS`` are made backwards like most of ``coordination``: a way back from the goals is a solution. Those
of ``HOPELESS`` have none: an odd permutation, another order round a ring or along a corridor, a bar that cannot turn.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, GridSpec, IntArray
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.coordination import Maker, Slot, Slots, drawn, free_slots, slot_scene, walked
from yarm.planning.scenes.instances import Instance
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand

TRIES = 200
SIDES = (1, 2, 3)
"""Cells of a robot along x and y."""
WALK = 400
"""Random moves for each robot of a crowd or of a box of blocks."""
RING_WAYS = 4
"""A tight ring is walked on by a number of places below this share of its length."""


def make_crowded(family: str, seed: int) -> Instance:
    """The instance of a family of ``HARD``, ``HOPELESS`` or ``CROWDS`` with this seed.

    Raises:
        KeyError: no such family.
        RuntimeError: no instance found for this seed.
    """
    maker = {**HARD, **HOPELESS, **CROWDS}[family]
    for attempt in range(TRIES):
        scene = maker(np.random.default_rng([seed, attempt]))
        if scene is not None:
            return Instance(family, seed, replace(scene, name=f"{family}_{seed}"))
    raise RuntimeError(f"no {family} instance found for seed {seed} in {TRIES} tries")


def _side(rng: np.random.Generator) -> int:
    return int(rng.choice(SIDES))


def _order(slots: Slots) -> List[int]:
    return sorted(range(len(slots)), key=lambda k: slots[k])


def _puzzle(wide: int, deep: int, rng: np.random.Generator) -> Optional[PlanScene]:
    """Sliding pieces, one free place."""
    rows = ["." * wide] * deep
    goals = drawn(rng, free_slots(rows), wide * deep - 1)
    starts = walked(rng, rows, goals)
    return slot_scene(rows, _side(rng), starts, goals) if starts != goals else None


def _odd_puzzle(wide: int, deep: int, rng: np.random.Generator) -> Optional[PlanScene]:
    """Sliding pieces, two of them exchanged after the shuffle."""
    rows = ["." * wide] * deep
    goals = drawn(rng, free_slots(rows), wide * deep - 1)
    starts = walked(rng, rows, goals)
    return slot_scene(rows, _side(rng), starts, (goals[1], goals[0], *goals[2:]))


def _one_bay(rng: np.random.Generator) -> Optional[PlanScene]:
    """A corridor with one bay for one robot; three to six robots in another order, two places free at least."""
    count = int(rng.integers(3, 7))
    length = count + int(rng.integers(1, 5))
    bay = int(rng.integers(1, length - 1))
    rows = ["." * length, "#" * bay + "." + "#" * (length - bay - 1)]
    goals = drawn(rng, [(x, 0) for x in range(length)], count)
    starts = walked(rng, rows, goals)
    return slot_scene(rows, _side(rng), starts, goals) if _order(starts) != _order(goals) else None


def _ring_way(wide: int, deep: int) -> Tuple[List[str], List[Slot]]:
    rows = ["." * wide, *["." + "#" * (wide - 2) + "."] * (deep - 2), "." * wide]
    way = [(x, 0) for x in range(wide)] + [(wide - 1, y) for y in range(1, deep)]
    way += [(x, deep - 1) for x in range(wide - 2, -1, -1)] + [(0, y) for y in range(deep - 2, 0, -1)]
    return rows, way


def _tight_ring(rng: np.random.Generator) -> Optional[PlanScene]:
    """A ring with one free place, everybody goes on by some places; in half of them a bay lets two exchange places."""
    wide, deep = int(rng.integers(3, 7)), int(rng.integers(3, 6))
    rows, way = _ring_way(wide, deep)
    count, on = len(way) - 1, 1 + int(rng.integers(max(1, len(way) // RING_WAYS)))
    if rng.random() < 0.5:
        side = _side(rng)
        return slot_scene(rows, side, tuple(way[:count]), [way[(k + on) % len(way)] for k in range(count)])
    rows = [row + ("." if y == deep // 2 else "#") for y, row in enumerate(rows)]
    goals = drawn(rng, way, count)
    return slot_scene(rows, _side(rng), walked(rng, rows, goals), goals)


def _wrong_ring(rng: np.random.Generator) -> Optional[PlanScene]:
    """A ring without a bay, two robots exchanged."""
    rows, way = _ring_way(int(rng.integers(3, 5)), int(rng.integers(3, 5)))
    count = int(rng.integers(3, len(way)))
    goals = [way[(k + 1) % len(way)] for k in range(count)]
    goals[0], goals[1] = goals[1], goals[0]
    return slot_scene(rows, _side(rng), tuple(way[:count]), goals)


def _full_corridor(rng: np.random.Generator) -> Optional[PlanScene]:
    """A corridor whose bay is at its end, where it only makes the corridor longer; another order."""
    count = int(rng.integers(2, 6))
    length = count + int(rng.integers(1, 3))
    rows = ["." * length, "#" * (length - 1) + "."]
    slots = [(x, 0) for x in range(length)]
    starts, goals = drawn(rng, slots, count), drawn(rng, slots, count)
    return slot_scene(rows, _side(rng), starts, goals) if _order(starts) != _order(goals) else None


def _yard(rng: np.random.Generator) -> Optional[PlanScene]:
    """Dead-end tracks beside each other, joined by a lead of the width of one robot; half to two thirds full."""
    tracks, deep = int(rng.integers(3, 6)), int(rng.integers(2, 4))
    rows = ["." * (2 * tracks - 1), *[".#" * (tracks - 1) + "."] * deep]
    slots = [(x, y) for x, y in free_slots(rows) if y > 0]
    goals = drawn(rng, slots, int(rng.integers(len(slots) // 2, 2 * len(slots) // 3 + 1)))
    starts = walked(rng, rows, goals)
    return slot_scene(rows, _side(rng), starts, goals) if starts != goals else None


def _blocks(rng: np.random.Generator) -> Optional[PlanScene]:
    """A box of blocks of one by one to two by two places, two to four places free, walked on from the goals."""
    wide, deep = int(rng.integers(3, 5)), int(rng.integers(4, 6))
    free = {(x, y) for x in range(wide) for y in range(deep)}
    room = int(rng.integers(2, 5))
    sizes, goals = [], []
    kinds = ((2, 2), (1, 2), (2, 1), (1, 1), (1, 1))
    for _ in range(40):
        a, b = kinds[int(rng.integers(len(kinds)))]
        x, y = int(rng.integers(wide)), int(rng.integers(deep))
        own = {(x + i, y + j) for i in range(a) for j in range(b)}
        if own <= free and len(free) - len(own) >= room:
            free -= own
            sizes.append((a, b))
            goals.append((x, y))
    starts = _pushed(rng, (wide, deep), sizes, goals)
    side = int(rng.integers(1, 3))
    pitch = side + 1
    shape = (wide * pitch - 1, deep * pitch - 1, 1)
    parts = [np.argwhere(np.ones((a * pitch - 1, b * pitch - 1, 1), dtype=bool)) for a, b in sizes]
    return _scene(shape, (), parts, [_cell(s, pitch) for s in starts], [_cell(s, pitch) for s in goals])


def _pushed(
    rng: np.random.Generator, room: Tuple[int, int], sizes: Sequence[Tuple[int, int]], at: Sequence[Slot]
) -> List[Slot]:
    """Where blocks are after many random moves by one place to where nothing is."""
    places = list(at)
    for _ in range(WALK * len(places)):
        k, (dx, dy) = int(rng.integers(len(places))), ((1, 0), (-1, 0), (0, 1), (0, -1))[int(rng.integers(4))]
        (x, y), (a, b) = (places[k][0] + dx, places[k][1] + dy), sizes[k]
        clear = all(
            x + a <= u or u + c <= x or y + b <= v or v + d <= y
            for j, ((u, v), (c, d)) in enumerate(zip(places, sizes))
            if j != k
        )
        if 0 <= x <= room[0] - a and 0 <= y <= room[1] - b and clear:
            places[k] = (x, y)
    return places


def _crowd(count: int, size: int, side: int, rng: np.random.Generator) -> Optional[PlanScene]:
    """Square carts at random places of a square map with some boxes, goals at others."""
    boxes: List[Box] = []
    for x, y, a, b in rng.integers((0, 0, 1, 1), (size, size, size // 8, size // 8), (size // 10, 4)).tolist():
        boxes.append((x, min(size, x + a), y, min(size, y + b), 0, 1))
    taken = PlanScene(_spec((size, size, 1)), tuple(boxes), (), {}).occupied()[:, :, 0]
    starts, ends = _spread(rng, taken, count, side), _spread(rng, taken, count, side)
    if starts is None or ends is None:
        return None
    cart = np.argwhere(np.ones((side, side, 1), dtype=bool))
    return _scene((size, size, 1), tuple(boxes), [cart] * count, starts, ends)


def _spread(rng: np.random.Generator, taken: BoolArray, count: int, side: int) -> Optional[List[Slot]]:
    """Columns of carts a margin apart from each other and from what is taken, all in the largest free part."""
    taken = taken.copy()
    room = ndimage.binary_dilation(taken, np.ones((3, 3), dtype=bool))
    wide, deep = taken.shape
    free = np.array([[not room[x : x + side, y : y + side].any() for y in range(deep)] for x in range(wide)])
    free[wide - side + 1 :], free[:, deep - side + 1 :] = False, False
    parts, _ = ndimage.label(free)
    free = parts == np.argmax(np.bincount(parts[free])) if free.any() else free
    places: List[Slot] = []
    while len(places) < count and free.any():
        x, y = (int(v) for v in rng.choice(np.argwhere(free)))
        places.append((x, y))
        free[max(0, x - side) : x + side + 1, max(0, y - side) : y + side + 1] = False
    return places if len(places) == count else None


def _cell(slot: Slot, pitch: int) -> Slot:
    return slot[0] * pitch, slot[1] * pitch


def _scene(
    shape: Tuple[int, int, int],
    boxes: Tuple[Box, ...],
    parts: Sequence[IntArray],
    starts: Sequence[Slot],
    ends: Sequence[Slot],
) -> PlanScene:
    robots = tuple(
        SceneRobot(f"cart_{k + 1}", Stand(start, 0.0), cells) for k, (start, cells) in enumerate(zip(starts, parts))
    )
    goals = {f"target_{k + 1}": Goal(f"target_{k + 1}", GoalKind.TARGET, end) for k, end in enumerate(ends)}
    return PlanScene(
        _spec(shape), boxes, robots, goals, {f"cart_{k + 1}": f"target_{k + 1}" for k in range(len(robots))}
    )


def _spec(shape: Tuple[int, int, int]) -> GridSpec:
    return GridSpec(shape, (0.0, 0.0, 0.0), (shape[0] / 10.0, shape[1] / 10.0, shape[2] / 10.0))


HARD: Dict[str, Maker] = {
    "puzzle_7": partial(_puzzle, 4, 2),
    "puzzle_8": partial(_puzzle, 3, 3),
    "puzzle_11": partial(_puzzle, 4, 3),
    "puzzle_15": partial(_puzzle, 4, 4),
    "one_bay": _one_bay,
    "tight_ring": _tight_ring,
    "yard": _yard,
    "blocks": _blocks,
}
"""Solvable families with hardly room to move."""
HOPELESS: Dict[str, Maker] = {
    "odd_7": partial(_odd_puzzle, 4, 2),
    "odd_8": partial(_odd_puzzle, 3, 3),
    "odd_11": partial(_odd_puzzle, 4, 3),
    "odd_15": partial(_odd_puzzle, 4, 4),
    "wrong_ring": _wrong_ring,
    "full_corridor": _full_corridor,
}
"""Families without a solution."""
CROWDS: Dict[str, Maker] = {
    "crowd_60": partial(_crowd, 60, 40, 1),
    "crowd_40": partial(_crowd, 40, 100, 3),
}
"""Many robots with room enough, each at a random place and sent to another."""
