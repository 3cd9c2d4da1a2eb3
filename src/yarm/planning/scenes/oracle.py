"""Complete searches over every cell and turn: what is solvable at all, and how short a path can be.

Slow and simple on purpose; no code of a planner is used. One robot moves at a time, by one cell along an axis or by one
turn in place. Nothing is lost by that: the cells a longer step sweeps hold a chain of such moves, and steps whose
sweeps are disjoint can be made one after the other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage, sparse
from scipy.sparse.csgraph import dijkstra

from yarm.geometry import BoolArray, FloatArray, GridSpec, IntArray, Mask
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import PlanRequest, Waypoint
from yarm.planning.scenes.scene import PlanScene, SceneRobot, Stand
from yarm.planning.verification.checker import sweep_of

ColumnBits = Tuple[IntArray, IntArray]
"""Columns (n, 2), and the heights occupied in each as the bits of a number (n,)."""


@dataclass(frozen=True)
class Node:
    """A place of one robot: index of its heading, and the column of its end effector."""

    heading: int
    x: int
    y: int


class Shape:
    """One robot's cells at every heading it can come to, and what it sweeps from one to the next."""

    def __init__(self, robot: SceneRobot, spec: GridSpec, turns_deg: Sequence[float] = PlannerParams.turns_deg) -> None:
        self.spec = spec
        self._robot = robot
        self.yaws: List[float] = _headings(robot.start.yaw_rad, turns_deg)
        self.masks: List[Mask] = [robot.mask(spec, yaw) for yaw in self.yaws]
        self.turns: Dict[Tuple[int, int], IntArray] = {}
        for i, yaw in enumerate(self.yaws):
            for turn in turns_deg:
                j = _heading_index(self.yaws, yaw + math.radians(turn))
                if turn and i != j:
                    self.turns[i, j] = self._turn_cells(i, math.radians(turn))
        self.mask_columns: List[ColumnBits] = [_column_bits(mask.cells) for mask in self.masks]
        self.turn_columns: Dict[Tuple[int, int], ColumnBits] = {p: _column_bits(c) for p, c in self.turns.items()}

    def heading(self, yaw_rad: float) -> int:
        """Index of a heading, rad.

        Raises:
            ValueError: the robot cannot come to that heading.
        """
        return _heading_index(self.yaws, yaw_rad)

    def _turn_cells(self, heading: int, angle: float) -> IntArray:
        """(n, 3) cells relative to the end effector's column that a turn in place sweeps."""
        robot = self._robot.standing(self.spec, Stand((0, 0), self.yaws[heading]))
        request = PlanRequest(self.spec, np.zeros(self.spec.shape, dtype=np.bool_), (robot,), {}, {})
        return sweep_of(request, robot, Waypoint((0, 0), self.yaws[heading] + angle)).cells


