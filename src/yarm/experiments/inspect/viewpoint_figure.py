"""Figure 3: the practice world's viewpoints for an exact disc that knows all boxes, of both depths."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any, List, Sequence, Tuple

import numpy as np

from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.study.tag_figures import write_rows
from yarm.geometry import Pose2
from yarm.inspection.boxes import Box
from yarm.inspection.viewpoints import Viewpoint, first_reachable
from yarm.sim.checks.layout_check import DISC_M
from yarm.sim.scenes.arena import Arena

DEPTHS_M = (0.16, 0.32)
"""Of boxes as public models have them, and as the text says."""
HEADER = ("depth_m", "box", "distance_m", "angle_deg", "x", "y", "yaw", "room_m")


def room_m(pose: Pose2, boxes: Sequence[Box], arena: Arena) -> float:
    """From the edge of a disc at a pose to the nearest wall or box, metres; negative where it does not fit."""
    walls = (*np.subtract((pose.x, pose.y), arena.lower), *np.subtract(arena.upper, (pose.x, pose.y)))
    return float(min(*walls, *(box.distance(pose.x, pose.y) for box in boxes))) - DISC_M


def disc_viewpoints(boxes: Sequence[Box], arena: Arena) -> List[Viewpoint]:
    """For each box the first viewpoint in the text's order where the disc fits; boxes without any are left out."""
    found = [first_reachable(box, lambda pose: room_m(pose, boxes, arena) >= 0.0) for box in boxes]
    return [view for view in found if view is not None]


def write_viewpoints(boxes: Sequence[Box], arena: Arena, folder: Path) -> str:
    """``inspect_viewpoints.csv`` and ``.png``; the table to print.

    Args:
        boxes: of the practice world.
        arena: that world.
        folder: where to.
    """
    rows: List[Tuple[str, ...]] = []
    figure, axes = new_figure(5.6 * len(DEPTHS_M), 5.8, len(DEPTHS_M))
    for axis, depth in zip(axes, DEPTHS_M):
        deep = [dataclasses.replace(box, size=dataclasses.replace(box.size, depth=depth)) for box in boxes]
        views = disc_viewpoints(deep, arena)
        for view in views:
            place = (f"{value:.4f}" for value in (view.pose.x, view.pose.y, view.pose.yaw_rad))
            room = f"{room_m(view.pose, deep, arena):.4f}"
            rows.append((f"{depth}", f"{view.box}", f"{view.distance_m}", f"{view.angle_deg:g}", *place, room))
        _draw(axis, deep, views, arena)
        axis.set_title(f"boxes {depth} m deep")
    write_rows(folder / "inspect_viewpoints.csv", HEADER, rows)
    save_figure(figure, folder / "inspect_viewpoints.png")
    return markdown_table(HEADER, rows)


def _draw(axis: Any, boxes: Sequence[Box], views: Sequence[Viewpoint], arena: Arena) -> None:
    """Walls, boxes with their numbers, and at each viewpoint the disc and where it looks."""
    (west, south), (east, north) = arena.lower, arena.upper
    axis.plot([west, east, east, west, west], [south, south, north, north, south], color="tab:purple", lw=0.8)
    for box in boxes:
        axis.fill(*box.corners().T, color="tab:gray", alpha=0.6)
        axis.annotate(str(box.number), (box.pose.x, box.pose.y), fontsize=8)
    around = np.linspace(0.0, 2.0 * math.pi, 40)
    for view in views:
        pose = view.pose
        colour = "tab:blue" if view.angle_deg == 0.0 else "tab:red"
        axis.plot(pose.x + DISC_M * np.cos(around), pose.y + DISC_M * np.sin(around), color=colour, lw=0.8)
        ahead = pose.compose(Pose2(DISC_M, 0.0))
        axis.plot([pose.x, ahead.x], [pose.y, ahead.y], color=colour, lw=0.8)
    axis.set(xlabel="x, m", ylabel="y, m", aspect="equal")
