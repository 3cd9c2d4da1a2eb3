"""Studies: which trials they are made of, and what their results come to."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Iterable, List, Mapping, Sequence, Tuple

from yarm.experiments.statistics import Proportion, interquartile_text
from yarm.experiments.study.trial import TrialResult, TrialSpec
from yarm.planning.model.params import PlannerParams

PARTICLES = (20, 100, 333, 2496)
Variant = Tuple[str, int]
"""A planner, and the cells it keeps from what stands in the map."""
FITTED = ("original", PlannerParams().original_margin_cells)
"""The publication gives no margin; this one was chosen because its paths have the published numbers of waypoints."""
YARM = ("yarm", 1)
VARIANTS: Tuple[Variant, ...] = (("original", 0), ("original", 1), ("original", 2), YARM)
PLANNERS = ("original", "yarm")
Cell = Tuple[Variant, bool, int]
"""Planner with its margin, re-planning, particles."""


@dataclass(frozen=True)
class Published:
    """One row of the published table, as printed there."""

    waypoints: str
    stationary: str
    moving: str
    stuck: str
    solved: str


PUBLISHED: Mapping[Tuple[bool, int], Published] = {
    (False, 20): Published("5-8", "yes", "yes", "yes", "sometimes"),
    (False, 100): Published("10-14", "sometimes", "sometimes", "sometimes", "sometimes"),
    (False, 333): Published("20-25", "sometimes", "sometimes", "sometimes", "sometimes"),
    (False, 2496): Published("35-40", "no", "sometimes", "no", "yes"),
    (True, 20): Published("5-8", "no", "no", "sometimes", "yes"),
    (True, 100): Published("10-14", "no", "no", "sometimes", "yes"),
    (True, 333): Published("20-25", "no", "no", "no", "yes"),
    (True, 2496): Published("35-40", "no", "no", "no", "yes"),
}
"""The publication's table by re-planning and particles."""


@dataclass(frozen=True)
class Study:
    """A set of trials in one scene.

    Attributes:
        name: for files.
        scene: the scene.
        replanning: with and without, or only one of them.
        trials: seeds for each combination.
        variants: planners with their margins.
        particles: numbers of particles.
    """

    name: str
    scene: str
    replanning: Tuple[bool, ...]
    trials: int
    variants: Tuple[Variant, ...] = (FITTED, YARM)
    particles: Tuple[int, ...] = PARTICLES

    def specs(self) -> List[TrialSpec]:
        """Every trial; seeds outermost, so that an interrupted study is even."""
        return [
            TrialSpec(self.scene, planner, replanning, particles, margin, seed)
            for seed in range(self.trials)
            for planner, margin in self.variants
            for replanning in self.replanning
            for particles in self.particles
        ]


def table_study(trials: int) -> Study:
    """The publication's table: one robot to a target past the moving HC10; `original` with each margin."""
    return Study("table", "1m1ma_target", (False, True), trials, VARIANTS)


def single_study(trials: int) -> Study:
    """The publication's figure: planning time by waypoint in ``single``."""
    return Study("planning_time", "single", (True,), trials)


@dataclass(frozen=True)
class CellSummary:
    """What the trials of one cell of the table come to.

    Attributes:
        planner: "original" or "yarm".
        margin_cells: what it keeps from what stands in the map, cells.
        replanning: with re-planning.
        particles: number of particles.
        trials: trials done.
        first_path: waypoints of the first paths.
        sent: waypoints sent.
        path_m: way of the end effector, metres, of those that solved it.
        time_s: simulated time, s, of those that solved it.
        shares: trials in which it happened: stationary, moving, stuck, solved, clean, elsewhere, free_end.
    """

    planner: str
    margin_cells: int
    replanning: bool
    particles: int
    trials: int
    first_path: Tuple[int, ...]
    sent: Tuple[int, ...]
    path_m: Tuple[float, ...]
    time_s: Tuple[float, ...]
    shares: Mapping[str, Proportion]


def summarise(results: Iterable[TrialResult]) -> List[CellSummary]:
    """One summary for each combination of planner, margin, re-planning and particles, in that order."""
    cells: Dict[Cell, List[TrialResult]] = {}
    for result in results:
        spec = result.spec
        cells.setdefault(((spec.planner, spec.margin_cells), spec.replanning, spec.particles), []).append(result)
    return [_summary(cell, cells[cell]) for cell in sorted(cells)]


def _summary(cell: Cell, results: Sequence[TrialResult]) -> CellSummary:
    happened = {
        "stationary": [bool(r.hits_stationary) for r in results],
        "moving": [bool(r.hits_moving) for r in results],
        "stuck": [r.stuck for r in results],
        "solved": [r.solved for r in results],
        "clean": [r.clean for r in results],
        "elsewhere": [r.declared_elsewhere for r in results],
        "free_end": [r.free_end_touches > 0 for r in results],
    }
    solved = [r for r in results if r.solved]
    (planner, margin_cells), replanning, particles = cell
    return CellSummary(
        planner,
        margin_cells,
        replanning,
        particles,
        len(results),
        tuple(r.first_path for r in results),
        tuple(len(r.sent) for r in results),
        tuple(r.path_m for r in solved),
        tuple(r.time_s for r in solved),
        {name: Proportion(sum(flags), len(results)) for name, flags in happened.items()},
    )


TABLE_HEADER = (
    "planner",
    "margin, cells",
    "re-planning",
    "particles",
    "N",
    "waypoints of the first path (published)",
    "hits stationary (published)",
    "hits moving (published)",
    "stuck (published)",
    "solved (published)",
    "solved, nothing touched",
    "declared elsewhere",
    "touched, end was free",
    "path m",
)


def table_rows(summaries: Sequence[CellSummary]) -> List[Tuple[str, ...]]:
    """Ours beside the published values: rates with 95 % intervals, medians with quartiles."""
    rows: List[Tuple[str, ...]] = []
    for cell in summaries:
        paper = PUBLISHED.get((cell.replanning, cell.particles), Published("-", "-", "-", "-", "-"))
        rows.append(
            (
                cell.planner,
                str(cell.margin_cells),
                "yes" if cell.replanning else "no",
                str(cell.particles),
                str(cell.trials),
                f"{interquartile_text(cell.first_path)} ({paper.waypoints})",
                f"{cell.shares['stationary'].text()} ({paper.stationary})",
                f"{cell.shares['moving'].text()} ({paper.moving})",
                f"{cell.shares['stuck'].text()} ({paper.stuck})",
                f"{cell.shares['solved'].text()} ({paper.solved})",
                cell.shares["clean"].text(),
                cell.shares["elsewhere"].text(),
                cell.shares["free_end"].text(),
                interquartile_text(cell.path_m, 1),
            )
        )
    return rows
