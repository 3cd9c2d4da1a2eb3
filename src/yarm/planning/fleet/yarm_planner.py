"""YARM, the default planner: particles, configuration-space look-ups, and a joint plan kept from step to step."""

from __future__ import annotations

import dataclasses
import math
import time
from itertools import combinations, islice
from typing import Collection, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, IntArray
from yarm.params import build
from yarm.planning.cspace.cell_sets import CellSet
from yarm.planning.cspace.robot_space import ShapeCache
from yarm.planning.fleet.fleet import Fleet, Move
from yarm.planning.fleet.joint_plan import Conflicts, StepChoice, path_of, planned_moves, valid
from yarm.planning.fleet.joint_search import JointSearch
from yarm.planning.fleet.never_stuck import NeverStuck
from yarm.planning.fleet.problem import PlanningProblem, explain_failure, turns_of
from yarm.planning.fleet.replanning import GoalKey, Memory, waypoint
from yarm.planning.fleet.schedule import Pace, alone_s, duration, soonest
from yarm.planning.model import request_check as check
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, RobotPlan, Waypoint
from yarm.planning.roadmap.particles import narrow_columns
from yarm.planning.roadmap.roadmap import OFFSETS, Roadmap, even_roadmap

MIN_ROUNDS = 30
"""Rounds of a joint search at least."""
SHARE = 5
"""Steps over which the rounds of the limit are spread."""
MOST_ENTERED = 2
"""Times that the places of all robots may be entered again for the same goals without a plan for all."""
DEARER_TURNS = 0.5
"""Share of ``turn_deg_per_cell`` at which plans that are to take little time are looked for, too: turning is slow."""
MORE_ROUNDS = 120
"""Rounds in which a plan that takes less time than the first is looked for."""
FEW_ROUNDS, WORTH_TRYING = 20, 1.2
"""Rounds in which one is looked for while a plan is carried out that takes so many times the slowest robot alone."""
SUBSETS = 6
"""Subsets of one size tried when the whole fleet finds no joint plan."""
ALL_SUBSETS = 24
"""Subsets tried in all, the largest first."""
CROWD = 12
"""Robots with a goal beyond which orders of them and pushing are no cheap attempts."""


