"""Tables and plots of the planning benchmarks, from the rows in bench/data."""

from __future__ import annotations

import os
import platform
from collections import defaultdict
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Sequence, Tuple

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from planning_table import Row, read_rows

Floats = npt.NDArray[np.float64]
Instance = Tuple[str, str]
"""Family and seed."""
RESAMPLES = 1000
OURS = "yarm"
HEAD_ON = "corridors_head_on"
LABELS = {
    "robots": "robots (200 x 200 grid, 333 particles)",
    "particles": "particles (3 robots, 50 x 50 grid)",
    "grid": "grid size, cells a side (3 robots, 333 particles)",
}
CONDITIONS = {
    "warm": "Warm: planners that have planned before, as in a mission; every table that robot and grid allow is there",
    "new": "New: a planner made for this plan; its own tables of shapes are empty, the grid's are there",
    "cold": "Cold: no table anywhere, as in the first plan after a start",
}
_INTRODUCTION = """# Planning benchmarks

    source tools/env.sh
    python3 bench/planning.py promises    # resumable; --count N instances of each family
    python3 bench/planning.py first
    python3 bench/planning.py fleets
    python3 bench/planning.py growth
    python3 bench/planning.py report      # writes this page from bench/data/*.csv

Measured on {machine}, shared with other work that kept it busy all the time. Times are processor
time, longer than on an idle machine; planners take turns on each instance, and what holds is how they compare.
[method.md](method.md) says for each figure what was measured and whom it favours. Intervals in brackets are 95 %
bootstrap intervals over instances.
"""


def write_report(data: Path, out: Path) -> Path:
    """Write ``planning.md`` and its plots into a folder from the rows of another; gives the page's path."""
    names = ("first", "fleets", "promises", "growth")
    rows = {name: read_rows(data / f"planning_{name}.csv") for name in names}
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    parts = [_INTRODUCTION.format(machine=machine)]
    if rows["first"]:
        parts.append(_first_plans(rows["first"]))
        _plot_first(rows["first"], out / "planning_compare.png")
        parts.append("![time and length of first plans](planning_compare.png)\n")
    if rows["fleets"]:
        parts.append(_fleets(rows["fleets"]))
    if rows["promises"]:
        parts.append(_promises(rows["promises"]))
    if rows["growth"]:
        parts.append(_growth(rows["growth"]))
        _plot_growth(rows["growth"], out / "planning_growth.png")
        parts.append("![growth of a planning step](planning_growth.png)\n")
    page = out / "planning.md"
    page.write_text("\n".join(parts), encoding="utf-8")
    return page


def _interval(of: Callable[[Floats], float], values: Floats) -> str:
    """A statistic with its bootstrap interval."""
    rng = np.random.default_rng(0)
    drawn = [of(values[rng.integers(len(values), size=len(values))]) for _ in range(RESAMPLES)]
    low, high = np.percentile(drawn, (2.5, 97.5))
    return f"{of(values):.2f} [{low:.2f}, {high:.2f}]"


def _percentile(percent: float) -> Callable[[Floats], float]:
    return lambda values: float(np.percentile(values, percent))


class _Firsts:
    """First plans of one condition: the least time of each planner on each instance, and what it found there."""

    def __init__(self, rows: Iterable[Row]) -> None:
        self.ms: Dict[str, Dict[Instance, float]] = defaultdict(dict)
        self.row: Dict[str, Dict[Instance, Row]] = defaultdict(dict)
        for row in rows:
            instance, planner, ms = (row["family"], row["seed"]), row["planner"], float(row["ms"])
            self.ms[planner][instance] = min(ms, self.ms[planner].get(instance, np.inf))
            if row["repeat"] == "0":
                self.row[planner][instance] = row

    def common(self, planners: Iterable[str]) -> List[Instance]:
        """Instances that all of some planners were given."""
        sets = [set(self.ms[planner]) for planner in planners]
        return sorted(set.intersection(*sets)) if sets else []

    def times(self, planner: str, instances: Sequence[Instance]) -> Floats:
        """Least times, ms."""
        return np.array([self.ms[planner][instance] for instance in instances])

    def ratios(self, planner: str, instances: Sequence[Instance]) -> Floats:
        """Lengths of the paths found over the shortest on the grid."""
        rows = [self.row[planner][instance] for instance in instances]
        found = [(float(r["length"]), float(r["optimum"])) for r in rows if r["length"]]
        return np.array([length / optimum for length, optimum in found if optimum > 0.0])


