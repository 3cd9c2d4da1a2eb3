#!/usr/bin/env python3
"""Whole missions in full physics over many seeds: how often they succeed, and why not when they do not.

    source tools/env.sh && python3 bench/missions.py --seeds 20
    python3 bench/missions.py --cells 1000
    python3 bench/missions.py --cells 1000 --kinematic

Runs in lock-step, so that a slow machine changes nothing but the wall time; a run whose results stand in the folder is
not run again, so an interrupted study goes on where it was. 1m1ma and 2m1ma run as published, without hands: reached
debris is deleted. The seed also lays out the scene: starts, debris, slips and
targets (docs/simulation.md); the layout of each run is in its summary.yaml. Ends with one row a case: successes, 95 %
confidence interval (Wilson), waypoints, simulated time, least clearance, faults; a row a run goes to a CSV file.
With ``--cells`` random cells are run in place of the cases, every kind in turn (docs/simulation.md, "Random cells"):
``cells.md`` in the folder has the share that failed, with its interval, and each failure with its seed and why.
With ``--kinematic`` besides they are run as the tests run some, in ``kinematic`` below the folder: the real Commander,
task queue, planner and checker, the cell's fleet, goals, obstacles and events, but no physics, no cameras, no nodes, no
person: robots go exactly where they are sent, maps are exact, and a touch is cells of two things that overlap.
"""

from __future__ import annotations

import argparse
import csv
import os
import statistics
import sys
import time
from pathlib import Path
from typing import Any, Dict, List, Sequence

import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from python.commander.random_mission import run_cell
from yarm.commander.params import Removal
from yarm.experiments.cells.study import cells, run_study
from yarm.experiments.run.cases import case_of
from yarm.experiments.run.writers import is_finished
from yarm.experiments.statistics import wilson_interval
from yarm.experiments.study.reproduce import ProgressBar
from yarm.ros.experiment.launcher import run as run_experiment

CASES = ("1m1ma", "2m1ma", "3m", "1m1ma_bin", "2m1ma_bin", "3m6_bin")


def summaries(results: Path, case: str, seeds: range, limit_s: float, flags: Sequence[str]) -> List[Dict[str, Any]]:
    """Summary of each seed of a case; those that are missing are run first."""
    found = []
    for seed in seeds:
        path = results / case / str(seed) / "summary.yaml"
        if not is_finished(path.parent):
            started = time.monotonic()
            words = ["--case", case, "--seed", str(seed), "--sync", "--speed", "0", "--results", str(results)]
            published = ["--removal", Removal.DELETE.value] if case_of(case).with_bin else []
            code = run_experiment([*words, *published, *flags, "--wall-limit", str(limit_s)])
            print(f"{case} seed {seed}: exit code {code} after {time.monotonic() - started:.0f} s", flush=True)
        read = yaml.safe_load(path.read_text()) if path.is_file() else {}
        found.append({"seed": seed, "success": False, "faults": ["no results were written"], **(read or {})})
    return found


COLUMNS = ("case", "layout", "seed", "success", "sim_s", "waypoints", "path_m", "clearance_m", "pauses", "faults")


def write_csv(path: Path, layout: str, table: Dict[str, List[Dict[str, Any]]]) -> None:
    """A row a run; ``waypoints`` and ``path_m`` of all robots together, ``clearance_m`` the least of any."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        for case, runs in table.items():
            for run in runs:
                robots = list(run.get("robots", {}).values())
                near = [robot["min_clearance_m"] for robot in robots if robot["min_clearance_m"] is not None]
                waypoints, way = (sum(robot[what] for robot in robots) for what in ("waypoints", "path_m"))
                known = [run.get("sim_s", ""), waypoints, round(way, 2), min(near, default="")]
                said = [len(run.get("pauses", [])), "; ".join(run["faults"])]
                rows.writerow([case, layout, run["seed"], run["success"], *known, *said])


def row(case: str, runs: List[Dict[str, Any]]) -> str:
    """One line of the table."""
    good = [run for run in runs if run["success"]]
    low, high = wilson_interval(len(good), len(runs))
    robots = [robot for run in good for robot in run["robots"].values()]
    waypoints = [robot["waypoints"] for robot in robots]
    near = [robot["min_clearance_m"] for robot in robots if robot["min_clearance_m"] is not None]
    cells = [
        case,
        f"{len(good)}/{len(runs)}",
        f"{100 * low:.0f} to {100 * high:.0f} %",
        f"{statistics.median(waypoints):.0f}" if waypoints else "-",
        f"{statistics.median([run['sim_s'] for run in good]):.1f}" if good else "-",
        f"{min(near):.3f}" if near else "-",
    ]
    return "| " + " | ".join(cells) + " |"


ABOUT = (
    "Random cells without physics: the Commander, its task queue, planner and checker decide; robots go exactly where "
    "they are sent, maps are exact, no camera fails and nobody walks. A touch is cells of two things that overlap."
)


def random_cells(options: argparse.Namespace) -> int:
    """The study of random cells (``reproduce --study cells``) in this folder; 0 when every one of them went well."""
    folder = options.results / "kinematic" if options.kinematic else options.results
    if options.kinematic:
        workers = options.workers or os.cpu_count() or 1
        print(run_study(run_cell, options, folder, workers, ProgressBar("cells"), ABOUT))
    else:
        print(cells(options, folder, ProgressBar))
    with (folder / "cells.csv").open(newline="", encoding="utf-8") as file:
        return 0 if all(row["success"] == "1" for row in csv.DictReader(file)) else 1


def main() -> int:
    """Run what is missing and print the table; 0 when every mission succeeded."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, help="seeds 1 to this many")
    parser.add_argument("--cases", nargs="+", default=list(CASES))
    parser.add_argument("--results", type=Path, default=Path("results") / "missions")
    parser.add_argument("--limit", type=float, default=900.0, help="wall seconds for one mission")
    parser.add_argument("--nominal", action="store_true", help="the layout of the scene file whatever the seed")
    parser.add_argument("--csv", type=Path, default=Path("results") / "missions" / "missions.csv")
    parser.add_argument("--cells", type=int, default=0, help="so many random cells in place of the cases")
    parser.add_argument("--kinematic", action="store_true", help="the cells without physics")
    parser.add_argument(
        "--workers", type=int, default=0, help="cells at a time; 0: one for two cores, one a core without physics"
    )
    parser.add_argument("--scheduler", default="", help="address of a Dask scheduler for the cells; default: here")
    options = parser.parse_args()
    if options.cells:
        return random_cells(options)
    flags = ["--nominal"] if options.nominal else []
    seeds = range(1, options.seeds + 1)
    table = {case: summaries(options.results, case, seeds, options.limit, flags) for case in options.cases}
    write_csv(options.csv, "nominal" if options.nominal else "seed", table)
    print("| case | solved | 95 % interval | waypoints a robot | simulated s | least clearance, m |")
    print("|---|---|---|---|---|---|")
    for case, runs in table.items():
        print(row(case, runs))
    failed = [(case, run) for case, runs in table.items() for run in runs if not run["success"]]
    for case, run in failed:
        print(f"{case} seed {run['seed']} failed: " + "; ".join(run["faults"]))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
