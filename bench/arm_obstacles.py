#!/usr/bin/env python3
"""The arm's obstacle task over seeds, each method in physics: checkpoints reached, touches, times.

    python3 bench/arm_obstacles.py [--seeds 100] [--others 10]

A seed moves the obstacles by up to 5 mm and draws the planner's chance; each has a process of its own, as OMPL takes
one seed a process, so that a row is the same whichever were made before it. Rows are kept in
bench/data/arm_obstacles.csv: a run that was stopped goes on where it was; the table is of all rows there.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from dataclasses import replace
from pathlib import Path
from typing import Dict, List

import numpy as np
from planning_table import Table, read_rows

from yarm.experiments.coursework.tasks import SPREAD_M
from yarm.experiments.run.tables import markdown_table
from yarm.manipulation.motion.checkpoints import load_arm_scene, moved_obstacles
from yarm.manipulation.obstacles.collision import YoubotCollision
from yarm.manipulation.obstacles.physics import play_task
from yarm.manipulation.obstacles.ways import MARGIN_M, Variant, plan_ways
from yarm.resources import resource

ROWS = Path(__file__).resolve().parent / "data" / "arm_obstacles.csv"
VALUES = ("reached", "wanted", "touches", "simulated_s", "planning_s", "tracking_rad")


def main() -> int:
    """Add the missing rows and print the table."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--seeds", type=int, default=100)
    options.add_argument("--others", type=int, default=10, help="the other methods get so many of the first seeds")
    options.add_argument("--first", type=int, default=1)
    chosen = options.parse_args()
    table = Table(ROWS, ("method", "seed"), VALUES)
    with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as fresh:
        for seed in range(chosen.first, chosen.first + chosen.seeds):
            for variant in Variant if seed < chosen.first + chosen.others else (Variant.YARM,):
                key = {"method": variant.value, "seed": seed}
                table.add(key, lambda v=variant, s=seed: fresh.apply(measured, (v, s)))
    print(summary(read_rows(ROWS)))
    return 0


def measured(variant: Variant, seed: int) -> Dict[str, float]:
    """One method on one seed."""
    scene = load_arm_scene(resource("scenes", "manipulation", "arm_obstacles.yaml"))
    obstacles = tuple(moved_obstacles(scene.obstacles, np.random.default_rng(seed), SPREAD_M))
    scene = replace(scene, obstacles=obstacles)
    YoubotCollision(scene.obstacles).free(np.array(scene.start), MARGIN_M)  # reads the arm's description, once
    begun = time.process_time()
    ways = plan_ways(scene, variant, seed)
    planned = time.process_time() - begun
    played = play_task(scene, ways)
    missed = "; ".join(f"{leg.goal}: {leg.reason}" for leg in played.legs if not leg.reached)
    print(f"{variant.value} {seed}: {played.reached} reached, {played.touches} touches; {missed}", flush=True)
    return {
        "reached": played.reached,
        "wanted": len(scene.checkpoints),
        "touches": played.touches,
        "simulated_s": round(played.duration_s, 2),
        "planning_s": round(planned, 3),
        "tracking_rad": round(played.tracking_rad, 4),
    }


def summary(rows: List[Dict[str, str]]) -> str:
    """A line for each method."""
    lines = []
    for variant in Variant:
        own = [row for row in rows if row["method"] == variant.value]
        if not own:
            continue
        column = {name: np.array([float(row[name]) for row in own]) for name in VALUES}
        whole = int(np.sum((column["reached"] == column["wanted"]) & (column["touches"] == 0)))
        lines.append(
            (
                variant.value,
                str(len(own)),
                f"{100.0 * column['reached'].sum() / column['wanted'].sum():.1f} %",
                f"{column['touches'].sum():.0f} ({column['touches'].max():.0f})",
                f"{whole} of {len(own)}",
                f"{np.median(column['simulated_s']):.1f}",
                f"{np.median(column['planning_s']):.2f} / {np.percentile(column['planning_s'], 99):.2f}",
            )
        )
    header = (
        "method",
        "seeds",
        "checkpoints reached",
        "touches (most)",
        "all five, none touched",
        "simulated s",
        "planning CPU s, p50 / p99",
    )
    return markdown_table(header, lines)


if __name__ == "__main__":
    raise SystemExit(main())