def _first_plans(rows: Sequence[Row]) -> str:
    parts = [
        "## One robot, first plan\n\nOne ankurbot in `open`, `table_and_stand` and `narrow_gaps`, the same instances"
        " for all planners of a table. *Ratio* is the planner's time over yarm's on the same instance, the median of"
        " all; *yarm quicker* the share of instances. `request` is what every planner does before it searches: the"
        " request's checks and the map's tables. Length is over the shortest way on the grid's eight neighbours with"
        " every turn tried (any-angle paths may be shorter: below 1); *simplified* is what compares with yarm, whose"
        " paths are always pulled tight.\n"
    ]
    for condition, text in CONDITIONS.items():
        firsts = _Firsts(row for row in rows if row["condition"] == condition)
        if not firsts.ms:
            continue
        most = max(len(times) for times in firsts.ms.values())
        parts.append(f"### {text}\n")
        parts.append(_first_table(firsts, [p for p, t in firsts.ms.items() if len(t) == most], condition == "warm"))
        if any(len(times) < most for times in firsts.ms.values()):
            parts.append("The slow planners too, on the first of these instances, each plan made once:\n")
            parts.append(_first_table(firsts, list(firsts.ms), True))
    return "\n".join(parts)


def _first_table(firsts: _Firsts, planners: Sequence[str], with_paths: bool) -> str:
    instances = firsts.common(planners)
    ours = firsts.times(OURS, instances)
    table = []
    for planner in sorted(planners, key=lambda p: (p != OURS, p == "request", p)):
        times = firsts.times(planner, instances)
        rows = [firsts.row[planner][instance] for instance in instances]
        quotient = times / ours
        is_ours = planner in (OURS, "request")
        line: List[Any] = [
            planner,
            len(times),
            _interval(_percentile(50), times),
            _interval(_percentile(90), times),
            _interval(_percentile(99), times),
            "" if is_ours else _interval(_percentile(50), quotient),
            "" if is_ours else f"{100.0 * np.mean(quotient > 1.0):.0f} %",
        ]
        if with_paths:
            line += _path_columns(rows, firsts.ratios(planner, instances))
        table.append(line)
    head = ["planner", "n", "ms p50", "ms p90", "ms p99", "ratio", "yarm quicker"]
    if with_paths:
        head += ["solved", "length p50", "length p90", "waypoints", "paths that touch"]
    return _table(head, table)


def _path_columns(rows: Sequence[Row], ratios: Floats) -> List[str]:
    if not len(ratios):
        return [""] * 5
    return [
        f"{100.0 * np.mean([r['status'] == 'SOLVED' for r in rows]):.1f} %",
        f"{np.median(ratios):.3f}",
        f"{np.percentile(ratios, 90):.3f}",
        f"{np.median([float(r['waypoints']) for r in rows]):.0f}",
        str(sum(r["touches"] not in ("", "0") for r in rows)),
    ]


