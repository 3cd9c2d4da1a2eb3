"""One robot's way to its goal over the particles, any-angle, and through every cell when the particles do not do.

A* (P. E. Hart, N. J. Nilsson, B. Raphael, 1968) in which a particle may be reached straight from a grandparent, as in
Theta* (A. Nash, K. Daniel, S. Koenig, A. Felner, "Theta*: any-angle path planning on grids", AAAI 2007); the path is
then shortened along checked moves (R. Geraerts, M. H. Overmars, "Creating high-quality paths for motion planning",
International Journal of Robotics Research 26, 2007).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

from yarm.planning.cspace.cell_sets import ColumnSet
from yarm.planning.cspace.robot_space import Pose, RobotSpace, View
from yarm.planning.model.types import Column
from yarm.planning.roadmap.cost_queue import CostQueue
from yarm.planning.roadmap.roadmap import Roadmap

Path = Tuple[Pose, ...]
State = Tuple[int, int]
"""Particle and heading."""

JOINED = 8
"""Particles that start, goal and corners are joined with, besides each other."""
_LONG_CELLS = 4


@dataclass(frozen=True)
class Target:
    """Where a path must end: a column, at one heading or at any."""

    column: Column
    heading: Optional[int] = None

    def holds(self, pose: Pose) -> bool:
        """Whether a pose is on the target."""
        return pose[:2] == self.column and self.heading in (None, pose[2])


class _Graph:
    """A roadmap with start, goal and added columns joined to it."""

    def __init__(self, roadmap: Roadmap, extra: Sequence[Column]) -> None:
        n = len(roadmap.columns)
        self.columns: List[Column] = [*roadmap.columns, *extra]
        self._roadmap = roadmap
        self._joined: Dict[int, List[int]] = {}
        added = range(n, n + len(extra))
        for i in added:
            close = roadmap.nearest(extra[i - n], JOINED)
            self._joined[i] = [*close, *(j for j in added if j != i)]
            for j in close:
                self._joined.setdefault(j, []).append(i)
        self._n = n

    def neighbours(self, i: int) -> Sequence[int]:
        own = self._roadmap.neighbours(i) if i < self._n else ()
        joined = self._joined.get(i)
        return own if joined is None else [*joined, *own]


def search(view: View, roadmap: Roadmap, start: Pose, target: Target, extra: Sequence[Column] = ()) -> Optional[Path]:
    """Cheapest any-angle way over the roadmap: A* in which a particle may be reached straight from a grandparent.

    Args:
        view: the robot's configuration space.
        roadmap: particles and graph.
        start: present pose.
        target: where to end.
        extra: columns added to the graph.

    Returns:
        poses from start to target, each move free; None when the graph holds none.
    """
    return _Search(view, _Graph(roadmap, [start[:2], target.column, *extra]), len(roadmap.columns), start, target).run()


class _Search:
    def __init__(self, view: View, graph: _Graph, first: int, start: Pose, target: Target) -> None:
        self._view, self._graph, self._target = view, graph, target
        self._start: State = (first, start[2])
        self._goal = first + 1
        self._goal_x, self._goal_y = target.column
        self._turns: Dict[int, Tuple[Tuple[float, float, int], ...]] = {}
        self._cost: Dict[State, float] = {}
        self._parent: Dict[State, State] = {}
        self._best: Dict[State, float] = {}
        self._turn_left: Dict[int, float] = {}
        self._far: Dict[int, float] = {}
        self._queue: CostQueue[Tuple[float, State, State, int]] = CostQueue()

    def run(self) -> Optional[Path]:
        self._queue.push(0.0, (0.0, self._start, self._start, -1))
        while not self._queue.is_empty:
            _, (cost, state, parent, turn) = self._queue.pop()
            if turn >= 0:
                self._offer_turn(parent, turn + 1)
            if state in self._cost or not self._may_turn(parent, state):
                continue
            self._cost[state], self._parent[state] = cost, parent
            if state[0] == self._goal and self._target.heading in (None, state[1]):
                return self._path(state)
            self._expand(state, cost)
            self._offer_turn(state, 0)
        return None

    def _may_turn(self, parent: State, state: State) -> bool:
        x, y = self._graph.columns[state[0]]
        return parent[1] == state[1] or self._view.turns(x, y, parent[1], state[1])

    def _expand(self, state: State, cost: float) -> None:
        view, columns = self._view, self._graph.columns
        node, h = state
        x, y = columns[node]
        up = self._parent[state]
        if up[1] != h:
            up = state
        ux, uy = columns[up[0]]
        done, best, hypot, up_cost = self._cost, self._best, math.hypot, self._cost[up]
        for other in self._graph.neighbours(node):
            new = (other, h)
            if new in done:
                continue
            ox, oy = columns[other]
            straight = up_cost + hypot(ox - ux, oy - uy)
            known = best.get(new, math.inf)
            if straight >= known:
                continue
            if view.line(ux, uy, ox, oy, h):
                best[new] = straight
                self._offer(straight, new, up)
            elif view.line(x, y, ox, oy, h):
                bent = cost + hypot(ox - x, oy - y)
                if bent < known:
                    best[new] = bent
                    self._offer(bent, new, state)

    def _offer(self, cost: float, state: State, parent: State) -> None:
        self._queue.push(cost + self._distance(state[0]) + self._turn_needed(state[1]), (cost, state, parent, -1))

    def _offer_turn(self, state: State, first: int) -> None:
        """Offer the most promising turn from a state, or the next one; the others wait until that one's time has come.

        What a turn costs and leaves to turn is the same everywhere, and so is their order; most are never needed.
        """
        node, h = state
        if h not in self._turns:
            ways = ((turn + self._turn_needed(k), turn, k) for k, turn in turn_costs(self._view.space, h))
            self._turns[h] = tuple(sorted(ways))
        turns, cost, column = self._turns[h], self._cost[state], self._graph.columns[node]
        for i in range(first, len(turns)):
            ahead, turn_cost, k = turns[i]
            new = (node, k)
            if new in self._cost or self._view.known_blocked(*column, h, k):
                continue
            if cost + turn_cost < self._best.get(new, math.inf):
                self._queue.push(cost + self._distance(node) + ahead, (cost + turn_cost, new, state, i))
                return

    def _distance(self, node: int) -> float:
        """Straight distance from a column to the goal, cells."""
        if node not in self._far:
            x, y = self._graph.columns[node]
            self._far[node] = math.hypot(self._goal_x - x, self._goal_y - y)
        return self._far[node]

    def _turn_needed(self, h: int) -> float:
        """Least cost of what must still be turned from a heading, cells."""
        if h not in self._turn_left:
            self._turn_left[h] = self._least_turn(h)
        return self._turn_left[h]

    def _least_turn(self, h: int) -> float:
        """Cost of the least turn from a heading to one that the goal can be stood on with."""
        if h in self._ends:
            return 0.0
        column = self._target.column
        costs = (self._view.space.move_cost((*column, h), (*column, k)) for k in self._ends)
        return min(costs, default=0.0)

    @cached_property
    def _ends(self) -> List[int]:
        """Headings that the goal can be stood on with."""
        view, target = self._view, self._target
        headings = range(len(view.space.headings)) if target.heading is None else (target.heading,)
        return [h for h in headings if view.stands((*target.column, h))]

    def _path(self, state: State) -> Path:
        poses: List[Pose] = []
        while True:
            x, y = self._graph.columns[state[0]]
            poses.append((x, y, state[1]))
            if self._parent[state] == state:
                return merged(poses[::-1])
            state = self._parent[state]


def turn_costs(space: RobotSpace, h: int) -> Tuple[Tuple[int, float], ...]:
    """Headings that one turn leads to, and what it costs, cells."""
    costs = []
    for k in range(len(space.headings)):
        angle = space.turn_angle(h, k)
        if angle is not None:
            costs.append((k, abs(angle) / space.turns.rad_per_cell))
    return tuple(costs)


def merged(poses: Sequence[Pose]) -> Path:
    """The same moves with a turn and the straight way after it made one move, and no pose twice in a row."""
    result: List[Pose] = []
    for pose in poses:
        if result and pose == result[-1]:
            continue
        if len(result) >= 2 and result[-1][:2] == result[-2][:2] and pose[2] == result[-1][2]:
            result[-1] = pose
        else:
            result.append(pose)
    return tuple(result)


def path_cost(view: View, path: Sequence[Pose]) -> float:
    """Cost of a path, cells."""
    return sum(view.space.move_cost(a, b) for a, b in zip(path, path[1:]))


def shortened(view: View, path: Path, rounds: int = 4) -> Path:
    """The path pulled tight along checked moves while it gets shorter.

    Corners are left out, the others shifted; where that ends, corners are added between them and shifted in turn.
    """
    poses = _corners_left_out(view, list(path))
    cost = path_cost(view, poses)
    for _ in range(rounds):
        if len(poses) < 3:
            break
        trial = _corners_shifted(view, list(poses), (8, 4, 2, 1))
        trial = _corners_shifted(view, _corners_added(view, trial), (2, 1))
        trial = _corners_left_out(view, trial)
        new = path_cost(view, trial)
        if new > cost - 0.05:
            break
        poses, cost = trial, new
    return tuple(poses)


def _corners_added(view: View, poses: List[Pose]) -> List[Pose]:
    """A corner near the middle of every long straight way, where both halves are free."""
    result = [poses[0]]
    for a, b in zip(poses, poses[1:]):
        if max(abs(b[0] - a[0]), abs(b[1] - a[1])) >= _LONG_CELLS:
            x, y = (a[0] + b[0]) // 2, (a[1] + b[1]) // 2
            around = [(x + dx, y + dy, b[2]) for dx in (0, 1, -1) for dy in (0, 1, -1)]
            around.sort(key=lambda p: math.dist(a[:2], p[:2]) + math.dist(p[:2], b[:2]))
            result += islice((p for p in around if view.stands(p) and view.move(a, p) and view.move(p, b)), 1)
        result.append(b)
    return result


def _corners_left_out(view: View, poses: List[Pose]) -> List[Pose]:
    travelled = [0.0]
    for a, b in zip(poses, poses[1:]):
        travelled.append(travelled[-1] + view.space.move_cost(a, b))
    result = [poses[0]]
    i = 0
    while i < len(poses) - 1:
        j = len(poses) - 1
        while j > i + 1:
            direct = view.space.move_cost(poses[i], poses[j])
            if direct <= travelled[j] - travelled[i] + 1e-9 and view.move(poses[i], poses[j]):
                break
            j -= 1
        result.append(poses[j])
        i = j
    return result


def _corners_shifted(view: View, poses: List[Pose], steps: Sequence[int]) -> List[Pose]:
    gx, gy, _ = view.space.layout.shape
    hypot = math.hypot
    for step in steps:
        for i in range(1, len(poses) - 1):
            a, b, c = poses[i - 1 : i + 2]
            (ax, ay, _), (cx, cy, _) = a, c
            best = hypot(b[0] - ax, b[1] - ay) + hypot(cx - b[0], cy - b[1]) - 1e-9
            for x in (b[0] - step, b[0], b[0] + step):
                for y in (b[1] - step, b[1], b[1] + step):
                    length = hypot(x - ax, y - ay) + hypot(cx - x, cy - y)
                    if length >= best or not (0 <= x < gx and 0 <= y < gy):
                        continue
                    trial = (x, y, b[2])
                    if view.move(a, trial) and view.move(trial, c):
                        best, poses[i] = length - 1e-9, trial
    return poses


def flood(view: View, start: Pose, wanted: Callable[[int], ColumnSet]) -> Optional[Path]:
    """Way to what is wanted: ``Flooding.way`` from one pose once."""
    return Flooding(view, start).way(wanted)


def reachable(view: View, start: Pose) -> Dict[int, ColumnSet]:
    """Every column reachable at each heading."""
    return Flooding(view, start).reached()


class Flooding:
    """Ways through neighbouring cells from one pose: every reachable cell and heading is entered in order of cost.

    It goes on where it stopped when it is asked again. Complete: what it does not reach cannot be reached through any
    cell at any allowed heading.
    """

    def __init__(self, view: View, start: Pose) -> None:
        """Nothing is entered yet but the start.

        Args:
            view: the robot's configuration space.
            start: present pose; taken as free.
        """
        self._view, self._start = view, start
        self._layout = view.space.layout
        count = len(view.space.headings)
        self._bit = 1 << self._layout.bit(start[0], start[1])
        self._left: List[ColumnSet] = [self._layout.field] * count  # not reached yet, by heading
        self._left[start[2]] &= ~self._bit
        self._fronts: List[Dict[int, ColumnSet]] = [{start[2]: self._bit}]
        self._turns: List[Tuple[int, int, int]] = []
        for h in range(count):
            self._turns += [(h, k, max(1, round(cost))) for k, cost in turn_costs(view.space, h)]
        self._longest = max([1, *(cost for _, _, cost in self._turns)])
        self._free: Dict[int, ColumnSet] = {}  # columns where the robot may stand at a heading
        self._free_turns: Dict[int, ColumnSet] = {}  # and where it may do a turn, by its place in the list

    @property
    def size_bytes(self) -> int:
        """Memory that it takes at most, about."""
        return len(self._fronts) * len(self._left) * self._layout.field.bit_length() // 8

    def way(self, wanted: Callable[[int], ColumnSet]) -> Optional[Path]:
        """Way to the nearest wanted pose (four-neighbour distance).

        Args:
            wanted: the columns wanted at a heading.

        Returns:
            poses one cell or one turn apart; None when nothing wanted is reachable.
        """
        asked: Dict[int, ColumnSet] = {}
        ring = 0
        while ring < len(self._fronts) or self._grow():
            for h, front in self._fronts[ring].items():
                if h not in asked:
                    asked[h] = wanted(h)
                hit = front & asked[h]
                if hit:
                    return self._way_to((hit & -hit).bit_length() - 1, h)
            ring += 1
        return None

    def wander(self, choose: Callable[[Dict[int, ColumnSet]], Optional[Tuple[int, int]]]) -> Optional[Path]:
        """Way to a pose chosen among all reachable ones.

        Args:
            choose: from the columns reachable at each heading, the heading and the bit of the pose wanted; None for
                none.

        Returns:
            poses one cell or one turn apart; None when none was chosen.
        """
        chosen = choose(self.reached())
        return None if chosen is None else self._way_to(chosen[1], chosen[0])

    def reached(self) -> Dict[int, ColumnSet]:
        """Every column reachable at each heading."""
        while self._grow():
            pass
        reached = {h: self._layout.field & ~left for h, left in enumerate(self._left)}
        reached[self._start[2]] |= self._bit
        return reached

    def _grow(self) -> bool:
        """Enter what comes next; False when there is nothing."""
        if not any(self._fronts[-self._longest :]):
            return False
        self._fronts.append(self._next())
        return True

    def _next(self) -> Dict[int, ColumnSet]:
        stride, fronts, left = self._layout.stride, self._fronts, self._left
        new: Dict[int, ColumnSet] = {}
        for h, front in fronts[-1].items():
            entered = front << 1 | front >> 1 | front << stride | front >> stride
            new[h] = entered & left[h] & self._free_at(h)
        before = [{}, *fronts[: -self._longest - 1 : -1]]  # by how many rings ago
        before += [{}] * (self._longest + 1 - len(before))
        free = self._free_turns
        for i, (h, k, cost) in enumerate(self._turns):
            front = before[cost].get(h, 0) & left[k]
            if front:
                if i not in free:
                    free[i] = self._layout.field & ~self._view.turn_blocked(h, k)
                new[k] = new.get(k, 0) | front & free[i]
        fresh = {h: front for h, front in new.items() if front}
        for h, front in fresh.items():
            left[h] ^= front
        return fresh

    def _free_at(self, h: int) -> ColumnSet:
        if h not in self._free:
            self._free[h] = self._layout.field & ~self._view.blocked(h)
        return self._free[h]

    def _way_to(self, bit: int, h: int) -> Path:
        """Way to a pose that has been reached."""
        stride, border = self._layout.stride, self._layout.border
        ring = next(ring for ring, fronts in enumerate(self._fronts) if fronts.get(h, 0) >> bit & 1)
        poses: List[Pose] = []
        while True:
            poses.append((bit // stride - border, bit % stride - border, h))
            if ring == 0:
                return tuple(poses[::-1])
            ring, bit, h = self._before(ring, bit, h)

    def _before(self, ring: int, bit: int, h: int) -> Tuple[int, int, int]:
        front = self._fronts[ring - 1].get(h, 0)
        for step in (1, -1, self._layout.stride, -self._layout.stride):
            if front >> (bit + step) & 1:
                return ring - 1, bit + step, h
        for g, k, cost in self._turns:
            if k == h and ring >= cost and self._fronts[ring - cost].get(g, 0) >> bit & 1:
                x, y = bit // self._layout.stride - self._layout.border, bit % self._layout.stride - self._layout.border
                if self._view.turns(x, y, g, h):
                    return ring - cost, bit, g
        raise AssertionError("every flooded cell has one before it")


def find_path(
    view: View,
    roadmap: Roadmap,
    start: Pose,
    target: Target,
    flooding: Callable[[View, Pose], Flooding] = Flooding,
) -> Optional[Path]:
    """A short way to a target: straight, else over the particles, else with particles added where these do not reach.

    The particles added are the corners of a way found through every cell, so None means that there is no way at all;
    where the roadmap does not admit so many, it is that way.

    Args:
        view: the robot's configuration space.
        roadmap: particles and graph.
        start: present pose.
        target: where to end.
        flooding: gives what is searched through every cell, where somebody keeps it.
    """
    headings = range(len(view.space.headings)) if target.heading is None else (target.heading,)
    if not any(view.stands((*target.column, h)) for h in headings):
        return None
    if target.heading in (None, start[2]) and view.line(*start[:2], *target.column, start[2]):
        return merged([start, (*target.column, start[2])])
    path = search(view, roadmap, start, target)
    if path is None:
        path = _path_through_cells(view, roadmap, start, target, flooding(view, start))
    return None if path is None else shortened(view, path)


def _path_through_cells(
    view: View, roadmap: Roadmap, start: Pose, target: Target, flooding: Flooding
) -> Optional[Path]:
    bit = 1 << view.space.layout.bit(*target.column)
    way = flooding.way(lambda h: bit if target.heading in (None, h) else 0)
    if way is None:
        return None
    way = tuple(_corners_left_out(view, list(straight_runs(way))))
    corners: List[Column] = []
    seen: Set[Column] = set()
    for x, y, _ in way[1:-1]:
        if (x, y) not in seen:
            seen.add((x, y))
            corners.append((x, y))
    found = search(view, roadmap, start, target, corners) if roadmap.admits(len(corners)) else None
    return way if found is None or path_cost(view, found) > path_cost(view, way) else found


def straight_runs(way: Path) -> Path:
    """Only the poses where a way of unit moves changes direction or turns."""
    kept = [way[0]]
    for before, pose, after in zip(way, way[1:], way[2:]):
        if tuple(b - a for a, b in zip(before, pose)) != tuple(b - a for a, b in zip(pose, after)):
            kept.append(pose)
    return merged([*kept, way[-1]])
