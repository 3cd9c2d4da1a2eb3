"""The pictures of docs/planning.md, drawn by the code they explain.

python3 -m yarm.planning.tools.pictures docs/images
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import List, Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from yarm.planning.model.params import PlannerParams
from yarm.planning.registry import make_planner
from yarm.planning.roadmap.graph import delaunay_edges
from yarm.planning.roadmap.particles import random_particles
from yarm.planning.scenes.oracle import Shape, Space
from yarm.planning.scenes.releasing import release_to_end
from yarm.planning.scenes.scene import Box, PlanScene, Stand
from yarm.planning.scenes.scene_file import load_scene
from yarm.planning.scenes.stepping import step_to_end
from yarm.planning.tools.plot import COLORS, draw_graph, draw_map, draw_obstacle, draw_robot, draw_scene
from yarm.planning.why.causes import Circumstances, why
from yarm.resources import resource


def draw_pictures(folder: Path) -> List[Path]:
    """Write every picture into a folder; gives their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    scenes = {name: load_scene(resource("scenes", "planning", f"{name}.yaml")) for name in _SCENES}
    made = [
        _particles(scenes["three_robots"], folder / "planning_particles.png"),
        _obstacles(scenes["three_robots"], folder / "planning_cspace.png"),
        _releases(scenes["three_robots"], folder / "planning_release.png"),
        _why(load_scene(resource("scenes", "planning", "walled_in.yaml")), folder / "planning_why.png"),
    ]
    for name in _SCENES:
        path = folder / f"planning_{name}.png"
        planner = make_planner("yarm")
        run = step_to_end(scenes[name], planner, np.random.default_rng(0), clearance=False)
        draw_scene(scenes[name], run.first, path, run.trails)
        made.append(path)
    return made


_SCENES = ("one_robot", "three_robots", "narrow_gap", "head_on")


def _particles(scene: PlanScene, path: Path) -> Path:
    """Random particles of the original beside the even ones of YARM, each with its graph."""
    figure = Figure(figsize=(13.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    request = scene.request()
    random = random_particles(PlannerParams().particles, scene.spec.shape[:2], np.random.default_rng(1))
    distinct = np.unique(random, axis=0)
    plan = make_planner("yarm").plan(request, np.random.default_rng(1))
    sets = [
        ("original: random draws", distinct, delaunay_edges(distinct)),
        ("yarm: even", plan.graph.particles, plan.graph.edges),
    ]
    for i, (title, particles, edges) in enumerate(sets):
        axes = figure.add_subplot(1, 2, i + 1)
        draw_map(axes, scene)
        draw_graph(axes, particles, edges)
        axes.set_title(f"{title}, {len(particles)} columns")
    figure.savefig(str(path), dpi=90)
    return path


def _obstacles(scene: PlanScene, path: Path) -> Path:
    """Where the end effector may not be at two headings: the configuration-space obstacle."""
    figure = Figure(figsize=(13.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    robot = scene.robots[0]
    shape = Shape(robot, scene.spec)
    space = Space(shape, scene.occupied())
    for i, heading in enumerate((0, 1)):
        axes = figure.add_subplot(1, 2, i + 1)
        draw_map(axes, scene)
        draw_obstacle(axes, space.free[heading])
        places = np.argwhere(space.free[heading])
        x, y = (int(v) for v in places[np.argmin(np.abs(places - (25, 40)).sum(axis=1))])
        draw_robot(axes, scene.spec, robot, Stand((x, y), shape.yaws[heading]), COLORS[0], 0.5)
        axes.set_title(f"end effector may not be in the red columns at {np.degrees(shape.yaws[heading]):.0f} deg")
    figure.savefig(str(path), dpi=90)
    return path


def _releases(scene: PlanScene, path: Path) -> Path:
    """The dependency graph of a joint plan, and when each of its moves was released and ended."""
    figure = Figure(figsize=(13.0, 4.4), layout="constrained")
    FigureCanvasAgg(figure)
    run = release_to_end(scene, make_planner("yarm"), np.random.default_rng(0), replans=False)
    moves = run.first.moves if run.first is not None else ()
    rows = {robot.name: -i for i, robot in enumerate(scene.robots)}
    graph, times = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    for k, move in enumerate(moves):
        color = COLORS[-rows[move.robot] % len(COLORS)]
        own = max((j for j in range(k) if moves[j].robot == move.robot), default=k)
        for j in {*move.after, own} - {k}:
            arrow = {"arrowstyle": "->", "shrinkA": 14, "shrinkB": 14, "color": "0.4" if j == own else "firebrick"}
            graph.annotate("", (k, rows[move.robot]), (j, rows[moves[j].robot]), arrowprops=arrow)
        graph.plot(k, rows[move.robot], "o", markersize=24, color=color)
        graph.text(k, rows[move.robot], str(k + 1), ha="center", va="center", color="white")
    for made in run.made:
        color, row = COLORS[-rows[made.move.robot] % len(COLORS)], rows[made.move.robot]
        times.barh(row, made.ended - made.began, 0.5, made.began, color=color, edgecolor="white")
        label = str(moves.index(made.move) + 1)
        times.text((made.began + made.ended) / 2.0, row, label, ha="center", va="center", color="white")
    for axes, title in (
        (graph, "who waits for whom, in the plan's order"),
        (times, "released and ended, cells of way"),
    ):
        axes.set_title(title)
        axes.set_yticks(list(rows.values()), list(rows))
        axes.set_ylim(min(rows.values()) - 0.6, 0.6)
    graph.set_xticks([])
    graph.set_xlim(-0.6, len(moves) - 0.4)
    figure.savefig(str(path), dpi=90)
    return path


def _why(scene: PlanScene, path: Path) -> Path:
    """A goal that cannot be reached, and the change that ``why`` names made."""
    figure = Figure(figsize=(13.0, 7.2), layout="constrained")
    FigureCanvasAgg(figure)
    request = scene.request()
    (goal,) = request.goals
    answer = why(goal, Circumstances(request, None, PlannerParams()))
    (change,) = next(cause.changes for cause in answer.causes if cause.changes)
    boxes = [
        _shifted(box, change.offset) if f"boxes[{i}]" == change.thing else box for i, box in enumerate(scene.boxes)
    ]
    made = replace(scene, boxes=tuple(boxes))
    for i, (shown, title) in enumerate(((scene, f"{goal} cannot be reached"), (made, str(change)))):
        axes = figure.add_subplot(1, 2, i + 1)
        draw_map(axes, shown)
        robot = shown.robots[0]
        draw_obstacle(axes, Space(Shape(robot, shown.spec, ()), shown.occupied()).free[0])
        draw_robot(axes, shown.spec, robot, robot.start, COLORS[0], 0.55)
        plan = make_planner("yarm").plan(shown.request(), np.random.default_rng(0)).robots[robot.name]
        way = np.array([waypoint.column for waypoint in plan.path] or [robot.start.column])
        axes.plot(way[:, 0], way[:, 1], "-o", color=COLORS[0], lw=2, ms=4)
        axes.plot(*shown.goals[goal].column, marker="*", ms=16, color=COLORS[0], mec="black", ls="none")
        axes.set_title(f"{plan.status.value}: {title}")
    figure.savefig(str(path), dpi=90)
    return path


def _shifted(box: Box, offset: Tuple[int, int]) -> Box:
    x0, x1, y0, y1, z0, z1 = box
    return x0 + offset[0], x1 + offset[0], y0 + offset[1], y1 + offset[1], z0, z1


if __name__ == "__main__":
    draw_pictures(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/images"))
