"""A joint plan for the fleet: an order of single moves in which every robot reaches its target."""

from __future__ import annotations

from itertools import islice, permutations
from typing import Dict, Iterator, List, Optional, Sequence, Set, Tuple

import numpy as np

from yarm.planning.cspace import Pose
from yarm.planning.fleet import Fleet, Move, Progress, free_path
from yarm.planning.pushing import push_through, stroll
from yarm.planning.search import Path, Target, find_path, path_cost

ORDERS = 24
"""Orders of the robots tried at most, each with and without pushing."""


class JointSearch:
    """Looks for a joint plan: orders of the robots, then pushing robots aside, then chance."""

    def __init__(self, fleet: Fleet, robots: Sequence[int], limit: int) -> None:
        """A search.

        Args:
            fleet: spaces and targets.
            robots: those with a target, which can be reached with no other robot there.
            limit: rounds; in each one robot moves, or an order is given up.
        """
        self._fleet = fleet
        self._robots = tuple(robots)
        self._limit = limit
        self.rounds = 0

    def quick(self) -> Optional[List[Move]]:
        """Robots go to their targets one after the other, in the most promising order only."""
        return self._in_order(_by_precedence(self._fleet, self._shortest_first()), 0, None)

    def run(self, rng: np.random.Generator) -> Optional[List[Move]]:
        """Moves that bring every robot to its target; None when none are found within the limit."""
        for pushes in (0, 4 * len(self._fleet.spaces)):
            for candidate in self._orders():
                moves = self._in_order(candidate, pushes, None)
                if moves is not None or self.rounds >= self._limit:
                    return moves
        while self.rounds < self._limit:
            candidate = tuple(int(i) for i in rng.permutation(self._robots))
            moves = self._in_order(candidate, 4 * len(self._fleet.spaces), rng)
            if moves is not None:
                return moves
        return None

    def _shortest_first(self) -> List[int]:
        fleet = self._fleet
        views = {i: fleet.view(i, fleet.starts) for i in self._robots}
        return sorted(self._robots, key=lambda i: (path_cost(views[i], fleet.alone(i) or ()), i))

    def _orders(self) -> Iterator[Tuple[int, ...]]:
        """Orders worth a trial: first the one in which robots clear the way of others and do not end in it."""
        first = _by_precedence(self._fleet, self._shortest_first())
        if len(first) <= 4:
            yield from islice(permutations(first), ORDERS)
            return
        for shift in range(len(first)):
            yield first[shift:] + first[:shift]

    def _in_order(
        self, order: Tuple[int, ...], pushes: int, rng: Optional[np.random.Generator]
    ) -> Optional[List[Move]]:
        fleet = self._fleet
        state = Progress(fleet.starts)
        if rng is not None and rng.random() < 0.5:
            stroll(fleet, state, int(rng.integers(len(fleet.spaces))), rng)
        pending = [i for i in order if not fleet.satisfied(i, state.poses[i])]
        while pending:
            self.rounds += 1
            i = next((i for i in pending if _walk(fleet, state, i, self._target(i, state, rng))), None)
            if i is None and pushes > 0:
                pushes -= 1
                i = next((i for i in pending if push_through(fleet, state, i, self._target(i, state, rng), rng)), None)
            if i is None or self.rounds >= self._limit:
                return None
            pending = [j for j in order if not fleet.satisfied(j, state.poses[j])]
            pending.sort(key=lambda j: (j == i, order.index(j)))
        return state.moves

    def _target(self, i: int, state: Progress, rng: Optional[np.random.Generator]) -> Target:
        """Target of a robot; by chance at one certain heading, so that it does not always end in another's way."""
        target = self._fleet.targets[i]
        assert target is not None
        if rng is None or target.heading is not None or rng.random() < 0.3:
            return target
        view = self._fleet.view(i, state.poses, range(len(self._fleet.spaces)))
        headings = [h for h in range(len(view.space.headings)) if view.stands((*target.column, h))]
        return Target(target.column, headings[int(rng.integers(len(headings)))]) if headings else target


def _by_precedence(fleet: Fleet, order: Sequence[int]) -> Tuple[int, ...]:
    before: Dict[int, Set[int]] = {i: set() for i in order}
    for i in order:
        path = fleet.alone(i)
        for j in order:
            other = fleet.alone(j)
            if j == i or path is None or other is None:
                continue
            if not _passes(fleet, i, path, j, other[0]):
                before[i].add(j)
            if not _passes(fleet, i, path, j, other[-1]):
                before[j].add(i)
    left, result = list(order), []
    while left:
        chosen = min(left, key=lambda i: (len(before[i] & set(left)), left.index(i)))
        left.remove(chosen)
        result.append(chosen)
    return tuple(result)


def _passes(fleet: Fleet, i: int, path: Path, j: int, pose: Pose) -> bool:
    """Whether a robot's path is free with another one standing at a pose."""
    poses = (*fleet.starts[:j], pose, *fleet.starts[j + 1 :])
    return free_path(fleet.view(i, poses, [k for k in range(len(poses)) if k != j]), path)


def _walk(fleet: Fleet, state: Progress, i: int, target: Target) -> bool:
    """Let a robot go to its target between the others, when it can."""
    view = fleet.view(i, state.poses)
    alone = fleet.alone(i)
    path: Optional[Path] = alone
    if alone is None or target != fleet.targets[i] or state.poses[i] != alone[0] or not free_path(view, alone):
        path = find_path(view, fleet.roadmap, state.poses[i], target)
    if path is None:
        return False
    state.go(i, path)
    return True
