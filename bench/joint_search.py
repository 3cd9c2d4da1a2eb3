#!/usr/bin/env python3
"""Fleets that must make room for each other, stepped to the end: the complete search beside what there was before it.

    python3 bench/joint_search.py run --count 26     # resumable: one row a run in bench/data/joint_search.csv
    python3 bench/joint_search.py run --crowded --count 10 --planners yarm    # hardly room to move, and crowds
    python3 bench/joint_search.py report             # writes bench/joint_search.md from it

Seeds are held out (``HELD_OUT``); ``--seen`` takes others, for work on the planners. Times are processor time, and the
planners take turns on each instance. A run counts as impossible when the brute force of
``yarm.planning.scenes.joint_oracle`` says so, or the family is so by construction.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence

import numpy as np
from joint_search_report import write_report
from planning_table import Table, read_rows

from yarm.planning.cspace.robot_space import Pose
from yarm.planning.fleet.fleet import Fleet, Move, Poses
from yarm.planning.fleet.never_stuck import NeverStuck
from yarm.planning.fleet.problem import PlanningProblem
from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest, StepCheck
from yarm.planning.registry import make_planner
from yarm.planning.roadmap.search import reachable
from yarm.planning.scenes.coordination import COORDINATED, IMPOSSIBLE, make_coordinated
from yarm.planning.scenes.crowded import CROWDS, HARD, HOPELESS, make_crowded
from yarm.planning.scenes.instances import Instance
from yarm.planning.scenes.joint_oracle import TooLargeError, least_cost
from yarm.planning.scenes.stepping import SteppedRun, step_to_end
from yarm.planning.verification.bruteforce import touches

ROOT = Path(__file__).resolve().parents[1]
HELD_OUT = 1_000_000
"""The first seed of the instances that are for measuring alone."""
PLANNERS = ("yarm", "attempts", "lacam")
"""``attempts`` is yarm without the complete search."""
MOST_STEPS = 400
GIVE_UP_MS = 10_000.0
"""Processor time of planning after which a run is stopped, ms."""
COLUMNS = ("robots", "status", "plans", "refused", "touches", "cost", "least", "sum_ms", "max_ms", "alone", "reason")
Record = Dict[str, Any]


class _NoSearch(NeverStuck):
    def moves(
        self, problem: PlanningProblem, fleet: Fleet, robots: Sequence[int], failures: int
    ) -> Optional[List[Move]]:
        del problem, fleet, robots, failures
        return None


def new_planner(name: str) -> FleetPlanner:
    """A planner by its name in the tables."""
    if name != "attempts":
        return make_planner(name)
    planner = YarmPlanner(PlannerParams())
    planner._never_stuck = _NoSearch(planner._turns, planner._cache)
    return planner


class _Timed:
    """A planner whose processor time is summed up, and which is not asked any more once that is spent."""

    def __init__(self, planner: FleetPlanner) -> None:
        self._planner = planner
        self.ms: List[float] = []

    def reset(self) -> None:
        """See ``FleetPlanner``."""
        self._planner.reset()

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """See ``FleetPlanner``; an empty plan when the time is spent."""
        if sum(self.ms) > GIVE_UP_MS:
            return replace(self._last, robots={}, reason=f"stopped after {GIVE_UP_MS / 1000:g} s of planning")
        began = time.process_time()
        self._last = self._planner.plan(request, rng)
        self.ms.append(1e3 * (time.process_time() - began))
        return self._last


@lru_cache(maxsize=4)
def kept_instance(family: str, seed: int) -> Instance:
    """The instance of a family of either module with this seed."""
    return (make_crowded if family in {**HARD, **HOPELESS, **CROWDS} else make_coordinated)(family, seed)


@lru_cache(maxsize=4)
def _least(family: str, seed: int) -> str:
    """Least cost by brute force; "none" when there is no way, empty when there are too many places to look at."""
    if family in {**IMPOSSIBLE, **HOPELESS}:
        return "none"
    try:
        least = least_cost(kept_instance(family, seed).scene)
    except TooLargeError:
        return ""
    return "none" if least is None else str(least)


def _cost(run: SteppedRun) -> float:
    """Cells travelled, and a cell for each 10 degrees turned."""
    total = 0.0
    for trail in run.trails.values():
        for a, b in zip(trail, trail[1:]):
            turned = abs(math.remainder(b.yaw_rad - a.yaw_rad, math.tau))
            total += math.dist(a.column, b.column) + math.degrees(turned) / PlannerParams.turn_deg_per_cell
    return total


def stepped(family: str, seed: int, name: str) -> Record:
    """One instance stepped to the end by one planner."""
    found: List[str] = []

    def look(request: PlanRequest, plan: FleetPlan, verdict: StepCheck) -> None:
        if verdict.safe:
            found.extend(touches(request, plan)[:1])

    scene = kept_instance(family, seed).scene
    planner = _Timed(new_planner(name))
    run = step_to_end(scene, planner, np.random.default_rng(seed), most_steps=MOST_STEPS, observe=look, clearance=False)
    return {
        "robots": len(scene.robots),
        "status": run.status.value,
        "plans": len(planner.ms),
        "refused": run.refused,
        "touches": len(found),
        "cost": f"{_cost(run):.2f}",
        "least": _least(family, seed),
        "sum_ms": f"{sum(planner.ms):.1f}",
        "max_ms": f"{max(planner.ms, default=0.0):.1f}",
        "alone": int(_one_after_the_other(family, seed)),
        "reason": run.reason.replace("\n", " ")[:200],
    }


@lru_cache(maxsize=4)
def _one_after_the_other(family: str, seed: int) -> bool:
    """Whether one robot after the other can go to its goal while all others stand, the first that can each time."""
    scene = kept_instance(family, seed).scene
    planner = YarmPlanner(PlannerParams())
    problem = PlanningProblem.of(scene.request(), planner._turns, planner._cache)
    assert problem is not None
    fleet = Fleet(problem.spaces, problem.targets, planner._roadmap(problem, np.random.default_rng(seed)))
    poses, left = fleet.starts, [i for i, target in enumerate(fleet.targets) if target is not None]
    while left:
        for i in left:
            target = fleet.targets[i]
            assert target is not None
            ends: List[Pose] = [
                (*target.column, h) for h in range(len(fleet.spaces[i].headings)) if target.heading in (None, h)
            ]
            end = _reached(fleet, i, poses, ends)
            if end is not None:
                poses = (*poses[:i], end, *poses[i + 1 :])
                left.remove(i)
                break
        else:
            return False
    return True


def _reached(fleet: Fleet, i: int, poses: Poses, ends: Sequence[Pose]) -> Optional[Pose]:
    """The first of some poses that a robot can reach while the others stand; None when it can reach none."""
    reached = reachable(fleet.view(i, poses), poses[i])
    layout = fleet.spaces[i].layout
    return next((end for end in ends if reached[end[2]] >> layout.bit(*end[:2]) & 1), None)


def run(data: Path, seeds: range, families: Sequence[str], planners: Sequence[str]) -> None:
    """All planners on all families, seed after seed."""
    table = Table(data / "joint_search.csv", ("family", "seed", "planner"), COLUMNS)
    for seed in seeds:
        for family in families:
            first = seed % len(planners)
            for name in (*planners[first:], *planners[:first]):
                key = {"family": family, "seed": seed, "planner": name}
                table.add(key, partial(stepped, family, seed, name))
        print(f"{seed + 1 - seeds.start} of {len(seeds)} seeds", flush=True)


def main() -> int:
    """See the module."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("run", "report"))
    parser.add_argument("--count", type=int, default=26, help="instances of each family")
    parser.add_argument("--crowded", action="store_true", help="the families with hardly room to move, and crowds")
    parser.add_argument("--planners", nargs="+", choices=PLANNERS, default=PLANNERS)
    parser.add_argument("--seen", action="store_true", help="other seeds than the held-out ones")
    parser.add_argument("--data", type=Path, default=ROOT / "bench" / "data", help="folder of the rows")
    args = parser.parse_args()
    if args.what == "run":
        first = 0 if args.seen else HELD_OUT
        families = (*HARD, *CROWDS, *HOPELESS) if args.crowded else (*COORDINATED, *IMPOSSIBLE)
        run(args.data, range(first, first + args.count), families, args.planners)
    else:
        write_report(read_rows(args.data / "joint_search.csv"), ROOT / "bench" / "joint_search.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
