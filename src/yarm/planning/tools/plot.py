"""Pictures of planning, drawn without a display: map, particles, graph, configuration-space obstacle, paths, robots."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Mapping, Optional, Sequence, Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.figure import Figure

from yarm.geometry import BoolArray, GridSpec, IntArray
from yarm.planning.model.types import FleetPlan
from yarm.planning.scenes.oracle import Shape, Space
from yarm.planning.scenes.scene import PlanScene, SceneRobot, Stand

COLORS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#e377c2")
"""One colour for each robot, in order, again from the first after the last."""


def draw_scene(
    scene: PlanScene,
    plan: Optional[FleetPlan],
    path: Path,
    trails: Optional[Mapping[str, Sequence[Stand]]] = None,
    obstacle_of: Optional[str] = None,
) -> None:
    """Write a picture of a scene seen from above, axes in cells.

    Args:
        scene: map, robots, goals.
        plan: its particles, edges and paths are drawn; None for none.
        path: file to write; its ending says the format.
        trails: places each robot came through, drawn instead of the plan's paths.
        obstacle_of: robot whose configuration-space obstacle (at its first heading) is drawn; the first one by default.
    """
    gx, gy, _ = scene.spec.shape
    figure = Figure(figsize=(8.0, 8.0 * max(0.35, min(1.6, gy / gx))), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    draw_map(axes, scene)
    owner = next((r for r in scene.robots if r.name == obstacle_of), scene.robots[0])
    draw_obstacle(axes, Space(Shape(owner, scene.spec, ()), scene.occupied()).free[0])
    if plan is not None:
        draw_graph(axes, plan.graph.particles, plan.graph.edges)
    for i, robot in enumerate(scene.robots):
        color = COLORS[i % len(COLORS)]
        stands = _way(robot, plan, trails)
        draw_robot(axes, scene.spec, robot, robot.start, color, 0.55)
        if len(stands) > 1:
            draw_robot(axes, scene.spec, robot, stands[-1], color, 0.2)
            xy = np.array([stand.column for stand in stands])
            axes.plot(xy[:, 0], xy[:, 1], "-o", color=color, lw=2, ms=4, label=robot.name, zorder=6)
        goal = scene.goals.get(scene.assignments.get(robot.name, ""))
        if goal is not None:
            axes.plot(*goal.column, marker="*", ms=16, color=color, mec="black", ls="none", zorder=7)
    for goal in scene.goals.values():
        if goal.name not in scene.assignments.values():
            axes.plot(*goal.column, marker="*", ms=16, color="white", mec="black", ls="none", zorder=7)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right")
    status = (
        ""
        if plan is None
        else f" - {plan.status.value}, {len(plan.graph.particles)} particles, {plan.planning_ms:.1f} ms"
    )
    axes.set_title(f"{scene.name}{status}")
    figure.savefig(str(path), dpi=110)


def draw_map(axes: Any, scene: PlanScene) -> None:
    """Highest occupied cell of each column in grey, the darker the higher."""
    occupied = scene.occupied()
    gx, gy, gz = occupied.shape
    top = np.where(occupied.any(axis=2), gz - np.argmax(occupied[:, :, ::-1], axis=2), 0)
    axes.imshow(top.T, origin="lower", cmap="Greys", vmin=0, vmax=1.3 * gz, extent=(-0.5, gx - 0.5, -0.5, gy - 0.5))
    axes.set_xlim(-0.5, gx - 0.5)
    axes.set_ylim(-0.5, gy - 0.5)
    axes.set_xlabel("x, cells")
    axes.set_ylabel("y, cells")
    axes.set_aspect("equal")


def draw_obstacle(axes: Any, free: BoolArray) -> None:
    """Columns (gx, gy) where an end effector may not be, in light red."""
    _overlay(axes, ~free, "#d62728", 0.13)


def draw_graph(axes: Any, particles: IntArray, edges: IntArray) -> None:
    """Particles (n, 2) and edges (m, 2) between them."""
    if len(edges):
        ends = particles[edges].astype(float)
        gaps = np.full((len(edges), 1, 2), np.nan)
        lines = np.concatenate([ends, gaps], axis=1).reshape(-1, 2)
        axes.plot(lines[:, 0], lines[:, 1], color="#4c78a8", lw=0.35, alpha=0.6, zorder=3)
    if len(particles):
        axes.plot(particles[:, 0], particles[:, 1], ".", color="#4c78a8", ms=2.5, zorder=4)


def draw_robot(axes: Any, spec: GridSpec, robot: SceneRobot, stand: Stand, color: str, alpha: float) -> None:
    """The columns a robot occupies at a place, and an arrow along its heading."""
    cells = robot.mask(spec, stand.yaw_rad).at(stand.column)
    image = np.zeros(spec.shape[:2], dtype=bool)
    image[tuple(cells[spec.contains(cells)][:, :2].T)] = True
    _overlay(axes, image, color, alpha)
    length = max(1.0, 0.04 * max(spec.shape[:2]))
    tip: Tuple[float, float] = (length * math.cos(stand.yaw_rad), length * math.sin(stand.yaw_rad))
    axes.annotate(
        "",
        xy=(stand.column[0] + tip[0], stand.column[1] + tip[1]),
        xytext=stand.column,
        arrowprops={"arrowstyle": "->", "color": color, "lw": 1.5},
        zorder=8,
    )


def _overlay(axes: Any, image: BoolArray, color: str, alpha: float) -> None:
    gx, gy = image.shape
    colors = ListedColormap([(0.0, 0.0, 0.0, 0.0), to_rgba(color, alpha)])
    axes.imshow(
        image.T.astype(int),
        origin="lower",
        cmap=colors,
        vmin=0,
        vmax=1,
        extent=(-0.5, gx - 0.5, -0.5, gy - 0.5),
        zorder=2,
    )


def _way(
    robot: SceneRobot, plan: Optional[FleetPlan], trails: Optional[Mapping[str, Sequence[Stand]]]
) -> Sequence[Stand]:
    if trails is not None:
        return trails.get(robot.name, (robot.start,))
    entry = None if plan is None else plan.robots.get(robot.name)
    return [] if entry is None else [Stand(waypoint.column, waypoint.yaw_rad) for waypoint in entry.path]
