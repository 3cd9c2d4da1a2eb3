"""Tables of bench/joint_search.py from its rows."""

from __future__ import annotations

import os
import platform
from collections import Counter, defaultdict
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import numpy as np
from planning_table import Row

_HEAD = """\
# The complete search for the fleet

    source tools/env.sh
    python3 bench/joint_search.py run --count {count}
    python3 bench/joint_search.py run --crowded --count {crowded} --planners yarm
    python3 bench/joint_search.py report

{instances} held-out instances, of the families of `yarm/planning/scenes/coordination.py` {count} each and of those of
`crowded.py` {crowded} each, stepped to the end by `yarm`, the former by two others too; in {hard} of them no robot
after the other can go to its goal while all others stand (the first that can each time): somebody has to step aside.
`attempts` is `yarm` without the complete search, what it was before; `lacam` is the peer of [planning.md](planning.md).
A run ends after 400 steps, five plans in a row without motion, or 10 s of planning. Times are processor time on
{machine}, shared with other work; the peers ran earlier than `yarm`, on a busier machine,
which favours `yarm` in time (not in what is solved).
"""


def write_report(rows: Sequence[Row], page: Path) -> None:
    """Write the page from the rows of all planners."""
    by: Dict[str, Dict[str, List[Row]]] = defaultdict(lambda: defaultdict(list))
    for row in rows:
        by[row["planner"]][row["family"]].append(row)
    ours = [row for row in rows if row["planner"] == "yarm"]
    families = list(dict.fromkeys(row["family"] for row in ours))
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    counts = Counter(row["family"] for row in ours)
    head = _HEAD.format(
        count=max(counts.values()),
        crowded=min(counts.values()),
        instances=len(ours),
        hard=sum(row["alone"] == "0" for row in ours),
        machine=machine,
    )
    parts = [head, _table(by, families), _costs(by), _refusals(rows), _timeouts(by)]
    page.write_text("\n".join(parts), encoding="utf-8")


def _table(by: Dict[str, Dict[str, List[Row]]], families: Sequence[str]) -> str:
    lines = [
        "## Solved and proved\n",
        "Families with a * have no solution. *One plan* is a run's dearest, *all* their sum.\n",
        "| family | robots | planner | solved | proved | TIMEOUT | plans | one plan ms p50 | p99 | all ms p50 | p99 |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for family in families:
        for name, rows in ((name, by[name][family]) for name in by if by[name][family]):
            robots = sorted({int(row["robots"]) for row in rows})
            status = Counter(row["status"] for row in rows)
            one, every = ([float(row[key]) for row in rows] for key in ("max_ms", "sum_ms"))
            cells = [
                family + ("*" if all(row["least"] == "none" for row in rows) else ""),
                f"{robots[0]} to {robots[-1]}",
                f"`{name}`",
                f"{status['SOLVED']}/{len(rows)}",
                str(status["INFEASIBLE"]),
                str(status["TIMEOUT"]),
                f"{np.median([int(row['plans']) for row in rows]):.0f}",
                *(f"{np.percentile(values, q):.0f}" for values in (one, every) for q in (50, 99)),
            ]
            lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _costs(by: Dict[str, Dict[str, List[Row]]]) -> str:
    lines = [
        "## Cost over the optimum\n",
        "Way and turns of all robots over the least by brute force, where that can be looked through; its moves are of "
        "one cell along an axis, a straight way across is shorter. Each planner over the instances it solved, and over "
        "those that all have solved.\n",
        "| planner | instances | p50 | p90 | greatest |",
        "|---|---|---|---|---|",
    ]
    ratios = {name: _ratios(families) for name, families in by.items()}
    shared = set.intersection(*(set(own) for own in ratios.values()))
    for name, own in ratios.items():
        both = {key: ratio for key, ratio in own.items() if key in shared}
        lines += [_cost_row(f"`{name}`", list(own.values())), _cost_row(f"`{name}`, shared", list(both.values()))]
    return "\n".join(filter(None, lines)) + "\n"


def _ratios(families: Dict[str, List[Row]]) -> Dict[Tuple[str, str], float]:
    """Cost over the least by family and seed, where a run was solved and the least is known and not zero."""
    rows = [row for own in families.values() for row in own if row["status"] == "SOLVED"]
    known = [row for row in rows if row["least"].isdigit() and int(row["least"])]
    return {(row["family"], row["seed"]): float(row["cost"]) / int(row["least"]) for row in known}


def _cost_row(what: str, ratios: Sequence[float]) -> str:
    if not ratios:
        return ""
    p50, p90 = np.percentile(ratios, (50, 90))
    return f"| {what} | {len(ratios)} | {p50:.2f} | {p90:.2f} | {max(ratios):.2f} |"


def _refusals(rows: Sequence[Row]) -> str:
    ours = [row for row in rows if row["planner"] == "yarm"]
    wrong = [row for row in ours if row["status"] == "INFEASIBLE" and row["least"] != "none"]
    return (
        f"`yarm`: {sum(int(row['refused']) for row in ours)} steps refused by the checker, "
        f"{sum(int(row['touches']) for row in ours)} touches found by brute force, {len(wrong)} of "
        f"{sum(row['status'] == 'INFEASIBLE' for row in ours)} proofs wrong.\n"
    )


def _timeouts(by: Dict[str, Dict[str, List[Row]]]) -> str:
    stuck = [row for rows in by["yarm"].values() for row in rows if row["status"] == "TIMEOUT"]
    if not stuck:
        return "No run of `yarm` ended in TIMEOUT.\n"
    lines = ["## Where `yarm` ends in TIMEOUT\n", "| instance | robots | plans | reason |", "|---|---|---|---|"]
    lines += [f"| {r['family']} {r['seed']} | {r['robots']} | {r['plans']} | {r['reason']} |" for r in stuck]
    return "\n".join(lines) + "\n"
