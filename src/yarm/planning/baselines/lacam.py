"""LaCAM over the cells and headings, with PIBT as its generator of configurations; for comparison.

Of Okumura, Machida, Defago and Tamura, "Priority Inheritance with Backtracking for Iterative Multi-agent Path Finding",
Artificial Intelligence 310, 2022, and Okumura, "LaCAM: Search-Based Algorithm for Quick Multi-Agent Pathfinding", AAAI
2023; adapted to robots that cover many cells and turn in place. A configuration is the pose of every robot. In a round
each robot, in order of priority, moves one cell or makes one turn; whoever stands in the way of its best move inherits
its priority and moves first. Moves of a round have an order, so no two robots can exchange places. A turn sweeps more
than one cell's way clears: then those in the way are moved off, and the turn is tried again in the next round.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import islice, permutations, product
from typing import Deque, Dict, List, Mapping, Optional, Sequence, Set, Tuple

import numpy as np

from yarm.planning.baselines.joint import JointFound, JointPlanner, Standing, tightened
from yarm.planning.cspace.cell_sets import ColumnSet, dilated
from yarm.planning.cspace.robot_space import Pose, View, poses_touch
from yarm.planning.fleet.fleet import Fleet, Move, Poses
from yarm.planning.roadmap.search import Target, flood, turn_costs

SHARES = (1, 1, 1, 1, 1, 2, 2, 2, 4)
"""Rounds of each beginning of the search, in ``iteration_limit``; each has another goal, other draws or priorities."""
CHOICES = 5
"""Goal configurations tried."""
COMBINATIONS = 4096
"""Combinations of headings on the targets looked at, at most."""
_STEPS = ((1, 0), (-1, 0), (0, 1), (0, -1))
Constraints = Tuple[Tuple[int, Pose], ...]


class LacamPlanner(JointPlanner):
    """See the module."""

    def _find(self, fleet: Fleet, robots: Sequence[int], rng: np.random.Generator) -> JointFound:
        standing = Standing(fleet)
        ways = Ways(standing)
        open_targets = {i: _target(fleet, i) for i in robots}
        hopeless = tuple(i for i in robots if math.isinf(ways.to(i, open_targets[i]).cost(fleet.starts[i])))
        open_targets = {i: target for i, target in open_targets.items() if i not in hopeless}
        fleet.restrict(open_targets)
        choices = goal_configurations(fleet, open_targets, ways)[:CHOICES]
        rounds = 0
        for start, share in enumerate(SHARES):
            targets = choices[start % len(choices)]
            search = _Search(fleet, standing, targets, {i: ways.to(i, targets[i]) for i in targets}, rng)
            ranks = rng.permutation(len(fleet.spaces)).tolist() if start >= len(choices) else [0] * len(fleet.spaces)
            moves = search.run(share * self.params.iteration_limit, ranks)
            rounds += search.rounds
            if moves is not None:
                return JointFound(tightened(fleet, standing, moves), rounds, hopeless)
        return JointFound(None, rounds, hopeless)


def _target(fleet: Fleet, i: int) -> Target:
    target = fleet.targets[i]
    assert target is not None
    return target


class Ways:
    """Costs to go of all robots to whatever targets, made when first asked for."""

    def __init__(self, standing: Standing) -> None:
        """Of the fleet that stands."""
        self._standing = standing
        self._known: Dict[Tuple[int, Target], CostToGo] = {}

    def to(self, i: int, target: Target) -> CostToGo:
        """Costs of a robot to a target."""
        if (i, target) not in self._known:
            self._known[i, target] = CostToGo(self._standing.alone[i], target)
        return self._known[i, target]


def goal_configurations(fleet: Fleet, targets: Mapping[int, Target], ways: Ways) -> List[Dict[int, Target]]:
    """Headings on the targets at which robots stand there without touching, the cheapest to go to first.

    LaCAM goes to one configuration; a target of ours may leave the heading open. It stays open where any heading does.
    """
    poses = {
        i: [
            (*target.column, h)
            for h in range(len(fleet.spaces[i].headings))
            if target.heading in (None, h) and not math.isinf(ways.to(i, target).cost((*target.column, h)))
        ]
        for i, target in targets.items()
    }

    def touch(i: int, a: Pose, j: int, b: Pose) -> bool:
        return poses_touch(fleet.spaces[i], a, fleet.spaces[j], b)

    near = {
        i
        for i, j in permutations(targets, 2)
        if any(touch(i, a, j, b) or touch(j, b, i, a) for a in poses[i] for b in poses[j])
    }
    if not near:
        return [dict(targets)]
    ranked: List[Tuple[float, int, Dict[int, Target]]] = []
    for ends in islice(product(*(poses[i] for i in sorted(near))), COMBINATIONS):
        at = dict(zip(sorted(near), ends))
        if not any(touch(i, at[i], j, at[j]) for i, j in permutations(at, 2)):
            closed = {i: Target(pose[:2], pose[2]) for i, pose in at.items()}
            cost = sum(ways.to(i, target).cost(fleet.starts[i]) for i, target in closed.items())
            ranked.append((cost, len(ranked), {**targets, **closed}))
    return [chosen for cost, _, chosen in sorted(ranked, key=lambda entry: entry[:2]) if math.isfinite(cost)] or [
        dict(targets)
    ]


class CostToGo:
    """Least cost, cells, from any pose to a target by moves of one cell and turns, if no other robot were there."""

    def __init__(self, view: View, target: Target) -> None:
        """Towards a target in a robot's space."""
        self._layout = view.space.layout
        count = len(view.space.headings)
        self._rings: List[List[ColumnSet]] = [[] for _ in range(count)]
        self._known: Dict[Pose, float] = {}
        bit = 1 << self._layout.bit(*target.column)
        goals = [h for h in range(count) if target.heading in (None, h) and view.stands((*target.column, h))]
        turns = [(h, k, max(1, round(cost))) for h in range(count) for k, cost in turn_costs(view.space, h)]
        fronts: List[List[ColumnSet]] = [[bit if h in goals else 0 for h in range(count)]]
        longest = max([1, *(cost for _, _, cost in turns)])
        stride = self._layout.stride
        reached = list(fronts[0])
        while any(any(front) for front in fronts[-longest:]):
            for h in range(count):
                self._rings[h].append(reached[h])
            new = [0] * count
            for h, front in enumerate(fronts[-1]):
                if front:
                    new[h] = (front << 1 | front >> 1 | front << stride | front >> stride) & ~view.blocked(h)
            for h, k, cost in turns:
                front = fronts[-cost][k] & ~reached[h] if len(fronts) >= cost else 0
                if front:
                    new[h] |= front & ~view.turn_blocked(h, k)
            fresh = [new[h] & self._layout.field & ~reached[h] for h in range(count)]
            reached = [reached[h] | fresh[h] for h in range(count)]
            fronts.append(fresh)

    def cost(self, pose: Pose) -> float:
        """Of a pose of the grid; infinite when there is no way."""
        if pose not in self._known:
            rings, bit = self._rings[pose[2]], self._layout.bit(pose[0], pose[1])
            low, high = 0, len(rings)
            while low < high:
                middle = (low + high) // 2
                low, high = (low, middle) if rings[middle] >> bit & 1 else (middle + 1, high)
            self._known[pose] = float(low) if low < len(rings) else math.inf
        return self._known[pose]


