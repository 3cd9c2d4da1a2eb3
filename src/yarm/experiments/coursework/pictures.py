"""Pictures of the coursework's tasks, drawn without a display."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List, Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from yarm.experiments.coursework.tasks import FloorResult, ObstacleResult, TourResult
from yarm.geometry import FloatArray, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.kinematics.forward import forward_many
from yarm.manipulation.motion.checkpoints import ArmScene, Obstacle
from yarm.manipulation.motion.tour import LineStatus, Order
from yarm.manipulation.obstacles.collision import link_poses

DPI = 110
COLOURS = {
    "potential_field": "tab:orange",
    "turn_extend_retract": "tab:red",
    "turn_extend_retract, obstacles yield": "tab:purple",
    "navigation_field": "tab:green",
    "yarm": "tab:blue",
}
FACES = ((0, 1, 3, 2), (4, 5, 7, 6), (0, 1, 5, 4), (2, 3, 7, 6), (0, 2, 6, 4), (1, 3, 7, 5))
"""Corners of a box's sides."""


def draw_tour(result: TourResult, scene: ArmScene, path: Path) -> Path:
    """The exact tour with its interpolated points, the greedy order beside it, and the joints over time."""
    figure = _figure(13.0, 5.6)
    axes = figure.add_subplot(1, 2, 1, projection="3d")
    exact = result.tours[Order.EXACT]
    _draw_arm(axes, exact.joints, 0.5)
    for line in result.lines:
        xyz = forward_many(line.joints)[:, :3, 3]
        straight = line.status is LineStatus.STRAIGHT
        axes.plot(*xyz.T, "-" if straight else ":", color="tab:blue", lw=1.5)
        if straight:
            axes.plot(*xyz[1:-1].T, ".", color="tab:blue", ms=5)
    for number, (name, joints) in enumerate(zip(exact.names, forward_many(exact.joints)[:, :3, 3]), start=1):
        axes.plot(*joints[:, None], "*", color="black", ms=10)
        axes.text(joints[0], joints[1], joints[2] + 0.03, f"{number} {name}", fontsize=8)
    start = forward_many(np.array([scene.start]))[0, :3, 3]
    axes.plot(*start[:, None], "o", color="tab:green", ms=8)
    greedy = result.tours[Order.GREEDY]
    axes.set_title(
        f"exact order and branches: {exact.length_rad:.1f} rad (greedy: {greedy.length_rad:.1f} rad)\n"
        "solid: hand goes straight, with the interpolated points; dotted: moves joint by joint",
        fontsize=10,
    )
    _frame(axes, 0.45)
    axes.view_init(elev=25, azim=-105)
    times, q, _, _ = result.motion.sampled()
    over = figure.add_subplot(1, 2, 2)
    for joint in range(q.shape[1]):
        over.plot(times, np.degrees(q[:, joint]), label=f"joint {joint + 1}")
    over.set_xlabel("s")
    over.set_ylabel("deg")
    over.set_title("the whole tour timed by TOPP-RA", fontsize=10)
    over.legend(fontsize=8)
    return _save(figure, path)


def draw_obstacles(result: ObstacleResult, path: Path) -> Path:
    """The hand's ways by each method among the obstacles, seen aslant and from above."""
    figure = _figure(13.0, 11.0)
    names = [name for name in result.played if "yield" not in name]
    for number, name in enumerate(names, start=1):
        axes = figure.add_subplot(2, 2, number, projection="3d")
        _draw_scene(axes, result.scene.obstacles)
        played = result.played[name]
        for leg in played.legs:
            axes.plot(*leg.hand.T, color=COLOURS[name], lw=1.5)
            if not leg.reached and len(leg.hand):
                axes.plot(*leg.hand[-1][:, None], "x", color="black", ms=9, mew=2.5)
        for point in result.scene.checkpoints:
            axes.plot(*point.pose[:3, 3][:, None], "*", color="gold", mec="black", ms=13)
        title = f"{name}: {played.reached} of {len(result.scene.checkpoints)} reached, {played.touches} touches"
        if name.startswith("turn"):
            through = result.played[f"{name}, obstacles yield"]
            title += f"\n(through obstacles that yield: {through.reached} reached, {through.touches} touches)"
        axes.set_title(title, fontsize=10)
        _frame(axes, 0.42)
        axes.view_init(elev=42, azim=-25)
    figure.suptitle("five checkpoints (stars) among walls and roofs; x: where the hand ended without reaching one")
    return _save(figure, path)


