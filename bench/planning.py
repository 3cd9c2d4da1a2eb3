#!/usr/bin/env python3
"""Planning benchmarks: each run is one row of a CSV file in bench/data, so that a stopped one goes on where it was.

    python3 bench/planning.py promises --count 1000     # success and touches of yarm, each family
    python3 bench/planning.py first --count 100         # one robot's first plan, all planners on the same instances
    python3 bench/planning.py fleets --count 40         # fleets stepped to the end, all planners on the same instances
    python3 bench/planning.py growth                    # robots, particles, grid size
    python3 bench/planning.py report                    # tables and plots from the files

Seeds are held out: nobody profiles, tunes or debugs a planner on them. ``--seen --data FOLDER`` takes others, for that.
A new measurement begins with the files removed. Times are processor time, and the planners take turns on each instance,
so that other work on the machine meets all of them. bench/method.md says what is measured, and bench/planning.md what
came out.
"""

from __future__ import annotations

import argparse
import importlib
import sys
import time
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

import numpy as np
from planning_report import write_report
from planning_table import Table

from yarm.geometry import GridSpec
from yarm.planning.baselines.baseline import Found, OneByOnePlanner
from yarm.planning.cspace import cell_sets, footprint
from yarm.planning.fleet.fleet import Fleet
from yarm.planning.fleet.problem import PlanningProblem
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, FleetPlanner, PlanRequest, PlanStatus, RobotPlan, StepCheck
from yarm.planning.registry import make_planner
from yarm.planning.roadmap import particles, roadmap
from yarm.planning.scenes.instances import CELL_GRID, FAMILIES, Instance, make_instance
from yarm.planning.scenes.oracle import shortest_length
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.verification.bruteforce import touches

ROOT = Path(__file__).resolve().parents[1]
HELD_OUT = 1_000_000
"""The first seed of the instances that are for measuring alone; all work on the planners is done on lower ones."""
OFFSETS = {"promises": 0, "first": 100_000, "fleets": 200_000, "growth": 300_000}
"""First seed of each measurement, after ``HELD_OUT`` or, for ``--seen``, after 0."""
COUNTS = {"promises": 1000, "first": 100, "fleets": 40, "growth": 5}
"""Seeds of each measurement unless given."""
SINGLE = ("open", "table_and_stand", "narrow_gaps")
"""Families of the first plans, with one robot each."""
REPEATS = 3
"""Times that each quick planner makes the same plan; the least time counts."""
QUICK = ("request", "yarm", "ma_astar", "ompl_rrtconnect first", "ompl_rrtconnect simplified", "ompl_bitstar first")
"""Planners that repeat their first plans."""
SLOW = ("ompl_prmstar first", "ompl_bitstar 1 s", "original")
"""Planners that make each first plan once, only with warm tables, and only for the first ``SLOW_SEEDS`` seeds."""
SLOW_SEEDS = 25
CONDITIONS = ("warm", "new", "cold")
"""warm: planners that have planned before; new: a planner made for this plan; cold: no table kept anywhere."""
FLEET_PLANNERS = (
    "yarm",
    "lacam",
    "ompl_joint_rrtconnect",
    "ma_astar",
    "ompl_rrtconnect simplified",
    "original",
    "original unchecked",
)
"""Planners that step fleets to the end; ``unchecked`` makes the steps that the checker refuses too."""
FIRST_LIMIT_S, FLEET_LIMIT_S, JOINT_LIMIT_S = 2.0, 0.5, 1.0
"""Processor time a search of OMPL's may take, s (PRM*: wall time): a first plan, a robot of a fleet, all of a fleet."""
MOST_STEPS = 200
WARMING = 20
"""Instances of each family, not among those measured, that planners plan before they are measured warm."""
ROBOTS = (1, 2, 3, 5, 7, 10, 15, 20)
PARTICLES = (20, 50, 100, 333, 1000, 2500)
GRIDS = (50, 70, 100, 140, 200)
Record = Dict[str, Any]
Progress = Callable[[str], None]


