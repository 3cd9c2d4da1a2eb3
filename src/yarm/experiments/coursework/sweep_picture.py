"""Picture of a cleaning round: the cells in the order they are gone over, and where the body really was."""

from __future__ import annotations

from pathlib import Path
from typing import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.spatial import ConvexHull

from yarm.geometry import FloatArray, transform_points
from yarm.geometry.solids import Solid
from yarm.manipulation.coverage.sweep import SweepPlan

DPI = 110


def draw_sweep(plan: SweepPlan, track: FloatArray, things: Sequence[Solid], path: Path) -> Path:
    """Draw a round.

    Args:
        plan: the round.
        track: (n, 2), metres, of the body's middle.
        things: what stands about, world.
        path: of the picture.
    """
    figure = Figure(figsize=(7.5, 6.5), dpi=DPI)
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    floor, coverage = plan.floor, plan.coverage
    order = np.full(floor.free.shape, np.nan)
    for number, (x, y) in reversed(list(enumerate(coverage.cells.tolist()))):
        order[x, y] = number
    low, high = floor.lower, floor.lower + floor.cell_m * np.array(floor.free.shape)
    image = axes.imshow(order.T, origin="lower", extent=[low[0], high[0], low[1], high[1]], cmap="viridis")
    figure.colorbar(image, ax=axes, label="gone over as number", shrink=0.8)
    for thing in things:
        axes.add_patch(Polygon(_outline(thing), facecolor="tab:gray", edgecolor="dimgray", alpha=0.5))
    if len(track):
        axes.plot(*track.T, color="white", lw=1.4, label="the body's middle, as driven")
        axes.plot(*track[0], "o", color="tab:red", ms=8, label="start")
    if len(coverage.unreachable):
        axes.plot(*floor.centre(coverage.unreachable).T, "x", color="black", ms=5, label="free, out of reach")
    over = int(plan.gone_over(track).sum())
    wanted = len({tuple(cell) for cell in coverage.cells.tolist()})
    axes.set_title(f"{over} cells gone over, {wanted} were to be; heading {np.degrees(plan.heading_rad):.0f} deg")
    axes.legend(loc="upper right", fontsize=8, facecolor="lightgray")
    axes.set_aspect("equal")
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    reach = max(float(np.abs(np.concatenate([low, high])).max()), float(np.abs(track).max()) if len(track) else 0.0)
    axes.set_xlim(-reach - 0.3, reach + 0.3)
    axes.set_ylim(-reach - 0.3, reach + 0.3)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, bbox_inches="tight")
    return path


def _outline(solid: Solid) -> FloatArray:
    """Corners (m, 2) of what a solid's box covers of the floor, metres."""
    signs = np.array(np.meshgrid((-1, 1), (-1, 1), (-1, 1))).reshape(3, -1).T
    points = transform_points(solid.pose, signs * solid.half_extent)[:, :2]
    return np.asarray(points[ConvexHull(points).vertices])