class Space:
    """Where one shape may stand and turn among fixed obstacles, with a margin of one cell or without."""

    def __init__(self, shape: Shape, occupied: BoolArray, margin: bool = True) -> None:
        self.shape = shape
        near = ndimage.binary_dilation(occupied, np.ones((3, 3, 3), dtype=bool)) if margin else occupied
        weights = np.left_shift(np.int64(1), np.arange(near.shape[2], dtype=np.int64))
        self._near: IntArray = near @ weights
        self.free: BoolArray = np.stack([self._clear(columns) for columns in shape.mask_columns])
        """(headings, gx, gy) columns where the robot may stand."""
        self.turn_free: Dict[Tuple[int, int], BoolArray] = {
            pair: self._clear(columns) for pair, columns in shape.turn_columns.items()
        }
        """(gx, gy) columns where it may turn from one heading to another."""

    def _clear(self, column_bits: ColumnBits) -> BoolArray:
        columns, bits = column_bits
        gx, gy = self._near.shape
        reach = int(np.abs(columns).max(initial=0))
        padded = np.full((gx + 2 * reach, gy + 2 * reach), -1, dtype=np.int64)
        padded[reach : reach + gx, reach : reach + gy] = self._near
        hit = np.zeros((gx, gy), dtype=np.int64)
        for (dx, dy), column in zip(columns, bits):
            hit |= padded[reach + dx : reach + dx + gx, reach + dy : reach + dy + gy] & column
        clear: BoolArray = hit == 0
        return clear

    def graph(self, diagonal: bool) -> sparse.csr_matrix:
        """Moves by one cell and turns in place, between places numbered by ``number``; weights are cells travelled.

        Args:
            diagonal: also to the four diagonal neighbours, where all four cells around are free.
        """
        n = self.free.size
        numbers = np.arange(n).reshape(self.free.shape)
        rows, columns, weights = [], [], []
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)) if diagonal else ((1, 0), (0, 1)):
            possible = self.free & self._neighbour(dx, dy)
            if dx and dy:
                possible = possible & self._neighbour(dx, 0) & self._neighbour(0, dy)
            a = numbers[possible]
            b = a + dx * self.free.shape[2] + dy
            rows += [a, b]
            columns += [b, a]
            weights.append(np.full(2 * len(a), math.hypot(dx, dy)))
        for (i, j), clear in self.turn_free.items():
            possible = clear & self.free[i] & self.free[j]
            rows.append(numbers[i][possible])
            columns.append(numbers[j][possible])
            weights.append(np.full(int(possible.sum()), 1e-9))
        data = (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.csr_matrix(data, shape=(n, n))

    def _neighbour(self, dx: int, dy: int) -> BoolArray:
        """Whether the column by (dx, dy) further on is free; outside the grid it is not."""
        _, gx, gy = self.free.shape
        padded = np.pad(self.free, ((0, 0), (1, 1), (1, 1)))
        result: BoolArray = padded[:, 1 + dx : 1 + dx + gx, 1 + dy : 1 + dy + gy]
        return result

    def number(self, node: Node) -> int:
        """Number of a place in the graph."""
        return int(np.ravel_multi_index((node.heading, node.x, node.y), self.free.shape))

    def lengths(self, node: Node, diagonal: bool = True) -> FloatArray:
        """(gx, gy) shortest way to each column in cells, at whatever heading; infinite where none leads."""
        if not self.free[node.heading, node.x, node.y]:
            return np.full(self.free.shape[1:], np.inf)
        distance = dijkstra(self.graph(diagonal), indices=self.number(node)).reshape(self.free.shape)
        shortest: FloatArray = distance.min(axis=0)
        return shortest


def shortest_length(scene: PlanScene, robot: str, goal: str) -> float:
    """Length in cells of the shortest way of one robot over the grid's eight neighbours; infinite when none exists.

    The other robots are obstacles where they stand.
    """
    mover = next(r for r in scene.robots if r.name == robot)
    occupied = scene.occupied()
    for other in scene.robots:
        if other.name != robot:
            cells = other.mask(scene.spec, other.start.yaw_rad).at(other.start.column)
            occupied[tuple(cells[scene.spec.contains(cells)].T)] = True
    space = Space(Shape(mover, scene.spec), occupied)
    start = Node(space.shape.heading(mover.start.yaw_rad), *mover.start.column)
    return float(space.lengths(start)[scene.goals[goal].column])


def pair_solvable(scene: PlanScene) -> bool:
    """Whether two robots can come to their assigned goals, by a search over all pairs of places (small grids only).

    A robot without a goal may end anywhere.
    """
    first, second = scene.robots
    spaces = [Space(Shape(robot, scene.spec, ()), scene.occupied()) for robot in (first, second)]
    starts = [space.number(Node(0, *robot.start.column)) for space, robot in zip(spaces, scene.robots)]
    goals = [_goal_column(scene, robot) for robot in scene.robots]
    apart = ~too_close(spaces[0].shape.masks[0], spaces[1].shape.masks[0], scene.spec)
    free = spaces[0].free.reshape(-1, 1) & spaces[1].free.reshape(1, -1) & apart
    moves = [(space.graph(diagonal=False) > 0).astype(np.int32) for space in spaces]
    reached = np.zeros_like(free)
    reached[starts[0], starts[1]] = free[starts[0], starts[1]]
    wanted = np.ones_like(free)
    for axis, goal in enumerate(goals):
        if goal is not None:
            keep = np.zeros(free.shape[axis], dtype=bool)
            keep[spaces[axis].number(Node(0, *goal))] = True
            wanted &= keep[:, None] if axis == 0 else keep[None, :]
    frontier = reached
    while frontier.any() and not (reached & wanted).any():
        ahead = (moves[0] @ frontier.astype(np.int32)) + (moves[1] @ frontier.T.astype(np.int32)).T
        frontier = (ahead > 0) & free & ~reached
        reached = reached | frontier
    return bool((reached & wanted).any())


def too_close(first: Mask, second: Mask, spec: GridSpec) -> BoolArray:
    """(gx * gy, gx * gy) which columns of two robots' end effectors bring their cells together or side by side."""
    gx, gy, _ = spec.shape
    table = overlap_offsets(inflated_cells(first.cells), second.cells)
    x, y = np.divmod(np.arange(gx * gy), gy)
    dx, dy = x[None, :] - x[:, None], y[None, :] - y[:, None]
    reach = table.shape[0] // 2
    near = (np.abs(dx) <= reach) & (np.abs(dy) <= reach)
    result = np.zeros((gx * gy, gx * gy), dtype=bool)
    result[near] = table[dx[near] + reach, dy[near] + reach]
    return result


def overlap_offsets(first: IntArray, second: IntArray) -> BoolArray:
    """(2 r + 1, 2 r + 1) whether cells (n, 3) and (m, 3) overlap when the second is moved by (dx - r, dy - r)."""
    parts = []
    for z in np.intersect1d(first[:, 2], second[:, 2]):
        a, b = first[first[:, 2] == z, :2], second[second[:, 2] == z, :2]
        parts.append((a[:, None, :] - b[None, :, :]).reshape(-1, 2))
    offsets = np.concatenate(parts) if parts else np.zeros((0, 2), dtype=np.int64)
    reach = int(np.abs(offsets).max(initial=0))
    table: BoolArray = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=bool)
    table[tuple((offsets + reach).T)] = True
    return table


