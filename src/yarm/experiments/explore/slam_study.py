"""Explorations with SLAM: the benchmark's twins in physics, the report's explorer at two speeds, maps of `practice`."""

from __future__ import annotations

import argparse
import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Sequence, Tuple

from yarm.experiments.explore import slam_maps
from yarm.experiments.explore.slam_trial import KINEMATIC, PHYSICS, SLAM_TRIALS, SlamResult, SlamSpec
from yarm.experiments.explore.study import median
from yarm.experiments.explore.trial import ExploreResult, ExploreSpec
from yarm.experiments.explore.trials import EXPLORE_TRIALS
from yarm.experiments.run.plots import new_figure, save_figure
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import bootstrap_interval
from yarm.experiments.study.runner import Progress, run_trials
from yarm.sim.scenes.arena_maker import benchmark_names

EVERY = 9
"""Every so many-th arena of the benchmark has a twin: all four kinds come."""
TRUE_MAP_S = 1.0
"""Between two maps in the trials without SLAM."""
SHARE_APART, TIME_APART = 0.02, 0.10
"""Twins may differ by so much in their share, and in their time to 95 % as a part of it."""
TIME_TICKS_S = (10, 20, 50, 100, 200, 500, 1000)
SPEED_ARENA = "practice"
WALL_MEAN_M, WALL_P95_M, SPURIOUS, POSE_M, CORE = 0.03, 0.07, 0.01, 0.03, 0.01
"""Targets for the saved map, the live pose, and SLAM's share of a core."""
TWIN_HEADER = (
    "arena",
    "share: kinematic, physics with SLAM, %",
    "s to 95 %: kinematic",
    "with SLAM, a map a second",
    "with SLAM, a map in 5 s",
    "physics with SLAM, a map in 5 s",
    "wall error, mean, 95 %, mm",
    "cells > 10 cm off, %",
    "pose RMSE, mm",
    "SLAM, % of a core",
    "bumps: kinematic, physics",
)
SPEED_FIELDS = ("wall error, mm", "cells > 10 cm off, %", "heading RMSE, deg", "pose RMSE, mm", "share, %", "bumps")


@dataclass(frozen=True)
class Twins:
    """The same arena, controller and seed, from the kinematic world to physics.

    Attributes:
        plain: kinematic, the map from the true pose, once a second.
        mapped: kinematic with SLAM, maps as often.
        rarer: kinematic with SLAM, maps as often as the node's.
        physics: in physics, with SLAM, maps as often as the node's.
    """

    plain: ExploreResult
    mapped: SlamResult
    rarer: SlamResult
    physics: SlamResult

    @property
    def times_s(self) -> Tuple[float, float, float, float]:
        """To 95 %."""
        results = (self.plain, self.mapped, self.rarer, self.physics)
        a, b, c, d = (result.measures.times[1] for result in results)
        return a, b, c, d

    @property
    def share_kept(self) -> bool:
        """The shares at the end are as near as they should be."""
        return abs(self.physics.measures.share - self.plain.measures.share) <= SHARE_APART

    @property
    def time_kept(self) -> bool:
        """The times to 95 % are as near as they should be; so are two that never came."""
        first, last = self.times_s[0], self.times_s[-1]
        return first == last or (math.isfinite(first) and abs(last - first) <= TIME_APART * first)


def add_options(options: argparse.ArgumentParser) -> None:
    """Options of this part."""
    options.add_argument("--twins", type=int, default=10, help="arenas of the exploration study repeated in physics")
    options.add_argument("--twin-controller", default="yarm", help="who explores them")
    options.add_argument("--speed-seeds", type=int, default=30, help="runs of report at each speed, with SLAM")
    options.add_argument("--speed-world", default=KINEMATIC, choices=(KINEMATIC, PHYSICS), help="where they are run")
    slam_maps.add_options(options)


def twin_specs(count: int, controller: str) -> List[Tuple[ExploreSpec, SlamSpec, SlamSpec, SlamSpec]]:
    """Plain, mapped, rarer, physics for each arena."""
    return [
        (
            ExploreSpec(arena, controller, 0),
            SlamSpec(arena, controller, 0, KINEMATIC, map_s=TRUE_MAP_S),
            SlamSpec(arena, controller, 0, KINEMATIC),
            SlamSpec(arena, controller, 0, PHYSICS),
        )
        for arena in benchmark_names()[::EVERY][:count]
    ]


def speed_specs(seeds: int, world: str) -> List[SlamSpec]:
    """`report` in `practice` at 0.2 and at 0.3 m/s, paired."""
    return [SlamSpec(SPEED_ARENA, "report", seed, world, fast) for seed in range(seeds) for fast in (False, True)]


