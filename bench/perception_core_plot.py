#!/usr/bin/env python3
"""Plots what perception_core_bench measured: compute a set against cameras and against points, both back ends.

Usage::

    devel/lib/yarm/perception_core_bench 200 bench/data/perception_core.csv
    python3 bench/perception_core_plot.py bench/data/perception_core.csv bench/perception_core.png
"""

from __future__ import annotations

import argparse
import csv
from collections import defaultdict
from pathlib import Path
from statistics import median
from typing import Dict, List, Tuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

Row = Tuple[float, float, float]
BUDGET_MS = 1.2
LABELS = {"cameras": "cameras of 102 400 points", "points": "points a set (4 cameras)"}


def read_rows(path: Path) -> Dict[str, List[Row]]:
    """Rows of (value, median ms of fused, of pcl) by what was varied."""
    times: Dict[Tuple[str, float, str], List[float]] = defaultdict(list)
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            if row["case"] in LABELS:
                times[row["case"], float(row["value"]), row["backend"]].append(float(row["total_ms"]))
    rows: Dict[str, List[Row]] = {}
    for name, value in sorted({(name, value) for name, value, _ in times}):
        fused, pcl = (median(times[name, value, backend]) for backend in ("fused", "pcl"))
        rows.setdefault(name, []).append((value, fused, pcl))
    return rows


def draw(rows: Dict[str, List[Row]], picture: Path) -> None:
    """One panel for each thing varied, logarithmic in time."""
    figure, axes = plt.subplots(1, len(rows), figsize=(6 * len(rows), 4), squeeze=False)
    for axis, (name, values) in zip(axes[0], sorted(rows.items())):
        x = [row[0] for row in values]
        axis.plot(x, [row[2] for row in values], "s-", label="pcl")
        axis.plot(x, [row[1] for row in values], "o-", label="fused")
        axis.axhline(BUDGET_MS, linestyle=":", color="grey", label="budget for 4 cameras")
        axis.set_yscale("log")
        axis.set_xlabel(LABELS[name])
        axis.set_ylabel("CPU ms a set, median")
        axis.legend()
        axis.grid(True, which="both", alpha=0.3)
    figure.tight_layout()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)


def main() -> int:
    """Read the rows, write a picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, help="CSV of perception_core_bench")
    parser.add_argument("picture", type=Path, help="PNG to write")
    arguments = parser.parse_args()
    rows = read_rows(arguments.rows)
    if not rows:
        parser.error(f"{arguments.rows} holds no rows of {', '.join(LABELS)}")
    draw(rows, arguments.picture)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