class RequestOnly(OneByOnePlanner):
    """What every planner does before it searches: check the request, make the map's tables."""

    def _search(
        self, problem: PlanningProblem, fleet: Fleet, active: Sequence[int], rng: np.random.Generator
    ) -> Tuple[Dict[int, Found], int]:
        del problem, fleet, active, rng
        return {}, 0


def new_planner(name: str, particle_count: int = 0, limit_s: float = FIRST_LIMIT_S) -> FleetPlanner:
    """A planner by its name in the tables; the word after an OMPL name says when it stops.

    With a number of particles YARM begins with them all; without, with as many as it does by itself.
    """
    base, _, mode = name.partition(" ")
    given = {"particles": particle_count, "particles_first": particle_count} if particle_count else {}
    params = PlannerParams(**given)
    if base == "request":
        return RequestOnly(params)
    if base == "ompl_joint_rrtconnect":
        joint = importlib.import_module("yarm.planning.baselines.ompl_joint")
        return joint.JointRRTConnectPlanner(params, JOINT_LIMIT_S, clock=time.process_time)  # type: ignore[no-any-return]
    if mode in ("", "unchecked"):
        return make_planner(base, params)
    ompl = importlib.import_module("yarm.planning.baselines.ompl_planners")
    cls = {"rrtconnect": ompl.RRTConnectPlanner, "prmstar": ompl.PRMStarPlanner, "bitstar": ompl.BITStarPlanner}
    if mode == "1 s":
        planner = cls[base[5:]](params, 1.0, improve=True, clock=time.process_time)
    else:
        clock = None if base == "ompl_prmstar" else time.process_time
        planner = cls[base[5:]](params, limit_s, simplify=mode == "simplified", clock=clock)
    return planner  # type: ignore[no-any-return]


kept_planner = lru_cache(maxsize=None)(new_planner)
"""A planner that lives as long as the benchmark, as the Commander's does; reset before each instance."""


def forget_tables() -> None:
    """Empty every table that lives outside a planner."""
    for kept in (
        cell_sets.band,
        cell_sets.band_rows,
        footprint.turned_columns,
        roadmap.even_roadmap,
        particles.cell_order,
    ):
        kept.cache_clear()


def make_tables(names: Sequence[str]) -> None:
    """Bring planners and tables to where a long mission brings them."""
    for family in SINGLE:
        for seed in range(900_000, 900_000 + WARMING):
            scene = make_instance(family, seed, 1).scene
            for name in names:
                if name not in SLOW or seed == 900_000:
                    kept_planner(name).reset()
                    kept_planner(name).plan(scene.request(), np.random.default_rng(seed))
    problem = PlanningProblem.of(make_instance("open", 900_000, 1).scene.request(), *_turns_and_cache())
    assert problem is not None
    gx, gy, _ = CELL_GRID.shape
    for dx in range(1 - gx, gx):
        for dy in range(1 - gy, gy):
            cell_sets.band(dx, dy, problem.layout.stride)


def _turns_and_cache() -> Tuple[Any, Any]:
    plain = RequestOnly(PlannerParams())
    return plain._turns, plain._cache


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


def stepped(instance: Instance, name: str, brute: bool = True, particle_count: int = 0) -> Record:
    """Step an instance to the end; what the checker refused and what brute force found in the steps made."""
    found: List[str] = []
    searched: List[bool] = []
    heeded = not name.endswith("unchecked")

    def look(request: PlanRequest, plan: FleetPlan, verdict: StepCheck) -> None:
        searched.append(plan.iterations > 0)
        if brute and (verdict.safe or not heeded):
            found.extend(touches(request, plan)[:1])

    run = step_to_end(
        instance.scene,
        CpuTimed(kept_planner(name, particle_count, FLEET_LIMIT_S)),
        np.random.default_rng(instance.seed),
        most_steps=MOST_STEPS,
        observe=look,
        clearance=False,
        heed_checker=heeded,
    )
    return {
        "robots": len(instance.scene.robots),
        "status": run.status.value,
        "steps": run.steps,
        "plans": len(run.ms),
        "searched": sum(searched),
        "refused": run.refused,
        "touches": len(found) if brute else "",
        "cost": round(run.sum_of_costs, 2),
        "makespan": round(run.makespan, 2),
        "ms": " ".join(f"{ms:.2f}" for ms in run.ms),
    }


