"""Reproduces the published table and figures: ``rosrun yarm reproduce`` (needs no ROS)."""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import List, Sequence

from yarm.experiments.cells.study import add_options as cell_options
from yarm.experiments.cells.study import cells
from yarm.experiments.explore.figures import MAPPED_IN_PRACTICE, plot_final_maps, write_study
from yarm.experiments.explore.measures import measure
from yarm.experiments.explore.method_figure import plot_method
from yarm.experiments.explore.pictures import plot_exploration
from yarm.experiments.explore.slam_study import add_options as slam_options
from yarm.experiments.explore.slam_study import slam_explorations
from yarm.experiments.explore.study import ablation_specs, known_controllers, mended_specs, table_specs
from yarm.experiments.explore.trial import ExploreSpec, judge_of, parameters_of, run_record
from yarm.experiments.explore.trials import EXPLORE_TRIALS
from yarm.experiments.explore.writers import write_exploration
from yarm.experiments.inspect.study import add_options as inspect_options
from yarm.experiments.inspect.study import inspections
from yarm.experiments.run.missions import run_missions
from yarm.experiments.run.versions import package_versions
from yarm.experiments.run.writers import explore_folder
from yarm.experiments.study.design import PLANNERS, Study, single_study, table_study
from yarm.experiments.study.physics_sample import run_sample, sample_specs, write_sample
from yarm.experiments.study.report import plot_rates, plot_waypoints, write_planning_times, write_table, write_trials
from yarm.experiments.study.runner import StudyError, of_other_code, run_specs, run_trials
from yarm.experiments.study.tag_reproduce import add_options as tag_options
from yarm.experiments.study.tag_reproduce import tags
from yarm.experiments.study.trial import TrialResult
from yarm.exploration.report.params import ReportParams
from yarm.geometry import Pose2

BAR = 40
STUDIES = ("table", "planning_time", "missions", "physics", "explore", "explore_slam", "tags", "inspect", "cells")
HALF_KNOWN_S = 150.0
"""The report's way with frontiers is shown on the map of `practice` at this time."""
IN_PHYSICS = ("missions", "physics", "cells")
"""These launch the whole system."""


def parser() -> argparse.ArgumentParser:
    """Options of ``rosrun yarm reproduce``."""
    options = argparse.ArgumentParser(
        prog="reproduce", description="Run the published studies in the kinematic world and print ours beside theirs."
    )
    options.add_argument("--trials", type=int, default=30, help="seeds for each cell of the table")
    options.add_argument("--time-trials", type=int, default=10, help="seeds for each line of the planning-time figure")
    options.add_argument("--physics-trials", type=int, default=32, help="trials repeated in full physics; needs ROS")
    options.add_argument("--study", choices=STUDIES, action="append", help="only this one; may be repeated")
    options.add_argument("--planner", choices=PLANNERS, action="append", help="only this planner; may be repeated")
    options.add_argument("--arenas", type=int, default=100, help="of the exploration study, kinds alternating")
    options.add_argument(
        "--controller", action="append", help="of the explorations and inspections, only this; may be repeated"
    )
    slam_options(options)
    inspect_options(options)
    tag_options(options)
    cell_options(options)
    options.add_argument("--results", default="results/reproduce", help="folder to write to and to resume from")
    options.add_argument("--scheduler", default="", help="address of a Dask scheduler; default: local processes")
    options.add_argument("--workers", type=int, default=0, help="local processes; 0 for one a core")
    return options


def studies_of(options: argparse.Namespace) -> List[Study]:
    """The studies that are asked for."""
    chosen = [table_study(options.trials), single_study(options.time_trials)]
    wanted = options.study or STUDIES
    planners = options.planner or PLANNERS
    return [
        replace(study, variants=tuple(variant for variant in study.variants if variant[0] in planners))
        for study in chosen
        if study.name in wanted
    ]


class ProgressBar:
    """A line that is written again and again, with the time left."""

    def __init__(self, title: str) -> None:
        """Time counts from now."""
        self._title = title
        self._began = time.monotonic()
        self._at_start = -1

    def __call__(self, done: int, total: int, key: str) -> None:
        """Show that so many of all are done."""
        if self._at_start < 0:
            self._at_start = done
        spent = time.monotonic() - self._began
        fresh = done - self._at_start
        left = f"{spent / fresh * (total - done):5.0f} s left" if fresh else "            "
        filled = BAR * done // max(1, total)
        sys.stdout.write(f"\r{self._title} [{'#' * filled}{'.' * (BAR - filled)}] {done}/{total} {left} {key:45.45}")
        if done == total:
            sys.stdout.write("\n")
        sys.stdout.flush()


def report(study: Study, results: Sequence[TrialResult], folder: Path) -> str:
    """Write the tables and figures of one study; the text to print."""
    write_trials(results, folder / f"{study.name}_trials.csv")
    if study.name == "planning_time":
        return f"figure: {write_planning_times(results, folder)}"
    plot_rates(results, folder / "table.png")
    plot_waypoints(results, folder / "table_waypoints.png", study.scene)
    return write_table(results, folder)


