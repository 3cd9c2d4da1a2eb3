#!/usr/bin/env python3
"""Plots what robustness_bench measured: shares of points given to the right object against each error.

Usage::

    make -C build robustness_bench
    devel/lib/yarm/robustness_bench 1 bench/data/robustness.csv
    python3 bench/robustness_plot.py bench/data/robustness.csv bench/robustness.png
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import defaultdict
from pathlib import Path
from statistics import mean
from typing import Dict, List, Tuple

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

Curve = List[Tuple[float, float, float, float]]
APART, CONTACT = 0.97, 0.92
"""What is wanted of robots nobody drew; here a line to read the curves by."""
ZERO = "pose"
"""The error whose level 0 is measured; the other curves begin there, too."""


def read_curves(path: Path) -> Tuple[Dict[Tuple[str, str], Curve], Curve]:
    """(level, apart, contact, sets with a phantom) by error and unit; and that of robots nobody drew."""
    rows: Dict[Tuple[str, str, float], List[Tuple[float, float, float]]] = defaultdict(list)
    with path.open(newline="") as file:
        for row in csv.DictReader(file):
            found = float(row["apart"]), float(row["contact"]), float(row["phantom_sets"])
            rows[row["error"], row["unit"], float(row["level"])].append(found)
    curves: Dict[Tuple[str, str], Curve] = defaultdict(list)
    for (error, unit, level), found in rows.items():
        apart, contact, phantoms = (mean(column) for column in zip(*found))
        curves[error, unit].append((level, apart, contact, phantoms))
    start = [point for point in curves.get((ZERO, "mm"), []) if point[0] == 0.0]
    undrawn = curves.pop(("robots undrawn", ""), [])
    for key, curve in curves.items():
        curves[key] = sorted(curve if key[0] == ZERO else [*start, *curve])
    return dict(curves), undrawn


def table(curves: Dict[Tuple[str, str], Curve], undrawn: Curve) -> str:
    """Markdown of all points."""
    lines = ["| error | apart, % | in contact, % | sets with a phantom, of 168 |", "|---|---|---|---|"]
    for (error, unit), curve in curves.items():
        for level, apart, contact, phantoms in curve:
            lines.append(f"| {error} {level:g} {unit} | {100 * apart:.1f} | {100 * contact:.1f} | {phantoms:.0f} |")
    lines += [f"| robots undrawn | {100 * a:.1f} | {100 * c:.1f} | {p:.0f} |" for _, a, c, p in undrawn]
    return "\n".join(lines) + "\n"


def draw(curves: Dict[Tuple[str, str], Curve], picture: Path) -> None:
    """A panel for each error."""
    figure, axes = plt.subplots(2, (len(curves) + 1) // 2, figsize=(14, 7), sharey=True, squeeze=False)
    for axis, ((error, unit), curve) in zip(axes.flat, curves.items()):
        levels = [point[0] for point in curve]
        axis.plot(levels, [100 * point[1] for point in curve], "o-", label="apart")
        axis.plot(levels, [100 * point[2] for point in curve], "s--", label="in contact")
        axis.axhline(100 * APART, linestyle=":", color="C0", linewidth=1)
        axis.axhline(100 * CONTACT, linestyle=":", color="C1", linewidth=1)
        axis.set_xlabel(f"{error}, {unit}")
        axis.set_ylim(40, 101)
        axis.grid(alpha=0.3)
    for axis in axes[:, 0]:
        axis.set_ylabel("points given to the right object, %")
    for axis in list(axes.flat)[len(curves) :]:
        axis.set_visible(False)
    axes[0][0].legend(loc="lower left")
    figure.tight_layout()
    picture.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(picture, dpi=110)


def main() -> int:
    """Read the rows, write a picture, print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rows", type=Path, help="CSV of robustness_bench")
    parser.add_argument("picture", type=Path, help="PNG to write")
    arguments = parser.parse_args()
    curves, undrawn = read_curves(arguments.rows)
    if not curves:
        parser.error(f"{arguments.rows} holds no rows")
    draw(curves, arguments.picture)
    sys.stdout.write(table(curves, undrawn))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
