"""Tables and figures of the exploration study, each with its CSV."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, List, Sequence

import numpy as np

from yarm.experiments.explore.ablation import write_ablation, write_fault_costs
from yarm.experiments.explore.figure_parts import box_figure, number_text, write_csv
from yarm.experiments.explore.pictures import draw_run, title_of
from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.explore.study import (
    TABLE_HEADER,
    by_variant,
    starts_in_contact,
    table_rows,
    targets,
)
from yarm.experiments.explore.trial import CURVE_STEP_S, ExploreResult, judge_of
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table

TARGET_HEADER = ("target", "measured", "met")
MAPPED_IN_PRACTICE = ("report_printed", "report", "yarm")
"""Figure 1 shows their final maps of `practice`."""
BUMP_TICKS = (0, 1, 2, 5, 10, 20, 50, 100, 200)
WAY_PASSES = 10
"""Every n-th pass of a way is written with a figure."""


def write_study(
    results: Sequence[ExploreResult], ablation: Sequence[ExploreResult], mended: Sequence[ExploreResult], folder: Path
) -> str:
    """All tables and figures of the trials; the text to print.

    Args:
        results: of whole controllers.
        ablation: of `report` without something.
        mended: of `report_printed` without faults.
        folder: where to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_trials([*results, *ablation, *mended], folder / "explore_trials.csv")
    table = markdown_table(TABLE_HEADER, table_rows(results))
    asked = [(t.text, t.measured, "yes" if t.met else "NO") for t in targets(results)]
    goals = markdown_table(TARGET_HEADER, asked)
    (folder / "explore_table.md").write_text(f"{table}\n\n{goals}\n")
    write_csv(folder / "explore_table.csv", TABLE_HEADER, table_rows(results))
    plot_coverage(results, folder)
    plot_faults(results, folder)
    plot_contact_starts(results, folder)
    parts = (write_ablation(results, ablation, folder), write_fault_costs(results, mended, folder))
    return "\n\n".join([table, goals, *(part for part in parts if part)])


def write_trials(results: Sequence[ExploreResult], path: Path) -> None:
    """One line a trial."""
    header = ["arena", "controller", "without", "seed", "share", "t90_s", "t95_s", "t99_s", "end_s", "done"]
    header += ["distance_m", "turning_rad", "bumps", "bumped_again", "fastest_bump", "too_fast_s", "too_fast_near_s"]
    header += ["standing", "early", "wall_mean_m", "wall_p95_m", "tall", "tall_detected", "low", "low_detected"]
    header += ["low_untouched", "freed_s", "step_p50_ms", "step_p99_ms", "reason"]
    rows: List[List[Any]] = []
    for r in results:
        s, m = r.spec, r.measures
        row: List[Any] = [s.arena, s.controller, s.without, s.seed, f"{m.share:.5f}", *m.times, r.end_s, int(r.done)]
        row += [f"{m.distance_m:.2f}", f"{m.turning_rad:.1f}", m.bumps, m.bumped_again, f"{m.fastest_bump:.3f}"]
        row += [f"{m.too_fast_s:.1f}", f"{m.too_fast_near_s:.1f}", int(m.standing), int(m.early)]
        row += [f"{m.wall.mean_m:.4f}", f"{m.wall.p95_m:.4f}", m.tall.count, m.tall.detected]
        row += [m.low.count, m.low.detected, m.low.untouched, r.freed_s]
        rows.append([*row, f"{m.step_p50_ms:.2f}", f"{m.step_p99_ms:.2f}", r.reason])
    write_csv(path, header, rows)


def plot_final_maps(records: Sequence[ExploreRecord], path: Path) -> Path:
    """Figure 1: final maps over the true walls, side by side; and what is drawn, as a CSV of the same name."""
    figure, axes = new_figure(5.2 * max(1, len(records)), 5.4, max(1, len(records)))
    for axis, record in zip(axes, records):
        draw_run(axis, record, judge_of(record.arena).arena)
        share = record.coverage[-1].share if record.coverage else math.nan
        axis.set_title(f"{title_of(record)}: {100 * share:.1f} % at {record.end_s:.0f} s", fontsize="medium")
    rows = [row for record in records for row in _drawn_rows(record)]
    write_csv(path.with_suffix(".csv"), ("controller", "what", "t_s", "x", "y"), rows)
    return save_figure(figure, path)


