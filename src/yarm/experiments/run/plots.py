"""Pictures of one experiment: waypoints and driven paths over the grid, and planning times (PNG, no display needed)."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List, Mapping, Optional, Sequence, Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from yarm.experiments.run.record import RunRecord
from yarm.geometry import BoolArray, GridSpec

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown")
PLOTS = ("map.png", "planning_time.png", "timing.png")
DPI = 110


def plot_run(record: RunRecord, folder: Path, spec: GridSpec, obstacles: Optional[BoolArray] = None) -> List[Path]:
    """Draw every picture of a run into its folder.

    Args:
        record: the run.
        folder: where to.
        spec: the grid.
        obstacles: (gx, gy) columns with something that never moves, drawn in grey.

    Returns:
        The files written: one map for each robot and one of all, planning times, time line.
    """
    folder.mkdir(parents=True, exist_ok=True)
    written = [plot_map(record, folder / "map.png", spec, obstacles)]
    names = [robot.name for robot in record.robots]
    written += [plot_map(record, folder / f"map_{name}.png", spec, obstacles, [name]) for name in names]
    written.append(_plot_planning_time(record, folder / "planning_time.png"))
    written.append(_plot_time_line(record, folder / "timing.png"))
    return written


def plot_map(
    record: RunRecord,
    path: Path,
    spec: GridSpec,
    obstacles: Optional[BoolArray] = None,
    robots: Optional[Sequence[str]] = None,
) -> Path:
    """Heat map of the waypoints sent and the path really driven, on grid indices."""
    names = [r.name for r in record.robots if robots is None or r.name in robots]
    figure, axes = _figure(6.4, 6.0)
    heat = np.zeros(spec.shape[:2])
    for row in record.waypoints:
        if row.robot in names and 0 <= row.column_x < spec.shape[0] and 0 <= row.column_y < spec.shape[1]:
            heat[row.column_x, row.column_y] += 1
    draw_obstacles(axes, obstacles)
    shown = np.where(heat.T > 0, heat.T, np.nan)
    image = axes.imshow(shown, origin="lower", cmap="YlOrRd", vmin=0, vmax=max(1.0, float(heat.max())))
    figure.colorbar(image, ax=axes, label="waypoints sent into the cell", shrink=0.8, ticks=MaxNLocator(integer=True))
    for name in names:
        _draw_path(axes, record, name, _colour(record, name))
    axes.set(
        xlim=(-0.5, spec.shape[0] - 0.5),
        ylim=(-0.5, spec.shape[1] - 0.5),
        xlabel="grid index x",
        ylabel="grid index y",
        title=f"{record.info.case}, seed {record.info.seed}: waypoints and path driven",
    )
    if names:
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncol=3, fontsize="small")
    return save_figure(figure, path)


def draw_obstacles(axes: Any, obstacles: Optional[BoolArray]) -> None:
    """Columns (gx, gy) with something that never moves, in grey."""
    if obstacles is not None and obstacles.any():
        shown = np.where(obstacles.T, 1.0, np.nan)
        axes.imshow(shown, origin="lower", cmap="Greys", vmin=0, vmax=2.5)


def _draw_path(axes: Any, record: RunRecord, name: str, colour: str) -> None:
    rows = [row for row in record.path if row.robot == name]
    sent = [row for row in record.waypoints if row.robot == name]
    if rows:
        x, y = np.array([(r.column_x - 0.5, r.column_y - 0.5) for r in rows]).T
        axes.plot(x, y, "-", color=colour, lw=1.5, label=f"{name}, end effector")
        axes.plot(x[:1], y[:1], "o", color=colour, ms=8, mfc="white")
        axes.plot(x[-1:], y[-1:], "*", color=colour, ms=13)
    axes.plot([r.column_x for r in sent], [r.column_y for r in sent], "x", color=colour, ms=5)


def _plot_planning_time(record: RunRecord, path: Path) -> Path:
    figure, axes = _figure(6.4, 4.0)
    for robot in record.robots:
        rows = [row for row in record.timing if row.robot == robot.name]
        axes.plot(
            [row.waypoint for row in rows],
            [row.planning_ms for row in rows],
            "o-",
            ms=3,
            lw=1,
            color=_colour(record, robot.name),
            label=robot.name,
        )
    axes.set(
        xlabel="waypoint index", ylabel="planning step, ms", title=f"{record.info.case}: planning time", yscale="log"
    )
    axes.grid(True, which="both", alpha=0.3)
    if record.timing:
        axes.legend(fontsize="small")
    return save_figure(figure, path)


def _plot_time_line(record: RunRecord, path: Path) -> Path:
    figure, axes = _figure(8.0, 0.6 * len(record.robots) + 2.2)
    labels: List[str] = []
    for level, robot in enumerate(record.robots):
        colour = _colour(record, robot.name)
        times = [row.time_s for row in record.waypoints if row.robot == robot.name]
        axes.plot(times, [level] * len(times), "|", ms=14, color=colour)
        for goal in record.goals:
            if goal.robot == robot.name and np.isfinite(goal.declared_s):
                axes.plot(goal.declared_s, level, "*" if goal.reached else "X", ms=13, color=colour)
                axes.annotate(
                    goal.name, (goal.declared_s, level), xytext=(4, 8), textcoords="offset points", fontsize=8
                )
        labels.append(robot.name)
    for pause in record.pauses:
        end = pause.end_s if np.isfinite(pause.end_s) else record.info.sim_s
        axes.axvspan(pause.start_s, end, color="tab:grey", alpha=0.3)
    axes.set(
        xlabel="simulated time, s (grey: manipulator paused; bars: waypoints sent; star: goal reached)",
        ylim=(-0.6, len(labels) - 0.2),
        xlim=(0, max(1.0, record.info.sim_s)),
        title=f"{record.info.case}, seed {record.info.seed}: time line",
    )
    axes.set_yticks(range(len(labels)))
    axes.set_yticklabels(labels)
    return save_figure(figure, path)


def new_figure(width: float, height: float, axes: int = 1, rows: int = 1) -> Tuple[Figure, Sequence[Any]]:
    """A figure, inches, that needs no display; its axes lie side by side, in so many rows of the same length."""
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure, [figure.add_subplot(rows, axes // rows, i + 1) for i in range(axes)]


def _figure(width: float, height: float) -> Tuple[Figure, Any]:
    figure, axes = new_figure(width, height)
    return figure, axes[0]


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG and hand back the file's name."""
    figure.tight_layout()
    figure.savefig(str(path), dpi=DPI)
    return path


def _colour(record: RunRecord, name: str) -> str:
    order: Mapping[str, int] = {robot.name: i for i, robot in enumerate(record.robots)}
    return COLOURS[order.get(name, 0) % len(COLOURS)]
