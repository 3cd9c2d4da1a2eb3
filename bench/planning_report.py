"""Tables and plots of the planning benchmarks."""

from __future__ import annotations

import os
import platform
from collections import defaultdict
from pathlib import Path
from typing import Any, Dict, Iterable, List, Sequence, Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

Record = Dict[str, Any]
LABELS = {
    "robots": "robots (200 x 200 grid, 333 particles)",
    "particles": "particles (3 robots, 50 x 50 grid)",
    "grid": "grid size, cells a side (3 robots, 333 particles)",
}


def write_report(records: Sequence[Record], out: Path) -> Path:
    """Write ``planning.md`` and its plots into a folder; gives the page's path."""
    by_kind: Dict[str, List[Record]] = defaultdict(list)
    for record in records:
        by_kind[record["key"][0]].append(record)
    parts = [
        _INTRODUCTION.format(
            machine=f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
        )
    ]
    if by_kind["families"]:
        parts.append(_families(by_kind["families"]))
    if by_kind["first"]:
        parts.append(_first_plans(by_kind["first"]))
        _plot_first(by_kind["first"], out / "planning_compare.png")
        parts.append("![time and length of first plans](planning_compare.png)\n")
    if by_kind["fleet"]:
        parts.append(_fleets(by_kind["fleet"]))
    growth = {kind: by_kind[kind] for kind in LABELS if by_kind[kind]}
    if growth:
        parts.append(_growth(growth))
        _plot_growth(growth, out / "planning_growth.png")
        parts.append("![growth of a planning step](planning_growth.png)\n")
    page = out / "planning.md"
    page.write_text("\n".join(parts), encoding="utf-8")
    return page


_INTRODUCTION = """# Planning benchmarks

    source tools/env.sh
    python3 bench/planning.py families    # resumable; --count N instances of each family
    python3 bench/planning.py compare
    python3 bench/planning.py growth
    python3 bench/planning.py report      # writes this page

Measured on {machine}. Times are processor time of one planning step (a plan
for the whole fleet). The planners live as long as the run, as the Commander's planner does, and are reset before each
instance. OMPL's searches use the same tables as YARM's and end after 2 s of wall time (so on a busy machine some find
nothing); "1 s" is BIT* given one second of processor time to shorten its path. Touches are found by brute force
(`yarm.planning.bruteforce`), refused steps by the independent checker; neither shares code with the planners.
"""


def _families(records: Sequence[Record]) -> str:
    rows = []
    for family, group in _grouped(records, 1).items():
        solved = sum(r["status"] == "SOLVED" for r in group)
        rows.append(
            [
                family,
                len(group),
                f"{100.0 * solved / len(group):.1f} %",
                sum(r["steps"] for r in group),
                sum(r["refused"] for r in group),
                sum(len(r["touches"]) for r in group),
                f"{np.median([r['steps'] for r in group]):.0f}",
                max(r["steps"] for r in group),
            ]
        )
    head = ["family", "instances", "solved", "steps checked", "refused", "touches", "steps p50", "steps max"]
    title = "## Promises of yarm, stepped to the end\n\nEvery instance is known to be solvable.\n\n"
    return (
        title + _table(head, rows) + "\nEach planning step of these runs, by robots in the cell:\n\n" + _steps(records)
    )


def _steps(records: Sequence[Record]) -> str:
    """Times of single planning steps by the number of robots."""
    rows = []
    for robots in sorted({record["robots"] for record in records}):
        ms = [value for record in records if record["robots"] == robots for value in record["ms"]]
        rows.append([robots, len(ms), *(f"{np.percentile(ms, q):.1f}" for q in (50, 99, 100))])
    return _table(["robots", "plans", "ms p50", "ms p99", "ms max"], rows)


def _first_plans(records: Iterable[Record]) -> str:
    rows = []
    for name, group in _grouped(records, 3).items():
        ms = [r["ms"] for r in group]
        ratios = [r["ratio"] for r in group if r["ratio"] is not None]
        rows.append(
            [
                name,
                len(group),
                f"{100.0 * np.mean([r['status'] == 'SOLVED' for r in group]):.1f} %",
                f"{np.percentile(ms, 50):.1f}",
                f"{np.percentile(ms, 99):.1f}",
                f"{np.median(ratios):.3f}" if ratios else "-",
                f"{np.percentile(ratios, 90):.3f}" if ratios else "-",
                f"{np.median([r['waypoints'] for r in group]):.0f}",
                sum(r["touches"] > 0 for r in group),
            ]
        )
    head = ["planner", "n", "solved", "ms p50", "ms p99", "length p50", "length p90", "waypoints", "paths that touch"]
    text = (
        "## One robot, first plan\n\nOne ankurbot in `open`, `table_and_stand` and `narrow_gaps`, the same instances"
        " for all. Length over the shortest way on the grid's eight neighbours with every turn tried (any-angle paths"
        " may be shorter: below 1).\n\n"
    )
    return text + _table(head, rows)


