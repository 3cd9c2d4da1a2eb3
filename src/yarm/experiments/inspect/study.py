"""The inspection study: rounds in the benchmark's layouts, ours and the report's paired, and their table."""

from __future__ import annotations

import argparse
import csv
import math
from pathlib import Path
from typing import Callable, List, Sequence

from yarm.experiments.inspect.fault_figure import write_faults
from yarm.experiments.inspect.fault_trial import LAYOUTS, fault_specs
from yarm.experiments.inspect.order_figure import write_orders, write_searches
from yarm.experiments.inspect.practice_figure import write_practice
from yarm.experiments.inspect.rule_figures import write_angles, write_edge_cases
from yarm.experiments.inspect.runner import parameters_of, run_round
from yarm.experiments.inspect.trial import KINEMATIC, NUMBERS, PHYSICS, InspectResult, InspectSpec
from yarm.experiments.inspect.trials import FAULT_TRIALS, INSPECT_TRIALS
from yarm.experiments.inspect.viewpoint_figure import write_viewpoints
from yarm.experiments.inspect.writers import write_inspection
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.run.versions import package_versions
from yarm.experiments.run.writers import inspect_folder
from yarm.experiments.statistics import percentile
from yarm.experiments.study.runner import Progress, run_trials
from yarm.inspection.model import OURS, REPORT
from yarm.sim.scenes.layout_file import find_layout
from yarm.sim.scenes.layout_maker import BENCHMARK

HEADER = (
    "controller",
    "rounds",
    "ten of ten",
    "right of all boxes",
    "wrong tags",
    "home in time",
    "s: median, p95",
    "m driven, median",
    "bumps",
    "place off, 95 % of a round, median and worst: mm; degrees",
    "looking, s",
    "slowest look, s",
    "computing, s",
)
PRACTICE_SEED = 0
PAIRED = (REPORT, OURS)
"""Controllers that are compared in every layout."""


def specs_of(layouts: int, controllers: Sequence[str] = PAIRED, world: str = KINEMATIC) -> List[InspectSpec]:
    """Every controller in the first so many layouts, kinds alternating, paired."""
    names = BENCHMARK[:layouts]
    return [InspectSpec(kind, seed, controller, 0, world) for kind, seed in names for controller in controllers]


def controllers_of(options: argparse.Namespace) -> List[str]:
    """Those of PAIRED that are asked for; both unless some are named."""
    return [name for name in PAIRED if name in (options.controller or PAIRED)]


def table(results: Sequence[InspectResult]) -> str:
    """One row a controller, in markdown, and below it every box of ours that was not read right."""
    groups = {name: [result for result in results if result.spec.controller == name] for name in PAIRED}
    lines = [markdown_table(HEADER, [_row(name, group) for name, group in groups.items() if group])]
    for result in results:
        for box, reason in result.unread if result.spec.controller == OURS else ():
            lines.append(f"\n{result.spec.key}, box {box}: {reason}")
    lines += saved(results)
    return "\n".join(lines)


def saved(results: Sequence[InspectResult]) -> List[str]:
    """How much shorter our round is than the report's in the same layout, seed for seed; a line if any."""
    ends = {(r.spec.kind, r.spec.layout, r.spec.seed, r.spec.controller): r.numbers["end_s"] for r in results}
    shares = [
        1.0 - end_s / ends[(*key[:3], REPORT)]
        for key, end_s in ends.items()
        if key[3] == OURS and (*key[:3], REPORT) in ends
    ]
    if not shares:
        return []
    median, least = 100.0 * percentile(shares, 50), 100.0 * min(shares)
    return [f"\n{len(shares)} pairs: ours is shorter by {median:.0f} % (median), {least:.0f} % at least"]


def _row(controller: str, group: Sequence[InspectResult]) -> List[str]:
    def column(name: str) -> List[float]:
        return [result.numbers[name] for result in group]

    boxes = sum(result.boxes for result in group)
    times = column("end_s")
    return [
        controller,
        str(len(group)),
        str(sum(result.all_right for result in group)),
        f"{sum(column('right')):.0f} of {boxes}",
        f"{sum(column('named_wrong')):.0f}",
        str(sum(result.kept for result in group)),
        f"{percentile(times, 50):.0f}, {percentile(times, 95):.0f}",
        f"{percentile(column('distance_m'), 50):.1f}",
        f"{sum(column('bumps')):.0f}",
        "; ".join(_two(column(name), scale) for name, scale in (("place_p95_m", 1e3), ("place_p95_deg", 1.0))),
        f"{percentile(column('looking_s'), 50):.1f}",
        f"{max(column('slowest_look_s')):.1f}",
        f"{percentile(column('computing_s'), 50):.1f}",
    ]


