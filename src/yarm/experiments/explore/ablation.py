"""Figure 5, `report` with each behaviour off, and 6, `report_printed` without its faults; by kind of arena.

And what the report's frontiers brought, from when they began.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, List, Sequence, Tuple

from yarm.experiments.explore.figure_parts import box_figure, number_text, write_csv
from yarm.experiments.explore.study import by_variant, median, median_text
from yarm.experiments.explore.trial import CURVE_STEP_S, ExploreResult
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.statistics import percentile

WHOLE, UNGUIDED = "report", "report without frontier"
EVERY_KIND = "all"
HALF = 0.5
"""The report holds that frontiers pay only once so much is mapped."""
FIELDS = (
    "variant",
    "kind",
    "runs",
    "share_median",
    "share_quartile_1",
    "share_quartile_3",
    "median_t95_s",
    "bumps_mean",
)
FRONTIER_FIELDS = ("arena", "from_s", "share_then", "share_with", "share_without")


@dataclass(frozen=True)
class FrontierGain:
    """What frontiers brought in one arena; until they begin both runs are the same.

    Attributes:
        arena: its name.
        from_s: when the runs part, on the curves' grid; inf when they never do.
        share_then: mapped by then.
        share_with: at the end, with frontiers.
        share_without: at the end, without.
    """

    arena: str
    from_s: float
    share_then: float
    share_with: float
    share_without: float

    @property
    def gain(self) -> float:
        """Share that is there with frontiers and not without."""
        return self.share_with - self.share_without


def write_fault_costs(results: Sequence[ExploreResult], mended: Sequence[ExploreResult], folder: Path) -> str:
    """Figure, CSV file and table of `report_printed` without its faults; the text to print. As ``write_ablation``."""
    return "" if not mended else _write_variants(_groups(results, mended), folder / "explore_fault_costs.md")


def write_ablation(results: Sequence[ExploreResult], ablation: Sequence[ExploreResult], folder: Path) -> str:
    """Figure, CSV files and table of `report` without each behaviour; the text to print, empty without trials.

    Args:
        results: trials of whole controllers; those of the same one in the same arenas are compared with.
        ablation: trials without something.
        folder: where to.
    """
    if not ablation:
        return ""
    groups = _groups(results, ablation)
    gains = frontier_gains(groups.get(WHOLE, []), groups.get(UNGUIDED, []))
    numbers = [(g.from_s, g.share_then, g.share_with, g.share_without) for g in gains]
    named = [(g.arena, *(number_text(value, 4) for value in row)) for g, row in zip(gains, numbers)]
    write_csv(folder / "explore_frontier_gain.csv", FRONTIER_FIELDS, named)
    return _write_variants(groups, folder / "explore_ablation.md", *([gain_table(gains)] if gains else []))


def _groups(results: Sequence[ExploreResult], without: Sequence[ExploreResult]) -> Dict[str, List[ExploreResult]]:
    """By variant, that without nothing first."""
    found = {(r.spec.arena, r.spec.controller) for r in without}
    whole = [r for r in results if not r.spec.without and (r.spec.arena, r.spec.controller) in found]
    return by_variant([*whole, *without])


def _write_variants(groups: Dict[str, List[ExploreResult]], path: Path, *more: str) -> str:
    """Table, and CSV and picture beside it; the text to print.

    Args:
        groups: trials by variant.
        path: of the table.
        more: further tables.
    """
    shares = {name: [100.0 * r.measures.share for r in group] for name, group in groups.items()}
    box_figure(shares, "share at the end, %", path.with_suffix(".png"))
    rows = [_row(name, kind, part) for name, group in groups.items() for kind, part in by_kind(group).items()]
    write_csv(path.with_suffix(".csv"), FIELDS, rows)
    text = "\n\n".join([ablation_table(groups), *more])
    path.write_text(text + "\n")
    return text


def by_kind(group: Sequence[ExploreResult]) -> Dict[str, List[ExploreResult]]:
    """All results, then those of each kind of arena, in the order the kinds first come."""
    kinds: Dict[str, List[ExploreResult]] = {EVERY_KIND: list(group)}
    for result in group:
        kinds.setdefault(kind_of(result.spec.arena), []).append(result)
    return kinds


def kind_of(arena: str) -> str:
    """Kind of a benchmark arena, which its name begins with."""
    return arena.rsplit("_", 1)[0]


def ablation_table(groups: Dict[str, List[ExploreResult]]) -> str:
    """A line a variant: all arenas together, then the median share at the end in each kind."""
    kinds = list(dict.fromkeys(kind_of(r.spec.arena) for group in groups.values() for r in group))
    header = ("variant", "runs", "share at the end: median (quartiles), %", "median s to 95 %", "bumps, mean")
    rows = []
    for name, group in groups.items():
        low, middle, high = _quartiles(group)
        parts = by_kind(group)
        times = median_text([r.measures.times[1] for r in group], False)
        line = (name, str(len(group)), f"{middle:.1f} ({low:.1f} to {high:.1f})", times, f"{_mean_bumps(group):.1f}")
        rows.append((*line, *(f"{_quartiles(parts[kind])[1]:.1f}" if kind in parts else "-" for kind in kinds)))
    return markdown_table((*header, *kinds), rows)


def frontier_gains(whole: Sequence[ExploreResult], without: Sequence[ExploreResult]) -> List[FrontierGain]:
    """What frontiers brought in each arena that both have; the runs are alike until the frontier mode first begins."""
    others = {(r.spec.arena, r.spec.seed): r for r in without}
    pairs = [(r, others[key]) for r in whole for key in [(r.spec.arena, r.spec.seed)] if key in others]
    gains = []
    for a, b in pairs:
        apart = next((i for i, (x, y) in enumerate(zip(a.curve, b.curve)) if x != y), None)
        last = len(a.curve) - 1 if apart is None else max(apart - 1, 0)
        from_s = math.inf if apart is None else CURVE_STEP_S * last
        gains.append(FrontierGain(a.spec.arena, from_s, a.curve[last], a.measures.share, b.measures.share))
    return gains


def gain_table(gains: Sequence[FrontierGain]) -> str:
    """Gains where frontiers began before half was mapped, after it, and where both runs ended alike."""
    began = [g for g in gains if math.isfinite(g.from_s)]
    parts = (
        (f"below {100 * HALF:.0f} %", [g for g in began if g.share_then < HALF]),
        (f"{100 * HALF:.0f} % or more", [g for g in began if g.share_then >= HALF]),
        ("no difference", [g for g in gains if not math.isfinite(g.from_s)]),
    )
    rows = [
        (
            name,
            str(len(part)),
            f"{100 * median([g.gain for g in part]):+.1f}" if part else "-",
            str(sum(g.gain > 0.0 for g in part)),
        )
        for name, part in parts
    ]
    return markdown_table(
        ("mapped when frontiers first made a difference", "runs", "median gain, points", "gained in"), rows
    )


def _row(name: str, kind: str, group: Sequence[ExploreResult]) -> Tuple[Any, ...]:
    low, middle, high = _quartiles(group)
    time = median([r.measures.times[1] for r in group])
    shares = (f"{value:.2f}" for value in (middle, low, high))
    return (name, kind, len(group), *shares, number_text(time), f"{_mean_bumps(group):.2f}")


def _quartiles(group: Sequence[ExploreResult]) -> Tuple[float, float, float]:
    shares = [100.0 * r.measures.share for r in group]
    return percentile(shares, 25), percentile(shares, 50), percentile(shares, 75)


def _mean_bumps(group: Sequence[ExploreResult]) -> float:
    return sum(r.measures.bumps for r in group) / len(group)
