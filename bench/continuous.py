#!/usr/bin/env python3
"""Missions with and without a barrier, side by side: how much sooner the last goal is reached, and what it costs.

    source tools/env.sh && python3 bench/continuous.py --cases 3m 2m1ma --seeds 10
    source tools/env.sh && python3 bench/continuous.py --cases random --seeds 20

The kinematic world of `what if` (docs/experiments.md): the real Commander, planner, checker and control law, bases with
delays and limits but no wheels that slip, exact maps 10 times a second, no cameras. Each seed draws a layout, which is
run with ``execution`` steps, continuous, and, for the lower bound, with each robot alone in the cell and the goals it
reached in the first of these. ``random`` takes the kinds of random cells in turn; what their events bring is there from
the beginning.

Columns of ``bench/data/continuous.csv``: simulated time until the last goal was reached (nan: not cleared); greatest of
the robots' times alone; least clearance; share of the time in which a robot with a goal stands without waiting for
anybody, and in which it waits for others (continuous alone says for whom); steps or releases that the checker refused;
planning time of a plan that took effect; why the mission did not clear.
"""

from __future__ import annotations

import argparse
import csv
import math
import statistics
import sys
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Dict, List, Set

import numpy as np

from yarm.commander.events import ShowPlan, TaskState
from yarm.commander.states import State
from yarm.experiments.what_if.cell import Cell, WhatIfError, cell_of, cell_of_case
from yarm.experiments.what_if.trial import params_of
from yarm.experiments.what_if.world import Fork
from yarm.sim.scenes.random_cell import KINDS, random_cell

EXECUTIONS = ("steps", "continuous")
COLUMNS = (
    "case",
    "seed",
    "execution",
    "clear_s",
    "alone_s",
    "least_m",
    "idle",
    "waits",
    "refusals",
    "plan_p50_ms",
    "plan_p99_ms",
    "why",
)


@dataclass
class Watched:
    """One run, and what was seen of it; times in maps."""

    fork: Fork
    robots: Set[str]
    open_maps: int = 0
    idle_maps: int = 0
    waiting_maps: int = 0
    plans_ms: List[float] = field(default_factory=list)
    reached: Dict[str, str] = field(default_factory=dict)

    def look(self) -> None:
        """Who stands with an open goal, and why."""
        for task in self.fork.commander.status(self.fork.now_s).tasks:
            if task.status is TaskState.REACHED:
                self.reached[task.goal] = task.robot
            if task.robot not in self.robots or task.status not in (TaskState.ASSIGNED, TaskState.MOVING):
                continue
            self.open_maps += 1
            if task.status is TaskState.ASSIGNED:
                waits = task.reason.startswith("waits for ")
                self.waiting_maps += waits
                self.idle_maps += not waits

    def note(self, shown: ShowPlan) -> None:
        """How long a plan took."""
        self.plans_ms.append(shown.plan.planning_ms)


def watched(cell: Cell, execution: str, seed: int, limit_s: float) -> tuple[Watched, str]:
    """One mission, and why it did not clear; empty when it did."""
    rng = np.random.default_rng([seed, 7])
    params = params_of(cell, (("execution", execution), ("give_up_s", "5.0")), seed)
    fork = Fork(cell, params, float(rng.uniform(0.0, 0.9)), rng)
    run = Watched(fork, set(fork.robots))
    fork.on_plan = run.note
    return run, fork.run(State.BOUNDLESS, limit_s, run.look)


def alone_s(cell: Cell, reached: Dict[str, str], seed: int, limit_s: float) -> float:
    """Greatest of the times in which each robot, alone in the cell, reaches the goals it reached; nan: not known."""
    slowest = 0.0
    for robot in cell.robots:
        goals = tuple(goal for goal in cell.goals if reached.get(goal.name) == robot.name)
        if goals:
            run, fault = watched(replace(cell, robots=(robot,), goals=goals), EXECUTIONS[1], seed, limit_s)
            slowest = math.nan if fault else max(slowest, run.fork.done_s)
    return slowest


def cell_for(case: str, seed: int) -> Cell:
    """The layout of a case by its seed."""
    if case != "random":
        return cell_of_case(case, seed)
    return cell_of(random_cell(KINDS[seed % len(KINDS)], seed), f"random {seed}")