def physics(options: argparse.Namespace, folder: Path) -> str:
    """Repeat a sample in full physics beside its kinematic twins; the text to print."""
    specs = sample_specs(options.physics_trials, options.planner or PLANNERS)
    kinematic = run_specs(specs, folder / "trials", workers=1)
    measured = run_sample(specs, folder / "physics", ProgressBar("physics"))
    return write_sample(measured, kinematic, folder)


def explorations(options: argparse.Namespace, folder: Path) -> List[str]:
    """Run the exploration study; texts to print.

    Raises:
        StudyError: trials failed.
    """
    controllers = [name for name in known_controllers() if name in (options.controller or known_controllers())]
    table = table_specs(options.arenas, controllers)
    less = ablation_specs(options.arenas) if "report" in controllers else []
    better = mended_specs(options.arenas) if "report_printed" in controllers else []
    results, ablation, mended = (
        run_trials(
            EXPLORE_TRIALS, specs, folder / "explore_trials", options.scheduler, options.workers, ProgressBar(title)
        )
        for title, specs in (("explore", table), ("explore, ablation", less), ("explore, faults", better))
    )
    text = write_study(results, ablation, mended, folder)
    practice_runs(controllers, folder)
    return [text]


def practice_runs(controllers: Sequence[str], folder: Path) -> None:
    """Whole runs in `practice` with all their files, their final maps side by side, and the report's frontier mode."""
    judge = judge_of("practice")
    records = []
    for name in (name for name in MAPPED_IN_PRACTICE if name in controllers):
        spec = ExploreSpec("practice", name, 0)
        record = run_record(spec, judge)
        run = explore_folder(folder, record.arena, record.controller, record.seed)
        write_exploration(record, measure(record, judge), run, parameters_of(spec), package_versions())
        plot_exploration(record, judge.arena, run)
        records.append(record)
    if records:
        plot_final_maps(records, folder / "explore_practice.png")
    if "report" in controllers:
        half = run_record(ExploreSpec("practice", "report", 0, time_limit_s=HALF_KNOWN_S), judge)
        if half.map is not None:
            end = half.path[-1]
            plot_method(half.map, Pose2(end.x, end.y, end.yaw), folder / "explore_method.png", ReportParams())


def in_physics(options: argparse.Namespace, folder: Path) -> List[str]:
    """What is asked for that needs the whole system; texts to print."""
    wanted = [name for name in options.study or STUDIES if name in IN_PHYSICS]
    if wanted and shutil.which("rosrun") is None:
        return [f"left out: {', '.join(wanted)}: rosrun is not on PATH (source tools/env.sh)"]
    texts = []
    if "missions" in wanted:
        texts.append(run_missions(folder / "missions", ProgressBar("missions")))
    if "physics" in wanted:
        texts.append(physics(options, folder))
    if "cells" in wanted:
        texts.append(cells(options, folder, ProgressBar))
    return texts


def main(arguments: Sequence[str]) -> int:
    """Run the studies; 0 when every trial could be run, 130 when interrupted (run again to go on)."""
    options = parser().parse_args(arguments)
    folder = Path(options.results)
    for study in studies_of(options):
        others = of_other_code(folder / "trials", study.specs())
        if others:
            sys.stderr.write(
                f"{others} trials of {study.name} in {folder / 'trials'} were made by another version of the code and "
                "are kept; delete them to run them again\n"
            )
        try:
            results = run_specs(
                study.specs(), folder / "trials", options.scheduler, options.workers, ProgressBar(study.name)
            )
        except StudyError as error:
            sys.stderr.write(f"\n{error}\n")
            return 1
        except KeyboardInterrupt:
            sys.stderr.write(f"\ninterrupted; what is done is in {folder / 'trials'}: run the same command to go on\n")
            return 130
        sys.stdout.write("\n" + report(study, results, folder) + "\n\n")
    try:
        texts = explorations(options, folder) if "explore" in (options.study or STUDIES) else []
        texts += (
            [slam_explorations(options, folder, ProgressBar)] if "explore_slam" in (options.study or STUDIES) else []
        )
        texts += [tags(options, folder, ProgressBar)] if "tags" in (options.study or STUDIES) else []
        texts += [inspections(options, folder, ProgressBar)] if "inspect" in (options.study or STUDIES) else []
        texts += in_physics(options, folder)
    except StudyError as error:
        sys.stderr.write(f"\n{error}\n")
        return 1
    except KeyboardInterrupt:
        sys.stderr.write(f"\ninterrupted; what is done is in {folder}: run the same command to go on\n")
        return 130
    for text in texts:
        sys.stdout.write("\n" + text + "\n\n")
    sys.stdout.write(f"numbers and figures: {folder.resolve()}\n")
    return 0
