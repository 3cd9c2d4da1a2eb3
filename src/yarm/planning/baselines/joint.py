"""Peers that plan all robots together: what they have in common besides their searches.

Their searches give a joint plan as YARM's does, an order of single moves; it is made tight, carried out and remembered
in the same way, so that what differs is how it is found.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Dict, List, Optional, Sequence, Tuple

import numpy as np

from yarm.planning.baselines.baseline import BaselinePlanner
from yarm.planning.cspace.robot_space import Pose, View
from yarm.planning.fleet.fleet import Fleet, Move, Poses
from yarm.planning.fleet.joint_plan import Conflicts, StepChoice, path_of, valid
from yarm.planning.fleet.problem import PlanningProblem, explain_failure
from yarm.planning.fleet.replanning import Memory, waypoint
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import PlanStatus, RobotPlan

FAR_CELLS = 8.0
"""Robots further apart than their reaches and the way of a move by this do not touch at any heading."""
PASSES = 4
"""Times that a plan is gone through to make it tight, at most."""


@dataclass(frozen=True)
class JointFound:
    """What a joint search gave.

    Attributes:
        moves: in order; None when none were found.
        rounds: of the search.
        hopeless: robots that have no way to their target even with no other robot there.
    """

    moves: Optional[List[Move]]
    rounds: int = 0
    hopeless: Tuple[int, ...] = ()


class Standing:
    """Which of the robots that stand somewhere are in the way of a move of another."""

    def __init__(self, fleet: Fleet) -> None:
        """Of a fleet."""
        self._fleet = fleet
        everybody = range(len(fleet.spaces))
        self.alone: Tuple[View, ...] = tuple(fleet.view(i, fleet.starts, everybody) for i in everybody)
        self._pairs: Dict[Tuple[int, int, Pose], View] = {}

    def blockers(self, i: int, a: Pose, b: Pose, poses: Sequence[Pose]) -> List[int]:
        """Robots that a robot would touch, or come within the margin of, on a move that is free of the map."""
        return [j for j in range(len(poses)) if j != i and self.blocks(i, a, b, j, poses[j])]

    def blocks(self, i: int, a: Pose, b: Pose, j: int, pose: Pose) -> bool:
        """Whether a robot that stands at a pose is in the way of a move of another."""
        spaces = self._fleet.spaces
        reach = spaces[i].shape0.reach + spaces[j].shape0.reach + FAR_CELLS
        if math.dist(a[:2], pose[:2]) > reach + math.dist(a[:2], b[:2]):
            return False
        return not self.beside(i, j, pose).move(a, b)

    def is_free(self, i: int, a: Pose, b: Pose, poses: Sequence[Pose]) -> bool:
        """Whether a move touches neither the map nor anybody."""
        return self.alone[i].move(a, b) and not self.blockers(i, a, b, poses)

    def beside(self, i: int, j: int, pose: Pose) -> View:
        """The space of a robot with one other alone in it, standing at a pose."""
        if (i, j, pose) not in self._pairs:
            poses = list(self._fleet.starts)
            poses[j] = pose
            others = [k for k in range(len(poses)) if k != j]
            self._pairs[i, j, pose] = self._fleet.view(i, tuple(poses), others)
        return self._pairs[i, j, pose]


class JointPlanner(BaselinePlanner):
    """A planner whose search gives a plan for the whole fleet, kept while it is free."""

    def __init__(self, params: Optional[PlannerParams] = None) -> None:
        super().__init__(params)
        self._memory = Memory()

    def reset(self) -> None:
        """Forget the plan."""
        self._memory = Memory()

    @abstractmethod
    def _find(self, fleet: Fleet, robots: Sequence[int], rng: np.random.Generator) -> JointFound:
        """A joint plan that brings some robots to their targets; the others may be moved too."""

    def _plans(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[str, RobotPlan], int]:
        fleet.restrict(active)
        names = [robot.name for robot in problem.robots]
        goals = {names[i]: problem.goal_key(i) for i in active}
        kept = self._memory.recall(fleet, names) if goals and goals == self._memory.goals else None
        if kept is not None and valid(fleet, kept, active):
            found = JointFound(kept)
        elif all(fleet.satisfied(i, pose) for i, pose in enumerate(fleet.starts)):
            found = JointFound([])
        else:
            found = self._find(fleet, active, rng)
        conflicts = Conflicts(fleet, problem.off_centre())
        choice = StepChoice(fleet, found.moves or [], self.params.least_step_cells, conflicts)
        steps = choice.choose()
        self._memory.keep(fleet, names, choice.moves)
        self._memory.goals = {} if found.moves is None else goals
        plans = {}
        for i, name in enumerate(names):
            if i in found.hopeless:
                status, reason = explain_failure(problem, fleet, i)
                plans[name] = RobotPlan(name, problem.request.assignments[name], status, reason)
            elif i in active or i in steps:
                plans[name] = _plan_of(problem, fleet, i, choice.moves, steps.get(i), i in active)
        return plans, found.rounds


def _plan_of(
    problem: PlanningProblem, fleet: Fleet, i: int, moves: Sequence[Move], step: Optional[Pose], is_active: bool
) -> RobotPlan:
    name, space = problem.robots[i].name, fleet.spaces[i]
    path = path_of(fleet, moves, i)
    solved = fleet.satisfied(i, path[-1])
    return RobotPlan(
        name,
        problem.request.assignments[name] if is_active else "",
        PlanStatus.SOLVED if solved else PlanStatus.TIMEOUT,
        "" if solved else f"{name} waits: no joint plan was found that brings it to its goal",
        tuple(waypoint(pose, space) for pose in path),
        None if step is None else waypoint(step, space),
        sum(math.dist(a[:2], b[:2]) for a, b in zip(path, path[1:])),
    )


def tightened(fleet: Fleet, standing: Standing, moves: Sequence[Move]) -> List[Move]:
    """The plan with moves of one robot joined into one straight move wherever that is free and no longer.

    The joined move is made when the first of them was, or the last, whichever the others' moves between allow.
    """
    result = list(moves)
    for _ in range(PASSES):
        before = len(result)
        index, poses = 0, fleet.starts
        while index < len(result):
            result = _joined_from(fleet, standing, result, index, poses)
            move = result[index]
            if move.start == move.end:
                del result[index]
                continue
            poses = (*poses[: move.robot], move.end, *poses[move.robot + 1 :])
            index += 1
        if len(result) == before:
            break
    return result


def _joined_from(fleet: Fleet, standing: Standing, moves: List[Move], index: int, poses: Poses) -> List[Move]:
    """The same with as many as possible of a robot's moves, from ``index`` on, joined."""
    i = moves[index].robot
    own = [k for k in range(index, len(moves)) if moves[k].robot == i]
    count = len(own)
    while count > 1:
        last = own[count - 1]
        direct = Move(i, moves[index].start, moves[last].end)
        between = [move for move in moves[index + 1 : last] if move.robot != i]
        joined = [moves[k] for k in own[:count]]
        if fleet.cost([direct]) <= fleet.cost(joined) + 1e-9:
            for trial in ([direct, *between], [*between, direct]):
                if _all_free(standing, trial, poses):
                    return [*moves[:index], *trial, *moves[last + 1 :]]
        count = count // 2 if count > 3 else count - 1
    return moves


def _all_free(standing: Standing, moves: Sequence[Move], poses: Poses) -> bool:
    at = list(poses)
    for move in moves:
        if move.start != move.end and not standing.is_free(move.robot, move.start, move.end, at):
            return False
        at[move.robot] = move.end
    return True
