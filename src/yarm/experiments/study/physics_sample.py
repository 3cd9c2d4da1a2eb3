"""A sample of the study's trials repeated in full physics, through the whole system, and how well the two agree."""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple

import yaml

from yarm.commander.params import Execution
from yarm.experiments.run.missions import experiment_command, launch
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.run.writers import is_finished
from yarm.experiments.statistics import Proportion, percentile
from yarm.experiments.study.design import FITTED, YARM, table_study
from yarm.experiments.study.trial import TrialResult, TrialSpec, raster_share
from yarm.geometry.kinds import ContactKind
from yarm.planning.model.hidden import HiddenPolicy

LIMIT_S = 120.0
"""Simulated time a run may take; in the kinematic world no trial that arrives takes half of it."""
POINTS_LIMIT = 5.0
LENGTH_LIMIT = 5.0


@dataclass(frozen=True)
class PhysicsResult:
    """One trial in full physics.

    Attributes:
        spec: the trial it repeats.
        solved: the end effector reached its goal (ground truth).
        clean: solved, and nothing was touched.
        path_m: way of the end effector, metres.
        waypoints: waypoints sent.
        refused: planning steps whose motions the independent checker refused or, for `original`, would have refused.
        faults: what was wrong, in sentences.
    """

    spec: TrialSpec
    solved: bool
    clean: bool
    path_m: float
    waypoints: int
    refused: int
    faults: Tuple[str, ...]


def sample_specs(count: int, planners: Sequence[str]) -> List[TrialSpec]:
    """The trials to repeat: from every cell of the table, as evenly as the count allows, the lowest seeds first."""
    study = replace(table_study(count), variants=tuple(v for v in (FITTED, YARM) if v[0] in planners))
    return study.specs()[:count]


def run_sample(
    specs: Sequence[TrialSpec], folder: Path, on_progress: Callable[[int, int, str], None]
) -> List[PhysicsResult]:
    """Run what has no results yet, one after the other, and read all."""
    results = []
    for done, spec in enumerate(specs):
        on_progress(done, len(specs), spec.key)
        summary = summary_file(folder, spec)
        if not is_finished(summary.parent):
            folder.mkdir(parents=True, exist_ok=True)
            with (folder / f"{spec.key}.log").open("w") as log:
                launch(command(folder, spec), log)
        results.append(read_result(spec, summary))
    on_progress(len(specs), len(specs), "")
    return results


def command(folder: Path, spec: TrialSpec) -> List[str]:
    """The run that repeats a trial: the same planner, seed and share of the raster done, what no camera sees free.

    In steps; ``original`` is unguarded.
    """
    options = {
        "--case": spec.scene,
        "--seed": spec.seed,
        "--planner": spec.planner,
        "--execution": Execution.STEPS.value,
        "--hidden": HiddenPolicy.FREE.value,
        "--particles": spec.particles,
        "--raster": f"{raster_share(spec.seed):.4f}",
        "--limit": LIMIT_S,
        "--results": cell_folder(folder, spec),
    }
    flags = ["--unguarded"] if spec.planner == "original" else []
    flags += [] if spec.replanning else ["--planned-once"]
    return [*experiment_command(), *flags, *(str(word) for option in options.items() for word in option)]


def cell_folder(folder: Path, spec: TrialSpec) -> Path:
    """Where the runs of a cell of the table leave their results."""
    return folder / f"{spec.planner}-{'replanning' if spec.replanning else 'once'}-{spec.particles:04d}"


def summary_file(folder: Path, spec: TrialSpec) -> Path:
    """Where the run leaves its results."""
    return cell_folder(folder, spec) / spec.scene / str(spec.seed) / "summary.yaml"