@dataclass
class _Node:
    """A configuration: how it was come to, how long each robot has been off its target, and constraints to try."""

    poses: Poses
    parent: Optional[_Node]
    moves: List[Move]
    waited: Tuple[int, ...]
    order: Tuple[int, ...]
    tree: Deque[Constraints] = field(default_factory=lambda: deque([()]))


class _Search:
    def __init__(
        self,
        fleet: Fleet,
        standing: Standing,
        targets: Mapping[int, Target],
        to_go: Mapping[int, CostToGo],
        rng: np.random.Generator,
    ) -> None:
        self._fleet, self._standing, self._targets, self._to_go, self._rng = fleet, standing, targets, to_go, rng
        self._aside: Dict[Tuple[int, Pose, Move], Optional[Move]] = {}
        self.rounds = 0

    def run(self, limit: int, ranks: Sequence[int]) -> Optional[List[Move]]:
        """Depth first over configurations; each is left for good once every constraint on it has been tried.

        Args:
            limit: rounds more at most.
            ranks: priority of each robot at first.
        """
        first = self._node(self._fleet.starts, tuple(ranks), None, [])
        stack, explored = [first], {first.poses: first}
        limit += self.rounds
        while stack and self.rounds < limit:
            node = stack[-1]
            if all(self._satisfied(i, pose) for i, pose in enumerate(node.poses)):
                return _moves_to(node)
            if not node.tree:
                stack.pop()
                continue
            self.rounds += 1
            constraints = node.tree.popleft()
            if len(constraints) < len(node.order):
                i = node.order[len(constraints)]
                for pose in self.choices(i, node.poses[i]):
                    node.tree.append((*constraints, (i, pose)))
            step = Step(self, node.poses)
            if not step.make(node.order, constraints):
                continue
            poses = tuple(step.poses)
            if poses not in explored:
                explored[poses] = self._node(poses, node.waited, node, step.moves)
            stack.append(explored[poses])
        return None

    def _node(self, poses: Poses, before: Sequence[int], parent: Optional[_Node], moves: List[Move]) -> _Node:
        waited = tuple(0 if self._satisfied(i, pose) else before[i] + 1 for i, pose in enumerate(poses))
        costs = [self.cost(i, pose) for i, pose in enumerate(poses)]
        order = tuple(sorted(range(len(poses)), key=lambda i: (-waited[i], -costs[i], i)))
        return _Node(poses, parent, moves, waited, order)

    def _satisfied(self, i: int, pose: Pose) -> bool:
        return i not in self._targets or self._targets[i].holds(pose)

    @property
    def standing(self) -> Standing:
        """Of the fleet."""
        return self._standing

    def cost(self, i: int, pose: Pose) -> float:
        """Cost to go; none for a robot without a target."""
        return self._to_go[i].cost(pose) if i in self._to_go else 0.0

    def step_aside(self, j: int, pose: Pose, move: Move) -> Optional[Move]:
        """First step of a robot's nearest way clear of another's move, with that other one where it stands."""
        key = j, pose, move
        if key not in self._aside:
            spaces = self._fleet.spaces
            space, layout = spaces[j], spaces[j].layout
            keep_free = dilated(spaces[move.robot].swept(move.start, move.end), layout.stride)
            view = self._standing.beside(j, move.robot, move.start)
            way = flood(view, pose, lambda h: layout.field & ~space.shape(h).blocked_by(keep_free))
            self._aside[key] = Move(j, way[0], way[1]) if way is not None and len(way) > 1 else None
        return self._aside[key]

    def choices(self, i: int, pose: Pose) -> List[Pose]:
        """What a robot can do in a round by the map alone, cheapest way on first; staying is one of them."""
        x, y, h = pose
        view = self._standing.alone[i]
        gx, gy, _ = view.space.layout.shape
        near = [(x + dx, y + dy, h) for dx, dy in _STEPS if 0 <= x + dx < gx and 0 <= y + dy < gy]
        near += [(x, y, k) for k in range(len(view.space.headings)) if k != h]
        free = [pose, *(b for b in near if view.move(pose, b))]
        draws = self._rng.random(len(free)).tolist()
        ranked = sorted(zip((self.cost(i, b) for b in free), draws, free))
        return [b for _, _, b in ranked]