def slam_explorations(options: argparse.Namespace, folder: Path, progress: Callable[[str], Progress]) -> str:
    """Run all parts; the text to print.

    Raises:
        StudyError: trials failed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    where = (options.scheduler, options.workers)
    rows = twin_specs(options.twins, options.twin_controller)
    plain = run_trials(
        EXPLORE_TRIALS, [row[0] for row in rows], folder / "explore_trials", *where, progress("explore, plain twins")
    )
    specs = [spec for row in rows for spec in row[1:]]
    mapped = run_trials(SLAM_TRIALS, specs, folder / "explore_slam_trials", *where, progress("explore, twins"))
    twins = [Twins(first, *mapped[3 * i : 3 * i + 3]) for i, first in enumerate(plain)]
    speeds = run_trials(
        SLAM_TRIALS,
        speed_specs(options.speed_seeds, options.speed_world),
        folder / "explore_slam_trials",
        *where,
        progress("explore, speeds"),
    )
    texts = [write_twins(twins, folder)] if twins else []
    texts += [write_speeds(speeds, folder)] if speeds else []
    if options.map_seconds > 0.0:
        texts.append(slam_maps.slam_maps(options.map_seconds, folder, progress("explore, maps")))
    return "\n\n".join(texts)


def write_twins(twins: Sequence[Twins], folder: Path) -> str:
    """Table, targets, figure and CSV of the twins; the text to print."""
    table = markdown_table(TWIN_HEADER, [_twin_row(pair) for pair in twins])
    text = f"{table}\n\n" + "\n".join(f"- {line}" for line in twin_targets(twins))
    (folder / "explore_twins.md").write_text(text + "\n")
    write_slam_trials(
        [result for pair in twins for result in (pair.mapped, pair.rarer, pair.physics)], folder / "explore_twins.csv"
    )
    plot_twins(twins, folder / "explore_twins.png")
    return text


def twin_targets(twins: Sequence[Twins]) -> List[str]:
    """What is asked of twins and of SLAM, beside what was measured; one sentence each."""
    m = [pair.physics.measures for pair in twins]
    n = len(m)

    def met(values: Sequence[float], limit: float) -> int:
        return sum(value <= limit for value in values)

    walls, tails = [x.wall.mean_m for x in m], [x.wall.p95_m for x in m]
    spurious, poses = [x.wall.spurious for x in m], [x.pose_rmse_m for x in m]
    cores = [pair.physics.slam_core for pair in twins]
    return [
        f"share within {100 * SHARE_APART:g} points: {sum(pair.share_kept for pair in twins)} of {n}",
        f"time to 95 % within {100 * TIME_APART:g} %: {sum(pair.time_kept for pair in twins)} of {n}",
        f"wall error, mean <= {1e3 * WALL_MEAN_M:g} mm: {met(walls, WALL_MEAN_M)} of {n}, worst {1e3 * max(walls):.1f}",
        f"95th percentile <= {1e3 * WALL_P95_M:g} mm: {met(tails, WALL_P95_M)} of {n}, worst {1e3 * max(tails):.1f}",
        f"<= {100 * SPURIOUS:g} % of the cells farther than 10 cm: {met(spurious, SPURIOUS)} of {n}, "
        f"worst {100 * max(spurious):.2f}",
        f"live pose RMSE <= {1e3 * POSE_M:g} mm: {met(poses, POSE_M)} of {n}, worst {1e3 * max(poses):.1f}",
        f"SLAM <= {100 * CORE:g} % of a core: {met(cores, CORE)} of {n}, worst {100 * max(cores):.2f}",
    ]


def _twin_row(pair: Twins) -> Tuple[str, ...]:
    plain, physics = pair.plain.measures, pair.physics.measures
    return (
        pair.plain.spec.arena,
        f"{100 * plain.share:.1f}, {100 * physics.share:.1f}",
        *(f"{time:.0f}" if math.isfinite(time) else "-" for time in pair.times_s),
        f"{1e3 * physics.wall.mean_m:.1f}, {1e3 * physics.wall.p95_m:.1f}",
        f"{100 * physics.wall.spurious:.2f}",
        f"{1e3 * physics.pose_rmse_m:.1f}",
        f"{100 * pair.physics.slam_core:.2f}",
        f"{plain.bumps}, {physics.bumps}",
    )


def plot_twins(twins: Sequence[Twins], path: Path) -> Path:
    """Time to 95 % of each arena, step by step from the kinematic world to physics."""
    figure, axes = new_figure(8.0, 4.6)
    axis = axes[0]
    for pair in twins:
        ends = "" if math.isfinite(pair.times_s[-1]) else " (never in physics)"
        axis.plot(range(4), pair.times_s, "o-", ms=4, alpha=0.7, label=pair.plain.spec.arena + ends)
    steps = ("kinematic,\ntrue map, 1 s", "kinematic,\nSLAM, 1 s", "kinematic,\nSLAM, 5 s", "physics,\nSLAM, 5 s")
    axis.set_xticks(range(4))
    axis.set_xticklabels(steps, fontsize="small")
    axis.set(ylabel="s to 95 %", yscale="log")
    shown = [time for pair in twins for time in pair.times_s if math.isfinite(time)]
    ticks = [tick for tick in TIME_TICKS_S if shown and min(shown) <= 2 * tick and tick <= 2 * max(shown)]
    axis.yaxis.set_ticks(ticks, labels=[str(tick) for tick in ticks])
    axis.yaxis.set_ticks([], minor=True)
    axis.grid(True, alpha=0.3, which="both")
    axis.legend(fontsize="x-small", loc="center left", bbox_to_anchor=(1.01, 0.5))
    return save_figure(figure, path)


def write_speeds(results: Sequence[SlamResult], folder: Path) -> str:
    """Figure 3, its CSV and table: what a higher speed does to the map; the text to print."""
    write_slam_trials(results, folder / "explore_speeds.csv")
    groups = {fast: [speed_values(r) for r in results if r.spec.fast == fast] for fast in (False, True)}
    world, count = results[0].spec.world, len(groups[False])
    rows = []
    for name in SPEED_FIELDS:
        slow, fast = ([values[name] for values in groups[key]] for key in (False, True))
        apart = [b - a for a, b in zip(slow, fast)]
        low, high = bootstrap_interval(apart, lambda sample: median(list(sample)))
        rows.append(
            (name, f"{median(slow):.2f}", f"{median(fast):.2f}", f"{median(apart):+.2f} ({low:+.2f} to {high:+.2f})")
        )
    header = (f"median of {count} runs, {world}", "0.2 m/s", "0.3 m/s", "of the differences (95 % interval)")
    text = markdown_table(header, rows)
    (folder / "explore_speeds.md").write_text(text + "\n")
    plot_speeds(groups, folder / "explore_speeds.png")
    return text


def speed_values(result: SlamResult) -> Dict[str, float]:
    """What is compared, by SPEED_FIELDS."""
    m = result.measures
    values = (
        1e3 * m.wall.mean_m,
        100 * m.wall.spurious,
        math.degrees(result.heading_rmse_rad),
        1e3 * m.pose_rmse_m,
        100 * m.share,
        float(m.bumps),
    )
    return dict(zip(SPEED_FIELDS, values))


def plot_speeds(groups: Dict[bool, List[Dict[str, float]]], path: Path) -> Path:
    """Wall error and heading error at both speeds, a point a run, a line a seed."""
    shown = (SPEED_FIELDS[0], SPEED_FIELDS[2], SPEED_FIELDS[3])
    figure, axes = new_figure(10.5, 4.2, len(shown))
    for axis, name in zip(axes, shown):
        slow, fast = ([values[name] for values in groups[key]] for key in (False, True))
        for a, b in zip(slow, fast):
            axis.plot((0, 1), (a, b), "o-", ms=3, lw=0.6, color="tab:blue", alpha=0.5)
        axis.boxplot([slow, fast], positions=(-0.25, 1.25), widths=0.2, showfliers=False)
        axis.set_xticks((0, 1))
        axis.set_xticklabels(("0.2 m/s", "0.3 m/s"))
        most = max((value for value in slow + fast if math.isfinite(value)), default=1.0)
        axis.set(ylabel=name, xlim=(-0.5, 1.5), ylim=(0, 1.08 * most))
        axis.grid(True, axis="y", alpha=0.3)
    return save_figure(figure, path)


def write_slam_trials(results: Sequence[SlamResult], path: Path) -> None:
    """One line a trial."""
    header = ["world", "arena", "controller", "fast", "map_s", "seed", "share", "t90_s", "t95_s", "t99_s", "end_s"]
    header += ["done", "distance_m", "turning_rad", "bumps", "fastest_bump", "too_fast_s", "too_fast_near_s"]
    header += ["standing", "wall_mean_m", "wall_p95_m", "spurious", "fitted_mean_m", "fit_x", "fit_y", "fit_yaw"]
    header += ["pose_rmse_m", "worst_pose_m", "heading_rmse_rad", "slam_core", "keyframes", "unmatched"]
    header += ["low", "low_detected", "low_untouched", "step_p50_ms", "step_p99_ms", "reason"]
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(header)
        for result in results:
            writer.writerow(_csv_row(result))


def _csv_row(r: SlamResult) -> List[Any]:
    s, m = r.spec, r.measures
    row: List[Any] = [s.world, s.arena, s.controller, int(s.fast), s.map_s, s.seed, f"{m.share:.5f}", *m.times]
    row += [r.end_s, int(r.done), f"{m.distance_m:.2f}", f"{m.turning_rad:.1f}", m.bumps, f"{m.fastest_bump:.3f}"]
    row += [f"{m.too_fast_s:.1f}", f"{m.too_fast_near_s:.1f}", int(m.standing)]
    row += [f"{value:.4f}" for value in (m.wall.mean_m, m.wall.p95_m, m.wall.spurious, m.wall_fitted.mean_m)]
    row += [f"{value:.4f}" for value in (m.fit.x, m.fit.y, m.fit.yaw_rad, m.pose_rmse_m, r.worst_pose_m)]
    row += [f"{r.heading_rmse_rad:.5f}", f"{r.slam_core:.5f}", r.keyframes, r.unmatched]
    row += [m.low.count, m.low.detected, m.low.untouched, f"{m.step_p50_ms:.2f}", f"{m.step_p99_ms:.2f}", r.reason]
    return row
