"""A complete search over all places of a whole fleet: what is solvable, and the least cost of it (small grids only).

Simple on purpose; no code of a planner is used. One robot moves at a time, by one cell along an axis or by one turn in
place, while all others stand (see ``oracle``).
"""

from __future__ import annotations

import math
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.planning.model.params import PlannerParams
from yarm.planning.scenes.oracle import Node, Shape, Space, inflated_cells, overlap_offsets
from yarm.planning.scenes.scene import PlanScene, SceneRobot

MOST_STATES = 40_000_000
"""Joint places looked at, at most; one byte each."""
Moves = Tuple[IntArray, IntArray, int, List[BoolArray]]
"""Places before and after, their cost, and for each robot the places (moves, places) of it that are in the way."""


class TooLargeError(ValueError):
    """More joint places than this search may look at."""


def least_cost(
    scene: PlanScene, turns_deg: Sequence[float] = PlannerParams.turns_deg, most_states: int = MOST_STATES
) -> Optional[int]:
    """Least sum of cells travelled and turns made, a cell for each 10 degrees, that brings all to their goals.

    Args:
        scene: robots apart from each other and from the boxes; one without a goal may end anywhere.
        turns_deg: allowed turns.
        most_states: joint places that may be looked at, one byte each.

    Returns:
        None when no order of moves does.

    Raises:
        TooLargeError: more than ``most_states`` joint places.
    """
    fleet = [_Mover(scene, robot, turns_deg) for robot in scene.robots]
    sizes = [mover.size for mover in fleet]
    total = math.prod(sizes)
    if total > most_states:
        raise TooLargeError(f"{total} joint places, at most {most_states}")
    weights = [math.prod(sizes[i + 1 :]) for i in range(len(fleet))]
    moves = [fleet[i].moves(fleet, i) for i in range(len(fleet))]
    wanted = [mover.wanted for mover in fleet]
    fronts: Dict[int, List[IntArray]] = {0: [np.array([0], dtype=np.int64)]}
    seen: BoolArray = np.zeros(total, dtype=np.bool_)
    cost = 0
    while fronts:
        front = np.unique(np.concatenate(fronts.pop(cost, [np.zeros(0, dtype=np.int64)])))
        front = front[~seen[front]]
        seen[front] = True
        at = [front // weight % size for weight, size in zip(weights, sizes)]
        if np.any(np.logical_and.reduce([w[a] for w, a in zip(wanted, at)])):
            return cost
        for i, kinds in enumerate(moves):
            for step in kinds if len(front) else ():
                after = _made(front, at, i, step, weights[i])
                fronts.setdefault(cost + step[2], []).append(after[~seen[after]])
        cost += 1
    return None


def _made(front: IntArray, at: Sequence[IntArray], i: int, step: Moves, weight: int) -> IntArray:
    """Joint places that a kind of move of one robot leads to."""
    number, after, _, in_way = step
    row = number[at[i]]
    possible = row >= 0
    for j, table in enumerate(in_way):
        if j != i:
            possible &= ~table[row, at[j]]
    made: IntArray = front[possible] + (after[row[possible]] - at[i][possible]) * weight
    return made


class _Mover:
    """One robot's places that it can come to with nobody else there, its start the first."""

    def __init__(self, scene: PlanScene, robot: SceneRobot, turns_deg: Sequence[float]) -> None:
        self._shape = Shape(robot, scene.spec, turns_deg)
        self._space = Space(self._shape, scene.occupied())
        self._kinds: List[Tuple[int, int, int, int, int]] = [(1, 0, -1, -1, 1), (-1, 0, -1, -1, 1)]
        self._kinds += [(0, 1, -1, -1, 1), (0, -1, -1, -1, 1)]
        for h, k in self._shape.turns:
            angle = abs(math.remainder(self._shape.yaws[k] - self._shape.yaws[h], math.tau))
            self._kinds.append((0, 0, h, k, max(1, round(math.degrees(angle) / PlannerParams.turn_deg_per_cell))))
        self.nodes: List[Node] = [Node(0, *robot.start.column)]
        index = {self.nodes[0]: 0}
        for node in self.nodes:
            for kind in self._kinds:
                after = self._after(node, kind)
                if after is not None and after not in index:
                    index[after] = len(self.nodes)
                    self.nodes.append(after)
        self._index = index
        self.size = len(self.nodes)
        goal = scene.goals.get(scene.assignments.get(robot.name, ""))
        self.wanted: BoolArray = np.array(
            [
                goal is None or ((node.x, node.y) == goal.column and self._faces(node, goal.yaw_rad))
                for node in self.nodes
            ]
        )

    def _faces(self, node: Node, yaw_rad: Optional[float]) -> bool:
        return yaw_rad is None or abs(math.remainder(self._shape.yaws[node.heading] - yaw_rad, math.tau)) < 1e-6

    def _after(self, node: Node, kind: Tuple[int, int, int, int, int]) -> Optional[Node]:
        dx, dy, h, k, _ = kind
        if h >= 0 and (node.heading != h or not self._space.turn_free[h, k][node.x, node.y]):
            return None
        after = Node(k if h >= 0 else node.heading, node.x + dx, node.y + dy)
        _, gx, gy = self._space.free.shape
        inside = 0 <= after.x < gx and 0 <= after.y < gy
        return after if inside and self._space.free[after.heading, after.x, after.y] else None

    def moves(self, fleet: Sequence[_Mover], i: int) -> List[Moves]:
        """Kinds of moves: row of each place (-1 for none), place after each row, cost, others in the way."""
        found = []
        for kind in self._kinds:
            pairs = [(p, self._index[a]) for p, n in enumerate(self.nodes) for a in [self._after(n, kind)] if a]
            if not pairs:
                continue
            number = np.full(self.size, -1, dtype=np.int64)
            number[[p for p, _ in pairs]] = np.arange(len(pairs))
            after = np.array([a for _, a in pairs], dtype=np.int64)
            tables = [
                np.zeros((0, 0), dtype=np.bool_) if j == i else self._in_way(pairs, kind, other)
                for j, other in enumerate(fleet)
            ]
            found.append((number, after, kind[4], tables))
        return found

    def _in_way(
        self, pairs: Sequence[Tuple[int, int]], kind: Tuple[int, int, int, int, int], other: _Mover
    ) -> BoolArray:
        """(moves, places of the other) whether the other is in the way of the place after a move, or of its turn."""
        table = self._touching([self.nodes[a] for _, a in pairs], other, None)
        if kind[2] >= 0:
            table |= self._touching([self.nodes[p] for p, _ in pairs], other, (kind[2], kind[3]))
        return table

    def _touching(self, mine: Sequence[Node], other: _Mover, turn: Optional[Tuple[int, int]]) -> BoolArray:
        touching: BoolArray = np.zeros((len(mine), other.size), dtype=np.bool_)
        xy, theirs = np.array([(n.x, n.y) for n in mine]), np.array([(n.x, n.y) for n in other.nodes])
        for h in sorted({n.heading for n in mine}):
            cells = self._shape.masks[h].cells if turn is None else self._shape.turns[turn]
            rows = np.array([n.heading == h for n in mine])
            for k in sorted({n.heading for n in other.nodes}):
                columns = np.array([n.heading == k for n in other.nodes])
                offsets = overlap_offsets(inflated_cells(cells), other._shape.masks[k].cells)
                reach = offsets.shape[0] // 2
                d = theirs[columns][None, :, :] - xy[rows][:, None, :]
                near = np.abs(d).max(axis=2) <= reach
                hit = near & offsets[np.clip(d[..., 0] + reach, 0, 2 * reach), np.clip(d[..., 1] + reach, 0, 2 * reach)]
                touching[np.ix_(rows, columns)] = hit
        return touching
