"""OMPL's RRTConnect in the joint space of all robots, meant for two, for comparison; needs the ompl wheel.

A state is every robot's pose. A motion takes all straight to their next poses, each as ``ompl_planners`` has it, with
the same look-ups; it is free when the robots can make their moves one after the other, in the fleet's order or in the
reverse. That is all that a plan of this package asks for, and more than a motion of all at once would allow. The path
found is made tight as any joint plan is.
"""

from __future__ import annotations

from typing import Any, Callable, List, Optional, Sequence, Tuple

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from yarm.planning.baselines.baseline import goal_poses
from yarm.planning.baselines.joint import JointFound, JointPlanner, Standing, tightened
from yarm.planning.baselines.ompl_planners import GOAL_RADIUS_CELLS, Poses, time_condition
from yarm.planning.cspace.robot_space import Pose
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.model.params import PlannerParams

MOST_GOALS = 64
"""Joint goals given to the search, at most: four headings of three robots."""
AXES = 3


class JointRRTConnectPlanner(JointPlanner):
    """See the module.

    Args:
        params: those about turns are used.
        time_limit_s: most time for a search.
        range_cells: longest motion added to a tree, over all robots.
        clock: what the time limit is measured by, s; wall time unless given.
    """

    def __init__(
        self,
        params: Optional[PlannerParams] = None,
        time_limit_s: float = 1.0,
        range_cells: float = 15.0,
        clock: Optional[Callable[[], float]] = None,
    ) -> None:
        super().__init__(params)
        self._time_limit_s, self._range_cells, self._clock = time_limit_s, range_cells, clock

    def _find(self, fleet: Fleet, robots: Sequence[int], rng: np.random.Generator) -> JointFound:
        del robots  # the others take part too
        standing = Standing(fleet)
        problem = _Problem(fleet, standing)
        if not problem.goals:
            return JointFound(None)
        ou.RNG.setSeed(int(rng.integers(1, 2**31)))
        planner = og.RRTConnect(problem.si)
        planner.setRange(self._range_cells)
        planner.setProblemDefinition(problem.definition)
        planner.setup()
        planner.solve(time_condition(self._time_limit_s, self._clock))
        moves = problem.moves()
        return JointFound(None if moves is None else tightened(fleet, standing, moves), 1)


class _Joint:
    """Poses of all robots as states, and what is free; knows nothing of OMPL, which would keep it for ever."""

    def __init__(self, fleet: Fleet, standing: Standing) -> None:
        self.starts = fleet.starts
        self.standing = standing
        self.poses = [Poses(view) for view in standing.alone]

    def of(self, state: Any) -> Tuple[Pose, ...]:
        """Poses of a state."""
        return tuple(poses.pose(state, AXES * i) for i, poses in enumerate(self.poses))

    def fill(self, state: Any, joint: Sequence[Pose]) -> Any:
        """Set a state to some poses; gives the state."""
        for i, (poses, pose) in enumerate(zip(self.poses, joint)):
            poses.fill(state, pose, AXES * i)
        return state

    def stand(self, joint: Sequence[Pose]) -> bool:
        """Whether all can stand so."""
        return all(
            self.standing.alone[i].stands(pose) and not self.standing.blockers(i, pose, pose, joint)
            for i, pose in enumerate(joint)
        )

    def ordered(self, a: Sequence[Pose], b: Sequence[Pose]) -> Optional[List[Move]]:
        """A motion as moves of one robot after the other; None when it is free in neither order."""
        robots = range(len(a))
        if not all(self.standing.alone[i].move(a[i], b[i]) for i in robots):
            return None
        for order in (robots, robots[::-1]):
            at, moves = list(a), []
            for i in order:
                if a[i] != b[i] and self.standing.blockers(i, a[i], b[i], at):
                    break
                moves.append(Move(i, a[i], b[i]))
                at[i] = b[i]
            else:
                return [move for move in moves if move.start != move.end]
        return None


class _Problem:
    """Joint space, start and goals for OMPL."""

    def __init__(self, fleet: Fleet, standing: Standing) -> None:
        self._joint = joint = _Joint(fleet, standing)
        bounds = ob.RealVectorBounds(AXES * len(joint.poses))
        for i, poses in enumerate(joint.poses):
            for axis, high in enumerate(poses.size):
                bounds.setLow(AXES * i + axis, 0.0)
                bounds.setHigh(AXES * i + axis, high)
        space = ob.RealVectorStateSpace(AXES * len(joint.poses))
        space.setBounds(bounds)
        self.si = ob.SpaceInformation(space)
        self.si.setStateValidityChecker(lambda state: joint.stand(joint.of(state)))
        self.si.setMotionValidator(_Validator(self.si, joint))
        self.si.setup()
        self.definition = ob.ProblemDefinition(self.si)
        self.definition.addStartState(joint.fill(self.si.allocState(), fleet.starts))
        self.goals = [goal for goal in _goals(fleet) if joint.stand(goal)][:MOST_GOALS]
        states = ob.GoalStates(self.si)
        for goal in self.goals:
            states.addState(joint.fill(self.si.allocState(), goal))
        states.setThreshold(GOAL_RADIUS_CELLS)
        self.definition.setGoal(states)

    def moves(self) -> Optional[List[Move]]:
        """The solution, shortened by OMPL's path simplifier, each motion checked once more; None when there is none."""
        if not self.definition.hasExactSolution():
            return None
        solution = self.definition.getSolutionPath()
        before = self._as_moves(solution)
        og.PathSimplifier(self.si).simplifyMax(solution)
        return self._as_moves(solution) or before

    def _as_moves(self, solution: Any) -> Optional[List[Move]]:
        states = [self._joint.of(solution.getState(k)) for k in range(solution.getStateCount())]
        moves: List[Move] = []
        for a, b in zip(states, states[1:]):
            ordered = self._joint.ordered(a, b)
            if ordered is None:
                return None
            moves += ordered
        return moves if states[0] == self._joint.starts and states[-1] in self.goals else None


def _goals(fleet: Fleet) -> List[Tuple[Pose, ...]]:
    """Poses of all robots on their targets; a robot without one where it stands."""
    joint: List[Tuple[Pose, ...]] = [()]
    for i, start in enumerate(fleet.starts):
        joint = [(*some, pose) for some in joint for pose in goal_poses(fleet, i) or [start]]
    return joint


class _Validator(ob.MotionValidator):  # type: ignore[misc]
    """A motion of all robots, in one order or the other."""

    def __init__(self, si: Any, joint: _Joint) -> None:
        super().__init__(si)
        self._joint = joint

    def checkMotion(self, first: Any, second: Any, last: Any = None) -> bool:  # noqa: N802
        """Whether the motion is free."""
        del last
        return self._joint.ordered(self._joint.of(first), self._joint.of(second)) is not None
