"""The youBot's floor as a task of the coursework: cleared in physics, judged by ground truth, and drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Tuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from yarm.experiments.coursework.tasks import Rows, TaskResult
from yarm.geometry import Pose2
from yarm.geometry.solids import Solid
from yarm.manipulation.clearing.arm_work import DROP_TILTS, LIFT_M, PIECE_M
from yarm.manipulation.clearing.floor_space import BASE_X_M, BASE_Y_M
from yarm.manipulation.clearing.mission import FloorMission
from yarm.manipulation.clearing.play import FloorPlayed, FloorRobot, Watch, play_mission, unwatched
from yarm.manipulation.clearing.reachability import ReachMap, reach_map
from yarm.sim.engine.youbot_floor import YoubotFloor
from yarm.sim.scenes.youbot_floor import HALF_M, FloorScene

MOST_N = 30.0
"""What the cup may push a piece with."""
DPI = 110
COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown")


@dataclass(frozen=True, eq=False)
class ClearingResult:
    """A floor that was cleared: its table, the scene, and what was played."""

    task: TaskResult
    scene: FloorScene
    played: FloorPlayed


def clearing(scene: FloorScene, seed: int, say: Callable[[str], None], watch: Watch = unwatched) -> ClearingResult:
    """The youBot clears a floor by itself.

    Args:
        scene: as the file has it; another seed than 0 lays the debris elsewhere.
        seed: of the debris, the slip, what is seen and the planner.
        say: is told what it does.
        watch: looks on.

    Raises:
        MissionError: it cannot begin.
    """
    scene = scene.varied(seed)
    mission = FloorMission(scene, seed=seed, say=say)
    with YoubotFloor(scene, mission.carry, seed) as world:
        played = play_mission(world, mission, FloorRobot(world, seed), watch=watch)
    rows: Rows = [
        (
            name,
            "in the bin" if played.in_bin[name] else "not in the bin",
            str(report.tries),
            f"{max(report.press_n, default=0.0):.0f} N",
            report.reason,
        )
        for name, report in played.pieces.items()
    ]
    way_m = float(np.linalg.norm(np.diff(played.track[:, :2], axis=0), axis=1).sum())
    rows.append(("together", f"{played.duration_s:.0f} s, {way_m:.1f} m", "", f"{played.press_n:.0f} N", ""))
    faults = list(played.faults)
    if played.press_n > MOST_N:
        faults.append(f"the cup pushed with {played.press_n:.0f} N, {MOST_N:g} N is allowed")
    header = (f"{len(scene.debris)} pieces", "by ground truth", "tries", "most on the cup", "why not")
    return ClearingResult(TaskResult("the youBot's floor, in physics", header, rows, tuple(faults)), scene, played)


def draw_clearing(result: ClearingResult, path: Path) -> Path:
    """The reachability maps the stands came from, and the floor with ways and stands."""
    figure = Figure(figsize=(14.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.25))
    rim = result.scene.bin.size[2]
    _draw_map(axes[0], reach_map(PIECE_M[2], LIFT_M), "on a piece on the floor, tool down")
    _draw_map(
        axes[1], reach_map(round(rim + 0.085, 3), 0.0, DROP_TILTS), f"over a rim of {rim:.2f} m, tool down or aslant"
    )
    _draw_floor(axes[2], result)
    figure.savefig(str(path), dpi=DPI)
    return path


def _draw_map(axes: Any, reach: ReachMap, title: str) -> None:
    half = -float(reach.lower[0])
    shown = np.where(reach.quality > 0.0, reach.quality, np.nan)
    image = axes.imshow(shown.T, origin="lower", extent=(-half, half, -half, half), cmap="viridis", vmin=0.0, vmax=1.0)
    axes.figure.colorbar(image, ax=axes, shrink=0.7, label="1: far from limits and singular")
    _outline(axes, Pose2(0.0, 0.0), "black")
    axes.set_title(f"where the cup gets to, {reach.height_m:.2f} m high\n{title}", fontsize=10)
    axes.set_xlabel("x ahead of the base, m")
    axes.set_ylabel("y, m")


def _draw_floor(axes: Any, result: ClearingResult) -> None:
    scene, played = result.scene, result.played
    for name, solid in scene.boxes():
        _solid(axes, solid, "peru" if name == "bin" else "lightgray")
    axes.plot(played.track[:, 0], played.track[:, 1], color="0.6", lw=1.0, zorder=1)
    _outline(axes, scene.start, "black", ":")
    for colour, piece in zip(COLOURS, scene.debris):
        report = played.pieces[piece.name]
        axes.plot(piece.x, piece.y, "*", color=colour, mec="black", ms=13, zorder=5)
        for number, stand in enumerate(report.stands):
            _outline(axes, stand, colour, "-" if number % 2 == 0 else "--")
        axes.plot(
            [], [], color=colour, label=f"{piece.name}: {'in the bin' if played.in_bin[piece.name] else report.reason}"
        )
    axes.legend(fontsize=8, loc="lower right")
    axes.set_xlim(-HALF_M, HALF_M)
    axes.set_ylim(-HALF_M, HALF_M)
    axes.set_aspect("equal")
    axes.set_title(f"stands (solid: picks, dashed: drops)\nand the base's way, {played.duration_s:.0f} s", fontsize=10)


def _outline(axes: Any, pose: Pose2, colour: str, style: str = "-") -> None:
    corners = [(x, y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    placed = [pose.compose(Pose2(BASE_X_M[x], BASE_Y_M[y])) for x, y in corners]
    axes.add_patch(Polygon([(p.x, p.y) for p in placed], closed=True, fill=False, edgecolor=colour, ls=style, lw=1.5))
    front = pose.compose(Pose2(BASE_X_M[1], 0.0))
    axes.plot([pose.x, front.x], [pose.y, front.y], color=colour, ls=style, lw=1.0)


def _solid(axes: Any, solid: Solid, colour: str) -> None:
    x, y, _ = solid.half_extent
    yaw = math.atan2(solid.pose[1, 0], solid.pose[0, 0])
    place = Pose2(float(solid.pose[0, 3]), float(solid.pose[1, 3]), yaw)
    corners: Tuple[Tuple[float, float], ...] = ((-x, -y), (x, -y), (x, y), (-x, y))
    placed = [place.compose(Pose2(float(a), float(b))) for a, b in corners]
    axes.add_patch(Polygon([(p.x, p.y) for p in placed], closed=True, facecolor=colour, edgecolor="black", lw=0.6))