class YarmPlanner:
    """Plans one step for the fleet at a time and keeps the promises of docs/planning.md. Not thread safe."""

    def __init__(self, params: Optional[PlannerParams] = None) -> None:
        """A planner without memory.

        Raises:
            ParamError: a parameter is out of range.
        """
        self.params = build(PlannerParams, dataclasses.asdict(params or PlannerParams()))
        self._turns = turns_of(self.params.turns_deg, self.params.turn_deg_per_cell)
        self._dearer = turns_of(self.params.turns_deg, DEARER_TURNS * self.params.turn_deg_per_cell)
        self._pace = Pace()
        self._cache = ShapeCache()
        self._never_stuck = NeverStuck(self._turns, self._cache)
        self.reset()

    def reset(self) -> None:
        """Forget the previous plan and the particles."""
        self._memory = Memory()
        self._offset: Optional[int] = None
        self._last: Optional[CellSet] = None
        self._tried: Dict[str, GoalKey] = {}
        self._failures = 0
        self._never_stuck.reset()
        self._entered: Dict[Tuple[Waypoint, ...], int] = {}
        self._places: Tuple[Waypoint, ...] = ()

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """Plan one step for the fleet; see ``FleetPlanner``."""
        began = time.perf_counter()
        fault = check.world_fault(request)
        if fault:
            return check.refused(request, fault)
        problem = PlanningProblem.of(request, self._turns, self._cache)
        if problem is None:
            plans = check.faulty_plans(request)
            status, reason = check.worst(plans)
            return FleetPlan(status, reason, plans)
        roadmap = self._roadmap(problem, rng)
        fleet = Fleet(problem.spaces, problem.targets, roadmap)
        plans = check.faulty_plans(request, [robot.name for robot in problem.robots])
        kept = self._kept_moves(problem, fleet, plans)
        known = {*plans, *(() if kept is None else self._memory.goals)}
        plans.update(_goal_plans(problem, fleet, known))
        open_robots = [i for i, robot in enumerate(problem.robots) if problem.targets[i] and robot.name not in plans]
        fleet.restrict(open_robots)
        conflicts = Conflicts(fleet, problem.off_centre())
        moves, rounds = self._moves(problem, fleet, open_robots, kept, conflicts, rng)
        choice = StepChoice(fleet, moves, self.params.least_step_cells, conflicts, problem.under_way())
        plans.update(self._steps(problem, fleet, open_robots, choice))
        status, reason = check.worst(plans)
        if status is PlanStatus.TIMEOUT and self._never_stuck.proof:
            status = PlanStatus.INFEASIBLE
        elapsed = 1e3 * (time.perf_counter() - began)
        shares = {name: dataclasses.replace(p, planning_ms=elapsed / len(plans)) for name, p in plans.items()}
        ordered = () if request.under_way is None else planned_moves(choice, fleet, [r.name for r in problem.robots])
        return FleetPlan(status, reason, shares, rounds, elapsed, roadmap, ordered, roadmap.used)

    def _roadmap(self, problem: PlanningProblem, rng: np.random.Generator) -> Roadmap:
        gx, gy, _ = problem.request.spec.shape
        if self._offset is None:
            self._offset = int(rng.integers(OFFSETS))
        params = self.params
        base = even_roadmap((gx, gy), params.particles_first, self._offset, params.narrow_factor, params.particles)

        def narrow(columns: IntArray) -> BoolArray:
            layout, column_set = problem.layout, 0
            for space, target in zip(problem.spaces, problem.targets):
                if target is not None:
                    column_set |= narrow_columns(layout.field & ~space.blocked(0), layout.stride)
            image = layout.image_of_set(column_set)
            chosen: BoolArray = image[columns[:, 0], columns[:, 1]]
            return chosen

        return base.denser(narrow)

    def _kept_moves(
        self, problem: PlanningProblem, fleet: Fleet, faulty: Mapping[str, RobotPlan]
    ) -> Optional[List[Move]]:
        """The remembered joint plan, while its goals are the same and its moves are free."""
        names = [robot.name for robot in problem.robots]
        goals = {name: problem.goal_key(i) for i, name in enumerate(names) if problem.targets[i] and name not in faulty}
        remembered = self._memory.goals
        if not remembered or any(goals.get(name) != goal for name, goal in remembered.items()):
            return None
        moves = self._memory.recall(fleet, names)
        return moves if moves is not None and valid(fleet, moves, [names.index(name) for name in remembered]) else None

    def _moves(
        self,
        problem: PlanningProblem,
        fleet: Fleet,
        open_robots: Sequence[int],
        kept: Optional[List[Move]],
        conflicts: Conflicts,
        rng: np.random.Generator,
    ) -> Tuple[List[Move], int]:
        """Joint plan: the remembered one while it is free, unless a new one is clearly cheaper."""
        goals = {problem.robots[i].name: problem.goal_key(i) for i in open_robots}
        search = JointSearch(fleet, open_robots, self._effort(goals))
        if kept is None or goals != self._memory.goals:
            full = self._full_plan(problem, fleet, open_robots, search, conflicts, rng)
            self._failures = 0 if full is not None else self._failures + 1
            if full is None:
                return self._moves_of_some(problem, fleet, open_robots, kept, rng), search.rounds
            kept = full
        elif problem.request.under_way is not None:
            kept = self._sooner(problem, fleet, search, open_robots, kept, conflicts, rng)
        elif self._last != problem.obstacles:
            fresh = search.quick()
            if fresh is not None and fleet.cost(fresh) < self.params.keep_gain * fleet.cost(kept):
                kept = fresh
        self._last = problem.obstacles
        self._memory.goals = goals
        return kept, search.rounds

    def _full_plan(
        self,
        problem: PlanningProblem,
        fleet: Fleet,
        open_robots: Sequence[int],
        search: JointSearch,
        conflicts: Conflicts,
        rng: np.random.Generator,
    ) -> Optional[List[Move]]:
        """Moves that bring all to their targets: by the cheap attempts, then by the complete search.

        Of a crowd only the first attempt is cheap; the others are made where there is no complete search.
        """
        known = self._never_stuck.knows(problem)
        is_crowd = len(open_robots) > CROWD
        full: Optional[List[Move]] = None
        if not known:
            full = search.quick() if is_crowd else self._found(problem, fleet, search, open_robots, conflicts, rng)
        if full is None and open_robots:
            full = self._never_stuck.moves(problem, fleet, open_robots, self._failures)
        if full is None and is_crowd and not self._never_stuck.searches:
            full = search.run(rng)
        return full

    def _found(
        self,
        problem: PlanningProblem,
        fleet: Fleet,
        search: JointSearch,
        open_robots: Sequence[int],
        conflicts: Conflicts,
        rng: np.random.Generator,
    ) -> Optional[List[Move]]:
        """The first joint plan that is found; when robots do not wait for each other, the one that takes least time."""
        if problem.request.under_way is None or not open_robots:
            return search.run(rng)
        fleets = [fleet, self._with_dearer_turns(problem, fleet, open_robots)]
        found = soonest(fleets, open_robots, search.limit, MORE_ROUNDS, self._pace, conflicts, rng)
        search.rounds += found.rounds
        return found.moves

    def _sooner(
        self,
        problem: PlanningProblem,
        fleet: Fleet,
        search: JointSearch,
        open_robots: Sequence[int],
        kept: List[Move],
        conflicts: Conflicts,
        rng: np.random.Generator,
    ) -> List[Move]:
        """The plan that is kept, unless a few others are tried and one of them is clearly sooner done from here."""
        takes = duration(fleet, kept, self._pace, conflicts)
        if not open_robots or takes.last_s <= WORTH_TRYING * alone_s(fleet, open_robots, self._pace):
            return kept
        tried = fleet if rng.random() < 0.5 else self._with_dearer_turns(problem, fleet, open_robots)
        found = soonest([tried], open_robots, FEW_ROUNDS, FEW_ROUNDS, self._pace, conflicts, rng, all_orders=False)
        search.rounds += found.rounds
        better = found.moves is not None and found.takes.beats(takes, self.params.keep_gain)
        return found.moves if better and found.moves is not None else kept

    def _with_dearer_turns(self, problem: PlanningProblem, fleet: Fleet, robots: Sequence[int]) -> Fleet:
        dearer = PlanningProblem.of(problem.request, self._dearer, self._cache)
        assert dearer is not None
        other = Fleet(dearer.spaces, dearer.targets, fleet.roadmap)
        other.restrict(robots)
        return other

    def _effort(self, goals: Mapping[str, GoalKey]) -> int:
        """Rounds of the joint search in this step: a share of the limit, less and less while the same goals fail.

        Meanwhile those robots move that can, and the next search starts from there.
        """
        if goals != self._tried:
            self._tried, self._failures, self._entered = dict(goals), 0, {}
        return max(MIN_ROUNDS, 2 * len(goals), self.params.iteration_limit // SHARE >> self._failures)

    def _moves_of_some(
        self,
        problem: PlanningProblem,
        fleet: Fleet,
        open_robots: Sequence[int],
        kept: Optional[List[Move]],
        rng: np.random.Generator,
    ) -> List[Move]:
        """When not all can reach their targets: a plan for as many as can, the others step aside for them."""
        if self._is_livelock(fleet):
            self._memory.goals = {}
            return []
        if kept is not None:
            return kept
        targets = fleet.targets
        sizes = range(len(open_robots) - 1, 0, -1)
        subsets = (some for size in sizes for some in islice(combinations(open_robots, size), SUBSETS))
        for some in islice(subsets, ALL_SUBSETS):
            fleet.restrict(some)
            moves = JointSearch(fleet, some, MIN_ROUNDS).run(rng)
            fleet.targets = targets
            if moves is not None:
                self._memory.goals = {problem.robots[i].name: problem.goal_key(i) for i in some}
                return moves
        self._memory.goals = {}
        return []

    def _is_livelock(self, fleet: Fleet) -> bool:
        """Whether the fleet has come back to where it stands now too often for the same goals; it stays then."""
        places = tuple(waypoint(space.start, space) for space in fleet.spaces)
        if places != self._places:
            self._entered[places] = self._entered.get(places, 0) + 1
            self._places = places
        return self._entered.get(places, 0) > MOST_ENTERED

    def _steps(
        self, problem: PlanningProblem, fleet: Fleet, open_robots: Sequence[int], choice: StepChoice
    ) -> Dict[str, RobotPlan]:
        steps = choice.choose()
        names = [robot.name for robot in problem.robots]
        self._memory.keep(fleet, names, choice.moves)
        plans: Dict[str, RobotPlan] = {}
        for i, (name, space) in enumerate(zip(names, fleet.spaces)):
            if i not in open_robots and i not in steps:
                continue
            path = path_of(fleet, choice.moves, i)
            solved = fleet.satisfied(i, path[-1])
            plans[name] = RobotPlan(
                name,
                problem.request.assignments[name] if i in open_robots else "",
                PlanStatus.SOLVED if solved else PlanStatus.TIMEOUT,
                "" if solved else self._never_stuck.proof or _stuck_reason(problem, i, self._never_stuck.visited),
                tuple(waypoint(pose, space) for pose in path),
                waypoint(steps[i], space) if i in steps else None,
                sum(math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in zip(path, path[1:])),
            )
        return plans


def _goal_plans(problem: PlanningProblem, fleet: Fleet, known: Collection[str]) -> Dict[str, RobotPlan]:
    """Plans of the robots, but those known, that have no way to their goal even with no other robot there."""
    plans = {}
    for i, robot in enumerate(problem.robots):
        if problem.targets[i] is not None and robot.name not in known and fleet.alone(i) is None:
            status, reason = explain_failure(problem, fleet, i)
            plans[robot.name] = RobotPlan(robot.name, problem.request.assignments[robot.name], status, reason)
    return plans


def _stuck_reason(problem: PlanningProblem, i: int, visited: int) -> str:
    others = ", ".join(robot.name for j, robot in enumerate(problem.robots) if j != i)
    goal = problem.request.assignments.get(problem.robots[i].name, "")
    name = problem.robots[i].name
    looked = f"; {visited} places of the fleet looked at, too many to decide in this step" if visited else ""
    return f"{name} waits: no order of moves was found that brings it to {goal} past {others or 'nobody'}{looked}"