def _two(values: Sequence[float], scale: float) -> str:
    """Median and most, scaled; those that are not numbers left out (no belief, so no error)."""
    known = [scale * value for value in values if math.isfinite(value)]
    return f"{percentile(known, 50):.1f}, {max(known):.1f}" if known else "-"


def write_rows(results: Sequence[InspectResult], file: Path) -> None:
    """Every trial as a row of CSV."""
    with file.open("w", newline="") as opened:
        rows = csv.writer(opened)
        rows.writerow(["layout", "controller", "seed", "kept", "boxes", *NUMBERS])
        for result in results:
            spec = result.spec
            numbers = [result.numbers[name] for name in NUMBERS]
            rows.writerow(
                [f"{spec.kind}_{spec.layout}", spec.controller, spec.seed, int(result.kept), result.boxes, *numbers]
            )


def add_options(options: argparse.ArgumentParser) -> None:
    """Options of this part."""
    options.add_argument("--layouts", type=int, default=100, help="of the inspection study, kinds alternating")
    options.add_argument(
        "--physics-layouts", type=int, default=100, help="of the same, those whose rounds are run in full physics too"
    )
    options.add_argument(
        "--fault-layouts", type=int, default=len(LAYOUTS), help="layouts in which each known fault is tried"
    )


def inspections(options: argparse.Namespace, folder: Path, progress: Callable[[str], Progress]) -> str:
    """Run the study and draw its figures; the text to print.

    Raises:
        StudyError: trials failed.
    """
    folder.mkdir(parents=True, exist_ok=True)
    controllers = controllers_of(options)
    kinematic = specs_of(options.layouts, controllers)
    physics = specs_of(options.physics_layouts, controllers, PHYSICS)
    texts = [
        rounds(options, folder, progress("inspect"), kinematic),
        rounds(options, folder, progress("inspect, physics"), physics, "inspect_physics"),
        *practice(folder),
    ]
    for world, name in ((KINEMATIC, "inspect_faults"), (PHYSICS, "inspect_faults_physics")):
        faults = run_trials(
            FAULT_TRIALS,
            fault_specs(options.fault_layouts, world),
            folder / "inspect_faults",
            options.scheduler,
            options.workers,
            progress(name.replace("_", ", ")),
        )
        if faults:
            texts.append(write_faults(faults, folder, name))
    return "\n\n".join([*texts, write_edge_cases(folder), f"figure: {write_angles(folder)}"])


def rounds(
    options: argparse.Namespace, folder: Path, progress: Progress, specs: Sequence[InspectSpec], name: str = "inspect"
) -> str:
    """Run rounds in the benchmark's layouts; their table.

    Args:
        options: as parsed.
        folder: to write to and to resume from.
        progress: shows how far it is.
        specs: the rounds.
        name: of the files of rows and table.

    Raises:
        StudyError: trials failed.
    """
    results = run_trials(
        INSPECT_TRIALS,
        specs,
        folder / "inspect_trials",
        options.scheduler,
        options.workers,
        progress,
    )
    write_rows(results, folder / f"{name}_trials.csv")
    text = table(results)
    (folder / f"{name}_table.md").write_text(text + "\n")
    return text


def practice(folder: Path) -> List[str]:
    """Whole rounds in the practice world with all their files, and the figures about it; texts to print."""
    layout = find_layout("practice")
    records = [run_round(layout, controller, PRACTICE_SEED) for controller in PAIRED]
    for record in records:
        info = record.info
        run = inspect_folder(folder, info.layout, info.controller, info.seed)
        write_inspection(record, layout.arena, run, parameters_of(info.controller), package_versions())
    return [
        write_practice(records, layout.arena, folder),
        write_viewpoints(records[0].boxes, layout.arena, folder),
        write_orders(records[0].boxes, folder),
        write_searches(folder),
    ]