def first_plan(instance: Instance, planner: FleetPlanner, optimum: float, look: bool) -> Record:
    """One robot's first plan: time, length, and touches of the whole path by brute force when they are looked for."""
    planner.reset()
    request, rng = instance.scene.request(), np.random.default_rng(instance.seed)
    plan = CpuTimed(planner).plan(request, rng)
    entry = next(iter(plan.robots.values()), None)
    solved = entry is not None and entry.status is PlanStatus.SOLVED
    legs = list(_legs(instance, entry)) if entry is not None and solved and look else []
    return {
        "status": entry.status.value if entry is not None else "",
        "ms": f"{plan.planning_ms:.3f}",
        "length": f"{entry.length_cells:.3f}" if entry is not None and solved else "",
        "optimum": f"{optimum:.3f}",
        "waypoints": len(entry.path) if entry is not None else "",
        "touches": sum(bool(touches(*leg)) for leg in legs) if look else "",
    }


def _legs(instance: Instance, entry: RobotPlan) -> Iterator[Tuple[PlanRequest, FleetPlan]]:
    stands = instance.scene.starts()
    kind = type(stands[entry.robot])
    for before, after in zip(entry.path, entry.path[1:]):
        stands = {**stands, entry.robot: kind(before.column, before.yaw_rad)}
        leg = RobotPlan(entry.robot, entry.goal, PlanStatus.SOLVED, step=after)
        yield instance.scene.request(stands), FleetPlan(PlanStatus.SOLVED, "", {entry.robot: leg})


STEPPED_COLUMNS = ("robots", "status", "steps", "plans", "searched", "refused", "touches", "cost", "makespan", "ms")


def run_promises(data: Path, seeds: range, progress: Progress) -> None:
    """Every family stepped to the end by yarm."""
    table = Table(data / "planning_promises.csv", ("family", "seed"), STEPPED_COLUMNS)
    for seed in seeds:
        for family in FAMILIES:
            row = table.add({"family": family, "seed": seed}, partial(_made_and_stepped, family, seed, "yarm"))
            if row and (row["status"] != "SOLVED" or row["touches"] != "0" or row["refused"] != "0"):
                progress(f"{family} {seed}: {row}")
        if seed % 50 == 49:
            progress(f"promises: {seed + 1 - seeds.start} of {len(seeds)} seeds")


def _made_and_stepped(family: str, seed: int, name: str) -> Record:
    return stepped(make_instance(family, seed), name)


def run_first(data: Path, seeds: range, planners: Sequence[str], conditions: Sequence[str], progress: Progress) -> None:
    """First plans of one robot; in each repetition another planner begins."""
    keys = ("condition", "family", "seed", "planner", "repeat")
    table = Table(data / "planning_first.csv", keys, ("status", "ms", "length", "optimum", "waypoints", "touches"))
    for condition in conditions:
        names = [name for name in planners if condition == "warm" or name in QUICK]
        if condition == "warm":
            make_tables(names)
        for seed in seeds:
            for family in SINGLE:
                instance = make_instance(family, seed, 1)
                robot, goal = next(iter(instance.scene.assignments.items()))
                optimum = shortest_length(instance.scene, robot, goal)
                for repeat in range(REPEATS):
                    for name in _turned(names, seed + repeat):
                        if name in SLOW and (repeat or seed - seeds.start >= SLOW_SEEDS):
                            continue
                        key = dict(zip(keys, (condition, family, seed, name, repeat)))
                        table.add(key, partial(_first_in, condition, instance, name, optimum, repeat == 0))
            if seed % 10 == 9:
                progress(f"first, {condition}: {seed + 1 - seeds.start} of {len(seeds)} seeds")


