"""Seeded instances in which robots must make room for each other, beside those of ``instances``.

Most are laid out in *slots*: squares as large as a robot, a margin apart, some of them walls. They are made backwards:
the robots stand on their goals, then random robots go to free neighbouring slots for a long time; the way back is a
solution. ``mixed`` and ``turning`` are drawn at random and kept when the complete search of ``joint_oracle`` can solve
them. The families of ``IMPOSSIBLE`` have no solution.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, GridSpec, IntArray
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.instances import Instance
from yarm.planning.scenes.joint_oracle import TooLargeError, least_cost
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand

Slot = Tuple[int, int]
Slots = Tuple[Slot, ...]
TRIES = 200
DRAWN_STATES = 4_000_000
"""Joint places of a scene drawn at random, at most, so that it is soon known to be solvable."""
WALK = 1500
"""Random moves for each robot that lead from the goals to the starts."""


def make_coordinated(family: str, seed: int) -> Instance:
    """The instance of a family of ``COORDINATED`` or ``IMPOSSIBLE`` with this seed.

    Raises:
        KeyError: no such family.
        RuntimeError: no instance found for this seed.
    """
    maker = {**COORDINATED, **IMPOSSIBLE}[family]
    for attempt in range(TRIES):
        scene = maker(np.random.default_rng([seed, attempt]))
        if scene is not None:
            return Instance(family, seed, replace(scene, name=f"{family}_{seed}"))
    raise RuntimeError(f"no {family} instance found for seed {seed} in {TRIES} tries")


def slot_scene(
    rows: Sequence[str], side: int, starts: Slots, goals: Sequence[Optional[Slot]], height: int = 1
) -> PlanScene:
    """Square robots in a plan of slots.

    Args:
        rows: the plan, one string a row of slots along y, "." for a free one and "#" for a wall, all as long.
        side: cells of a robot along x and y.
        starts: slot (column, row) of each robot.
        goals: slot of each robot's goal; None for a robot that only stands there.
        height: cells of the grid and of the robots along z.
    """
    pitch, wide, deep = side + 1, len(rows[0]), len(rows)
    shape = (wide * pitch - 1, deep * pitch - 1, height)
    free: BoolArray = np.zeros(shape[:2], dtype=np.bool_)
    for j, row in enumerate(rows):
        for i, slot in enumerate(row):
            if slot == ".":
                free[i * pitch : i * pitch + side, j * pitch : j * pitch + side] = True
    boxes = boxes_of(~ndimage.binary_dilation(free, np.ones((3, 3), dtype=bool)), height)
    cells: IntArray = np.argwhere(np.ones((side, side, height), dtype=bool))
    robots, targets, assignments = [], {}, {}
    for k, (start, goal) in enumerate(zip(starts, goals)):
        robots.append(SceneRobot(f"cart_{k + 1}", Stand((start[0] * pitch, start[1] * pitch), 0.0), cells))
        if goal is not None:
            name = f"target_{k + 1}"
            targets[name] = Goal(name, GoalKind.TARGET, (goal[0] * pitch, goal[1] * pitch))
            assignments[robots[-1].name] = name
    top = (shape[0] / 10.0, shape[1] / 10.0, height / 10.0)
    return PlanScene(GridSpec(shape, (0.0, 0.0, 0.0), top), boxes, tuple(robots), targets, assignments)


def boxes_of(occupied: BoolArray, height: int) -> Tuple[Box, ...]:
    """Boxes that fill the occupied columns (gx, gy): one for each run along y, runs side by side joined."""
    open_runs: Dict[Tuple[int, int], int] = {}
    boxes: List[Box] = []
    for x in range(occupied.shape[0] + 1):
        row = occupied[x] if x < occupied.shape[0] else np.zeros(occupied.shape[1], dtype=np.bool_)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(np.int8), [0]]))).tolist()
        runs = set(zip(edges[::2], edges[1::2]))
        for run in sorted(set(open_runs) - runs):
            boxes.append((open_runs.pop(run), x, *run, 0, height))
        for run in runs - set(open_runs):
            open_runs[run] = x
    return tuple(sorted(boxes))


def walked(rng: np.random.Generator, rows: Sequence[str], at: Slots) -> Slots:
    """Where robots in slots are after many random moves to free neighbouring slots."""
    slots = list(at)
    taken = set(slots)
    for _ in range(WALK * len(slots)):
        k, (dx, dy) = int(rng.integers(len(slots))), ((1, 0), (-1, 0), (0, 1), (0, -1))[int(rng.integers(4))]
        x, y = slots[k][0] + dx, slots[k][1] + dy
        if 0 <= y < len(rows) and 0 <= x < len(rows[0]) and rows[y][x] == "." and (x, y) not in taken:
            taken.remove(slots[k])
            slots[k] = (x, y)
            taken.add((x, y))
    return tuple(slots)


def free_slots(rows: Sequence[str]) -> List[Slot]:
    """Slots of a plan that are no walls."""
    return [(x, y) for y, row in enumerate(rows) for x, slot in enumerate(row) if slot == "."]


def drawn(rng: np.random.Generator, slots: Sequence[Slot], count: int) -> Slots:
    """Some of the slots, as many as there are at most, in random order."""
    return tuple(slots[int(k)] for k in rng.permutation(len(slots))[:count])


def _shuffled(
    rng: np.random.Generator, rows: Sequence[str], count: int, side: int, idle: int = 0
) -> Optional[PlanScene]:
    """Robots on random slots, walked away from them; the last ``idle`` of them have no goal."""
    goals = drawn(rng, free_slots(rows), count)
    starts = walked(rng, rows, goals)
    wanted: List[Optional[Slot]] = [*goals[: count - idle], *[None] * idle]
    return slot_scene(rows, side, starts, wanted) if any(a != b for a, b in zip(starts, wanted) if b) else None


def _side(rng: np.random.Generator) -> int:
    return int(rng.integers(1, 4))


def _corridor_bay(rng: np.random.Generator) -> Optional[PlanScene]:
    """A corridor with one bay that holds one robot; two to four robots in another order."""
    length, count = int(rng.integers(5, 9)), int(rng.integers(2, 5))
    bay = int(rng.integers(1, length - 1))
    rows = ["." * length, "#" * bay + "." + "#" * (length - bay - 1)]
    corridor = [(x, 0) for x in range(length)]
    goals = drawn(rng, corridor, min(count, length - 2))
    starts = walked(rng, rows, goals)
    order = [sorted(range(len(p)), key=lambda k: p[k]) for p in (starts, goals)]
    return slot_scene(rows, _side(rng), starts, goals) if order[0] != order[1] else None


def _ring(rng: np.random.Generator) -> Optional[PlanScene]:
    """A ring of slots, all but one or two of them taken; everybody moves on by some places."""
    wide, deep = int(rng.integers(3, 6)), int(rng.integers(3, 5))
    rows = ["." * wide, *["." + "#" * (wide - 2) + "."] * (deep - 2), "." * wide]
    way = [(x, 0) for x in range(wide)] + [(wide - 1, y) for y in range(1, deep)]
    way += [(x, deep - 1) for x in range(wide - 2, -1, -1)] + [(0, y) for y in range(deep - 2, 0, -1)]
    count, on = len(way) - int(rng.integers(1, 3)), int(rng.integers(1, 3))
    starts = tuple(way[:count])
    return slot_scene(rows, _side(rng), starts, [way[(k + on) % len(way)] for k in range(count)])


def _parking(rng: np.random.Generator) -> Optional[PlanScene]:
    """A full lot with one free place."""
    wide, deep = [(3, 2), (3, 3), (4, 2)][int(rng.integers(3))]
    return _shuffled(rng, ["." * wide] * deep, wide * deep - 1, _side(rng))


def _pocket(rng: np.random.Generator) -> Optional[PlanScene]:
    """A small room whose side pocket is a dead end two places deep, with somebody at its end."""
    wide = int(rng.integers(3, 5))
    rows = ["." * wide + "..", "." * wide + "##"]
    free = free_slots(rows)
    inside: List[Slot] = [(wide + 1, 0)]
    rest = [slot for slot in free if slot not in inside]
    goals = (*inside, *drawn(rng, rest, int(rng.integers(1, 4))))
    starts = walked(rng, rows, goals)
    return slot_scene(rows, _side(rng), starts, goals) if starts[0] != goals[0] else None


def _tee(rng: np.random.Generator) -> Optional[PlanScene]:
    """A T of three arms one place wide."""
    arm = int(rng.integers(2, 4))
    rows = ["." * (2 * arm + 1), *["#" * arm + "." + "#" * arm] * arm]
    return _shuffled(rng, rows, int(rng.integers(2, 5)), _side(rng))


def _doors(rng: np.random.Generator) -> Optional[PlanScene]:
    """Two rooms with a door one place wide."""
    wide = int(rng.integers(2, 4))
    rows = ["." * wide + "#" + "." * wide, "." * wide + "." + "." * wide, "." * wide + "#" + "." * wide]
    return _shuffled(rng, rows, int(rng.integers(3, 7)), _side(rng))


def _bystanders(rng: np.random.Generator) -> Optional[PlanScene]:
    """A cross of two lanes in which robots without a goal stand."""
    rows = ["##..##", "......", "......", "##..##"]
    return _shuffled(rng, rows, int(rng.integers(5, 9)), _side(rng), idle=int(rng.integers(2, 4)))


def _puzzle(rng: np.random.Generator) -> Optional[PlanScene]:
    """Sliding blocks: 11 in 4 x 3 places or 15 in 4 x 4."""
    deep = int(rng.integers(3, 5))
    return _shuffled(rng, ["." * 4] * deep, 4 * deep - 1, 1)


SHAPES: Tuple[Tuple[Tuple[int, int, int], ...], ...] = (
    ((0, 0, 0),),
    ((0, 0, 0), (1, 0, 0)),
    ((0, 0, 0), (-1, 0, 0), (-1, 1, 0)),
    ((0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)),
    ((0, 0, 2), (1, 0, 2)),
    ((0, 0, 0), (0, 0, 1), (0, 0, 2)),
)
"""Cells of small robots; some are high enough for others to pass below."""


def random_scene(rng: np.random.Generator, shapes: Sequence[int] = range(len(SHAPES))) -> Optional[PlanScene]:
    """Two or three robots of random shapes among boxes, at random starts and goals; nobody says that it is solvable."""
    gx, gy, gz = int(rng.integers(5, 9)), int(rng.integers(4, 8)), 3
    boxes: List[Box] = []
    for x, y, long in rng.integers((0, 0, 1), (gx, gy, 4), (int(rng.integers(0, 4)), 3)).tolist():
        boxes.append((x, x + 1, y, min(gy, y + long), 0, gz))
    spec = GridSpec((gx, gy, gz), (0.0, 0.0, 0.0), (gx / 10.0, gy / 10.0, gz / 10.0))
    occupied = PlanScene(spec, tuple(boxes), (), {}).occupied()
    cells = [np.array(SHAPES[int(rng.choice(list(shapes)))]) for _ in range(int(rng.integers(2, 4)))]
    starts, ends = _placed(rng, occupied, cells), _placed(rng, occupied, cells)
    if starts is None or ends is None:
        return None
    robots = tuple(SceneRobot(f"robot_{k + 1}", Stand(s, 0.0), c) for k, (s, c) in enumerate(zip(starts, cells)))
    some = [k for k in range(len(robots)) if k == 0 or rng.random() < 0.85]
    goals = {f"target_{k + 1}": Goal(f"target_{k + 1}", GoalKind.TARGET, ends[k]) for k in some}
    return PlanScene(spec, tuple(boxes), robots, goals, {f"robot_{k + 1}": f"target_{k + 1}" for k in some})


def _placed(rng: np.random.Generator, occupied: BoolArray, shapes: Sequence[IntArray]) -> Optional[List[Slot]]:
    """Columns at which robots stand a margin apart from each other and from what is occupied."""
    taken, places = occupied.copy(), []
    for cells in shapes:
        near = ndimage.binary_dilation(taken, np.ones((3, 3, 3), dtype=bool))
        fits = [
            (x, y)
            for x, y in np.argwhere(~near.all(axis=2)).tolist()
            if all(0 <= x + a < near.shape[0] and 0 <= y + b < near.shape[1] for a, b, _ in cells.tolist())
            and not near[tuple((cells + np.array([x, y, 0])).T)].any()
        ]
        if not fits:
            return None
        x, y = fits[int(rng.integers(len(fits)))]
        places.append((int(x), int(y)))
        taken[tuple((cells + np.array([x, y, 0])).T)] = True
    return places


def _mixed(rng: np.random.Generator) -> Optional[PlanScene]:
    return _if_solvable(random_scene(rng))


def _turning(rng: np.random.Generator) -> Optional[PlanScene]:
    """Robots that are longer than wide, where somebody has to turn: without turns there is no solution."""
    scene = random_scene(rng, (1, 2, 4))
    return None if scene is None or least_cost(scene, ()) is not None else _if_solvable(scene)


def _if_solvable(scene: Optional[PlanScene]) -> Optional[PlanScene]:
    try:
        return scene if scene is not None and least_cost(scene, most_states=DRAWN_STATES) else None
    except TooLargeError:
        return None


def _no_bay(rng: np.random.Generator) -> Optional[PlanScene]:
    """A corridor without a bay, robots in another order."""
    length, count = int(rng.integers(4, 8)), int(rng.integers(2, 4))
    slots = [(x, 0) for x in range(length)]
    starts, goals = drawn(rng, slots, count), drawn(rng, slots, count)
    order = [sorted(range(count), key=lambda k: p[k]) for p in (starts, goals)]
    return slot_scene(["." * length], _side(rng), starts, goals) if order[0] != order[1] else None


def _wrong_parity(rng: np.random.Generator) -> Optional[PlanScene]:
    """A full lot with one free place, two robots exchanged after the shuffle: never reached."""
    wide, deep = [(3, 2), (3, 3)][int(rng.integers(2))]
    rows = ["." * wide] * deep
    goals = drawn(rng, free_slots(rows), wide * deep - 1)
    starts = walked(rng, rows, goals)
    return slot_scene(rows, int(rng.integers(1, 3)), starts, (goals[1], goals[0], *goals[2:]))


Maker = Callable[[np.random.Generator], Optional[PlanScene]]
COORDINATED: Dict[str, Maker] = {
    "corridor_bay": _corridor_bay,
    "ring": _ring,
    "parking": _parking,
    "pocket": _pocket,
    "tee": _tee,
    "doors": _doors,
    "bystanders": _bystanders,
    "puzzle": _puzzle,
    "mixed": _mixed,
    "turning": _turning,
}
"""Solvable families: a generator -> a scene, or None where this draw gives none."""
IMPOSSIBLE: Dict[str, Maker] = {"no_bay": _no_bay, "wrong_parity": _wrong_parity}
"""Families without a solution."""
