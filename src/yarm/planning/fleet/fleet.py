"""The fleet: each robot's space with the others standing somewhere, and a joint plan in the making.

In a joint plan one robot moves at a time while all others stand, so each move is checked against where the others stand
by then. Moves that do not touch each other are later made at the same time (``joint_plan``).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Collection, Dict, Iterable, List, Optional, Sequence, Set, Tuple

from yarm.planning.cspace.cell_sets import CellSet, union
from yarm.planning.cspace.robot_space import Pose, RobotSpace, View, close_pair, margin_around
from yarm.planning.roadmap.roadmap import Roadmap
from yarm.planning.roadmap.search import Flooding, Path, Target, find_path

Poses = Tuple[Pose, ...]
FLOODINGS_BYTES = 32 * 2**20
"""Memory that searches through every cell may take which are kept for the next plan from the same poses, about."""


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
        self._alone: Dict[Tuple[int, Target], Optional[Path]] = {}
        self._paths: Dict[Tuple[View, Pose, Target], Optional[Path]] = {}
        self._floodings: Dict[Tuple[View, Pose], Flooding] = {}
        self._close: Set[Tuple[int, int]] = set()
        for i, one in enumerate(spaces):
            for j in range(i):
                if close_pair(one, spaces[j]):
                    self._close |= {(i, j), (j, i)}

    @property
    def close_pairs(self) -> Tuple[Tuple[int, int], ...]:
        """Pairs of robots that stand within each other's margin at their starts, both ways round, in order."""
        return tuple(sorted(self._close))

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

    def path(self, view: View, start: Pose, target: Target) -> Optional[Path]:
        """Way of a view's robot from a pose to a target; looked for once, since orders of robots share beginnings."""
        key = view, start, target
        if key not in self._paths:
            self._paths[key] = find_path(view, self.roadmap, start, target, self.flooding)
        return self._paths[key]

    def flooding(self, view: View, start: Pose) -> Flooding:
        """What a view's robot reaches from a pose; kept, since what is tried by chance begins where all stand now."""
        key = view, start
        if key not in self._floodings:
            kept_bytes = sum(flooding.size_bytes for flooding in self._floodings.values())
            while self._floodings and kept_bytes > FLOODINGS_BYTES:
                kept_bytes -= self._floodings.pop(next(iter(self._floodings))).size_bytes
            self._floodings[key] = Flooding(view, start)
        return self._floodings[key]

    def alone(self, i: int, target: Optional[Target] = None) -> Optional[Path]:
        """Way of a robot from its start to a target, its own unless given, if no other robot were there."""
        target = target or self.targets[i]
        if target is None:
            return None
        if (i, target) not in self._alone:
            view = self.view(i, self.starts, range(len(self.spaces)))
            self._alone[i, target] = self.path(view, self.starts[i], target)
        return self._alone[i, target]

    def restrict(self, robots: Collection[int]) -> None:
        """Let only some of the robots keep their targets."""
        self.targets = tuple(target if i in robots else None for i, target in enumerate(self.targets))

    def satisfied(self, i: int, pose: Pose) -> bool:
        """Whether a robot at a pose is where it must be."""
        target = self.targets[i]
        return target is None or target.holds(pose)

    def cost(self, moves: Sequence[Move]) -> float:
        """Sum of the costs of moves, cells."""
        return sum(self.spaces[move.robot].move_cost(move.start, move.end) for move in moves)

    def swept(self, i: int, path: Sequence[Pose]) -> CellSet:
        """Cells a robot sweeps along a path."""
        cells = self.spaces[i].shape(path[0][2]).at(path[0][:2])
        for a, b in zip(path, path[1:]):
            cells = union(cells, self.spaces[i].swept(a, b))
        return cells


@dataclass
class Progress:
    """A joint plan in the making: where everybody stands, and the moves so far."""

    poses: Poses
    moves: List[Move] = field(default_factory=list)

    def go(self, i: int, path: Path) -> None:
        """Append a robot's path."""
        self.moves += [Move(i, a, b) for a, b in zip(path, path[1:])]
        self.poses = (*self.poses[:i], path[-1], *self.poses[i + 1 :])

    def copy(self) -> Progress:
        """The same, to try something out."""
        return Progress(self.poses, list(self.moves))


def free_path(view: View, path: Path) -> bool:
    """Whether every move of a path is free."""
    return all(view.move(a, b) for a, b in zip(path, path[1:]))