def _fleets(rows: Sequence[Row]) -> str:
    by_planner: Dict[str, Dict[Instance, Row]] = defaultdict(dict)
    for row in rows:
        by_planner[row["planner"]][row["family"], row["seed"]] = row
    instances = sorted(set.intersection(*(set(found) for found in by_planner.values())))
    families = sorted({family for family, _ in instances}, key=lambda f: (f == HEAD_ON, f))
    counts = ", ".join(f"{sum(f == family for f, _ in instances)} {family}" for family in families)
    others = [instance for instance in instances if instance[0] != HEAD_ON]
    table = []
    for planner in sorted(by_planner, key=lambda p: (p != OURS, p)):
        found = by_planner[planner]
        ms = np.array([float(v) for i in instances for v in found[i]["ms"].split()])
        first = np.array([float(found[i]["ms"].split()[0]) for i in instances])
        shares = [_share([found[i] for i in instances if i[0] == family]) for family in families]
        costs = _against_ours(by_planner, planner, instances)
        table.append(
            [
                planner,
                *shares,
                _share([found[i] for i in others]),
                _share([found[i] for i in instances]),
                *costs,
                *(f"{np.percentile(first, q):.1f}" for q in (50, 90)),
                *(f"{np.percentile(ms, q):.1f}" for q in (50, 90, 99)),
                sum(int(found[i]["refused"]) for i in instances),
                sum(int(found[i]["touches"]) for i in instances),
            ]
        )
    head = ["planner", *families, "without head-on", "all", "solved by both", "way", "makespan"]
    head += ["first plan ms p50", "p90", "any plan ms p50", "p90", "p99", "steps refused", "steps that touch"]
    text = (
        f"## Fleets of 1 to 3, stepped to the end\n\nThe same {len(instances)} instances for every planner ({counts}),"
        " all known to be solvable, at most 200 steps each for all. A step that the checker refuses is not made, so a"
        " planner that gives unsafe steps stands still and does not arrive; `original unchecked` makes them all the"
        " same, and its touches are counted by brute force. `ma_astar` and `ompl_rrtconnect` plan one robot at a time"
        f" and nobody gives way, so `{HEAD_ON}` is 0 % for them by construction; the next column leaves it out."
        " *Way* (of all robots together) and *makespan* are sums over the instances that both this planner and yarm"
        " solved, over yarm's. The planners that keep their plan (yarm, lacam, ompl_joint_rrtconnect) search in few"
        " of their planning steps, mostly in the first.\n\n"
    )
    return text + _table(head, table)


def _share(rows: Sequence[Row]) -> str:
    return f"{100.0 * np.mean([row['status'] == 'SOLVED' for row in rows]):.0f} %" if rows else "-"


def _against_ours(by_planner: Dict[str, Dict[Instance, Row]], planner: str, instances: Sequence[Instance]) -> List[str]:
    mine, ours = by_planner[planner], by_planner[OURS]
    both = [i for i in instances if mine[i]["status"] == ours[i]["status"] == "SOLVED"]
    if not both:
        return ["0", "-", "-"]
    sums = [sum(float(side[i][what]) for i in both) for what in ("cost", "makespan") for side in (mine, ours)]
    return [str(len(both)), f"{sums[0] / sums[1]:.2f}", f"{sums[2] / sums[3]:.2f}"]


def _promises(rows: Sequence[Row]) -> str:
    table = []
    for family, group in _grouped(rows, "family").items():
        table.append(
            [
                family,
                len(group),
                f"{100.0 * np.mean([r['status'] == 'SOLVED' for r in group]):.1f} %",
                sum(int(r["steps"]) for r in group),
                sum(int(r["refused"]) for r in group),
                sum(int(r["touches"]) for r in group),
                f"{np.median([int(r['steps']) for r in group]):.0f}",
                max(int(r["steps"]) for r in group),
            ]
        )
    head = ["family", "instances", "solved", "steps checked", "refused", "touches", "steps p50", "steps max"]
    steps = []
    for robots, group in sorted(_grouped(rows, "robots").items()):
        ms = np.array([float(v) for r in group for v in r["ms"].split()])
        steps.append([robots, len(ms), *(f"{np.percentile(ms, q):.1f}" for q in (50, 90, 99, 100))])
    return (
        "## Promises of yarm, stepped to the end\n\nEvery instance is known to be solvable; they are not those of the"
        " tables above.\n\n"
        + _table(head, table)
        + "\nEach planning step of these runs, by robots in the cell:\n\n"
        + _table(["robots", "plans", "ms p50", "ms p90", "ms p99", "ms max"], steps)
    )


