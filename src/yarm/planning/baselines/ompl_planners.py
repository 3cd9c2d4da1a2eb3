"""OMPL's RRTConnect, PRM* and BIT* behind the planner interface, for comparison; needs the ompl wheel.

The state space is (x, y, heading): x and y in cells, the heading as a third axis on which each heading has an interval
as long as the cost of a turn. A motion is what a robot does: turn about the end effector, then go straight from column
centre to column centre, looked up in the same tables as YARM's. Robots are planned one at a time, the others are
obstacles where they stand. These planners cannot prove that there is no path, they run out of time.
"""

from __future__ import annotations

import math
import time
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from yarm.planning.baselines.baseline import Found, OneByOnePlanner, goal_poses
from yarm.planning.cspace.robot_space import Pose, View
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import PlanStatus
from yarm.planning.roadmap.search import Path, merged

ou.setLogLevel(ou.LOG_NONE)
GOAL_RADIUS_CELLS = 1e-3


def time_condition(limit_s: float, clock: Optional[Callable[[], float]] = None) -> Any:
    """What ends a search after some time, s, by a clock; wall time unless given.

    A condition on the solution alone hangs BIT* and PRM* of this wheel; a time does not.
    """
    if clock is None:
        return ob.timedPlannerTerminationCondition(limit_s)
    deadline_s = clock() + limit_s
    return ob.PlannerTerminationCondition(lambda: clock() > deadline_s)


class OmplPlanner(OneByOnePlanner):
    """What the OMPL planners have in common.

    Args:
        params: those about turns are used.
        time_limit_s: most time for one robot's search.
        improve: use all the time to make the path shorter; else stop at the first path and shorten it by OMPL's
            path simplifier.
        simplify: whether to simplify.
        clock: what the time limit is measured by, s, for instance ``time.process_time`` on a machine that is busy with
            other things; not for PRM*, which hangs with it.
    """

    several_goals = True
    """Whether the planner may be given one goal state for each heading it can stand at the goal with."""

    def __init__(
        self,
        params: Optional[PlannerParams] = None,
        time_limit_s: float = 1.0,
        improve: bool = False,
        simplify: bool = True,
        clock: Optional[Callable[[], float]] = None,
    ) -> None:
        super().__init__(params)
        self._clock = clock
        self._time_limit_s = time_limit_s
        self._improve = improve
        self._simplify = simplify

    def _search(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[int, Found], int]:
        found: Dict[int, Found] = {}
        for i in active:
            began = time.perf_counter()
            view = fleet.view(i, fleet.starts)
            if fleet.satisfied(i, fleet.starts[i]):
                path: Optional[Path] = (fleet.starts[i],)
            else:
                path = self._find(view, fleet.starts[i], goal_poses(fleet, i), int(rng.integers(1, 2**31)))
            ms = 1e3 * (time.perf_counter() - began)
            if path is None:
                reason = f"{problem.robots[i].name} found no way to its goal within {self._time_limit_s:g} s"
                found[i] = Found(None, PlanStatus.TIMEOUT, reason, ms)
            else:
                found[i] = Found(path, ms=ms)
        return found, len(found)

    def _find(self, view: View, start: Pose, goals: List[Pose], seed: int) -> Optional[Path]:
        goals = [goal for goal in goals if view.stands(goal)]
        if not goals or not view.stands(start):
            return None
        if self.several_goals:
            return self._solve(view, start, goals, seed, self._time_limit_s)
        goals.sort(key=lambda goal: (goal[2] != start[2], goal[2]))
        for goal in goals:
            path = self._solve(view, start, [goal], seed, self._time_limit_s / len(goals))
            if path is not None:
                return path
        return None

    def _solve(self, view: View, start: Pose, goals: Sequence[Pose], seed: int, limit_s: float) -> Optional[Path]:
        ou.RNG.setSeed(seed)
        problem = _Problem(view, start, goals, self._improve)
        planner = self._make(problem.si)
        planner.setProblemDefinition(problem.definition)
        planner.setup()
        planner.solve(time_condition(limit_s, self._clock))
        return problem.path(self._simplify)

    def _make(self, si: Any) -> Any:
        """The planner, for a space information."""
        raise NotImplementedError


class RRTConnectPlanner(OmplPlanner):
    """Two trees grown towards each other; fast, far from shortest."""

    range_cells = 10.0
    """Longest motion added to a tree; OMPL's own choice of about 20 for a grid of 50 x 50 is no quicker."""

    def _make(self, si: Any) -> Any:
        planner = og.RRTConnect(si)
        planner.setRange(self.range_cells)
        return planner


