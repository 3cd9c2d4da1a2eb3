#!/usr/bin/env python3
"""How many particles YARM needs among more and more boxes, and its time beside always beginning with all 333.

    source tools/env.sh && python3 bench/clutter.py --seeds 40
    python3 bench/clutter.py --report

First plans of three robots, both kinds of the same planner in turns, each as warm as the other; the least of three
times counts. Rows go to bench/data/planning_clutter.csv, a row that is there is not measured again; the picture to
bench/planning_clutter.png. Columns: boxes, seed, planner; how planning ended; processor time, ms; particles that its
searches needed; length of the robots' ways in all, cells.
"""

from __future__ import annotations

import argparse
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, Dict, List, Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from planning_table import Row, Table, read_rows

from yarm.planning.fleet.yarm_planner import YarmPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.scenes.instances import Instance, make_cluttered

HERE = Path(__file__).resolve().parent
ROWS, PICTURE = HERE / "data" / "planning_clutter.csv", HERE / "planning_clutter.png"
HELD_OUT, WARMING, REPEATS = 1_400_000, 20, 3
BOXES = (0, 2, 4, 6, 8, 10, 12, 14)
PLANNERS = {
    "as needed": PlannerParams(),
    "all 333": PlannerParams(particles_first=PlannerParams.particles),
}
KEYS, VALUES = ("boxes", "seed", "planner"), ("status", "ms", "particles", "length")


def first_plan(planner: YarmPlanner, instance: Instance) -> Dict[str, Any]:
    """The row of one planner on one instance."""
    least_ms = np.inf
    request = instance.scene.request()
    for _ in range(REPEATS):
        planner.reset()
        began = time.process_time()
        plan = planner.plan(request, np.random.default_rng(instance.seed))
        least_ms = min(least_ms, 1e3 * (time.process_time() - began))
    length = sum(entry.length_cells for entry in plan.robots.values())
    return {
        "status": plan.status.value,
        "ms": f"{least_ms:.3f}",
        "particles": plan.particles,
        "length": f"{length:.3f}",
    }


def measure(seeds: int) -> None:
    """Every instance that has no row yet."""
    table, planners = Table(ROWS, KEYS, VALUES), {name: YarmPlanner(params) for name, params in PLANNERS.items()}
    for seed in range(WARMING):
        for planner in planners.values():
            first_plan(planner, make_cluttered(BOXES[seed % len(BOXES)], seed))
    for k in range(seeds):
        for boxes in BOXES:
            instance = make_cluttered(boxes, HELD_OUT + k)
            for name in sorted(planners, reverse=bool(k % 2)):
                key = {"boxes": boxes, "seed": instance.seed, "planner": name}
                table.add(key, partial(first_plan, planners[name], instance))


def of(rows: Sequence[Row], boxes: int, planner: str, column: str) -> List[float]:
    """Values of a column, in the order of the seeds."""
    found = [row for row in rows if int(row["boxes"]) == boxes and row["planner"] == planner]
    return [float(row[column]) for row in sorted(found, key=lambda row: int(row["seed"]))]


def lines(rows: Sequence[Row]) -> List[str]:
    """The table."""
    found = [
        "| boxes | scenes | solved | particles p50 (p90) | ms p50 (p90) | all 333: ms p50 (p90) | length, of theirs |"
    ]
    found.append("|---|---|---|---|---|---|---|")
    ours, fixed = PLANNERS
    for boxes in BOXES:
        lengths = zip(of(rows, boxes, ours, "length"), of(rows, boxes, fixed, "length"))
        share = float(np.mean([a / b for a, b in lengths if b > 0.0]))
        solved = [
            sum(r["status"] == "SOLVED" for r in rows if (r["boxes"], r["planner"]) == (str(boxes), name))
            for name in PLANNERS
        ]
        used = np.percentile(of(rows, boxes, ours, "particles"), [50, 90])
        ms = [np.percentile(of(rows, boxes, name, "ms"), [50, 90]) for name in PLANNERS]
        cells = [f"{used[0]:.0f} ({used[1]:.0f})", *(f"{a:.1f} ({b:.1f})" for a, b in ms), f"{share:.3f}"]
        scenes = len(of(rows, boxes, ours, "ms"))
        found.append(f"| {boxes} | {scenes} | {solved[0]}, {solved[1]} | " + " | ".join(cells) + " |")
    return found


def draw(rows: Sequence[Row], path: Path) -> None:
    """Particles and time against the number of boxes: medians, and shaded from the 10th to the 90th percentile."""
    figure = Figure(figsize=(11.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    for axes, column, names in ((left, "particles", ["as needed"]), (right, "ms", list(PLANNERS))):
        for k, name in enumerate(names):
            low, middle, high = np.array([np.percentile(of(rows, b, name, column), [10, 50, 90]) for b in BOXES]).T
            axes.plot(BOXES, middle, "os"[k] + "-", color=f"C{k}", label=name)
            axes.fill_between(BOXES, low, high, color=f"C{k}", alpha=0.2)
        axes.set_xlabel("boxes among three robots, 50 x 50 columns")
        axes.grid(alpha=0.3)
    left.axhline(PlannerParams.particles, color="0.4", ls="--", label="ceiling")
    left.set_ylim(0.0)
    left.set_ylabel("particles that a first plan needed")
    right.set_yscale("log")
    right.set_ylabel("processor time of a first plan, ms")
    for axes in (left, right):
        axes.legend()
    figure.savefig(str(path), dpi=100)


def main(argv: Sequence[str]) -> int:
    """Measure what is missing, print the table, draw the picture."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=40, help="scenes of each number of boxes")
    parser.add_argument("--report", action="store_true", help="measure nothing")
    options = parser.parse_args(argv)
    if not options.report:
        measure(options.seeds)
    rows = read_rows(ROWS)
    print("\n".join(lines(rows)))
    draw(rows, PICTURE)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