def _first_in(condition: str, instance: Instance, name: str, optimum: float, look: bool) -> Record:
    if condition == "cold":
        forget_tables()
    planner = kept_planner(name) if condition == "warm" else new_planner(name)
    return first_plan(instance, planner, optimum, look and condition == "warm")


def _turned(names: Sequence[str], by: int) -> List[str]:
    by %= len(names)
    return [*names[by:], *names[:by]]


def run_fleets(data: Path, seeds: range, planners: Sequence[str], progress: Progress) -> None:
    """Fleets stepped to the end, all planners on the same instances."""
    table = Table(data / "planning_fleets.csv", ("family", "seed", "planner"), STEPPED_COLUMNS)
    for seed in seeds:
        for family in FAMILIES:
            instance = make_instance(family, seed)
            for name in _turned(planners, seed):
                table.add({"family": family, "seed": seed, "planner": name}, partial(stepped, instance, name))
        progress(f"fleets: {seed + 1 - seeds.start} of {len(seeds)} seeds")


def run_growth(data: Path, seeds: range, progress: Progress) -> None:
    """How the time of a step grows with robots, particles and grid size."""
    table = Table(data / "planning_growth.csv", ("what", "value", "seed"), STEPPED_COLUMNS)
    for seed in seeds:
        for value in ROBOTS:
            key = {"what": "robots", "value": value, "seed": seed}
            table.add(key, partial(_grown, "open", seed, value, 200, 333))
        for value in PARTICLES:
            key = {"what": "particles", "value": value, "seed": seed}
            table.add(key, partial(_grown, "table_and_stand", seed, 3, 50, value))
        for value in GRIDS:
            key = {"what": "grid", "value": value, "seed": seed}
            table.add(key, partial(_grown, "open", seed, 3, value, 333))
        progress(f"growth: {seed + 1 - seeds.start} of {len(seeds)} seeds")


def _grown(family: str, seed: int, robots: int, cells: int, particle_count: int) -> Record:
    half = cells / 20.0
    grid = GridSpec((cells, cells, 20), (-half, -half, 0.01), (half, half, 1.3))
    instance = make_instance(family, seed, robots, grid)
    return stepped(instance, "yarm", False, particle_count)


def main() -> int:
    """Run what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("promises", "first", "fleets", "growth", "report"))
    parser.add_argument("--count", type=int, default=0, help=f"seeds; default {COUNTS}")
    parser.add_argument("--seen", action="store_true", help="instances for work on the planners, not those held out")
    parser.add_argument("--conditions", default=",".join(CONDITIONS), help="of the first plans")
    parser.add_argument("--planners", default="", help="of the first plans or the fleets; all unless given")
    parser.add_argument("--data", type=Path, default=ROOT / "bench" / "data", help="folder of the CSV files")
    parser.add_argument("--out", type=Path, default=ROOT / "bench", help="folder of the report")
    options = parser.parse_args()
    began = time.perf_counter()
    planners = [name for name in options.planners.split(",") if name]

    def progress(text: str) -> None:
        print(f"[{time.perf_counter() - began:7.1f} s] {text}", flush=True)

    if options.what == "report":
        progress(f"wrote {write_report(options.data, options.out)}")
        return 0
    start = OFFSETS[options.what] + (0 if options.seen else HELD_OUT)
    seeds = range(start, start + (options.count or COUNTS[options.what]))
    if options.what == "promises":
        run_promises(options.data, seeds, progress)
    elif options.what == "first":
        run_first(options.data, seeds, planners or (*QUICK, *SLOW), options.conditions.split(","), progress)
    elif options.what == "fleets":
        run_fleets(options.data, seeds, planners or FLEET_PLANNERS, progress)
    else:
        run_growth(options.data, seeds, progress)
    return 0


if __name__ == "__main__":
    sys.exit(main())