class PRMStarPlanner(OmplPlanner):
    """A roadmap that grows denser; given one goal state, since it hangs with several."""

    several_goals = False

    def _make(self, si: Any) -> Any:
        return og.PRMstar(si)


class BITStarPlanner(OmplPlanner):
    """Batches of samples searched in order of cost; becomes shorter with time."""

    def _make(self, si: Any) -> Any:
        return og.BITstar(si)


class _Validator(ob.MotionValidator):  # type: ignore[misc]
    """A motion as the robot makes it; the third axis is the heading."""

    def __init__(self, si: Any, view: View, poses: Poses) -> None:
        super().__init__(si)
        self._view, self._poses = view, poses

    def checkMotion(self, first: Any, second: Any, last: Any = None) -> bool:  # noqa: N802
        """Whether the motion is free."""
        del last
        return self._view.move(self._poses.pose(first), self._poses.pose(second))


class Poses:
    """States of the space and poses of the robot."""

    def __init__(self, view: View) -> None:
        self.shape = view.space.layout.shape[:2]
        self.count = len(view.space.headings)
        quarter = 2.0 * math.pi / max(self.count, 1)
        self.per_heading = max(1.0, quarter / view.space.turns.rad_per_cell) if self.count > 1 else 1.0
        self.size = (float(self.shape[0]), float(self.shape[1]), self.count * self.per_heading)
        """Length of the space along its three axes; each begins at 0."""

    def pose(self, state: Any, first: int = 0) -> Pose:
        """Pose of a state whose axes begin at ``first``."""
        x = min(max(int(state[first]), 0), self.shape[0] - 1)
        y = min(max(int(state[first + 1]), 0), self.shape[1] - 1)
        return x, y, min(max(int(state[first + 2] / self.per_heading), 0), self.count - 1)

    def fill(self, state: Any, pose: Pose, first: int = 0) -> Any:
        """Set the axes of a state that begin at ``first``; gives the state."""
        state[first], state[first + 1] = pose[0] + 0.5, pose[1] + 0.5
        state[first + 2] = (pose[2] + 0.5) * self.per_heading
        return state


class _Problem:
    """Space, start and goals for OMPL."""

    def __init__(self, view: View, start: Pose, goals: Sequence[Pose], improve: bool) -> None:
        self._view, self._start, self._goals = view, start, goals
        self._poses = poses = Poses(view)
        bounds = ob.RealVectorBounds(3)
        for axis, high in enumerate(poses.size):
            bounds.setLow(axis, 0.0)
            bounds.setHigh(axis, high)
        space = ob.RealVectorStateSpace(3)
        space.setBounds(bounds)
        self.si = ob.SpaceInformation(space)
        self.si.setStateValidityChecker(lambda state: view.stands(poses.pose(state)))
        self.si.setMotionValidator(_Validator(self.si, view, poses))
        self.si.setup()
        self.definition = ob.ProblemDefinition(self.si)
        self.definition.addStartState(poses.fill(self.si.allocState(), start))
        if len(goals) == 1:
            self.definition.setGoalState(poses.fill(self.si.allocState(), goals[0]), GOAL_RADIUS_CELLS)
        else:
            states = ob.GoalStates(self.si)
            for goal in goals:
                states.addState(poses.fill(self.si.allocState(), goal))
            states.setThreshold(GOAL_RADIUS_CELLS)
            self.definition.setGoal(states)
        objective = ob.PathLengthOptimizationObjective(self.si)
        if not improve:
            objective.setCostThreshold(ob.Cost(math.inf))
        self.definition.setOptimizationObjective(objective)

    def path(self, simplify: bool) -> Optional[Path]:
        """The solution as poses, each move checked once more; None when there is none."""
        if not self.definition.hasExactSolution():
            return None
        solution = self.definition.getSolutionPath()
        before = self._as_poses(solution)
        if simplify:
            og.PathSimplifier(self.si).simplifyMax(solution)
            after = self._as_poses(solution)
            if self._is_free(after):
                return after
        return before if self._is_free(before) else None

    def _as_poses(self, solution: Any) -> Path:
        poses = [self._poses.pose(solution.getState(k)) for k in range(solution.getStateCount())]
        return merged(poses)

    def _is_free(self, path: Path) -> bool:
        ends = path[0] == self._start and path[-1] in self._goals
        return ends and all(self._view.move(a, b) for a, b in zip(path, path[1:]))