def draw_coverage(result: FloorResult, path: Path) -> Path:
    """The floor's cells in the order they are entered, and the base's ways through its checkpoints."""
    figure = _figure(13.0, 6.0)
    axes, beside = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    floor, coverage = result.floor, result.coverage
    order = np.full(floor.free.shape, np.nan)
    for number, (x, y) in reversed(list(enumerate(coverage.cells.tolist()))):
        order[x, y] = number
    extent = [floor.lower[0], -floor.lower[0], floor.lower[1], -floor.lower[1]]
    image = axes.imshow(order.T, origin="lower", extent=extent, cmap="viridis")
    figure.colorbar(image, ax=axes, label="entered as number", shrink=0.8)
    closed = floor.centre(np.vstack([coverage.round, coverage.round[:1]]))
    axes.plot(*closed.T, color="white", lw=1.2)
    if len(coverage.after):
        axes.plot(*floor.centre(np.vstack([coverage.round[-1:], coverage.after])).T, ":", color="tab:red", lw=1.5)
        axes.plot(*floor.centre(coverage.loose).T, "s", color="tab:red", ms=4, label="in no block, covered after")
        axes.legend(loc="lower right", fontsize=8)
    axes.plot(*closed[0], "o", color="white", mec="black", ms=9)
    axes.set_title(f"one closed round through {len(coverage.round)} cells, {len(coverage.loose)} after it", fontsize=10)
    for name, way in result.ways.items():
        colour = "tab:orange" if name == "potential field" else "tab:blue"
        beside.plot(*way.points.T, color=colour, lw=2, label=f"{name}: {way.reached} of {len(result.goals)}")
        if way.reached < len(result.goals):
            beside.plot(*way.points[-1], "x", color="black", ms=11, mew=3)
    for number, goal in enumerate(result.goals, start=1):
        beside.plot(*goal, "*", color="gold", mec="black", ms=16)
        beside.annotate(str(number), (goal[0] + 0.1, goal[1] + 0.1))
    beside.set_title("the base from checkpoint to checkpoint; x: a local minimum", fontsize=10)
    beside.legend(loc="lower right", fontsize=8)
    for plot in (axes, beside):
        _draw_outlines(plot, result.obstacles)
        plot.set_xlim(extent[0], extent[1])
        plot.set_ylim(extent[2], extent[3])
        plot.set_aspect("equal")
        plot.set_xlabel("x, m")
        plot.set_ylabel("y, m")
    return _save(figure, path)


def _draw_arm(axes: Any, joints: FloatArray, alpha: float) -> None:
    """The links of configurations (n, 5) as lines from axis 1 to the hand."""
    hands = forward_many(joints)[:, :3, 3]
    for q, hand in zip(joints, hands):
        _, origins = link_poses(q)
        points = np.vstack([np.zeros(3), origins[1:5], hand])
        axes.plot(*points.T, "-o", color="tab:gray", ms=3, lw=3, alpha=alpha)


def _draw_scene(axes: Any, obstacles: Sequence[Obstacle]) -> None:
    for obstacle in obstacles:
        if obstacle.name == "floor":
            continue
        faces = _faces(obstacle.solid)
        axes.add_collection3d(Poly3DCollection(faces, facecolor="tab:gray", edgecolor="dimgray", alpha=0.35, lw=0.5))


def _faces(solid: Solid) -> List[FloatArray]:
    """Polygons (k, 3) of a solid's surface; what is round is drawn with twenty sides, a sphere as its box."""
    if solid.shape == Shape.CYLINDER:
        angles = np.linspace(0.0, 2.0 * np.pi, 21)
        ring = np.column_stack([solid.size[0] * np.cos(angles), solid.size[0] * np.sin(angles), np.zeros(21)])
        up = np.array([0.0, 0.0, 0.5 * solid.size[1]])
        sides = [np.array([a - up, b - up, b + up, a + up]) for a, b in zip(ring[:-1], ring[1:])]
        return [transform_points(solid.pose, face) for face in [*sides, ring - up, ring + up]]
    half = solid.half_extent
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    placed = transform_points(solid.pose, corners)
    return [placed[list(face)] for face in FACES]


def _draw_outlines(axes: Any, obstacles: Sequence[Obstacle]) -> None:
    for obstacle in obstacles:
        x, y, _ = obstacle.solid.half_extent
        corners = np.array([(-x, -y, 0.0), (x, -y, 0.0), (x, y, 0.0), (-x, y, 0.0)])
        placed = transform_points(obstacle.solid.pose, corners)[:, :2]
        axes.add_patch(Polygon(placed, closed=True, facecolor="lightgray", edgecolor="black", zorder=3))
    axes.set_prop_cycle(color=[colormaps["tab10"](index) for index in range(10)])


def _frame(axes: Any, half: float) -> None:
    axes.set_xlim(-half, half)
    axes.set_ylim(-half, half)
    axes.set_zlim(0.0, 1.3 * half)
    axes.set_box_aspect((2.0, 2.0, 1.3), zoom=0.9)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    axes.set_zlabel("z, m")


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _save(figure: Figure, path: Path) -> Path:
    figure.savefig(str(path), dpi=DPI)
    return path