def inflated_cells(cells: IntArray) -> IntArray:
    """Cells (n, 3) with all their 26 neighbours, (m, 3)."""
    around = np.argwhere(np.ones((3, 3, 3), dtype=bool)) - 1
    inflated: IntArray = np.unique((cells[:, None, :] + around).reshape(-1, 3), axis=0)
    return inflated


def _goal_column(scene: PlanScene, robot: SceneRobot) -> Optional[Tuple[int, int]]:
    goal = scene.assignments.get(robot.name)
    return None if goal is None else scene.goals[goal].column


def _column_bits(cells: IntArray) -> ColumnBits:
    columns, index = np.unique(cells[:, :2], axis=0, return_inverse=True)
    bits = np.zeros(len(columns), dtype=np.int64)
    np.bitwise_or.at(bits, index, np.left_shift(np.int64(1), cells[:, 2]))
    return columns, bits


def _headings(yaw_rad: float, turns_deg: Sequence[float]) -> List[float]:
    """Every heading that repeated turns lead to, the present one first; a full circle of one degree at most."""
    found = [yaw_rad]
    for yaw in found:
        for turn in turns_deg:
            new = yaw + math.radians(turn)
            if all(abs(math.remainder(new - known, 2.0 * math.pi)) > 1e-6 for known in found) and len(found) < 360:
                found.append(math.remainder(new, 2.0 * math.pi))
    return found


def _heading_index(yaws: Sequence[float], yaw_rad: float) -> int:
    for i, yaw in enumerate(yaws):
        if abs(math.remainder(yaw - yaw_rad, 2.0 * math.pi)) < 1e-6:
            return i
    raise ValueError(f"heading {yaw_rad} rad is none of {', '.join(f'{yaw:.6f}' for yaw in yaws)}")
