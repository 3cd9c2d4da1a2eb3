"""A joint plan for the fleet: an order of single moves in which every robot reaches its target.

One robot moves at a time while all others stand, so each move is checked against where the others stand by then; moves
that do not touch each other are later made at the same time (``joint_plan``). Robots in the way are pushed aside first.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import islice, permutations
from typing import Dict, Iterable, Iterator, List, Optional, Sequence, Set, Tuple

from yarm.planning.bitboard import Board, Layers, dilated, union
from yarm.planning.cspace import Pose, RobotSpace, View, close_pair, margin_around
from yarm.planning.search import Path, Roadmap, Target, find_path, flood, merged, path_cost, shortened

Poses = Tuple[Pose, ...]


@dataclass(frozen=True)
class Move:
    """One robot's move: its index, where from and where to."""

    robot: int
    start: Pose
    end: Pose


class Fleet:
    """The robots' spaces, their targets, and views of each with the others standing somewhere."""

    def __init__(self, spaces: Sequence[RobotSpace], targets: Sequence[Optional[Target]], roadmap: Roadmap) -> None:
        """A fleet.

        Args:
            spaces: one for each robot.
            targets: where each must go; None for a robot that may be anywhere.
            roadmap: shared by all.
        """
        self.spaces = tuple(spaces)
        self.targets = tuple(targets)
        self.roadmap = roadmap
        self.starts: Poses = tuple(space.start for space in spaces)
        self._views: Dict[Tuple[int, Poses], View] = {}
        self._alone: Dict[int, Optional[Path]] = {}
        self._close: Set[Tuple[int, int]] = set()
        for i, one in enumerate(spaces):
            for j in range(i):
                if close_pair(one, spaces[j]):
                    self._close |= {(i, j), (j, i)}

    def view(self, i: int, poses: Poses, without: Iterable[int] = ()) -> View:
        """Space of a robot with the others standing at poses, those in ``without`` taken away."""
        skip = {i, *without}
        key = (i, tuple((-1, -1, -1) if j in skip else pose for j, pose in enumerate(poses)))
        if key not in self._views:
            space, others, near = self.spaces[i], [], []
            for j, pose in enumerate(poses):
                if j in skip:
                    continue
                if (i, j) in self._close and pose == self.starts[j]:
                    near.append(margin_around(space, self.spaces[j]))
                else:
                    others.append((self.spaces[j], pose))
            self._views[key] = View(space, others, near)
        return self._views[key]

    def alone(self, i: int) -> Optional[Path]:
        """Way of a robot to its target from its start if no other robot were there; None when there is none."""
        target = self.targets[i]
        if i not in self._alone and target is not None:
            view = self.view(i, self.starts, range(len(self.spaces)))
            self._alone[i] = find_path(view, self.roadmap, self.starts[i], target)
        return self._alone.get(i)

    def satisfied(self, i: int, pose: Pose) -> bool:
        """Whether a robot at a pose is where it must be."""
        target = self.targets[i]
        return target is None or (pose[:2] == target.column and target.heading in (None, pose[2]))

    def cost(self, moves: Sequence[Move]) -> float:
        """Sum of the costs of moves, cells."""
        return sum(self.spaces[move.robot].move_cost(move.start, move.end) for move in moves)

    def swept(self, i: int, path: Sequence[Pose]) -> Layers:
        """Cells a robot sweeps along a path."""
        cells = self.spaces[i].shape(path[0][2]).at(path[0][:2])
        for a, b in zip(path, path[1:]):
            cells = union(cells, self.spaces[i].swept(a, b))
        return cells


@dataclass
class _Progress:
    """A joint plan in the making: where everybody stands, the moves so far, and who is not at its target yet."""

    poses: Poses
    moves: List[Move]
    pending: List[int]

    def go(self, i: int, path: Path) -> None:
        """Append a robot's path."""
        self.moves += [Move(i, a, b) for a, b in zip(path, path[1:])]
        self.poses = (*self.poses[:i], path[-1], *self.poses[i + 1 :])


def joint_moves(fleet: Fleet, order: Sequence[int], limit: int) -> Tuple[Optional[List[Move]], int]:
    """Moves that bring every robot with a target to it.

    Orders of the robots are tried one after the other, the one given first; then robots push others aside.

    Args:
        fleet: spaces and targets.
        order: robots with a target that can be reached with no other robot there, most urgent first.
        limit: rounds; each moves one robot or gives up an order.

    Returns:
        moves, None when none were found; and the rounds used.
    """
    rounds = 0
    for pushing in (False, True):
        for candidate in _orders(fleet, order):
            moves, used = _in_order(fleet, candidate, pushing, limit - rounds)
            rounds += used
            if moves is not None or rounds >= limit:
                return moves, rounds
    return None, rounds


