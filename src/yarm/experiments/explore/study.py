"""The exploration study: which trials it is made of, the table of its results, and the targets beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Mapping, Sequence, Tuple

import numpy as np

from yarm.experiments.explore.measures import SHARES
from yarm.experiments.explore.trial import ExploreResult, ExploreSpec
from yarm.experiments.statistics import Proportion, bootstrap_interval, percentile
from yarm.exploration.registry import CONTROLLERS
from yarm.exploration.report.params import BEHAVIOURS
from yarm.exploration.report.printed import FAULTS
from yarm.robots.turtlebot import RADIUS_M
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import TOUCH_M
from yarm.sim.scenes.arena_maker import benchmark_names, find_arena

OURS = "yarm"
RIVALS = ("explore_lite", "nearest", "report")
ORDER = ("report_printed", "report", "nearest", "explore_lite", OURS)
ABLATED = tuple(name for name in BEHAVIOURS if name not in ("deadline", "selection", "forward"))
"""Without selection or driving ahead it stays at the first wall, and the deadline is kept without it: no figures."""
ABLATION_ARENAS = 20
SIDE_BUMP = "side_bump"
MENDED = (SIDE_BUMP, *(f"{SIDE_BUMP}+{name}" for name in FAULTS if name != SIDE_BUMP))
"""Backing in a circle for ever hides what the other faults cost: they are mended where that one is."""
TABLE_HEADER = (
    "controller",
    "runs",
    "share at the end: least, median (95 % interval)",
    ">= 99 %, % of the runs (95 % interval)",
    "median s to 90 % (95 % interval)",
    "to 95 %",
    "to 99 %",
    "bumps: median, p95, most",
    "fastest bump, m/s",
    "bumped again, runs",
    "low obstacles detected, before a touch",
    "too fast near, runs",
    "ended early, runs",
    "pass p99, ms",
)


@dataclass(frozen=True)
class Target:
    """A target and what was measured.

    Attributes:
        text: what is asked for.
        measured: what came out.
        met: whether it is.
    """

    text: str
    measured: str
    met: bool


def known_controllers() -> Tuple[str, ...]:
    """The controllers that there are, worst first as far as one can expect."""
    return tuple(name for name in ORDER if name in CONTROLLERS)


def table_specs(arenas: int, controllers: Sequence[str]) -> List[ExploreSpec]:
    """All controllers in the first so many arenas of the benchmark, paired; arenas outermost."""
    return [ExploreSpec(arena, name, 0) for arena in benchmark_names()[:arenas] for name in controllers]


def ablation_specs(arenas: int) -> List[ExploreSpec]:
    """`report` with each of its behaviours off."""
    names = benchmark_names()[: min(arenas, ABLATION_ARENAS)]
    return [ExploreSpec(arena, "report", 0, without) for arena in names for without in ABLATED]


def mended_specs(arenas: int) -> List[ExploreSpec]:
    """`report_printed` without its faults."""
    names = benchmark_names()[: min(arenas, ABLATION_ARENAS)]
    return [ExploreSpec(arena, "report_printed", 0, without) for arena in names for without in MENDED]


def by_variant(results: Sequence[ExploreResult]) -> Dict[str, List[ExploreResult]]:
    """Results of each variant, in the order they first come."""
    groups: Dict[str, List[ExploreResult]] = {}
    for result in results:
        groups.setdefault(result.spec.variant, []).append(result)
    return groups


def table_rows(results: Sequence[ExploreResult]) -> List[Tuple[str, ...]]:
    """The table, a row a variant; fields of TABLE_HEADER."""
    return [_row(name, group) for name, group in by_variant(results).items()]


def _row(name: str, group: Sequence[ExploreResult]) -> Tuple[str, ...]:
    measures = [result.measures for result in group]
    shares = [m.share for m in measures]
    bumps = [float(m.bumps) for m in measures]
    low = [sum(getattr(m.low, field) for m in measures) for field in ("count", "detected", "untouched")]
    return (
        name,
        str(len(group)),
        f"{100 * min(shares):.1f}, {_interval_text(shares)} %",
        Proportion(sum(share >= 0.99 for share in shares), len(shares)).text(),
        *(median_text([m.times[i] for m in measures], True) for i in range(len(SHARES))),
        f"{percentile(bumps, 50):g}, {percentile(bumps, 95):g}, {max(bumps):g}",
        f"{max(m.fastest_bump for m in measures):.2f}",
        str(sum(m.bumped_again > 0 for m in measures)),
        f"{Proportion(low[1], low[0]).text()}, {Proportion(low[2], low[0]).text()}",
        str(sum(m.too_fast_near_s > 0.0 for m in measures)),
        str(sum(m.early for m in measures)),
        f"{percentile([m.step_p99_ms for m in measures], 50):.1f}",
    )


def median(values: Sequence[float]) -> float:
    """Median that counts what was never reached as later than everything; NaN without values."""
    ordered = sorted(values)
    if not ordered:
        return math.nan
    middle = len(ordered) // 2
    return ordered[middle] if len(ordered) % 2 else 0.5 * (ordered[middle - 1] + ordered[middle])


def median_text(values: Sequence[float], interval: bool) -> str:
    """Median, with its bootstrap interval if wanted; "-" where half never got there."""
    middle = median(values)
    text = f"{middle:.0f}" if math.isfinite(middle) else "-"
    if not interval:
        return text
    low, high = (
        f"{v:.0f}" if math.isfinite(v) else "-" for v in bootstrap_interval(values, lambda sample: median(list(sample)))
    )
    return f"{text} ({low} to {high})"


def _interval_text(shares: Sequence[float]) -> str:
    """Median of shares with its bootstrap interval, in per cent."""
    low, high = bootstrap_interval(shares, lambda sample: median(list(sample)))
    return f"{100 * percentile(shares, 50):.1f} ({100 * low:.1f} to {100 * high:.1f})"


def targets(results: Sequence[ExploreResult]) -> List[Target]:
    """What is asked of ours, beside what it did; nothing without runs of ours."""
    groups = by_variant(results)
    ours = groups.get(OURS, [])
    if not ours:
        return []
    found = _own_targets(ours)
    for rival in RIVALS:
        if rival in groups:
            found += _against(ours, groups[rival], rival)
    return found


def _own_targets(ours: Sequence[ExploreResult]) -> List[Target]:
    m = [result.measures for result in ours]
    n = len(m)
    shares = [x.share for x in m]
    enough, least = sum(share >= 0.99 for share in shares), min(shares)
    bumps = [float(x.bumps) for x in m]
    low, seen, before = (sum(getattr(x.low, f) for x in m) for f in ("count", "detected", "untouched"))
    tall, tall_seen = sum(x.tall.count for x in m), sum(x.tall.detected for x in m)
    p50, p95, fastest = percentile(bumps, 50), percentile(bumps, 95), max(x.fastest_bump for x in m)
    again = sum(x.bumped_again for x in m)
    still = sum(x.standing for x in m)
    violations = sum(x.too_fast_s > 0.0 or x.too_fast_near_s > 0.0 for x in m)
    p99 = max(x.step_p99_ms for x in m)
    return [
        Target("share >= 99 % in 95 of 100 arenas", f"{enough} of {n}", enough >= 0.95 * n),
        Target("share never below 90 %", f"least {100 * least:.1f} %", least >= 0.90),
        Target("every obstacle at scan height in the map", f"{tall_seen} of {tall}", tall_seen == tall),
        Target("low obstacles detected >= 95 %", _percent(seen, low), seen >= 0.95 * low),
        Target("low obstacles before any touch >= 80 %", _percent(before, low), before >= 0.80 * low),
        Target("never bumped into the same thing twice", f"{again} times", again == 0),
        Target("bumps: median 0, 95th percentile 2", f"{p50:g}, {p95:g}", p50 == 0 and p95 <= 2),
        Target("no bump above 0.1 m/s", f"fastest {fastest:.2f} m/s", fastest <= 0.105),
        Target("standing still at the end, every run", f"{still} of {n}", still == n),
        Target("no early end with something left", f"{sum(x.early for x in m)} runs", not any(x.early for x in m)),
        Target("no violation of the speed rules", f"{violations} runs", violations == 0),
        Target("pass of the loop, p99 <= 20 ms", f"worst run {p99:.1f} ms", p99 <= 20.0),
    ]


def _against(ours: Sequence[ExploreResult], theirs: Sequence[ExploreResult], rival: str) -> List[Target]:
    pairs = paired_times(ours, theirs)
    mine, other = median([a for a, _ in pairs]), median([b for _, b in pairs])
    factor = 0.8 if rival == "explore_lite" else 1.0
    asked = "20 % below" if rival == "explore_lite" else "below"
    text = f"{mine:.0f} s against {other:.0f} s" if math.isfinite(other) else f"{mine:.0f} s against never"
    text = f"{text}; in pairs {ratio_text(pairs)}"
    found = [Target(f"median time to 95 % {asked} {rival}'s", text, mine <= factor * other and mine < math.inf)]
    if rival == "report":
        shorter = sum(a < b for a, b in pairs)
        text = f"{shorter} of {len(pairs)}: {Proportion(shorter, len(pairs)).text()}"
        found.append(Target("time to 95 % shorter than report's in 90 of 100 pairs", text, shorter >= 0.9 * len(pairs)))
    return found


def ratio_text(pairs: Sequence[Tuple[float, float]]) -> str:
    """Median of the first time over the second of each pair, with its bootstrap interval; how often the first is less.

    Never over never is 1.
    """
    ratios = [1.0 if a == b else a / b for a, b in pairs]
    low, high = bootstrap_interval(ratios, lambda sample: median(list(sample)))
    sooner = Proportion(sum(a < b for a, b in pairs), len(pairs))
    return f"{median(ratios):.2f} of it ({low:.2f} to {high:.2f}), sooner in {sooner.text()}"


def paired_times(ours: Sequence[ExploreResult], theirs: Sequence[ExploreResult]) -> List[Tuple[float, float]]:
    """Times to 95 % of the arenas and seeds that both have, ours first."""
    other: Mapping[Tuple[str, int], float] = {(r.spec.arena, r.spec.seed): r.measures.times[1] for r in theirs}
    keys = [(r.spec.arena, r.spec.seed) for r in ours]
    return [(r.measures.times[1], other[key]) for r, key in zip(ours, keys) if key in other]


def starts_in_contact(arena: str) -> bool:
    """Whether the robot touches something at its start."""
    made = find_arena(arena)
    gap = float(np.min(FlatBoxes(made.blocks).distances(made.start.x, made.start.y)))
    return gap <= RADIUS_M + TOUCH_M


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.0f} %" if whole else "-"
