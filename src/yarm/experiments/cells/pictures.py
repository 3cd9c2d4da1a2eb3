"""Random cells from above."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Sequence

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle
from matplotlib.transforms import Affine2D

from yarm.geometry import Pose2
from yarm.geometry.kinds import ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M, BODY_RADIUS_M
from yarm.robots.hc10 import station_boxes
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import HALF_CELL_M, ThingSpec

COLUMNS = 4
SIDE_IN = 3.2
DEBRIS_M = (0.15, 0.06)


def plot_cells(cells: Sequence[Scene], path: Path) -> Path:
    """Draw cells side by side, and write the picture; what falls or comes later is drawn hollow, ways as arrows."""
    rows = math.ceil(len(cells) / COLUMNS)
    figure = Figure(figsize=(SIDE_IN * COLUMNS, SIDE_IN * 1.08 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    for i, cell in enumerate(cells):
        _draw(figure.add_subplot(rows, COLUMNS, i + 1), cell)
    figure.savefig(path, dpi=80)
    return path


def _draw(axes: Any, cell: Scene) -> None:
    axes.set(xlim=(-HALF_CELL_M, HALF_CELL_M), ylim=(-HALF_CELL_M, HALF_CELL_M), aspect="equal", xticks=[], yticks=[])
    axes.set_title(f"{cell.name[len('random_') :]}, seed {cell.seed}", fontsize=9)
    for box in station_boxes():
        x, y, _ = box.centre
        axes.add_patch(
            Rectangle((x - 0.5 * box.size[0], y - 0.5 * box.size[1]), *box.size[:2], facecolor="tan", edgecolor="grey")
        )
    for robot in cell.robots:
        tip = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
        axes.add_patch(Circle((robot.x, robot.y), BODY_RADIUS_M, facecolor="lightsteelblue", edgecolor="navy"))
        axes.plot([robot.x, tip.x], [robot.y, tip.y], color="navy", linewidth=2.0)
        axes.text(robot.x, robot.y, robot.name[-1], ha="center", va="center", fontsize=8)
    places = {thing.name: thing for thing in cell.things}
    for thing in cell.things:
        _draw_thing(axes, thing, there=True)
    for event in cell.events:
        if event.spawn is not None:
            places[event.spawn.name] = event.spawn
            _draw_thing(axes, event.spawn, there=False)
        moved = places.get(event.push or event.move)
        if moved is not None:
            way = {"length_includes_head": True, "head_width": 0.08, "color": "black", "linewidth": 0.8}
            axes.arrow(moved.x, moved.y, event.dx_m, event.dy_m, **way)


def _draw_thing(axes: Any, thing: ThingSpec, there: bool) -> None:
    if thing.kind == ObjectKind.TARGET:
        axes.plot(thing.x, thing.y, "*", color="green", markersize=9)
        return
    debris = thing.kind == ObjectKind.DEBRIS
    colour = "red" if debris else "dimgrey" if thing.registered else "darkorange"
    length, width = DEBRIS_M if debris else thing.size[:2]
    patch = Rectangle((thing.x - 0.5 * length, thing.y - 0.5 * width), length, width, edgecolor=colour)
    patch.set(facecolor=colour if there else "none", transform=_turn(thing) + axes.transData)
    axes.add_patch(patch)


def _turn(thing: ThingSpec) -> Affine2D:
    return Affine2D().rotate_around(thing.x, thing.y, thing.yaw_rad)
