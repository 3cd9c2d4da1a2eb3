"""Figure 2: what `report` makes of a map on its way to a frontier: cropped, padded, frontier cells, paths."""

from __future__ import annotations

import csv
from collections import deque
from pathlib import Path
from typing import Any, List, Tuple

import numpy as np

from yarm.experiments.run.plots import new_figure, save_figure
from yarm.exploration.report.frontiers import OCCUPIED, Frontier, Reach, cropped, frontiers, padded, with_probabilities
from yarm.exploration.report.params import ReportParams
from yarm.geometry import BoolArray, IntArray, Pose2
from yarm.navigation.grid_map import UNKNOWN, CellArray, GridMap

COLOURS = {"padded": "tab:red", "bare": "tab:blue", "breadth": "tab:green"}


def plot_method(room: GridMap, robot: Pose2, path: Path, numbers: ReportParams) -> Path:
    """Four panels, and the frontier cells as a CSV of the same name.

    Args:
        room: a map in which not everything is known.
        robot: pose of the base in it.
        path: of the picture.
        numbers: of the report's method.

    Raises:
        ValueError: nothing is known in the map, or no frontier can be reached in it.
    """
    small = cropped(room)
    if small is None:
        raise ValueError("the map has no known cell: there is nothing to show")
    here = small.cell_of(robot.x, robot.y)
    cells = padded(small, numbers.padding, numbers.speck, numbers.speck_window)
    reach = Reach(cells, here)
    able = with_probabilities(
        [f for f in frontiers(cells, here, numbers) if np.isfinite(reach.distance(f.row, f.column))]
    )
    if not able:
        raise ValueError(f"no frontier can be reached from cell {here}: take a map of a moment before all is known")
    farthest = max(able, key=lambda f: reach.distance(f.row, f.column))
    figure, axes = new_figure(11.0, 10.0, 4, rows=2)
    _show(axes[0], room.cells, f"as it came: {room.rows} x {room.columns} cells")
    _show(axes[1], small.cells, f"cropped: {small.rows} x {small.columns}")
    _frontier_panel(axes[2], cells, able, here)
    _path_panel(axes[3], (small.cells, cells), here, farthest)
    _write(able, path.with_suffix(".csv"))
    return save_figure(figure, path)


def _show(axis: Any, cells: CellArray, title: str) -> None:
    shades = np.select([cells == UNKNOWN, cells >= OCCUPIED], [0.8, 0.0], 1.0)
    axis.imshow(shades, origin="lower", cmap="gray", vmin=0.0, vmax=1.0)
    axis.set(title=title, xlabel="column", ylabel="row")


def _frontier_panel(axis: Any, cells: CellArray, able: List[Frontier], here: Tuple[int, int]) -> None:
    _show(axis, cells, "padded by 0.25 m; frontier cells, probability of the draw, %")
    axis.scatter(
        [f.column for f in able], [f.row for f in able], s=[20 + 2000 * f.probability for f in able], alpha=0.5
    )
    for f in sorted(able, key=lambda f: -f.probability)[:8]:
        axis.annotate(f"{100 * f.probability:.1f}", (f.column, f.row), fontsize="small")
    axis.plot(here[1], here[0], "o", color="tab:green")


def _path_panel(axis: Any, maps: Tuple[CellArray, CellArray], here: Tuple[int, int], goal: Frontier) -> None:
    """Ways to one frontier: shortest with and without padding, and with the fewest cells."""
    bare, cells = maps
    _show(axis, bare, "ways to the farthest: by length and by number of cells")
    way = Reach(cells, here).path(goal.row, goal.column)
    direct = Reach(np.where(bare == UNKNOWN, UNKNOWN, bare).astype(np.int8), here).path(goal.row, goal.column)
    fewest = breadth_first(cells == 0, here, (goal.row, goal.column))
    for cells_of, label, colour in (
        (direct, "without padding", COLOURS["bare"]),
        (way, "padded, Dijkstra", COLOURS["padded"]),
        (fewest, "padded, breadth first", COLOURS["breadth"]),
    ):
        axis.plot(cells_of[:, 1], cells_of[:, 0], "-", color=colour, label=f"{label}, {length_of(cells_of):.1f} cells")
    axis.legend(fontsize="small", loc="lower right")


def breadth_first(free: BoolArray, start: Tuple[int, int], goal: Tuple[int, int]) -> IntArray:
    """(n, 2) a way of the fewest cells, 8-connected, from start to goal; only the start when there is none."""
    before = {start: start}
    queue = deque([start])
    steps = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    while queue and goal not in before:
        at = queue.popleft()
        for row, column in ((at[0] + a, at[1] + b) for a, b in steps):
            inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
            if inside and free[row, column] and (row, column) not in before:
                before[(row, column)] = at
                queue.append((row, column))
    way = [goal if goal in before else start]
    while before[way[-1]] != way[-1]:
        way.append(before[way[-1]])
    cells: IntArray = np.array(way[::-1], dtype=np.int64)
    return cells


def length_of(cells: IntArray) -> float:
    """Length of a way (n, 2) of cells, cells."""
    return float(np.hypot(*np.diff(cells, axis=0).T).sum())


def _write(able: List[Frontier], path: Path) -> None:
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["row", "column", "distance", "unknown", "obstacles", "fitness", "probability"])
        for f in able:
            values = (f.distance, f.unknown, f.obstacles, f.fitness, f.probability)
            writer.writerow([f.row, f.column, *(f"{value:.4f}" for value in values)])