def _drawn_rows(record: ExploreRecord) -> List[Sequence[Any]]:
    """The occupied cells at the end, the way second by second, the bumps; world, metres."""
    points = judge_of(record.arena).occupied_points(record.map, record.world_from_map) if record.map is not None else ()
    rows: List[Sequence[Any]] = [
        *(("occupied", f"{record.end_s:.1f}", f"{x:.3f}", f"{y:.3f}") for x, y in points),
        *(("way", f"{p.t_s:.1f}", f"{p.true_x:.3f}", f"{p.true_y:.3f}") for p in record.path[::WAY_PASSES]),
        *(("bump", f"{t.t_s:.1f}", f"{t.x:.3f}", f"{t.y:.3f}") for t in record.touches),
    ]
    return [(record.controller, *row) for row in rows]


def plot_coverage(results: Sequence[ExploreResult], folder: Path) -> Path:
    """Figure 4: share against time, median and quartiles of each controller."""
    figure, axes = new_figure(7.6, 4.6)
    axis, rows = axes[0], []
    for name, group in by_variant(results).items():
        curves = 100.0 * np.array([result.curve for result in group])
        times = CURVE_STEP_S * np.arange(curves.shape[1])
        low, middle, high = np.percentile(curves, (25, 50, 75), axis=0)
        axis.plot(times, middle, label=f"{name} ({len(group)})")
        axis.fill_between(times, low, high, alpha=0.2)
        rows += [(name, f"{t:g}", *(f"{v:.2f}" for v in q)) for t, *q in zip(times, low, middle, high)]
    axis.set(xlabel="time, s", ylabel="share of the mappable area, %", ylim=(0, 101), xlim=(0, None))
    axis.grid(True, alpha=0.3)
    axis.legend(fontsize="small", loc="lower right")
    write_csv(folder / "explore_coverage.csv", ("controller", "t_s", "quartile_1", "median", "quartile_3"), rows)
    return save_figure(figure, folder / "explore_coverage.png")


def plot_faults(results: Sequence[ExploreResult], folder: Path) -> Path:
    """Figure 6: what the printed program's faults cost, arena by arena, against the described method."""
    groups = by_variant(results)
    printed = {r.spec.arena: r.measures for r in groups.get("report_printed", [])}
    pairs = [
        (r.spec.arena, r.measures, printed[r.spec.arena]) for r in groups.get("report", []) if r.spec.arena in printed
    ]
    figure, axes = new_figure(9.6, 4.4, 2)
    axes[0].plot([0, 100], [0, 100], "-", color="0.7", lw=0.8)
    axes[0].plot([100 * a.share for _, a, _ in pairs], [100 * b.share for _, _, b in pairs], "o", ms=4)
    axes[0].set(xlabel="share at the end, report, %", ylabel="report_printed, %")
    bumps = ([a.bumps for _, a, _ in pairs], [b.bumps for _, _, b in pairs])
    axes[1].plot(*bumps, "o", ms=4)
    axes[1].set(xlabel="bumps, report", ylabel="bumps, report_printed", yscale="symlog", xscale="symlog")
    for axis, counts in zip((axes[1].xaxis, axes[1].yaxis), bumps):
        ticks = [tick for tick in BUMP_TICKS if tick <= 2 * max([1, *counts])]
        axis.set_ticks(ticks, labels=[str(tick) for tick in ticks])
    for axis in axes:
        axis.grid(True, alpha=0.3)
    header = (
        "arena",
        "share_report",
        "share_printed",
        "bumps_report",
        "bumps_printed",
        "turned_report",
        "turned_printed",
    )
    rows = [
        (arena, f"{a.share:.4f}", f"{b.share:.4f}", a.bumps, b.bumps, f"{a.turning_rad:.0f}", f"{b.turning_rad:.0f}")
        for arena, a, b in pairs
    ]
    write_csv(folder / "explore_faults.csv", header, rows)
    return save_figure(figure, folder / "explore_faults.png")


def plot_contact_starts(results: Sequence[ExploreResult], folder: Path) -> Path:
    """Figure 7: starts in contact with something: how long until the robot was away."""
    touching = [result for result in results if starts_in_contact(result.spec.arena)]
    header = ("arena", "controller", "freed", "freed_s", "share")
    rows = [
        (r.spec.arena, r.spec.variant, int(math.isfinite(r.freed_s)), number_text(r.freed_s), f"{r.measures.share:.4f}")
        for r in touching
    ]
    write_csv(folder / "explore_contact_starts.csv", header, rows)
    freed = {
        f"{name}\n{sum(math.isfinite(r.freed_s) for r in group)} of {len(group)}": [
            r.freed_s for r in group if math.isfinite(r.freed_s)
        ]
        for name, group in by_variant(touching).items()
    }
    return box_figure(freed, "time until 0.3 m away, s", folder / "explore_contact_starts.png")
