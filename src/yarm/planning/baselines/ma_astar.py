"""Multi-agent A* on the cells, from which YARM grew; for comparison.

In each round every robot in turn takes the cheapest state of its own agenda (way so far + distance left), which it
claims for this round, and looks at the eight neighbour columns and at the allowed turns. States it has visited, and
states that touch what the others claim in this round, are left out. A robot with no choice but for the others' claims
waits a round. Claims are not tied to times, so the paths together promise nothing; each step is checked before it is
made.
"""

from __future__ import annotations

import math
from typing import Dict, Iterator, List, Optional, Sequence, Set, Tuple

import numpy as np

from yarm.planning.baselines.baseline import Found, OneByOnePlanner, straightened
from yarm.planning.cspace.robot_space import Pose, View
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem, explain_failure
from yarm.planning.model.types import PlanStatus
from yarm.planning.roadmap.cost_queue import CostQueue
from yarm.planning.roadmap.search import Path, Target, merged

NEIGHBOURS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
WAIT_COST = 1.0


class MultiAgentAStar(OneByOnePlanner):
    """See the module."""

    def _search(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[int, Found], int]:
        del rng  # it draws nothing
        agents = {i: _Agent(fleet, i) for i in active}
        limit = 4 * fleet.spaces[0].layout.shape[0] * fleet.spaces[0].layout.shape[1] if active else 0
        rounds = 0
        while any(agent.is_open for agent in agents.values()) and rounds < limit:
            rounds += 1
            claims = {i: agent.take() for i, agent in agents.items()}
            poses = tuple(claims.get(i, fleet.starts[i]) for i in range(len(fleet.spaces)))
            for i, agent in agents.items():
                if agent.is_open:
                    others = [(fleet.spaces[j], poses[j]) for j in range(len(poses)) if j != i]
                    agent.expand(View(fleet.spaces[i], others) if others else agent.alone)
        return {i: self._found(problem, fleet, i, agent) for i, agent in agents.items()}, rounds

    def _found(self, problem: PlanningProblem, fleet: Fleet, i: int, agent: _Agent) -> Found:
        if agent.path is not None:
            return Found(merged(straightened(agent.path)))
        name = problem.robots[i].name
        if agent.is_exhausted and not agent.was_hindered:
            status, reason = explain_failure(problem, fleet, i)
            return Found(None, status, reason)
        return Found(None, PlanStatus.TIMEOUT, f"{name} found no way between the other robots in this step")


class _Agent:
    """One robot's agenda."""

    def __init__(self, fleet: Fleet, i: int) -> None:
        space = fleet.spaces[i]
        target = fleet.targets[i]
        assert target is not None
        self.alone = View(space, ())
        self.path: Optional[Path] = None
        self.is_exhausted = False
        self.was_hindered = False
        self._space, self._target = space, target
        self._pose: Pose = space.start
        self._parents: Dict[Pose, Pose] = {space.start: space.start}
        self._visited: Set[Pose] = {space.start}
        self._queue: CostQueue[Tuple[float, Pose]] = CostQueue()
        self._queue.push(0.0, (0.0, space.start))
        self._cost = 0.0

    @property
    def is_open(self) -> bool:
        """Whether it still searches."""
        return self.path is None and not self.is_exhausted

    def take(self) -> Pose:
        """The state it claims in this round: the cheapest of its agenda, or where it ended."""
        if self.is_open:
            if self._queue.is_empty:
                self.is_exhausted = True
            else:
                _, (self._cost, self._pose) = self._queue.pop()
                if _reached(self._pose, self._target):
                    self.path = self._way_back()
        return self._pose

    def expand(self, view: View) -> None:
        """Put what can be reached from the claimed state on the agenda."""
        chosen, hindered = 0, 0
        for pose in self._next():
            if pose in self._visited or not self.alone.move(self._pose, pose):
                continue
            if not view.move(self._pose, pose):
                hindered += 1
                continue
            chosen += 1
            self._visited.add(pose)
            self._parents[pose] = self._pose
            cost = self._cost + self._space.move_cost(self._pose, pose)
            self._queue.push(cost + math.dist(pose[:2], self._target.column), (cost, pose))
        self.was_hindered |= hindered > 0
        if hindered and not chosen and len(self._visited) > 1:
            self._wait()

    def _wait(self) -> None:
        cost = self._cost + WAIT_COST
        if cost < 4.0 * (len(self._visited) + 100):
            self._queue.push(cost + math.dist(self._pose[:2], self._target.column), (cost, self._pose))

    def _next(self) -> Iterator[Pose]:
        x, y, h = self._pose
        gx, gy, _ = self._space.layout.shape
        for dx, dy in NEIGHBOURS:
            if 0 <= x + dx < gx and 0 <= y + dy < gy:
                yield x + dx, y + dy, h
        for k in range(len(self._space.headings)):
            if k != h:
                yield x, y, k

    def _way_back(self) -> Path:
        poses: List[Pose] = [self._pose]
        while self._parents[poses[-1]] != poses[-1]:
            poses.append(self._parents[poses[-1]])
        return tuple(reversed(poses))


def _reached(pose: Pose, target: Target) -> bool:
    return pose[:2] == target.column and target.heading in (None, pose[2])
