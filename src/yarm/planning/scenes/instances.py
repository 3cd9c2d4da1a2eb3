"""Seeded planning instances that are known to be solvable, for tests and benchmarks.

Families: ``open`` (a few boxes), ``table_and_stand`` (the cell of the missions), ``narrow_gaps`` (a wall with a gap
hardly wider than the robot and its margin), ``crossing`` (robots that change sides), ``corridors_head_on`` (two robots
that meet in a corridor with a bay). A fleet is made backwards: the robots stand on their goals, then make random moves,
each of which is safe by itself; the way back is a solution. Where random moves would not get through (gaps, crossings)
the robots are brought to their goals one after the other by a complete search, and pairs in corridors are judged by a
complete search over both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from scipy.sparse.csgraph import connected_components

from yarm.geometry import BoolArray, GridSpec, IntArray
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.oracle import Node, Shape, Space, inflated_cells, overlap_offsets, pair_solvable
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand

CELL_GRID = GridSpec()
"""The grid of the missions, 50 x 50 x 20 cells."""
TABLE_AND_STAND: Tuple[Box, ...] = (
    (20, 30, 19, 31, 0, 11),
    (20, 25, 22, 28, 11, 12),
    (12, 16, 23, 27, 0, 20),
)
"""Table, part, and stand with the manipulator folded over it."""
PART = (20, 25, 22, 28)
"""Columns of the part: x0, x1, y0, y1, ends exclusive."""
TRIES = 300


@dataclass(frozen=True, eq=False)
class Instance:
    """A scene and how it was made; every robot has a goal, and all goals can be reached."""

    family: str
    seed: int
    scene: PlanScene


def make_instance(family: str, seed: int, robots: int = 0, grid: Optional[GridSpec] = None) -> Instance:
    """The instance of a family with this seed.

    Args:
        family: one of ``FAMILIES``.
        seed: whole number >= 0.
        robots: size of the fleet; 0 for what is usual in the family (``corridors_head_on`` always has two).
        grid: another grid than the missions', for ``open`` and ``crossing``.

    Raises:
        KeyError: no such family.
        RuntimeError: no instance found for this seed (more robots than the grid holds).
    """
    maker = FAMILIES[family]
    for attempt in range(TRIES):
        rng = np.random.default_rng([seed, attempt])
        scene = maker(rng, robots, grid or CELL_GRID)
        if scene is not None:
            return Instance(family, seed, replace(scene, name=f"{family}_{seed}"))
    raise RuntimeError(f"no {family} instance with {robots} robots found for seed {seed} in {TRIES} tries")


def make_cluttered(boxes: int, seed: int, robots: int = 3) -> Instance:
    """Robots among so many boxes of any size on the missions' grid, every one on a walk away from its goal.

    Raises:
        RuntimeError: no instance found for this seed (more boxes than leave room).
    """
    for attempt in range(TRIES):
        rng = np.random.default_rng([seed, boxes, attempt])
        placed = _random_boxes(rng, boxes, CELL_GRID)
        scene = _backwards(rng, robots, placed, CELL_GRID, np.ones(CELL_GRID.shape[:2], dtype=bool))
        if scene is not None:
            return Instance("cluttered", seed, replace(scene, name=f"cluttered_{boxes}_{seed}"))
    raise RuntimeError(f"no instance of {robots} robots among {boxes} boxes found for seed {seed} in {TRIES} tries")


class Fleet:
    """Robots of one shape in one map, and which places are free for each of them."""

    def __init__(self, shape: Shape, occupied: BoolArray) -> None:
        self.shape = shape
        self.occupied = occupied
        self.space = Space(shape, occupied)
        self.nodes: List[Node] = []

    def add(self, rng: np.random.Generator, allowed: BoolArray) -> bool:
        """Put one more robot somewhere in the allowed columns (gx, gy); false when there is no room."""
        places = np.argwhere(self.space.free & allowed)
        for index in rng.permutation(len(places))[:TRIES]:
            heading, x, y = (int(v) for v in places[index])
            if self.clear(len(self.nodes), Node(heading, x, y)):
                self.nodes.append(Node(heading, x, y))
                return True
        return False

    def walk(self, rng: np.random.Generator, legs: int) -> None:
        """Each leg turns one robot in place or not, then moves it straight on until something is in the way."""
        for _ in range(legs):
            robot = int(rng.integers(len(self.nodes)))
            if rng.random() < 0.3:
                self._turn(robot, rng)
            dx, dy = ((1, 0), (-1, 0), (0, 1), (0, -1))[int(rng.integers(4))]
            for _ in range(int(rng.integers(3, 25))):
                node = self.nodes[robot]
                ahead = Node(node.heading, node.x + dx, node.y + dy)
                if not (self._free(ahead) and self.clear(robot, ahead)):
                    break
                self.nodes[robot] = ahead

    def reaches(self, robot: int, goal: Node) -> bool:
        """Whether one robot can come to a column, at any heading, while the others stay."""
        blocked = self.occupied.copy()
        for i, node in enumerate(self.nodes):
            if i != robot:
                blocked[tuple(self.shape.masks[node.heading].at((node.x, node.y)).T)] = True
        space = Space(self.shape, blocked)
        _, labels = connected_components(space.graph(diagonal=False), directed=False)
        labels = labels.reshape(space.free.shape)
        here = self.nodes[robot]
        return bool(labels[here.heading, here.x, here.y] == labels[goal.heading, goal.x, goal.y])

    def _free(self, node: Node) -> bool:
        _, gx, gy = self.space.free.shape
        return 0 <= node.x < gx and 0 <= node.y < gy and bool(self.space.free[node.heading, node.x, node.y])

    def _turn(self, robot: int, rng: np.random.Generator) -> None:
        node = self.nodes[robot]
        choices = [pair for pair in self.space.turn_free if pair[0] == node.heading]
        if choices:
            pair = choices[int(rng.integers(len(choices)))]
            if self.space.turn_free[pair][node.x, node.y] and self.clear(robot, node, pair):
                self.nodes[robot] = Node(pair[1], node.x, node.y)

    def clear(self, robot: int, node: Node, motion: Optional[Tuple[int, int]] = None) -> bool:
        """Whether a robot that stands there, or turns between two headings, stays a margin away from all others."""
        moved = motion or (node.heading, node.heading)
        return not any(_is_close(self.shape, moved, node, other) for i, other in enumerate(self.nodes) if i != robot)


def _is_close(shape: Shape, motion: Tuple[int, int], node: Node, other: Node) -> bool:
    table = _close_table(shape, motion, other.heading)
    reach = table.shape[0] // 2
    dx, dy = other.x - node.x, other.y - node.y
    return max(abs(dx), abs(dy)) <= reach and bool(table[dx + reach, dy + reach])


@lru_cache(maxsize=512)
def _close_table(shape: Shape, motion: Tuple[int, int], heading: int) -> BoolArray:
    cells = shape.masks[motion[0]].cells if motion[0] == motion[1] else shape.turns[motion]
    return overlap_offsets(inflated_cells(cells), shape.masks[heading].cells)


@lru_cache(maxsize=16)
def _ankurbot(grid: GridSpec) -> Shape:
    return Shape(SceneRobot("ankurbot", Stand((0, 0), 0.0)), grid)


def _scene(fleet: Fleet, starts: Sequence[Node], goals: Sequence[Node], boxes: Sequence[Box]) -> PlanScene:
    robots, targets, assignments = [], {}, {}
    for i, (start, goal) in enumerate(zip(starts, goals), 1):
        name, wanted = f"ankurbot_{i}", f"target_{i}"
        robots.append(SceneRobot(name, Stand((start.x, start.y), fleet.shape.yaws[start.heading])))
        targets[wanted] = Goal(wanted, GoalKind.TARGET, (goal.x, goal.y))
        assignments[name] = wanted
    return PlanScene(fleet.shape.spec, tuple(boxes), tuple(robots), targets, assignments)


def _backwards(
    rng: np.random.Generator, robots: int, boxes: Sequence[Box], grid: GridSpec, allowed: BoolArray
) -> Optional[PlanScene]:
    """Robots on their goals in the allowed columns, then walked away from them."""
    fleet = Fleet(_ankurbot(grid), _filled(grid, boxes))
    if not all(fleet.add(rng, allowed) for _ in range(robots)):
        return None
    goals = list(fleet.nodes)
    fleet.walk(rng, 12 * robots)
    return _scene(fleet, fleet.nodes, goals, boxes) if fleet.nodes != goals else None


def _one_by_one(
    rng: np.random.Generator,
    boxes: Sequence[Box],
    grid: GridSpec,
    starts: Sequence[BoolArray],
    goals: Sequence[BoolArray],
) -> Optional[PlanScene]:
    """Robots in the start columns of each and goals in the goal columns, brought there one after the other."""
    at_start, at_goal = (Fleet(_ankurbot(grid), _filled(grid, boxes)) for _ in range(2))
    if not all(at_start.add(rng, allowed) for allowed in starts) or not all(
        at_goal.add(rng, allowed) for allowed in goals
    ):
        return None
    first = list(at_start.nodes)
    for robot in rng.permutation(len(first)):
        goal = at_goal.nodes[robot]
        if not at_start.clear(robot, goal) or not at_start.reaches(robot, goal):
            return None
        at_start.nodes[robot] = goal
    return _scene(at_start, first, at_goal.nodes, boxes)


def _filled(grid: GridSpec, boxes: Sequence[Box]) -> BoolArray:
    return PlanScene(grid, tuple(boxes), (), {}).occupied()


def _random_boxes(rng: np.random.Generator, count: int, grid: GridSpec) -> List[Box]:
    boxes: List[Box] = []
    for _ in range(count):
        sx, sy, sz = (int(v) for v in rng.integers((2, 2, 3), (9, 9, grid.shape[2] + 1)))
        x, y = int(rng.integers(grid.shape[0] - sx)), int(rng.integers(grid.shape[1] - sy))
        boxes.append((x, x + sx, y, y + sy, 0, sz))
    return boxes


def _columns(grid: GridSpec, x0: int, x1: int, y0: int, y1: int) -> BoolArray:
    allowed: BoolArray = np.zeros(grid.shape[:2], dtype=bool)
    allowed[x0:x1, y0:y1] = True
    return allowed


def _open(rng: np.random.Generator, robots: int, grid: GridSpec) -> Optional[PlanScene]:
    area = grid.shape[0] * grid.shape[1] / 2500.0
    boxes = _random_boxes(rng, int(rng.integers(0, max(1, round(4 * area)) + 1)), grid)
    return _backwards(rng, robots or int(rng.integers(1, 4)), boxes, grid, np.ones(grid.shape[:2], dtype=bool))


def _table_and_stand(rng: np.random.Generator, robots: int, grid: GridSpec) -> Optional[PlanScene]:
    del grid
    return _backwards(rng, robots or int(rng.integers(1, 4)), TABLE_AND_STAND, CELL_GRID, _columns(CELL_GRID, *PART))


def _narrow_gaps(rng: np.random.Generator, robots: int, grid: GridSpec) -> Optional[PlanScene]:
    del grid
    grid = CELL_GRID
    count, along_y = robots or int(rng.integers(1, 3)), bool(rng.random() < 0.5)
    wall, thick = int(rng.integers(20, 29)), int(rng.integers(1, 4))
    gap, width = int(rng.integers(1, 39)), int(rng.integers(9, 12))
    pieces = [(wall, wall + thick, 0, gap, 0, 20), (wall, wall + thick, gap + width, 50, 0, 20)]
    boxes = [p if along_y else (p[2], p[3], p[0], p[1], p[4], p[5]) for p in pieces if p[2] < p[3]]
    low, high = _columns(grid, 0, wall, 0, 50), _columns(grid, wall + thick, 50, 0, 50)
    low, high = (low, high) if along_y else (low.T, high.T)
    sides = [(low, high) if rng.random() < 0.5 else (high, low) for _ in range(count)]
    return _one_by_one(rng, boxes, grid, [a for a, _ in sides], [b for _, b in sides])


def _crossing(rng: np.random.Generator, robots: int, grid: GridSpec) -> Optional[PlanScene]:
    count = robots or int(rng.integers(2, 4))
    gx, gy, _ = grid.shape
    boxes = _random_boxes(rng, int(rng.integers(0, 3)), grid)
    sides = [
        _columns(grid, 0, gx // 3, 0, gy),
        _columns(grid, gx - gx // 3, gx, 0, gy),
        _columns(grid, 0, gx, 0, gy // 3),
        _columns(grid, 0, gx, gy - gy // 3, gy),
    ]
    order = [int(rng.integers(2)) * 2 + i % 2 for i in range(count)]
    return _one_by_one(rng, boxes, grid, [sides[i] for i in order], [sides[i ^ 1] for i in order])


def _corridors_head_on(rng: np.random.Generator, robots: int, grid: GridSpec) -> Optional[PlanScene]:
    """Two square robots in a corridor as wide as one and its margins; a bay is deep enough to let the other pass."""
    del robots, grid
    side = int(rng.choice([1, 3]))
    half, length = side // 2, int(rng.integers(8, 15)) * side
    wall, depth = side + 3, side + int(rng.integers(0, 2))
    bay, bay_length = int(rng.integers(1, length - side - 3)), side + 2 + int(rng.integers(0, side + 1))
    spec = GridSpec((length, wall + depth, 2), (0.0, 0.0, 0.0), (length / 10.0, (wall + depth) / 10.0, 0.2))
    boxes: List[Box] = [(0, length, 0, 1, 0, 2), (0, bay, wall, wall + depth, 0, 2)]
    if bay + bay_length < length:
        boxes.append((bay + bay_length, length, wall, wall + depth, 0, 2))
    cells: IntArray = np.argwhere(np.ones((side, side, 2), dtype=bool)) - np.array([half, half, 0])
    row, left, right = 2 + half, half + int(rng.integers(0, 2)), length - 1 - half - int(rng.integers(0, 2))
    places = [(left, row), (right, row)]
    fleet = tuple(SceneRobot(f"cart_{i + 1}", Stand(place, 0.0), cells) for i, place in enumerate(places))
    goals: Dict[str, Goal] = {
        f"target_{i + 1}": Goal(f"target_{i + 1}", GoalKind.TARGET, place) for i, place in enumerate(reversed(places))
    }
    assigned: Mapping[str, str] = {robot.name: goal for robot, goal in zip(fleet, goals)}
    scene = PlanScene(spec, tuple(boxes), fleet, goals, assigned)
    return scene if pair_solvable(scene) else None


FAMILIES: Dict[str, Callable[[np.random.Generator, int, GridSpec], Optional[PlanScene]]] = {
    "open": _open,
    "table_and_stand": _table_and_stand,
    "narrow_gaps": _narrow_gaps,
    "crossing": _crossing,
    "corridors_head_on": _corridors_head_on,
}
"""Makers by family: (generator, robots, grid) -> a scene, or None where this draw gives none."""
