"""What could be different for one robot to reach one goal, and whether it would then (docs/planning.md, "Why").

Other robots are taken away: a robot that could go if they made room has a way. A change is tried on the request itself,
and the search that decides looks at every cell and heading.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from typing import Callable, Collection, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import IntArray, Mask
from yarm.planning.cspace.cell_sets import CellSet, ColumnSet, dilated
from yarm.planning.cspace.robot_space import RobotSpace, ShapeCache, View
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import Goal, PlanRequest, Robot, without_things
from yarm.planning.roadmap.search import Target, flood, reachable
from yarm.robots.turns import FINER_TURNS_DEG

UNKNOWN = "something unknown"
"""What stands in the map and belongs to nothing that anybody named."""


class ChangeKind(Enum):
    """What is changed; from the smallest to the largest."""

    MOVE = "move"
    LAY_DOWN = "lay_down"
    TURNS = "turns"
    REMOVE = "remove"
    ENTER = "enter"
    MARGIN = "margin"


_ORDER = {kind: i for i, kind in enumerate(ChangeKind)}


@dataclass(frozen=True)
class Change:
    """One thing that could be different.

    Attributes:
        kind: what is done.
        thing: what is moved, removed or laid down; empty for the rest.
        offset: columns it is moved by.
        metres: how far that is.
    """

    kind: ChangeKind
    thing: str = ""
    offset: Tuple[int, int] = (0, 0)
    metres: float = 0.0

    @property
    def size(self) -> Tuple[int, float, str]:
        """What smaller changes come first by: kind, then distance, then name."""
        return _ORDER[self.kind], self.metres, self.thing

    def __str__(self) -> str:
        """What to do, for a person."""
        turns = " and ".join(f"{angle:g}" for angle in FINER_TURNS_DEG if angle > 0.0)
        return {
            ChangeKind.MOVE: f"move {self.thing} by {self.metres:.2f} m{_direction(self.offset)}",
            ChangeKind.LAY_DOWN: f"let it lay {self.thing} down",
            ChangeKind.TURNS: f"allow turns of {turns} deg too (turns_deg)",
            ChangeKind.REMOVE: f"remove {self.thing}",
            ChangeKind.ENTER: "let it enter the private areas (mode BOUNDLESS)",
            ChangeKind.MARGIN: "plan without the margin of one cell (which no planner here does)",
        }[self.kind]


def _direction(offset: Tuple[int, int]) -> str:
    words = [f"{sign}{axis}" for value, axis in zip(offset, "xy") if value for sign in ("+" if value > 0 else "-")]
    return f" towards {' '.join(words)}" if words else ""


class Crossing:
    """One robot on its way to one goal, with nobody else there."""

    def __init__(
        self,
        request: PlanRequest,
        robot: str,
        goal: Goal,
        params: PlannerParams,
        bare: Optional[Callable[[float], Mask]] = None,
    ) -> None:
        """A robot and a goal of a request.

        Args:
            request: map, robots and objects; its assignments are not read.
            robot: name of the robot.
            goal: where it is to go.
            params: turns allowed.
            bare: mask of the robot without what it carries, at any heading, rad; None when it carries nothing.

        Raises:
            KeyError: no such robot.
        """
        named = [one for one in request.robots if one.name == robot]
        if not named:
            raise KeyError(f"there is no robot {robot}")
        self.robot: Robot = replace(named[0], turns_deg=None)
        self.goal = goal
        self._bare = bare
        self._turns_deg = params.turns_deg if named[0].turns_deg is None else named[0].turns_deg
        self._deg_per_cell = params.turn_deg_per_cell
        self._cache = ShapeCache()
        self._request = replace(request, goals={goal.name: goal}, assignments={robot: goal.name})
        self.things = _things(request, goal)
        standing = np.zeros(request.spec.shape, dtype=np.bool_)
        for one in request.robots:
            standing[tuple(one.cells[request.spec.contains(one.cells)].T)] = True
        self._beside_robots = ndimage.binary_dilation(standing, np.ones((3, 3, 3), dtype=np.bool_))

    @property
    def fault(self) -> str:
        """What is wrong with robot or goal whatever stands where; empty when nothing is."""
        fault = check.robot_fault(self.robot, self._request) or check.goal_fault(self.robot, self._request)
        return fault[1] if fault else ""

    def general_changes(self) -> List[Change]:
        """Changes that are not about a thing and say something new."""
        changes = [Change(ChangeKind.LAY_DOWN, self.robot.carries)] if self._bare is not None else []
        if not {abs(turn) for turn in FINER_TURNS_DEG} <= {abs(turn) for turn in self._turns_deg}:
            changes.append(Change(ChangeKind.TURNS))
        if self._request.forbidden is not None:
            changes.append(Change(ChangeKind.ENTER))
        return [*changes, Change(ChangeKind.MARGIN)]

    def reached(self, changes: Collection[Change] = ()) -> bool:
        """Whether the robot has a way to the goal with some changes made; complete over cells and headings."""
        problem = self._problem(changes)
        if problem is None or problem.targets[0] is None:
            return False
        space, wanted = problem.spaces[0], _wanted(problem, problem.targets[0])
        return flood(View(space, ()), space.start, lambda h: wanted[h]) is not None

    def in_the_way(self, changes: Collection[Change] = ()) -> List[str]:
        """Names of the things that border on what the robot can reach with some changes made."""
        problem = self._problem(changes)
        if problem is None:
            return []
        space = problem.spaces[0]
        reached = reachable(View(space, ()), space.start)
        gone = {change.thing for change in changes if change.kind is ChangeKind.REMOVE}
        margin = all(change.kind is not ChangeKind.MARGIN for change in changes)
        names = []
        for name, cells in self.things.items():
            if name not in gone and _stops(space, reached, problem.layout.set_of_cells(cells), margin):
                names.append(name)
        return names

    def moves(self, thing: str, limit_cells: int) -> List[Change]:
        """Ways to move a thing to where it stands free, the shortest first."""
        size = np.asarray(self._request.spec.resolution[:2])
        span = range(-limit_cells, limit_cells + 1)
        offsets = [(x, y) for x in span for y in span if 0 < math.hypot(x, y) <= limit_cells]
        moves = []
        for offset in offsets:
            if self._fits(thing, offset):
                moves.append(Change(ChangeKind.MOVE, thing, offset, float(np.hypot(*(np.array(offset) * size)))))
        return sorted(moves, key=lambda move: (move.metres, move.offset))

    def _fits(self, thing: str, offset: Tuple[int, int]) -> bool:
        """Whether a thing moved by columns stays in the grid and meets nothing, nor comes beside a robot."""
        spec, cells = self._request.spec, self.things[thing]
        moved = cells + np.array([*offset, 0])
        if not np.all(spec.contains(moved)):
            return False
        free = ~(without_things(spec, self._request.occupied, self.things, {thing}) | self._beside_robots)
        return bool(np.all(free[tuple(moved.T)]))

    def _problem(self, changes: Collection[Change]) -> Optional[PlanningProblem]:
        """The robot's space with some changes made; None when it cannot be planned for."""
        kinds = {change.kind for change in changes}
        moved = [change for change in changes if change.kind is ChangeKind.MOVE]
        gone = {change.thing for change in changes if change.kind in (ChangeKind.MOVE, ChangeKind.REMOVE)}
        occupied = without_things(self._request.spec, self._request.occupied, self.things, gone)
        for change in moved:
            cells = self.things[change.thing] + np.array([*change.offset, 0])
            occupied[tuple(cells.T)] = True
        robot = self.robot
        if ChangeKind.LAY_DOWN in kinds and self._bare is not None:
            robot = replace(robot, mask=self._bare(robot.yaw_rad), mask_at=self._bare, carries="")
        robots = tuple(robot if one.name == robot.name else one for one in self._request.robots)
        forbidden = None if ChangeKind.ENTER in kinds else self._request.forbidden
        request = replace(self._request, occupied=occupied, robots=robots, forbidden=forbidden)
        finer = FINER_TURNS_DEG if ChangeKind.TURNS in kinds else ()
        turns = turns_of((*self._turns_deg, *finer), self._deg_per_cell)
        margin = ChangeKind.MARGIN not in kinds
        return PlanningProblem.of(request, turns, self._cache, robot.name, margin)


