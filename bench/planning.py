#!/usr/bin/env python3
"""Planning benchmarks: runs are appended to a file, so that a stopped one goes on where it was.

    python3 bench/planning.py families --count 1000     # success and touches of yarm, each family
    python3 bench/planning.py compare --count 100       # all planners on the same instances
    python3 bench/planning.py growth                    # robots, particles, grid size
    python3 bench/planning.py report                    # tables and plots from what has been run

Times are processor time, and the planners take turns on each instance, so that other work on the machine changes
little. See bench/planning.md for figures.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import time
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Optional, Tuple

import numpy as np
from planning_report import write_report

from yarm.geometry import GridSpec
from yarm.planning.bruteforce import touches
from yarm.planning.instances import FAMILIES, Instance, make_instance
from yarm.planning.oracle import shortest_length
from yarm.planning.params import PlannerParams
from yarm.planning.registry import make_planner
from yarm.planning.stepping import step_to_end
from yarm.planning.types import FleetPlan, FleetPlanner, PlanRequest, PlanStatus, RobotPlan, StepCheck

ROOT = Path(__file__).resolve().parents[1]
PLANNERS = (
    "yarm",
    "original",
    "ma_astar",
    "ompl_rrtconnect first",
    "ompl_rrtconnect simplified",
    "ompl_prmstar first",
    "ompl_bitstar first",
    "ompl_bitstar 1 s",
)
"""Planners compared; the word after an OMPL name says when it stops."""
FLEET_PLANNERS = ("yarm", "original", "ma_astar", "ompl_rrtconnect simplified")
"""Planners that step fleets to the end."""
SLOW_PLANNERS = {"ompl_bitstar 1 s": 3, "original": 3}
"""Planners that get only one instance in so many."""
ROBOTS = (1, 2, 3, 5, 7, 10, 15, 20)
PARTICLES = (20, 50, 100, 333, 1000, 2500)
GRIDS = (50, 70, 100, 140, 200)
Record = Dict[str, Any]


class Results:
    """Records in a file of one JSON object a line, known by their key."""

    def __init__(self, path: Path) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        self.records: List[Record] = []
        if path.exists():
            self.records = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line]
        self._known = {json.dumps(record["key"]) for record in self.records}

    def add(self, key: List[Any], make: Callable[[], Record]) -> Optional[Record]:
        """Make and keep a record unless there is one of this key."""
        if json.dumps(key) in self._known:
            return None
        record = {"key": key, **make()}
        self.records.append(record)
        self._known.add(json.dumps(key))
        with self._path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(record) + "\n")
        return record


@lru_cache(maxsize=None)
def planner_of(name: str, particles: int = 333) -> FleetPlanner:
    """A planner that lives as long as the benchmark, as the Commander's does; reset before each instance."""
    base, _, mode = name.partition(" ")
    params = PlannerParams(particles=particles)
    if not mode:
        return make_planner(base, params)
    ompl = importlib.import_module("yarm.planning.ompl_planners")
    cls = {"rrtconnect": ompl.RRTConnectPlanner, "prmstar": ompl.PRMStarPlanner, "bitstar": ompl.BITStarPlanner}
    if mode == "1 s":
        return cls[base[5:]](params, 1.0, improve=True, clock=time.process_time)
    return cls[base[5:]](params, 2.0, simplify=mode == "simplified")


class CpuTimed:
    """A planner whose plans say the processor time they took, which other work on the machine changes little."""

    def __init__(self, planner: FleetPlanner) -> None:
        self._planner = planner

    def reset(self) -> None:
        """See ``FleetPlanner``."""
        self._planner.reset()

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        """See ``FleetPlanner``."""
        began = time.process_time()
        plan = self._planner.plan(request, rng)
        return replace(plan, planning_ms=1e3 * (time.process_time() - began))


def stepped(instance: Instance, name: str, brute: bool) -> Record:
    """Step an instance to the end; what the checker refused and what brute force found."""
    found: List[str] = []

    def look(request: PlanRequest, plan: FleetPlan, verdict: StepCheck) -> None:
        if brute and verdict.safe:
            found.extend(touches(request, plan))

    planner = CpuTimed(planner_of(name))
    run = step_to_end(
        instance.scene,
        planner,
        np.random.default_rng(instance.seed),
        most_steps=200 if name == "yarm" else 60,
        observe=look,
        clearance=False,
    )
    return {
        "status": run.status.value,
        "reason": run.reason,
        "robots": len(instance.scene.robots),
        "steps": run.steps,
        "plans": len(run.ms),
        "refused": run.refused,
        "refusals": run.refusals[:2],
        "touches": found[:2],
        "ms": [round(ms, 2) for ms in run.ms],
        "cost": round(run.sum_of_costs, 2),
        "makespan": round(run.makespan, 2),
    }