def _fleets(records: Iterable[Record]) -> str:
    records = list(records)
    families = list(_grouped(records, 1))
    rows = []
    for name, group in _grouped(records, 3).items():
        by_family = _grouped(group, 1)
        solved = [f"{100.0 * np.mean([r['status'] == 'SOLVED' for r in by_family.get(f, [])]):.0f} %" for f in families]
        ms = [ms for r in group for ms in r["ms"]]
        rows.append(
            [
                name,
                *solved,
                f"{np.percentile(ms, 50):.1f}",
                f"{np.percentile(ms, 99):.1f}",
                sum(r["refused"] for r in group),
                sum(len(r["touches"]) for r in group),
            ]
        )
    head = ["planner", *families, "ms p50", "ms p99", "refused", "touches"]
    count = len(records) // max(1, len(rows))
    text = f"## Fleets of 1 to 3, stepped to the end\n\nShare solved by family, {count} instances a planner.\n\n"
    return text + _table(head, rows)


def _growth(growth: Dict[str, List[Record]]) -> str:
    parts = ["## Growth of a planning step\n"]
    for kind, records in growth.items():
        rows = []
        for value, group in sorted(_grouped(records, 1).items()):
            ms = [ms for r in group for ms in r["ms"]]
            solved = 100.0 * np.mean([r["status"] == "SOLVED" for r in group])
            rows.append(
                [value, len(ms), f"{solved:.0f} %", f"{np.percentile(ms, 50):.1f}", f"{np.percentile(ms, 99):.1f}"]
            )
        parts.append(_table([LABELS[kind], "plans", "solved", "ms p50", "ms p99"], rows))
    return "\n".join(parts)


def _plot_first(records: Iterable[Record], path: Path) -> None:
    figure, axes = _figure(1)
    for i, (name, group) in enumerate(_grouped(records, 3).items()):
        solved = [r for r in group if r["ratio"] is not None]
        if solved:
            ms, ratio = np.array([r["ms"] for r in solved]), np.array([r["ratio"] for r in solved])
            axes[0].plot(ms, ratio, ".", ms=4, alpha=0.35, color=f"C{i}")
            axes[0].plot(np.median(ms), np.median(ratio), "D", ms=9, color=f"C{i}", mec="black", label=name)
    axes[0].set_xscale("log")
    axes[0].set_ylim(0.8, 3.0)
    axes[0].set_xlabel("time to the first plan, ms (diamonds: medians)")
    axes[0].set_ylabel("length over the grid's shortest way")
    axes[0].legend()
    axes[0].grid(alpha=0.3)
    figure.savefig(str(path), dpi=100)


def _plot_growth(growth: Dict[str, List[Record]], path: Path) -> None:
    figure, axes = _figure(len(growth))
    for axis, (kind, records) in zip(axes, growth.items()):
        groups = sorted(_grouped(records, 1).items())
        x = [value for value, _ in groups]
        for percent, style in ((50, "o-"), (99, "s--")):
            y = [np.percentile([ms for r in group for ms in r["ms"]], percent) for _, group in groups]
            axis.plot(x, y, style, label=f"p{percent}")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_xticks(x, [str(v) for v in x])
        axis.set_ylim(1.0, 500.0)
        axis.set_yticks([1, 3, 10, 30, 100, 300], ["1", "3", "10", "30", "100", "300"])
        axis.minorticks_off()
        axis.set_xlabel(LABELS[kind])
        axis.set_ylabel("ms a planning step")
        axis.grid(alpha=0.3)
        axis.legend()
    figure.savefig(str(path), dpi=100)


def _figure(count: int) -> Tuple[Figure, List[Any]]:
    figure = Figure(figsize=(6.0 * max(count, 1.4), 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, [figure.add_subplot(1, count, i + 1) for i in range(count)]


def _grouped(records: Iterable[Record], position: int) -> Dict[Any, List[Record]]:
    groups: Dict[Any, List[Record]] = defaultdict(list)
    for record in records:
        groups[record["key"][position]].append(record)
    return dict(groups)


def _table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    lines += ["| " + " | ".join(str(value) for value in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"
