"""From an order of single moves to what the robots do now, at the same time, without touching.

A move waits only for those earlier moves that it touches, as in W. Hoenig, S. Kiesel, A. Tinka, J. W. Durham, N.
Ayanian, "Persistent and robust execution of MAPF schedules in warehouses", IEEE Robotics and Automation Letters, 2019.
"""

from __future__ import annotations

from functools import reduce
from operator import or_
from typing import Collection, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, dilated, overlap
from yarm.planning.cspace.robot_space import Pose
from yarm.planning.fleet.fleet import Fleet, Move, Poses
from yarm.planning.fleet.replanning import waypoint
from yarm.planning.model.types import PlannedMove


def valid(fleet: Fleet, moves: Sequence[Move], robots: Iterable[int]) -> bool:
    """Whether moves, made one after the other from where all stand, touch nothing and bring robots to their targets."""
    poses: Poses = fleet.starts
    for move in moves:
        if poses[move.robot] != move.start or not fleet.view(move.robot, poses).move(move.start, move.end):
            return False
        poses = (*poses[: move.robot], move.end, *poses[move.robot + 1 :])
    return all(fleet.satisfied(i, poses[i]) for i in robots)


def path_of(fleet: Fleet, moves: Sequence[Move], i: int) -> Tuple[Pose, ...]:
    """Poses of one robot, from where it stands."""
    return (fleet.starts[i], *(move.end for move in moves if move.robot == i))


class Conflicts:
    """Which moves of a fleet must keep their order: those whose sweeps, with the margin, are not disjoint."""

    def __init__(self, fleet: Fleet, off_centre: Collection[int] = ()) -> None:
        """Nothing looked at yet.

        Args:
            fleet: spaces.
            off_centre: robots that do not stand on their column's centre, so that they really move beside the way
                planned by less than a cell; two of them moving at once keep one more cell apart.
        """
        self._fleet = fleet
        self._off_centre = off_centre
        self._swept: Dict[Move, CellSet] = {}
        self._grown: Dict[Move, CellSet] = {}
        self._shadows: Dict[Move, Tuple[ColumnSet, ColumnSet]] = {}  # columns of what is swept, and of that grown
        self._known: Dict[Tuple[Move, Move], bool] = {}

    def between(self, one: Move, other: Move) -> bool:
        """Whether a move must not be made at the same time as another, earlier one."""
        if (one, other) not in self._known:
            self._known[one, other] = self._touch(one, other)
        return self._known[one, other]

    def with_cells(self, move: Move, grown: CellSet) -> bool:
        """Whether a move touches cells that are grown by the margin already."""
        swept = self._swept_by(move)
        if move.robot in self._off_centre:
            swept = dilated(swept, self.stride(move.robot))
        return overlap(swept, grown)

    def stride(self, i: int) -> int:
        """Of a robot's layout."""
        return self._fleet.spaces[i].layout.stride

    def _touch(self, one: Move, other: Move) -> bool:
        off_centre = one.robot in self._off_centre and other.robot in self._off_centre
        if not off_centre and not self._shadows_of(one)[0] & self._shadows_of(other)[1]:
            return False  # as most are: no column of the grid is in both
        if overlap(self._swept_by(one), self._grown_by(other)):
            return True
        return off_centre and overlap(dilated(self._swept_by(one), self.stride(one.robot)), self._grown_by(other))

    def _grown_by(self, move: Move) -> CellSet:
        if move not in self._grown:
            self._grown[move] = dilated(self._swept_by(move), self.stride(move.robot))
        return self._grown[move]

    def _shadows_of(self, move: Move) -> Tuple[ColumnSet, ColumnSet]:
        if move not in self._shadows:
            cells = self._swept_by(move), self._grown_by(move)
            swept, grown = (reduce(or_, cell_set) for cell_set in cells)
            self._shadows[move] = swept, grown
        return self._shadows[move]

    def _swept_by(self, move: Move) -> CellSet:
        if move not in self._swept:
            self._swept[move] = self._fleet.spaces[move.robot].swept(move.start, move.end)
        return self._swept[move]


