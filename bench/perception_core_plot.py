#!/usr/bin/env python3
"""Plots what perception_core_bench printed: compute a set against cameras and against points, both back ends.

Usage::

    devel/lib/yarm/perception_core_bench | tee results/bench/perception_core.log
    python3 bench/perception_core_plot.py results/bench/perception_core.log results/bench/perception_core.png
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Dict, List, Tuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

Row = Tuple[float, float, float]
BUDGET_MS = 1.2
LABELS = {"cameras": "cameras of 102 400 points", "points": "points a set (4 cameras)"}


def read_rows(text: str) -> Dict[str, List[Row]]:
    """Rows of (value, fused ms, pcl ms) by what was varied."""
    rows: Dict[str, List[Row]] = {}
    for line in text.splitlines():
        if line.startswith("csv,"):
            _, name, value, fused, pcl = line.split(",")
            rows.setdefault(name, []).append((float(value), float(fused), float(pcl)))
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
        axis.set_xlabel(LABELS.get(name, name))
        axis.set_ylabel("CPU ms a set, median")
        axis.legend()
        axis.grid(True, which="both", alpha=0.3)
    figure.tight_layout()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=120)


def main() -> int:
    """Read a log, write a picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("log", type=Path, help="output of perception_core_bench")
    parser.add_argument("picture", type=Path, help="PNG to write")
    arguments = parser.parse_args()
    rows = read_rows(arguments.log.read_text())
    if not rows:
        parser.error(f"{arguments.log} holds no plot data (lines that start with csv,)")
    draw(rows, arguments.picture)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