def _things(request: PlanRequest, goal: Goal) -> Dict[str, IntArray]:
    """Cells (n, 3) in the map of everything that could be moved or taken away, by name; the goal itself is none.

    Things that nobody named are told apart by standing apart, and are called by where they stand.
    """
    occupied = np.asarray(request.occupied, dtype=np.bool_)
    given = {name: np.asarray(cells, dtype=np.int64).reshape(-1, 3) for name, cells in request.objects.items()}
    given.update({name: np.asarray(other.cells, dtype=np.int64) for name, other in request.goals.items()})
    given.pop(goal.name, None)
    things = {}
    nameless = occupied.copy()
    nameless[tuple(goal.cells[request.spec.contains(goal.cells)].T)] = False
    for name, cells in given.items():
        inside = np.unique(cells[request.spec.contains(cells)], axis=0)
        own = inside[occupied[tuple(inside.T)]]
        if len(own):
            things[name] = own
            nameless[tuple(own.T)] = False
    labels, count = ndimage.label(nameless, structure=np.ones((3, 3, 3), dtype=np.int64))
    for label, where in enumerate(ndimage.find_objects(labels), start=1):
        own = np.argwhere(labels[where] == label) + np.array([axis.start for axis in where])
        middle = np.median(own[:, :2], axis=0)
        x, y = request.spec.column_centre((int(middle[0]), int(middle[1])))
        name = f"{UNKNOWN} at ({x:.2f}, {y:.2f}) m"
        things[name if name not in things else f"{name} ({label} of {count})"] = own
    return things


def _wanted(problem: PlanningProblem, target: Target) -> Sequence[ColumnSet]:
    """The target's column as a set for each heading at which it counts."""
    bit = 1 << problem.layout.bit(*target.column)
    return [bit if target.heading in (None, h) else 0 for h in range(len(problem.spaces[0].headings))]


def _stops(space: RobotSpace, reached: Mapping[int, ColumnSet], cells: CellSet, margin: bool) -> bool:
    """Whether a thing keeps a robot from a column beside those it reaches, or from a turn in one of them."""
    stride, field = space.layout.stride, space.layout.field
    obstacle = dilated(cells, stride) if margin else cells
    for h, columns in reached.items():
        if columns:
            beside = (columns << 1 | columns >> 1 | columns << stride | columns >> stride) & field & ~columns
            if beside & space.shape(h).blocked_by(obstacle):
                return True
            turns = [k for k in range(len(space.headings)) if space.turn_angle(h, k) is not None]
            if any(columns & ~reached[k] & space.turn_shape(h, k).blocked_by(obstacle) for k in turns):
                return True
    return False
