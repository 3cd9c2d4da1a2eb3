"""Pictures of explorations: the map over the true walls, the share against time."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

import numpy as np

from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.geometry import FloatArray
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, BlockKind

PICTURES = ("map.png", "coverage.png")
LOW_COLOUR = "tab:red"
BORDER_M = 0.3
"""Around the arena."""
SHADES = {"unknown": 0.80, "free": 1.0, "occupied": 0.0}


def plot_exploration(record: ExploreRecord, arena: Arena, folder: Path) -> List[Path]:
    """Draw the pictures of a run into its folder."""
    figure, axes = new_figure(6.4, 6.4)
    draw_run(axes[0], record, arena)
    written = [save_figure(figure, folder / PICTURES[0])]
    figure, axes = new_figure(6.4, 3.6)
    axis = axes[0]
    axis.plot([row.t_s for row in record.coverage], [100.0 * row.share for row in record.coverage])
    axis.set(xlabel="time, s", ylabel="share of the mappable area, %", ylim=(0, 102), title=title_of(record))
    axis.grid(True, alpha=0.3)
    return [*written, save_figure(figure, folder / PICTURES[1])]


def title_of(record: ExploreRecord) -> str:
    """Arena, controller, seed."""
    return f"{record.arena}, {record.controller}, seed {record.seed}"


def draw_run(axis: Any, record: ExploreRecord, arena: Arena) -> None:
    """Map, true outlines, the way and the bumps of a run."""
    if record.map is not None:
        draw_map(axis, record)
    draw_arena(axis, arena)
    way = np.array([(row.true_x, row.true_y) for row in record.path]).reshape(-1, 2)
    axis.plot(way[:, 0], way[:, 1], "-", color="tab:blue", lw=0.8)
    axis.plot([arena.start.x], [arena.start.y], "o", color="tab:green", ms=6)
    axis.plot([t.x for t in record.touches], [t.y for t in record.touches], "x", color="tab:orange", ms=6)
    axis.set(title=title_of(record), xlabel="x, m", ylabel="y, m", aspect="equal")
    axis.set(xlim=(arena.lower[0] - BORDER_M, arena.upper[0] + BORDER_M))
    axis.set(ylim=(arena.lower[1] - BORDER_M, arena.upper[1] + BORDER_M))


def draw_arena(axis: Any, arena: Arena) -> None:
    """Outlines of what really stands there; low things in red."""
    for block, corners in zip(arena.blocks, FlatBoxes(arena.blocks).corners()):
        outline: FloatArray = np.concatenate([corners, corners[:1]])
        axis.plot(
            outline[:, 0], outline[:, 1], "-", lw=0.8, color=LOW_COLOUR if block.kind == BlockKind.LOW else "tab:purple"
        )


def draw_map(axis: Any, record: ExploreRecord) -> None:
    """The cells in grey, turned and moved into the world."""
    grid = record.map
    assert grid is not None
    shades = np.full(grid.cells.shape, SHADES["unknown"])
    shades[grid.free] = SHADES["free"]
    shades[grid.occupied] = SHADES["occupied"]
    pose = record.world_from_map.compose(grid.origin)
    rows, columns = np.arange(grid.rows + 1) * grid.resolution_m, np.arange(grid.columns + 1) * grid.resolution_m
    c, s = np.cos(pose.yaw_rad), np.sin(pose.yaw_rad)
    x = pose.x + c * columns[None, :] - s * rows[:, None]
    y = pose.y + s * columns[None, :] + c * rows[:, None]
    axis.pcolormesh(x, y, shades, cmap="gray", vmin=0.0, vmax=1.0, rasterized=True)
