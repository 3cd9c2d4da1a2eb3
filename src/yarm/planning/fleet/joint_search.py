"""A joint plan for the fleet: an order of single moves in which every robot reaches its target.

Robots plan one after the other around those that went before (M. Erdmann, T. Lozano-Perez, "On multiple moving
objects", Algorithmica 2, 1987), in an order that follows from who stands, or will stand, in whose way (S. J. Buckley,
"Fast motion planning for multiple moving robots", ICRA 1989); other orders are tried at random when that fails (M.
Bennewitz, W. Burgard, S. Thrun, "Optimizing schedules for prioritized path planning of multi-robot systems", ICRA
2001).
"""

from __future__ import annotations

from itertools import islice, permutations
from typing import Dict, Iterator, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from yarm.planning.cspace.robot_space import Pose
from yarm.planning.fleet.fleet import Fleet, Move, Progress, free_path
from yarm.planning.fleet.goal_headings import Targets, target_choices
from yarm.planning.fleet.pushing import push_through, stroll
from yarm.planning.roadmap.search import Path, Target, path_cost

Trial = Tuple[Tuple[int, ...], Targets, int, Optional[np.random.Generator]]
"""An order of the robots, targets, how many may be pushed aside, and chance when it has a say."""
CHOICES = 6
"""Choices of headings on the targets that are tried before chance takes over."""


class JointSearch:
    """Looks for a joint plan: headings on the targets, orders of the robots, then pushing aside, then chance."""

    def __init__(self, fleet: Fleet, robots: Sequence[int], limit: int) -> None:
        """A search.

        Args:
            fleet: spaces and targets.
            robots: those with a target, which can be reached with no other robot there.
            limit: rounds; in each one robot moves, or an order is given up.
        """
        self._fleet = fleet
        self._robots = tuple(robots)
        self.limit = limit
        self._pushes = 4 * len(fleet.spaces)
        self.rounds = 0

    def quick(self) -> Optional[List[Move]]:
        """Robots go to their targets one after the other, in the most promising order only."""
        return self._promising(target_choices(self._fleet, self._robots)[:1], 0)

    def run(self, rng: np.random.Generator) -> Optional[List[Move]]:
        """Moves that bring every robot to its target; None when none are found within the limit."""
        choices = target_choices(self._fleet, self._robots)
        moves = self._promising(choices[:CHOICES], 0) or self._promising(choices[:CHOICES], self._pushes)
        if moves is None and len(self._robots) > 1:
            moves = self._other_orders(choices[:2])
        while moves is None and self.rounds < self.limit:
            targets = choices[int(rng.integers(len(choices)))]
            order = tuple(int(i) for i in rng.permutation(self._robots))
            moves = self._in_order(order, targets, self._pushes, rng)
        return moves

    def candidates(self, rng: np.random.Generator, more: int, all_orders: bool = True) -> Iterator[List[Move]]:
        """Different joint plans, until the limit when there are none, else until so many rounds after the first.

        Args:
            rng: of what chance tries.
            more: so many rounds.
            all_orders: try all orders before chance takes over; false: only the most promising one.
        """
        seen: Set[Tuple[Move, ...]] = set()
        for order, targets, pushes, chance in self._trials(rng, all_orders):
            moves = self._in_order(order, targets, pushes, chance)
            if moves is not None and tuple(moves) not in seen:
                self.limit = self.limit if seen else self.rounds + more
                seen.add(tuple(moves))
                yield moves
            if self.rounds >= self.limit or moves == []:
                return

    def _trials(self, rng: np.random.Generator, all_orders: bool) -> Iterator[Trial]:
        """What may be tried: the most promising first, at last chance for ever."""
        choices = target_choices(self._fleet, self._robots)
        if all_orders:
            yield from self._planned_trials(choices)
        else:
            yield self._first_order(choices[0]), choices[0], 0, None
        while True:
            targets = choices[int(rng.integers(min(CHOICES, len(choices))))]
            order = tuple(int(i) for i in rng.permutation(self._robots))
            yield order, targets, self._pushes, rng if all_orders or rng.random() < 0.5 else None

    def _planned_trials(self, choices: Sequence[Targets]) -> Iterator[Trial]:
        for pushes in (0, self._pushes):
            for targets in choices[:CHOICES]:
                yield self._first_order(targets), targets, pushes, None
        if len(self._robots) > 1:
            for pushes in (0, self._pushes):
                for targets in choices[:2]:
                    for order in _orders(self._first_order(targets)):
                        yield order, targets, pushes, None

    def _promising(self, choices: Sequence[Targets], pushes: int) -> Optional[List[Move]]:
        """With each choice of headings, the order in which robots clear the way of others and do not end in it."""
        for targets in choices:
            if self.rounds >= self.limit:
                return None
            moves = self._in_order(self._first_order(targets), targets, pushes, None)
            if moves is not None:
                return moves
        return None

    def _other_orders(self, choices: Sequence[Targets]) -> Optional[List[Move]]:
        for pushes in (0, self._pushes):
            for targets in choices:
                for order in _orders(self._first_order(targets)):
                    if self.rounds >= self.limit:
                        return None
                    moves = self._in_order(order, targets, pushes, None)
                    if moves is not None:
                        return moves
        return None

    def _first_order(self, targets: Targets) -> Tuple[int, ...]:
        fleet = self._fleet
        alone = {i: fleet.alone(i, targets[i]) for i in self._robots}
        views = {i: fleet.view(i, fleet.starts) for i in self._robots}
        shortest_first = sorted(self._robots, key=lambda i: (path_cost(views[i], alone[i] or ()), i))
        return _by_precedence(fleet, shortest_first, alone)

    def _in_order(
        self, order: Tuple[int, ...], targets: Targets, pushes: int, rng: Optional[np.random.Generator]
    ) -> Optional[List[Move]]:
        fleet = self._fleet
        state = Progress(fleet.starts)
        if rng is not None and rng.random() < 0.5:
            stroll(fleet, state, int(rng.integers(len(fleet.spaces))), rng)
        pending = [i for i in order if not targets[i].holds(state.poses[i])]
        while pending:
            self.rounds += 1
            i = next((i for i in pending if _walk(fleet, state, i, targets[i])), None)
            if i is None and pushes > 0:
                pushes -= 1
                i = next((i for i in pending if push_through(fleet, state, i, targets[i], rng)), None)
            if i is None or self.rounds >= self.limit:
                return None
            pending = [j for j in order if not targets[j].holds(state.poses[j])]
            pending.sort(key=lambda j: (j == i, order.index(j)))
        return state.moves


def _orders(first: Tuple[int, ...]) -> Iterator[Tuple[int, ...]]:
    """Orders other than the first one: all, or for a large fleet those that begin with another robot."""
    if len(first) <= 4:
        yield from islice(permutations(first), 1, None)
        return
    for shift in range(1, len(first)):
        yield first[shift:] + first[:shift]


def _by_precedence(fleet: Fleet, order: Sequence[int], alone: Mapping[int, Optional[Path]]) -> Tuple[int, ...]:
    before: Dict[int, Set[int]] = {i: set() for i in order}
    for i in order:
        path = alone[i]
        for j in order:
            other = alone[j]
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
    alone = fleet.alone(i, target)
    path: Optional[Path] = alone
    if alone is None:
        return False
    if state.poses[i] != alone[0] or not free_path(view, alone):
        path = fleet.path(view, state.poses[i], target)
    if path is None:
        return False
    state.go(i, path)
    return True