class StepChoice:
    """Which of the moves may be made at once.

    The order of two moves matters only when what they sweep is not disjoint (with the margin). So a robot's next move
    may be made now when it is disjoint from every earlier unfinished move of the others; then any two robots that move
    now are disjoint, and the moves left still follow the order wherever it matters.
    """

    def __init__(
        self,
        fleet: Fleet,
        moves: Sequence[Move],
        least_cells: int,
        conflicts: Optional[Conflicts] = None,
        under_way: Optional[Mapping[int, CellSet]] = None,
    ) -> None:
        """Choose among the moves of a fleet.

        Args:
            fleet: spaces.
            moves: joint plan.
            least_cells: a robot that must wait moves up to the conflict when that is as far as this.
            conflicts: of the fleet's moves, when some were looked at already.
            under_way: what is swept by moves being made already, by the robot that makes them; they come before all.
        """
        self._fleet = fleet
        self.moves = list(moves)
        self._least = least_cells
        self._conflicts = conflicts or Conflicts(fleet)
        grown = {i: dilated(cells, self._conflicts.stride(i)) for i, cells in (under_way or {}).items()}
        self._under_way: Dict[int, CellSet] = grown

    def choose(self) -> Dict[int, Pose]:
        """End of the move each robot makes now; robots not named stay. ``moves`` may have been split for it."""
        chosen: Dict[int, Pose] = {}
        seen = set(self._under_way)
        index = 0
        while index < len(self.moves):
            move = self.moves[index]
            if move.robot not in seen:
                seen.add(move.robot)
                end = self._possible(index)
                if end is not None:
                    chosen[move.robot] = end
            index += 1
        return chosen

    def after(self, index: int) -> Tuple[int, ...]:
        """Indices of the earlier moves of others that a move must not be made before."""
        move = self.moves[index]
        earlier = enumerate(self.moves[:index])
        return tuple(k for k, other in earlier if other.robot != move.robot and self._conflicts.between(move, other))

    def behind(self, move: Move) -> Tuple[int, ...]:
        """Other robots whose moves under way a move is not disjoint from."""
        others = ((i, grown) for i, grown in self._under_way.items() if i != move.robot)
        return tuple(i for i, grown in others if self._conflicts.with_cells(move, grown))

    def _possible(self, index: int) -> Optional[Pose]:
        move = self.moves[index]
        earlier = [other for other in self.moves[:index] if other.robot != move.robot]
        if not self._held_up(move, earlier):
            return move.end
        if move.start[2] != move.end[2]:
            return None
        for tenths in (8, 6, 4, 2):
            split = self._split(index, tenths / 10.0)
            if split and not self._held_up(split[0], earlier):
                trial = [*self.moves[:index], *split, *self.moves[index + 1 :]]
                if valid(self._fleet, trial, range(len(self._fleet.spaces))):
                    self.moves = trial
                    return split[0].end
        return None

    def _split(self, index: int, fraction: float) -> List[Move]:
        move = self.moves[index]
        (ax, ay, _), (bx, by, h) = move.start, move.end
        dx, dy = round((bx - ax) * fraction), round((by - ay) * fraction)
        if max(abs(dx), abs(dy)) < self._least or (dx, dy) == (bx - ax, by - ay):
            return []
        middle = (ax + dx, ay + dy, h)
        return [Move(move.robot, move.start, middle), Move(move.robot, middle, move.end)]

    def _held_up(self, move: Move, earlier: Iterable[Move]) -> bool:
        return bool(self.behind(move)) or any(self._conflicts.between(move, other) for other in earlier)


def planned_moves(choice: StepChoice, fleet: Fleet, names: Sequence[str]) -> Tuple[PlannedMove, ...]:
    """The joint plan of a choice, by the robots' names, with who waits for whom."""
    planned = []
    for index, move in enumerate(choice.moves):
        space = fleet.spaces[move.robot]
        ends = waypoint(move.start, space), waypoint(move.end, space)
        behind = tuple(names[i] for i in choice.behind(move))
        planned.append(PlannedMove(names[move.robot], *ends, choice.after(index), behind))
    return tuple(planned)