def _moves_to(node: _Node) -> List[Move]:
    rounds = []
    at: Optional[_Node] = node
    while at is not None:
        rounds.append(at.moves)
        at = at.parent
    return [move for moves in reversed(rounds) for move in moves]


class Step:
    """One round from a configuration: the poses after it, and its moves in an order in which each is free."""

    def __init__(self, search: _Search, poses: Poses) -> None:
        """Before anybody has moved."""
        self._search = search
        self.poses = list(poses)
        self.moves: List[Move] = []
        self._decided: Set[int] = set()

    def make(self, order: Sequence[int], constraints: Constraints) -> bool:
        """Let all robots decide; false when a constraint cannot be kept."""
        for i, pose in constraints:
            if i in self._decided or not self._decide(i, [pose], ()):
                return False
        for i in order:
            if i not in self._decided:
                self._decide(i, self._search.choices(i, self.poses[i]), ())
        return True

    def _decide(self, i: int, choices: Sequence[Pose], above: Tuple[Move, ...]) -> bool:
        """Make the first choice that can be made, others moving out of its way, and out of that of the moves above.

        Where no choice that leads on can be made in one round, others make room for the best of them instead.
        """
        here = self.poses[i]
        stay = self._search.cost(i, here)
        best: Optional[Move] = None
        self._decided.add(i)
        for there in choices:
            if any(self._search.standing.blocks(m.robot, m.start, m.end, i, there) for m in above):
                continue
            leads_on = self._search.cost(i, there) < stay
            if not leads_on and best is not None and not above and self._make_room(best):
                return True
            if there == here:
                return True
            move = Move(i, here, there)
            if self._clear_the_way(move, above):
                self._go(move)
                return True
            best = move if leads_on and best is None else best
        if above:
            self._decided.discard(i)
        return False

    def _go(self, move: Move) -> None:
        self.poses[move.robot] = move.end
        self.moves.append(move)

    def _clear_the_way(self, move: Move, above: Tuple[Move, ...]) -> bool:
        standing = self._search.standing
        before = list(self.poses), len(self.moves), set(self._decided)
        for j in standing.blockers(move.robot, move.start, move.end, self.poses):
            if j not in self._decided:
                self._decide(j, self._search.choices(j, self.poses[j]), (*above, move))
        if not standing.blockers(move.robot, move.start, move.end, self.poses):
            return True
        self.poses, self._decided = before[0], before[2]
        del self.moves[before[1] :]
        return False

    def _make_room(self, move: Move) -> bool:
        """Let those in the way of a move make the first step of their way out of it; whether anybody did."""
        moved = False
        for j in self._search.standing.blockers(move.robot, move.start, move.end, self.poses):
            step = None if j in self._decided else self._search.step_aside(j, self.poses[j], move)
            if step is not None:
                self._decided.add(j)
                if self._clear_the_way(step, ()):
                    self._go(step)
                    moved = True
                else:
                    self._decided.discard(j)
        return moved