def read_result(spec: TrialSpec, summary: Path) -> PhysicsResult:
    """What a run came to; one without results is not solved."""
    try:
        values: Mapping[str, Any] = yaml.safe_load(summary.read_text())
    except FileNotFoundError:
        return PhysicsResult(spec, False, False, float("nan"), 0, 0, ("no results",))
    robots, goals = list(values["robots"].values()), list(values["goals"].values())
    solved = bool(goals) and all(goal["reached"] for goal in goals)
    touched = any(contact["kind"] == ContactKind.FAILURE for contact in values["contacts"])
    path_m = robots[0]["path_m"] if robots else float("nan")
    waypoints = robots[0]["waypoints"] if robots else 0
    refused = values["steps"]["refused"]
    return PhysicsResult(spec, solved, solved and not touched, path_m, waypoints, refused, tuple(values["faults"]))


HEADER = (
    "planner",
    "re-planning",
    "N",
    "solved, physics",
    "solved, kinematic",
    "the same, trial by trial",
    "nothing touched, physics",
    "nothing touched, kinematic",
    "path m, physics",
    "path m, kinematic",
    "agree",
)


def compare(physics: Sequence[PhysicsResult], kinematic: Sequence[TrialResult]) -> List[Tuple[str, ...]]:
    """One row for each planner with and without re-planning, over all numbers of particles, in both worlds.

    Shares are of the same trials; ways are medians of the trials solved in both worlds.
    """
    by_spec = {result.spec: result for result in kinematic}
    rows = []
    for planner, replanning in sorted({(r.spec.planner, r.spec.replanning) for r in physics if r.spec in by_spec}):
        mine = [
            r for r in physics if (r.spec.planner, r.spec.replanning) == (planner, replanning) and r.spec in by_spec
        ]
        both = [(r, by_spec[r.spec]) for r in mine]
        solved = [Proportion(sum(pair[i].solved for pair in both), len(both)) for i in (0, 1)]
        clean = [Proportion(sum(pair[i].clean for pair in both), len(both)) for i in (0, 1)]
        alike = Proportion(sum(a.solved == b.solved for a, b in both), len(both))
        ways = [percentile([pair[i].path_m for pair in both if pair[0].solved and pair[1].solved], 50) for i in (0, 1)]
        points = 100.0 * abs(solved[0].rate - solved[1].rate)
        length = 100.0 * abs(ways[0] / ways[1] - 1.0)
        good = points <= POINTS_LIMIT and length <= LENGTH_LIMIT
        rows.append(
            (
                planner,
                "yes" if replanning else "no",
                str(len(mine)),
                *(share.text() for share in (*solved, alike, *clean)),
                *(f"{way:.2f}" for way in ways),
                f"{'yes' if good else 'no'}: {points:.0f} points, {length:.1f} %",
            )
        )
    return rows


def write_sample(physics: Sequence[PhysicsResult], kinematic: Sequence[TrialResult], folder: Path) -> str:
    """``physics.csv`` and ``physics.md``; the Markdown text."""
    by_spec = {result.spec: result for result in kinematic}
    with (folder / "physics.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        measured = ["solved", "clean", "path_m", "waypoints"]
        asked = ["planner", "margin_cells", "replanning", "particles", "seed"]
        writer.writerow([*asked, *measured, *(f"{name}_kinematic" for name in measured), "refused", "faults"])
        for r in physics:
            other: Optional[TrialResult] = by_spec.get(r.spec)
            twin = ["", "", "", ""]
            if other is not None:
                twin = [str(int(other.solved)), str(int(other.clean)), f"{other.path_m:.3f}", str(len(other.sent))]
            cell = [r.spec.planner, r.spec.margin_cells, int(r.spec.replanning), r.spec.particles, r.spec.seed]
            own = [int(r.solved), int(r.clean), f"{r.path_m:.3f}", r.waypoints]
            writer.writerow([*cell, *own, *twin, r.refused, "; ".join(r.faults)])
    text = markdown_table(HEADER, compare(physics, kinematic))
    (folder / "physics.md").write_text(text + "\n")
    return text
