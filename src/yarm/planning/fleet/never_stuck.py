"""The complete search from call to call: carried on while nothing has changed; what it has proved, in a sentence."""

from __future__ import annotations

from dataclasses import replace
from typing import Callable, List, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.planning.cspace.robot_space import ShapeCache, Turns
from yarm.planning.fleet.complete_search import WORK, CompleteSearch, make_complete_search
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.fleet.joint_native import Outcome
from yarm.planning.fleet.problem import PlanningProblem
from yarm.planning.model.types import PlanRequest, without_things
from yarm.planning.roadmap.roadmap import Roadmap

LEAST_SHARE = 8
"""A call that follows failures of the same goals may take 1/2, 1/4, ... of ``WORK``, but not less than 1 / this."""
CAUSE_WORK = WORK // 4
"""Look-ups to find the smallest set of robots and things that make a fleet's goals impossible."""
CAUSES = 16
"""Robots and things tried to be left out, at most."""


class NeverStuck:
    """What the planner asks when its cheap attempts have failed. Not thread safe."""

    def __init__(self, turns: Turns, cache: ShapeCache) -> None:
        """Nothing is searched yet.

        Args:
            turns: allowed turns.
            cache: kept shapes.
        """
        self._turns = turns
        self._cache = cache
        self.reset()

    def reset(self) -> None:
        """Forget the search."""
        self._key: object = None
        self._search: Optional[CompleteSearch] = None
        self.proof = ""
        """Why the goals of the last call cannot all be reached, in a sentence; empty when that is not proved."""

    @property
    def searches(self) -> bool:
        """Whether there is a complete search for the last problem; there is none where the library is not built."""
        return self._search is not None

    @property
    def visited(self) -> int:
        """Places of the whole fleet looked at in the last search."""
        return 0 if self._search is None else self._search.visited

    def knows(self, problem: PlanningProblem) -> bool:
        """Whether this very problem has been proved to have no solution."""
        return bool(self.proof) and self._key == _key_of(problem)

    def moves(
        self, problem: PlanningProblem, fleet: Fleet, robots: Sequence[int], failures: int
    ) -> Optional[List[Move]]:
        """Search on; moves that bring every robot to its target, or None.

        Args:
            problem: what is asked.
            fleet: its spaces, with the targets of the robots alone.
            robots: those with a target.
            failures: calls for the same goals that have failed so far.
        """
        key = _key_of(problem)
        same = key == self._key
        if not same:
            self.reset()
            self._key, self._search = key, make_complete_search(fleet, robots)
        if self._search is None:
            return None
        work = WORK if same else max(WORK >> failures, WORK // LEAST_SHARE)
        found = self._search.run(fleet, work)
        if self._search.proved and not self.proof:
            names = [problem.robots[i].name for i in robots]
            self.proof = self._sentence(problem.request, names, self._search)
        return found

    def _sentence(self, request: PlanRequest, names: Sequence[str], search: CompleteSearch) -> str:
        """Who and what make it impossible: each one left out, there would be a plan."""
        left = [CAUSE_WORK]

        def impossible(trial: PlanRequest) -> bool:
            outcome, work = self._outcome(trial, left[0])
            left[0] -= work
            return outcome is Outcome.IMPOSSIBLE

        robots = [robot.name for robot in request.robots]
        things = [name for name in request.objects if name not in request.goals]
        narrowed, is_smallest = request, len(robots) + len(things) <= CAUSES
        for name in set(request.assignments) - set(names):
            narrowed = _without_goal(name)(narrowed)
        if is_smallest:
            narrowed = _smallest(narrowed, [*map(_without_robot, robots)], impossible)
            narrowed = _smallest(narrowed, [*map(_without_goal, names)], impossible)
            narrowed = _smallest(narrowed, [*map(_without_thing, things)], impossible)
            is_smallest = left[0] > 0
        goals = [f"{name} to {goal}" for name, goal in sorted(narrowed.assignments.items()) if name in names]
        beside = [robot.name for robot in narrowed.robots if robot.name not in narrowed.assignments]
        between = [*beside, *(name for name in narrowed.objects if name not in request.goals)]
        others = f" past {', '.join(between)}" if between else ""
        tail = "; it would be possible without any one of these" if is_smallest else ""
        return f"no order of moves through any cell brings {' and '.join(goals)}{others}: {_why(search)}{tail}"

    def _outcome(self, request: PlanRequest, work: int) -> Tuple[Outcome, int]:
        """How the search of another request ends within some look-ups, and how many it took."""
        problem = PlanningProblem.of(request, self._turns, self._cache)
        if problem is None or work <= 0:
            return Outcome.OPEN, 0
        fleet = Fleet(problem.spaces, problem.targets, _NOWHERE)
        search = make_complete_search(fleet, range(len(problem.robots)))
        assert search is not None
        return search.outcome_within(work), search.work


def _why(search: CompleteSearch) -> str:
    if not search.visited:
        return "they cannot stand there together"
    if search.by_exchange:
        return f"{search.visited} places looked at, and no exchange of equal robots that can be made leads there"
    return f"all {search.visited} places of the fleet that can be reached have been tried"


_NOWHERE = Roadmap.of(np.zeros((0, 2), dtype=np.int64))
"""For a fleet in which only the complete search looks for ways."""
Change = Callable[[PlanRequest], PlanRequest]


def _key_of(problem: PlanningProblem) -> object:
    robots = tuple(
        (robot.name, space.start, space.headings, space.obstacles, space.shape0.groups)
        for robot, space in zip(problem.robots, problem.spaces)
    )
    return problem.layout, robots, tuple(problem.targets)


def _smallest(
    request: PlanRequest, changes: Sequence[Change], impossible: Callable[[PlanRequest], bool]
) -> PlanRequest:
    """The request with everything left out that is not needed to make it impossible, one after the other."""
    for change in changes:
        trial = change(request)
        if impossible(trial):
            request = trial
    return request


def _without_robot(name: str) -> Change:
    def change(request: PlanRequest) -> PlanRequest:
        robots = tuple(robot for robot in request.robots if robot.name != name)
        return replace(_without_goal(name)(request), robots=robots)

    return change


def _without_goal(name: str) -> Change:
    """Without what stands on the goal too, which is an obstacle once nobody is sent there."""

    def change(request: PlanRequest) -> PlanRequest:
        left = {robot: goal for robot, goal in request.assignments.items() if robot != name}
        goal = request.goals.get(request.assignments.get(name, ""))
        cells = np.zeros((0, 3), dtype=np.int64) if goal is None else goal.cells
        return replace(request, assignments=left, occupied=_cleared(request, cells))

    return change


def _without_thing(name: str) -> Change:
    def change(request: PlanRequest) -> PlanRequest:
        objects = {other: cells for other, cells in request.objects.items() if other != name}
        occupied = without_things(request.spec, request.occupied, request.objects, (name,))
        return replace(request, objects=objects, occupied=occupied)

    return change


def _cleared(request: PlanRequest, cells: IntArray) -> BoolArray:
    occupied: BoolArray = np.array(request.occupied, dtype=np.bool_)
    inside = np.asarray(cells, dtype=np.int64).reshape(-1, 3)
    occupied[tuple(inside[request.spec.contains(inside)].T)] = False
    return occupied