def _orders(fleet: Fleet, order: Sequence[int]) -> Iterator[Tuple[int, ...]]:
    """Orders worth a trial: first the one in which robots clear the way of others and do not end in it."""
    first = _by_precedence(fleet, order)
    seen = {first}
    yield first
    for candidate in islice(permutations(first), 1, 24):
        if candidate not in seen:
            seen.add(candidate)
            yield candidate
    if len(first) > 4:
        for shift in range(1, len(first)):
            yield first[shift:] + first[:shift]


def _by_precedence(fleet: Fleet, order: Sequence[int]) -> Tuple[int, ...]:
    before: Dict[int, Set[int]] = {i: set() for i in order}
    for i in order:
        path = fleet.alone(i)
        if path is None:
            continue
        for j in order:
            other = fleet.alone(j)
            if j == i or other is None:
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
    view = fleet.view(i, poses, [k for k in range(len(poses)) if k != j])
    return all(view.move(a, b) for a, b in zip(path, path[1:]))


def _in_order(fleet: Fleet, order: Tuple[int, ...], pushing: bool, limit: int) -> Tuple[Optional[List[Move]], int]:
    state = _Progress(fleet.starts, [], [i for i in order if not fleet.satisfied(i, fleet.starts[i])])
    rounds = 0
    pushes = 4 * len(fleet.spaces) if pushing else 0
    while state.pending:
        rounds += 1
        if rounds > limit:
            return None, rounds
        i = next((i for i in state.pending if _walk(fleet, state, i)), None)
        if i is None and pushes > 0:
            pushes -= 1
            i = next((i for i in state.pending if _push_through(fleet, state, i)), None)
        if i is None:
            return None, rounds
        state.pending = [j for j in order if not fleet.satisfied(j, state.poses[j])]
        state.pending.sort(key=lambda j: (j == i, order.index(j)))
    return state.moves, rounds


def _walk(fleet: Fleet, state: _Progress, i: int) -> bool:
    """Let a robot go to its target between the others, when it can."""
    view = fleet.view(i, state.poses)
    target = fleet.targets[i]
    alone = fleet.alone(i)
    if target is None or alone is None:
        return False
    path: Optional[Path] = alone
    if state.poses[i] != alone[0] or not all(view.move(a, b) for a, b in zip(alone, alone[1:])):
        path = find_path(view, fleet.roadmap, state.poses[i], target)
    if path is None:
        return False
    state.go(i, path)
    return True


def _push_through(fleet: Fleet, state: _Progress, i: int) -> bool:
    """Let a robot go to its target after those in its way have stepped aside, when they can."""
    target = fleet.targets[i]
    everybody = range(len(fleet.spaces))
    ghost = fleet.view(i, state.poses, everybody)
    if target is None:
        return False
    path = find_path(ghost, fleet.roadmap, state.poses[i], target)
    if path is None:
        return False
    trial = _Progress(state.poses, list(state.moves), [])
    keep_free = dilated(fleet.swept(i, path), fleet.spaces[i].layout.stride)
    for j in everybody:
        if j != i and not _stands_clear(fleet, j, trial.poses[j], keep_free):
            if not _step_aside(fleet, trial, j, keep_free, frozenset({i})):
                return False
    view = fleet.view(i, trial.poses)
    if not all(view.move(a, b) for a, b in zip(path, path[1:])):
        return False
    trial.go(i, path)
    state.poses, state.moves = trial.poses, trial.moves
    return True


def _stands_clear(fleet: Fleet, j: int, pose: Pose, keep_free: Layers) -> bool:
    return not any(a & b for a, b in zip(fleet.spaces[j].shape(pose[2]).at(pose[:2]), keep_free))


def _step_aside(fleet: Fleet, state: _Progress, j: int, keep_free: Layers, above: frozenset[int]) -> bool:
    """Move a robot to the nearest place clear of ``keep_free``, pushing others (but those above it) on when needed."""
    space = fleet.spaces[j]

    def wanted(h: int) -> Board:
        return space.layout.field & ~space.shape(h).blocked_by(keep_free) & space_ok(h)

    def space_ok(h: int) -> Board:
        return ~space.blocked(h)

    view = fleet.view(j, state.poses)
    way = flood(view, state.poses[j], wanted)
    if way is not None:
        state.go(j, shortened(view, merged(way)))
        return True
    below = [k for k in range(len(fleet.spaces)) if k != j and k not in above]
    view = fleet.view(j, state.poses, below)
    way = flood(view, state.poses[j], wanted) if below else None
    if way is None:
        return False
    path = shortened(view, merged(way))
    free_too = union(keep_free, dilated(fleet.swept(j, path), space.layout.stride))
    for k in below:
        if not _stands_clear(fleet, k, state.poses[k], free_too):
            if not _step_aside(fleet, state, k, free_too, above | {j}):
                return False
    view = fleet.view(j, state.poses)
    if not all(view.move(a, b) for a, b in zip(path, path[1:])):
        return False
    state.go(j, path)
    return True


__all__ = ["Fleet", "Move", "Poses", "joint_moves", "path_cost"]