def _growth(rows: Sequence[Row]) -> str:
    seeds = len({row["seed"] for row in rows})
    parts = [
        f"## Growth of a planning step\n\nScenes of {seeds} seed{'s' * (seeds > 1)} for each value. The first plan of a"
        " scene is searched for, later ones are mostly the remembered one carried on; where the first search finds no"
        " plan for all, those robots move that can, and the next steps search too (*steps that searched*).\n"
    ]
    for what, label in LABELS.items():
        table = []
        for value, group in _by_value(rows, what):
            all_ms = [[float(v) for v in r["ms"].split()] for r in group]
            first, ms = [of_scene[0] for of_scene in all_ms], [v for of_scene in all_ms for v in of_scene]
            solved = 100.0 * np.mean([r["status"] == "SOLVED" for r in group])
            searched = sum(int(r["searched"]) for r in group)
            times = [f"{np.percentile(first, 50):.1f}", f"{np.percentile(ms, 50):.1f}", f"{np.percentile(ms, 99):.1f}"]
            table.append([value, len(group), f"{solved:.0f} %", len(ms), searched, *times])
        head = [label, "scenes", "solved", "plans", "steps that searched", "first plan ms p50", "any ms p50", "ms p99"]
        parts.append(_table(head, table))
    return "\n".join(parts)


def _by_value(rows: Sequence[Row], what: str) -> List[Tuple[int, List[Row]]]:
    chosen = [row for row in rows if row["what"] == what]
    return sorted((int(value), group) for value, group in _grouped(chosen, "value").items())


def _plot_first(rows: Sequence[Row], path: Path) -> None:
    firsts = _Firsts(row for row in rows if row["condition"] == "warm")
    figure, axes = _figure(1)
    for i, planner in enumerate(p for p in firsts.ms if p != "request"):
        found = [(firsts.ms[planner][k], r) for k, r in firsts.row[planner].items() if r["length"]]
        ms = np.array([time for time, _ in found])
        ratio = np.array([float(r["length"]) / max(float(r["optimum"]), 1e-9) for _, r in found])
        if len(ms):
            axes[0].plot(ms, ratio, ".", ms=4, alpha=0.35, color=f"C{i}")
            axes[0].plot(np.median(ms), np.median(ratio), "D", ms=9, color=f"C{i}", mec="black", label=planner)
    axes[0].set_xscale("log")
    axes[0].set_ylim(0.8, 3.0)
    axes[0].set_xlabel("processor time to the first plan, warm, ms (diamonds: medians)")
    axes[0].set_ylabel("length over the grid's shortest way")
    axes[0].legend()
    axes[0].grid(alpha=0.3)
    figure.savefig(str(path), dpi=100)


def _plot_growth(rows: Sequence[Row], path: Path) -> None:
    figure, axes = _figure(len(LABELS))
    for axis, (what, label) in zip(axes, LABELS.items()):
        groups = _by_value(rows, what)
        x = [value for value, _ in groups]
        for percent, style in ((50, "o-"), (99, "s--")):
            y = [np.percentile([float(v) for r in group for v in r["ms"].split()], percent) for _, group in groups]
            axis.plot(x, y, style, label=f"p{percent}")
        axis.set_xscale("log")
        axis.set_yscale("log")
        axis.set_ylim(1.0, 4000.0)
        axis.set_yticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])
        axis.set_xticks(x, [str(v) for v in x])
        axis.minorticks_off()
        axis.set_xlabel(label)
        axis.set_ylabel("processor time of a planning step, ms")
        axis.grid(alpha=0.3)
        axis.legend()
    figure.savefig(str(path), dpi=100)


def _figure(count: int) -> Tuple[Figure, List[Any]]:
    figure = Figure(figsize=(6.0 * max(count, 1.4), 4.5), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, [figure.add_subplot(1, count, i + 1) for i in range(count)]


def _grouped(rows: Iterable[Row], column: str) -> Dict[str, List[Row]]:
    groups: Dict[str, List[Row]] = defaultdict(list)
    for row in rows:
        groups[row[column]].append(row)
    return dict(groups)


def _table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head)]
    lines += ["| " + " | ".join(str(value) for value in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"