def first_plan(instance: Instance, name: str, optimum: float) -> Record:
    """One robot's first plan: time, length over the optimum, and touches of the whole path by brute force."""
    planner = CpuTimed(planner_of(name))
    planner.reset()
    plan = planner.plan(instance.scene.request(), np.random.default_rng(instance.seed))
    entry = next(iter(plan.robots.values()))
    solved = entry.status is PlanStatus.SOLVED
    hits = sum(bool(touches(*leg)) for leg in _legs(instance, entry)) if solved else 0
    ratio = entry.length_cells / optimum if solved and optimum > 0 else None
    return {
        "status": entry.status.value,
        "ms": plan.planning_ms,
        "ratio": ratio,
        "waypoints": len(entry.path),
        "touches": hits,
    }


def _legs(instance: Instance, entry: RobotPlan) -> Iterator[Tuple[PlanRequest, FleetPlan]]:
    stands = instance.scene.starts()
    kind = type(stands[entry.robot])
    for before, after in zip(entry.path, entry.path[1:]):
        stands = {**stands, entry.robot: kind(before.column, before.yaw_rad)}
        leg = RobotPlan(entry.robot, entry.goal, PlanStatus.SOLVED, step=after)
        yield instance.scene.request(stands), FleetPlan(PlanStatus.SOLVED, "", {entry.robot: leg})


def run_families(results: Results, count: int, names: List[str], progress: Callable[[str], None]) -> None:
    """Every family stepped to the end by yarm."""
    for seed in range(count):
        for family in names:
            record = results.add(["families", family, seed], partial(_made_and_stepped, family, seed, "yarm"))
            if record and (record["status"] != "SOLVED" or record["touches"] or record["refused"]):
                faults = f"{record['reason']} {record['touches']} {record['refusals']}"
                progress(f"{family} {seed}: {record['status']} {faults}")
        if seed % 50 == 49:
            progress(f"families: {seed + 1} of {count} seeds")


def _made_and_stepped(family: str, seed: int, name: str) -> Record:
    return stepped(make_instance(family, seed), name, True)


def run_compare(results: Results, count: int, planners: List[str], progress: Callable[[str], None]) -> None:
    """All planners: first plans of one robot, and fleets stepped to the end."""
    for seed in range(count):
        for family in ("open", "table_and_stand", "narrow_gaps"):
            instance = make_instance(family, 100_000 + seed, robots=1)
            robot, goal = next(iter(instance.scene.assignments.items()))
            optimum = shortest_length(instance.scene, robot, goal)
            for name in planners:
                if name in SLOW_PLANNERS and seed >= count // SLOW_PLANNERS[name]:
                    continue
                results.add(["first", family, seed, name], partial(first_plan, instance, name, optimum))
        if seed < count // 4:
            for family in FAMILIES:
                for name in FLEET_PLANNERS:
                    if name in SLOW_PLANNERS and seed >= count // (4 * SLOW_PLANNERS[name]):
                        continue
                    results.add(["fleet", family, seed, name], partial(_made_and_stepped, family, 200_000 + seed, name))
        if seed % 10 == 9:
            progress(f"compare: {seed + 1} of {count} seeds")


def run_growth(results: Results, count: int, progress: Callable[[str], None]) -> None:
    """How the time of a step grows with robots, particles and grid size."""
    for seed in range(count):
        for robots in ROBOTS:
            results.add(["robots", robots, seed], partial(_timed, "open", seed, robots, 200, 333))
        for particles in PARTICLES:
            results.add(["particles", particles, seed], partial(_timed, "table_and_stand", seed, 3, 50, particles))
        for cells in GRIDS:
            results.add(["grid", cells, seed], partial(_timed, "open", seed, 3, cells, 333))
        progress(f"growth: {seed + 1} of {count} seeds")


def _timed(family: str, seed: int, robots: int, cells: int, particles: int) -> Record:
    half = cells / 20.0
    instance = make_instance(
        family, seed, robots, GridSpec((cells, cells, 20), (-half, -half, 0.01), (half, half, 1.3))
    )
    planner = CpuTimed(planner_of("yarm", particles))
    run = step_to_end(instance.scene, planner, np.random.default_rng(instance.seed), clearance=False)
    return {"status": run.status.value, "reason": run.reason, "ms": [round(ms, 2) for ms in run.ms], "steps": run.steps}


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("families", "compare", "growth", "report"))
    parser.add_argument("--count", type=int, default=0, help="seeds; default 1000, 100 and 5")
    parser.add_argument("--families", default=",".join(FAMILIES), help="families to run")
    parser.add_argument("--planners", default=",".join(PLANNERS), help="planners to compare")
    parser.add_argument(
        "--results", type=Path, default=ROOT / "results" / "bench" / "planning.jsonl", help="file of runs"
    )
    parser.add_argument("--out", type=Path, default=ROOT / "bench", help="folder of the report")
    options = parser.parse_args()
    results = Results(options.results)
    began = time.perf_counter()

    def progress(text: str) -> None:
        print(f"[{time.perf_counter() - began:7.1f} s] {text}", flush=True)

    if options.what == "families":
        run_families(results, options.count or 1000, options.families.split(","), progress)
    elif options.what == "compare":
        run_compare(results, options.count or 100, options.planners.split(","), progress)
    elif options.what == "growth":
        run_growth(results, options.count or 5, progress)
    else:
        progress(f"wrote {write_report(results.records, options.out)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
