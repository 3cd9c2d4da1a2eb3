"""The picture of docs/commander.md, drawn by the code it explains.

python3 -m yarm.commander.pictures docs/images
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from yarm.commander.foreseen import where_they_may_be
from yarm.commander.params import CommanderParams
from yarm.planning.model.types import without_robots
from yarm.planning.registry import make_planner
from yarm.planning.scenes.scene import PlanScene
from yarm.planning.scenes.scene_file import load_scene
from yarm.planning.tools.plot import COLORS, draw_map, draw_obstacle, draw_robot
from yarm.resources import resource
from yarm.safety.people import Tracked, Walking, disc_of

PLACE_M, VELOCITY_MPS, SIZE_M = (-0.8, 1.2), (0.0, -0.5), (0.35, 0.35, 1.7)


def draw_foreseen(path: Path) -> Path:
    """Where somebody may be before a robot stands, and what is planned: when he is watched, and when he is new."""
    figure = Figure(figsize=(13.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    scene = load_scene(resource("scenes", "planning", "one_robot.yaml"))
    for i, (age_s, title) in enumerate(((Walking().watched_s, "followed for 1 s"), (0.4, "first seen 0.4 s ago"))):
        seen = Tracked(1, (*PLACE_M, SIZE_M[2] / 2.0), VELOCITY_MPS, SIZE_M, 0.0, 0.05, age_s, 0.0)
        _panel(figure.add_subplot(1, 2, i + 1), scene, seen, title)
    figure.savefig(str(path), dpi=90)
    return path


def _panel(axes: Any, scene: PlanScene, seen: Tracked, title: str) -> None:
    ahead_s, spec, request = CommanderParams().people_s, scene.spec, scene.request()
    (cells,) = where_they_may_be(spec, [seen], {seen.name}, 0.0, ahead_s).values()
    kept = request.occupied.copy()
    kept[tuple(cells.T)] = True
    kept = without_robots(spec, kept, request.robots)
    robot, taken = scene.robots[0], np.ones(spec.shape[:2], dtype=np.bool_)
    taken[tuple(cells[:, :2].T)] = False
    draw_map(axes, scene)
    draw_obstacle(axes, taken)
    draw_robot(axes, spec, robot, robot.start, COLORS[0], 0.55)
    for occupied, style in ((request.occupied, ":"), (kept, "-o")):
        plan = make_planner("yarm").plan(replace(request, occupied=occupied), np.random.default_rng(0))
        way = np.array([place.column for place in plan.robots[robot.name].path] or [robot.start.column])
        axes.plot(way[:, 0], way[:, 1], style, color=COLORS[0], lw=2, ms=4)
    disc, size = disc_of(seen, Walking()), spec.resolution[0]
    middle = (np.array([disc.x, disc.y]) - spec.lower[:2]) / spec.resolution[:2] - 0.5
    axes.add_patch(Circle(tuple(middle), disc.radius_m / size, color=COLORS[1]))
    axes.add_patch(
        Circle(tuple(middle), (disc.radius_m + disc.speed_mps * ahead_s) / size, fill=False, color=COLORS[1])
    )
    axes.plot(*scene.goals[scene.assignments[robot.name]].column, marker="*", ms=16, color=COLORS[0], mec="black")
    axes.set_title(f"{plan.status.value}, {title}: {disc.speed_mps:.2f} m/s, any way, for {ahead_s:g} s")


if __name__ == "__main__":
    draw_foreseen(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images") / "commander_foreseen.png")