def rows_of(case: str, seed: int, limit_s: float) -> List[Dict[str, object]]:
    """Both executions of one layout."""
    cell = cell_for(case, seed)
    rows: List[Dict[str, object]] = []
    bound = math.nan
    for execution in EXECUTIONS:
        run, fault = watched(cell, execution, seed, limit_s)
        if execution == EXECUTIONS[0]:
            bound = alone_s(cell, run.reached, seed, limit_s)
        share = 1.0 / max(1, run.open_maps)
        times = run.plans_ms or [math.nan]
        values = (
            case,
            seed,
            execution,
            f"{math.nan if fault else run.fork.done_s:.2f}",
            f"{bound:.2f}",
            f"{run.fork.least_m:.4f}",
            f"{share * run.idle_maps:.3f}",
            f"{share * run.waiting_maps:.3f}",
            run.fork.refusals,
            f"{np.percentile(times, 50):.1f}",
            f"{np.percentile(times, 99):.1f}",
            fault,
        )
        rows.append(dict(zip(COLUMNS, values)))
    return rows


def summary(case: str, rows: List[Dict[str, object]]) -> str:
    """One line of the table: medians over the seeds that cleared both ways."""
    by = {way: {row["seed"]: row for row in rows if row["execution"] == way} for way in EXECUTIONS}
    steps, other = (by[way] for way in EXECUTIONS)
    both = [s for s in steps if all(math.isfinite(float(str(t[s]["clear_s"]))) for t in (steps, other))]

    def number(row: Dict[str, object], name: str) -> float:
        return float(str(row[name]))

    ratios = [number(other[s], "clear_s") / number(steps[s], "clear_s") for s in both]
    over = [number(other[s], "clear_s") / number(other[s], "alone_s") for s in both if number(other[s], "alone_s") > 0]
    cells = [case, f"{len(both)}/{len(steps)}"]
    for way in (steps, other):
        cells.append(f"{statistics.median([number(way[s], 'clear_s') for s in both]):.1f}" if both else "-")
    cells.append(f"{statistics.median(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})" if ratios else "-")
    cells.append(f"{statistics.median(over):.2f}" if over else "-")
    cells.append(f"{100 * statistics.mean([number(other[s], 'idle') for s in both]):.1f} %" if both else "-")
    cells.append(f"{100 * statistics.mean([number(other[s], 'waits') for s in both]):.1f} %" if both else "-")
    cells.append(" / ".join(f"{min(number(row, 'least_m') for row in way.values()):.4f}" for way in (steps, other)))
    cells.append(" / ".join(str(sum(int(number(row, "refusals")) for row in way.values())) for way in (steps, other)))
    return "| " + " | ".join(cells) + " |"


def main() -> int:
    """Run and print the table; 0 when everything cleared that clears in steps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", nargs="+", default=["3m", "2m1ma", "random"])
    parser.add_argument("--seeds", type=int, default=10, help="so many")
    parser.add_argument("--first", type=int, default=1, help="the first of them")
    parser.add_argument("--limit", type=float, default=300.0, help="simulated seconds for one mission")
    parser.add_argument("--csv", type=Path, default=Path("results") / "continuous.csv")
    options = parser.parse_args()
    table: Dict[str, List[Dict[str, object]]] = {}
    for case in options.cases:
        table[case] = []
        for seed in range(options.first, options.first + options.seeds):
            try:
                found = rows_of(case, seed, options.limit)
            except WhatIfError as error:
                print(f"{case} {seed}: left out: {error}", file=sys.stderr, flush=True)
                continue
            table[case] += found
            for row in found:
                print(", ".join(str(value) for value in row.values()), file=sys.stderr, flush=True)
    options.csv.parent.mkdir(parents=True, exist_ok=True)
    with options.csv.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(row for rows in table.values() for row in rows)
    print("| case | cleared | steps, s | continuous, s | ratio | over alone | idle | waits | least, m | refused |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for case, rows in table.items():
        print(summary(case, rows))
    good = {(row["case"], row["seed"]) for rows in table.values() for row in rows if row["why"] == ""}
    return int(any(row["why"] and (row["case"], row["seed"]) in good for rows in table.values() for row in rows))


if __name__ == "__main__":
    sys.exit(main())
