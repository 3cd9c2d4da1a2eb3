"""Figure 11: what each known fault of the report's program costs, switched on by itself in the same layouts."""

from __future__ import annotations

from pathlib import Path
from typing import Dict, Sequence, Tuple

from yarm.experiments.inspect.fault_trial import KEPT, FaultResult
from yarm.experiments.inspect.switches import PLAIN
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.study.tag_figures import write_rows

HEADER = (
    "variant",
    "right",
    "wrong tags",
    "s, mean",
    "computing, s, mean",
    "goals failed",
    "m, mean",
    "off home at the end, worst",
)


def write_faults(results: Sequence[FaultResult], folder: Path, name: str = "inspect_faults") -> str:
    """Rows and figure of one world's trials, as ``.csv`` and ``.png`` of a name; the table to print."""
    header = ["layout", "variant", "seed", "boxes", *KEPT]
    rows = [[r.spec.layout, r.spec.fault, r.spec.seed, r.boxes, *(r.numbers[name] for name in KEPT)] for r in results]
    write_rows(folder / f"{name}.csv", header, rows)
    totals = [_total(fault, results) for fault in dict.fromkeys(r.spec.fault for r in results)]
    figure, axes = new_figure(12.0, 4.2, 2)
    names = [fault for fault, _ in totals]
    for axis, column, label in zip(axes, ("right", "end_s"), ("boxes read right, of all", "s a round, mean")):
        axis.barh(range(len(names)), [numbers[column] for _, numbers in totals], color="tab:blue")
        axis.axvline(dict(totals)[PLAIN][column], color="tab:grey", ls=":")
        axis.set_yticks(range(len(names)))
        axis.set_yticklabels(names if axis is axes[0] else [""] * len(names), fontsize=8)
        axis.invert_yaxis()
        axis.set(xlabel=label)
    save_figure(figure, folder / f"{name}.png")
    lines = [
        (
            fault,
            f"{n['right']:.0f} of {n['boxes']:.0f}",
            f"{n['named_wrong']:.0f}",
            f"{n['end_s']:.0f}",
            f"{n['computing_s']:.1f}",
            f"{n['goals_failed']:.0f}",
            f"{n['distance_m']:.1f}",
            f"{n['home_m']:.2f} m, {n['home_rad']:.2f} rad",
        )
        for fault, n in totals
    ]
    return markdown_table(HEADER, lines)


def _total(fault: str, results: Sequence[FaultResult]) -> Tuple[str, Dict[str, float]]:
    """Of one variant over its layouts: sums of counts, means of times and lengths, the worst end."""
    mine = [r for r in results if r.spec.fault == fault]
    found = {name: sum(r.numbers[name] for r in mine) for name in ("right", "named_wrong", "goals_failed")}
    found["boxes"] = float(sum(r.boxes for r in mine))
    for name in ("end_s", "distance_m", "computing_s"):
        found[name] = sum(r.numbers[name] for r in mine) / max(1, len(mine))
    for name in ("home_m", "home_rad"):
        found[name] = max(r.numbers[name] for r in mine)
    return fault, found
