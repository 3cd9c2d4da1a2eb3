"""Pictures of a round: the way among the boxes with what was read, and what the time went into."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, List

import numpy as np

from yarm.experiments.explore.pictures import BORDER_M, draw_arena
from yarm.experiments.inspect.record import RoundRecord
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.inspection.model import reading_words
from yarm.inspection.viewpoints import viewpoint
from yarm.sim.scenes.arena import Arena

PICTURES = ("map.png", "time.png")
DOING_COLOURS = {"drive": "tab:blue", "spin": "tab:cyan", "look": "tab:orange", "clear": "tab:red"}
RIGHT, WRONG, NONE = "tab:green", "tab:red", "tab:grey"


def plot_round(record: RoundRecord, arena: Arena, folder: Path) -> List[Path]:
    """Draw the pictures of a round into its folder."""
    figure, axes = new_figure(6.8, 6.8)
    draw_round(axes[0], record, arena)
    written = [save_figure(figure, folder / PICTURES[0])]
    figure, axes = new_figure(9.0, 2.2)
    draw_times(axes[0], record)
    return [*written, save_figure(figure, folder / PICTURES[1])]


def draw_round(axis: Any, record: RoundRecord, arena: Arena) -> None:
    """Boxes coloured by their verdicts, the way driven, and where the robot looked from."""
    draw_arena(axis, arena)
    verdicts = {verdict.box: verdict for verdict in record.verdicts}
    for box in record.boxes:
        verdict, truth = verdicts.get(box.number), record.truth[box.number]
        read = None if verdict is None else verdict.reading.tag
        colour = RIGHT if read == truth else (NONE if read is None or read < 0 else WRONG)
        axis.fill(*record.map_in_world.moved(box.corners()).T, color=colour, alpha=0.5)
        label = f"{box.number}: {'-' if read is None else reading_words(read)}"
        out = record.map_in_world.compose(viewpoint(box, -0.5 * box.size.depth - 0.12, 0).pose)
        axis.annotate(label, (out.x, out.y), fontsize=8, ha="center", va="center")
        face = record.map_in_world.compose(box.face)
        axis.plot([face.x], [face.y], ".", color="black", ms=4)
    way = np.array([(row.true_x, row.true_y) for row in record.path]).reshape(-1, 2)
    axis.plot(way[:, 0], way[:, 1], "-", color="tab:blue", lw=0.9)
    axis.plot(way[:1, 0], way[:1, 1], "o", color="tab:green", ms=7, label="start")
    for look in {(round(look.robot.x, 1), round(look.robot.y, 1), look.box): look for look in record.looks}.values():
        at = record.map_in_world.compose(look.robot)
        axis.arrow(at.x, at.y, 0.15 * math.cos(at.yaw_rad), 0.15 * math.sin(at.yaw_rad), head_width=0.06, color="0.3")
    axis.plot([t.x for t in record.touches], [t.y for t in record.touches], "x", color="tab:orange", ms=7)
    info = record.info
    title = f"{info.layout}, {info.controller}, seed {info.seed}: {record.end_s:.0f} s"
    axis.set(title=title, xlabel="x, m", ylabel="y, m", aspect="equal")
    axis.set(xlim=(arena.lower[0] - BORDER_M, arena.upper[0] + BORDER_M))
    axis.set(ylim=(arena.lower[1] - BORDER_M, arena.upper[1] + BORDER_M))


def draw_times(axis: Any, record: RoundRecord) -> None:
    """The orders along time, and when each box got its verdict."""
    named = set()
    for order in record.orders:
        label = None if order.doing in named else order.doing
        named.add(order.doing)
        hatch = "//" if order.outcome == "failed" else None
        span = order.end_s - order.start_s
        axis.barh(0, span, left=order.start_s, color=DOING_COLOURS[order.doing], label=label, hatch=hatch)
    for verdict in record.verdicts:
        text = f"{verdict.box}: {reading_words(verdict.reading.tag)}"
        axis.annotate(text, (verdict.found_s, 0.45), fontsize=7, rotation=60)
    axis.set(yticks=[], ylim=(-0.5, 1.4), xlim=(0.0, record.end_s), xlabel=f"time, s, of {record.info.time_limit_s:g}")
    axis.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
