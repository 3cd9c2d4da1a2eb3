"""Figure 1 again with SLAM in physics: final maps of `practice`, and how far they lie outside the room."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

import numpy as np

from yarm.experiments.explore.figure_parts import write_csv
from yarm.experiments.explore.figures import MAPPED_IN_PRACTICE, plot_final_maps
from yarm.experiments.explore.judge import SPURIOUS_M, Judge
from yarm.experiments.explore.measures import Measures, measure
from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.explore.slam_trial import PHYSICS, SlamSpec, run_slam_record
from yarm.experiments.explore.trial import judge_of
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.study.runner import Progress

ARENA = "practice"
HEADER = (
    "controller",
    "share, %",
    "bumps",
    "wall error: mean, 95 %, mm",
    "mean after the best rigid fit, mm",
    "the fit: x, y, mm; yaw, deg",
    "occupied cells > 0.10 m outside, %",
    "farthest outside, mm",
    "pose RMSE, mm",
)


@dataclass(frozen=True)
class Outside:
    """Occupied cells that lie outside the room: beyond the inner faces of its outer walls.

    Attributes:
        share: of them, farther than 0.10 m; NaN without cells.
        farthest_m: the farthest; 0 where none is.
    """

    share: float
    farthest_m: float


def add_options(options: argparse.ArgumentParser) -> None:
    """Options of this part."""
    options.add_argument(
        "--map-seconds", type=float, default=900.0, help="of each run in practice whose map is drawn; 0 for none"
    )


def slam_maps(limit_s: float, folder: Path, progress: Progress) -> str:
    """Run each controller of figure 1 in physics with SLAM; picture, its CSV and table. The text to print.

    Args:
        limit_s: the robot stands from here on.
        folder: where to.
        progress: told of every run.
    """
    judge = judge_of(ARENA)
    records: List[ExploreRecord] = []
    for name in MAPPED_IN_PRACTICE:
        progress(len(records), len(MAPPED_IN_PRACTICE), name)
        records.append(run_slam_record(SlamSpec(ARENA, name, 0, PHYSICS, time_limit_s=limit_s), judge)[0])
    progress(len(records), len(MAPPED_IN_PRACTICE), "")
    plot_final_maps(records, folder / "explore_practice_slam.png")
    rows = [map_row(record.controller, measure(record, judge), outside(record, judge)) for record in records]
    write_csv(folder / "explore_practice_slam_table.csv", HEADER, rows)
    text = markdown_table(HEADER, rows)
    (folder / "explore_practice_slam.md").write_text(text + "\n")
    return text


def outside(record: ExploreRecord, judge: Judge) -> Outside:
    """How far the final map of a run lies outside the room, unaligned."""
    if record.map is None:
        return Outside(math.nan, 0.0)
    points = judge.occupied_points(record.map, record.world_from_map)
    if not len(points):
        return Outside(math.nan, 0.0)
    lower, upper = np.array(judge.arena.lower), np.array(judge.arena.upper)
    beyond = np.maximum(np.maximum(lower - points, points - upper).max(axis=1), 0.0)
    return Outside(float((beyond > SPURIOUS_M).mean()), float(beyond.max()))


def map_row(name: str, measures: Measures, beyond: Outside) -> Tuple[str, ...]:
    """Fields of HEADER."""
    wall, fit = measures.wall, measures.fit
    return (
        name,
        f"{100 * measures.share:.1f}",
        str(measures.bumps),
        f"{1e3 * wall.mean_m:.1f}, {1e3 * wall.p95_m:.1f}",
        f"{1e3 * measures.wall_fitted.mean_m:.1f}",
        f"{1e3 * fit.x:+.0f}, {1e3 * fit.y:+.0f}; {math.degrees(fit.yaw_rad):+.2f}",
        f"{100 * beyond.share:.2f}",
        f"{1e3 * beyond.farthest_m:.0f}",
        f"{1e3 * measures.pose_rmse_m:.1f}",
    )
