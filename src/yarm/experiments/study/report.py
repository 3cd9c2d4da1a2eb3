"""Tables (CSV, Markdown) and figures of a study."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator

from yarm.experiments.run.plots import DPI, draw_obstacles, new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import percentile
from yarm.experiments.study.design import PARTICLES, TABLE_HEADER, YARM, CellSummary, Variant, summarise, table_rows
from yarm.experiments.study.kinematic import KinematicWorld
from yarm.experiments.study.trial import TrialResult
from yarm.geometry import GridSpec
from yarm.sim.scenes.scene import load_scene

SHARES = ("stationary", "moving", "stuck", "solved", "clean", "elsewhere", "free_end")
SHARE_TITLES = (
    "hits stationary",
    "hits moving",
    "stuck",
    "solved",
    "solved, nothing touched",
    "declared elsewhere",
    "touched, end was free",
)


def write_trials(results: Sequence[TrialResult], path: Path) -> None:
    """One line a trial."""
    header = [
        "scene",
        "planner",
        "margin_cells",
        "replanning",
        "particles",
        "seed",
        "solved",
        "declared",
        "declared_m",
        "stuck",
    ]
    header += ["hits_stationary", "hits_moving", "free_end_touches", "first_path", "sent", "path_m", "time_s"]
    header += ["least_m", "planning_p50_ms", "reason"]
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        for r in results:
            s = r.spec
            row: List[Any] = [s.scene, s.planner, s.margin_cells, int(s.replanning), s.particles, s.seed, int(r.solved)]
            row += [int(r.declared), f"{r.declared_m:.3f}", int(r.stuck)]
            row += [" ".join(r.hits_stationary), " ".join(r.hits_moving), r.free_end_touches, r.first_path, len(r.sent)]
            row += [f"{v:.3f}" for v in (r.path_m, r.time_s, r.least_m, percentile(r.planning_ms, 50))]
            writer.writerow([*row, r.reason])


def write_table(results: Sequence[TrialResult], folder: Path) -> str:
    """The table as ``table.csv`` and ``table.md``; the Markdown text."""
    summaries = summarise(results)
    with (folder / "table.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        bounds = [f"{name}_{part}" for name in SHARES for part in ("rate", "low", "high")]
        measured = ["trials", "first_path_median", "path_median_m", *bounds]
        writer.writerow(["planner", "margin_cells", "replanning", "particles", *measured])
        writer.writerows(_csv_row(cell) for cell in summaries)
    text = markdown_table(TABLE_HEADER, table_rows(summaries))
    (folder / "table.md").write_text(text + "\n")
    return text


def _csv_row(cell: CellSummary) -> List[Any]:
    row: List[Any] = [cell.planner, cell.margin_cells, int(cell.replanning), cell.particles, cell.trials]
    row += [percentile(cell.first_path, 50), percentile(cell.path_m, 50)]
    for name in SHARES:
        share = cell.shares[name]
        row += [f"{value:.4f}" for value in (share.rate, *share.interval)]
    return row


def plot_rates(results: Sequence[TrialResult], path: Path) -> Path:
    """Rates with 95 % intervals by number of particles, planned once above and with re-planning below."""
    summaries = summarise(results)
    figure, axes = new_figure(16.0, 6.4, 2 * len(SHARES), rows=2)
    variants = sorted({(cell.planner, cell.margin_cells) for cell in summaries})
    panels = [(replanning, name, title) for replanning in (False, True) for name, title in zip(SHARES, SHARE_TITLES)]
    for axis, (replanning, name, title) in zip(axes, panels):
        for shift, variant in enumerate(variants):
            cells = [c for c in summaries if (c.planner, c.margin_cells) == variant and c.replanning == replanning]
            x = [PARTICLES.index(c.particles) + 0.15 * (shift - (len(variants) - 1) / 2) for c in cells]
            y = np.array([c.shares[name].rate for c in cells])
            bounds = np.array([c.shares[name].interval for c in cells]).reshape(-1, 2)
            errors = np.abs(np.stack([y - bounds[:, 0], bounds[:, 1] - y]))
            axis.errorbar(x, y, errors, fmt="o", ms=4, capsize=2, label=_variant_text(variant))
        axis.set(ylim=(-0.05, 1.05), title="" if replanning else title, xlabel="particles" if replanning else "")
        axis.set_xticks(range(len(PARTICLES)))
        axis.set_xticklabels([str(n) for n in PARTICLES])
        axis.grid(True, alpha=0.3)
    axes[0].set_ylabel("planned once: share, 95 %")
    axes[len(SHARES)].set_ylabel("re-planning: share, 95 %")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, fontsize="small", loc="lower center", ncol=max(1, len(variants)))
    figure.tight_layout(rect=(0.0, 0.06, 1.0, 1.0))
    figure.savefig(str(path), dpi=DPI)
    return path


def _variant_text(variant: Variant) -> str:
    planner, margin = variant
    return planner if variant == YARM else f"{planner}, margin {margin}"


def planning_times(results: Sequence[TrialResult]) -> Dict[Tuple[str, int], List[Tuple[float, float, float]]]:
    """By planner and particles: median and quartiles, ms, of the planning time at each waypoint index.

    Of the trials that arrived (a robot that is stuck goes on planning where it stands), and only as far as half of them
    go, so that a median is not one stray trial's.
    """
    times: Dict[Tuple[str, int], List[List[float]]] = {}
    for result in (result for result in results if result.solved):
        rows = times.setdefault((result.spec.planner, result.spec.particles), [])
        for index, value in enumerate(result.planning_ms):
            if index == len(rows):
                rows.append([])
            rows[index].append(value)
    return {
        key: [
            (percentile(row, 50), percentile(row, 25), percentile(row, 75))
            for row in rows
            if 2 * len(row) >= len(rows[0])
        ]
        for key, rows in sorted(times.items())
    }


def write_planning_times(results: Sequence[TrialResult], folder: Path) -> Path:
    """``planning_time.csv`` and the figure of planning time against waypoint index."""
    series = planning_times(results)
    with (folder / "planning_time.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["planner", "particles", "waypoint", "median_ms", "quartile_1_ms", "quartile_3_ms"])
        for (planner, particles), rows in series.items():
            writer.writerows([planner, particles, i, *(f"{v:.4f}" for v in row)] for i, row in enumerate(rows))
    planners = sorted({planner for planner, _ in series})
    figure, axes = new_figure(5.5 * max(1, len(planners)), 4.2, max(1, len(planners)))
    for axis, planner in zip(axes, planners):
        for particles in PARTICLES:
            rows = series.get((planner, particles), [])
            if not rows:
                continue
            middle, low, high = (np.array(column) for column in zip(*rows))
            axis.plot(range(len(middle)), middle, "o-", ms=3, label=f"{particles} particles")
            axis.fill_between(range(len(middle)), low, high, alpha=0.2)
        axis.set(title=f"single, {planner}", xlabel="waypoint index", ylabel="processor time, ms", yscale="log")
        axis.xaxis.set_major_locator(MaxNLocator(integer=True))
        axis.grid(True, which="both", alpha=0.3)
        axis.legend(fontsize="small")
    return save_figure(figure, folder / "planning_time.png")


def plot_waypoints(results: Sequence[TrialResult], path: Path, scene: str) -> Path:
    """Heat map of the columns that were sent, over all trials of each planner and margin with re-planning."""
    world = KinematicWorld(load_scene(scene), GridSpec())
    spec = world.spec
    obstacles = np.zeros(spec.shape[:2], dtype=bool)
    for cells in world.static_cells.values():
        obstacles[cells[:, 0], cells[:, 1]] = True
    variants = sorted({(r.spec.planner, r.spec.margin_cells) for r in results})
    figure, axes = new_figure(4.6 * max(1, len(variants)), 4.2, max(1, len(variants)))
    for axis, variant in zip(axes, variants):
        heat = np.zeros(spec.shape[:2])
        for result in results:
            if (result.spec.planner, result.spec.margin_cells) == variant and result.spec.replanning:
                for x, y in result.sent:
                    heat[x, y] += 1
        draw_obstacles(axis, obstacles)
        shown = np.where(heat.T > 0, heat.T, math.nan)
        image = axis.imshow(
            shown, origin="lower", cmap="YlOrRd", norm=LogNorm(vmin=1, vmax=max(2.0, float(heat.max())))
        )
        figure.colorbar(image, ax=axis, shrink=0.8, label="waypoints sent into the cell")
        axis.set(title=f"{scene}, {_variant_text(variant)}", xlabel="grid index x", ylabel="grid index y")
    return save_figure(figure, path)
