"""A sample of the study's trials repeated in full physics, through the whole system, and how well the two agree."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, List, Mapping, Optional, Sequence, Tuple

import yaml

from yarm.experiments.missions import experiment_command, launch
from yarm.experiments.statistics import Proportion, percentile
from yarm.experiments.tables import markdown_table
from yarm.experiments.trial import TrialResult, TrialSpec, raster_share
from yarm.experiments.writers import is_finished

SCENE = "1m1ma_target"
PARTICLES = 333
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
        faults: what was wrong, in sentences.
    """

    spec: TrialSpec
    solved: bool
    clean: bool
    path_m: float
    waypoints: int
    faults: Tuple[str, ...]


def sample_specs(count: int, planners: Sequence[str]) -> List[TrialSpec]:
    """The trials to repeat: with re-planning, the same number for each planner."""
    return [
        TrialSpec(SCENE, planner, True, PARTICLES, seed)
        for seed in range(-(-count // len(planners)))
        for planner in planners
    ][:count]


def run_sample(
    specs: Sequence[TrialSpec], folder: Path, on_progress: Callable[[int, int, str], None]
) -> List[PhysicsResult]:
    """Run what has no results yet, one after the other, and read all."""
    results = []
    for done, spec in enumerate(specs):
        on_progress(done, len(specs), spec.key)
        summary = summary_file(folder, spec)
        if not is_finished(summary.parent):
            (folder / spec.planner).mkdir(parents=True, exist_ok=True)
            with (folder / f"{spec.key}.log").open("w") as log:
                launch(command(folder, spec), log)
        results.append(read_result(spec, summary))
    on_progress(len(specs), len(specs), "")
    return results


def command(folder: Path, spec: TrialSpec) -> List[str]:
    """The run that repeats a trial: the same planner, seed and share of the raster done; ``original`` unguarded."""
    options = {
        "--case": spec.scene,
        "--seed": spec.seed,
        "--planner": spec.planner,
        "--particles": spec.particles,
        "--raster": f"{raster_share(spec.seed):.4f}",
        "--results": folder / spec.planner,
    }
    unguarded = ["--unguarded"] if spec.planner == "original" else []
    return [*experiment_command(), *unguarded, *(str(word) for option in options.items() for word in option)]


def summary_file(folder: Path, spec: TrialSpec) -> Path:
    """Where the run leaves its results."""
    return folder / spec.planner / spec.scene / str(spec.seed) / "summary.yaml"


def read_result(spec: TrialSpec, summary: Path) -> PhysicsResult:
    """What a run came to; one without results is not solved."""
    try:
        values: Mapping[str, Any] = yaml.safe_load(summary.read_text())
    except FileNotFoundError:
        return PhysicsResult(spec, False, False, float("nan"), 0, ("no results",))
    robots, goals = list(values["robots"].values()), list(values["goals"].values())
    solved = bool(goals) and all(goal["reached"] for goal in goals)
    touched = any(contact["kind"] == "failure" for contact in values["contacts"])
    path_m = robots[0]["path_m"] if robots else float("nan")
    waypoints = robots[0]["waypoints"] if robots else 0
    return PhysicsResult(spec, solved, solved and not touched, path_m, waypoints, tuple(values["faults"]))


HEADER = (
    "planner",
    "N",
    "solved, physics",
    "solved, kinematic",
    "nothing touched, physics",
    "nothing touched, kinematic",
    "path m, physics",
    "path m, kinematic",
    "agree",
)


def compare(physics: Sequence[PhysicsResult], kinematic: Sequence[TrialResult]) -> List[Tuple[str, ...]]:
    """One row for each planner: shares and median ways of the same trials in both worlds."""
    by_spec = {result.spec: result for result in kinematic}
    rows = []
    for planner in sorted({result.spec.planner for result in physics}):
        mine = [r for r in physics if r.spec.planner == planner and r.spec in by_spec]
        theirs = [by_spec[r.spec] for r in mine]
        solved = [Proportion(sum(r.solved for r in group), len(group)) for group in (mine, theirs)]
        clean = [Proportion(sum(r.clean for r in group), len(group)) for group in (mine, theirs)]
        ways = [percentile([r.path_m for r in group if r.solved], 50) for group in (mine, theirs)]
        points = 100.0 * abs(solved[0].rate - solved[1].rate)
        length = 100.0 * abs(ways[0] / ways[1] - 1.0)
        good = points <= POINTS_LIMIT and length <= LENGTH_LIMIT
        rows.append(
            (
                planner,
                str(len(mine)),
                *(share.text() for share in (*solved, *clean)),
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
        writer.writerow(["planner", "seed", *measured, *(f"{name}_kinematic" for name in measured), "faults"])
        for r in physics:
            other: Optional[TrialResult] = by_spec.get(r.spec)
            twin = ["", "", "", ""]
            if other is not None:
                twin = [str(int(other.solved)), str(int(other.clean)), f"{other.path_m:.3f}", str(len(other.sent))]
            own = [r.spec.planner, r.spec.seed, int(r.solved), int(r.clean), f"{r.path_m:.3f}", r.waypoints]
            writer.writerow([*own, *twin, "; ".join(r.faults)])
    text = markdown_table(HEADER, compare(physics, kinematic))
    (folder / "physics.md").write_text(text + "\n")
    return text
