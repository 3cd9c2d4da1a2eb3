"""What a person sees at the end of a run."""

from __future__ import annotations

import math
from typing import List, Optional, Sequence, Tuple

from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.measures import SHARES, Measures, Obstacles
from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.run.tables import text_table, usage_table

BEHAVIOURS_SHOWN = 8


def summary_table(
    record: ExploreRecord, measures: Measures, faults: Sequence[str], cost: Optional[RunCost] = None
) -> str:
    """What a person wants to know at the end of an exploration.

    Args:
        record: of the run.
        measures: what it comes to.
        faults: what went wrong.
        cost: of the run; None where nobody measured it.
    """
    verdict = "FAILED" if faults else "SUCCESS"
    lines = [
        f"{record.arena}, {record.controller}, seed {record.seed}: {verdict}; {record.reason or 'no reason given'}"
    ]
    lines += [f"  wrong: {fault}" for fault in faults]
    lines += ["", text_table(("measure", "value"), _rows(record, measures))]
    spent = sorted(record.behaviours.items(), key=lambda item: -item[1])[:BEHAVIOURS_SHOWN]
    lines += ["", text_table(("behaviour", "s"), [(name, f"{seconds:.1f}") for name, seconds in spent])]
    if cost is not None:
        lines += ["", _speed(cost), "", usage_table(cost.nodes, "pass")]
    return "\n".join(lines)


def _rows(record: ExploreRecord, m: Measures) -> List[Tuple[str, str]]:
    reached = ", ".join(f"{100 * share:.0f} % {_seconds(at_s)}" for share, at_s in zip(SHARES, m.times))
    return [
        ("mapped", f"{100 * m.share:.1f} % of what can be mapped, {m.known_m2:.1f} m2 known"),
        ("reached", reached),
        ("ended at", f"{record.end_s:.1f} s of {record.time_limit_s:.0f} s"),
        ("driven", f"{m.distance_m:.1f} m, turned {math.degrees(m.turning_rad):.0f} deg"),
        ("bumps", f"{m.bumps}, the fastest at {m.fastest_bump:.2f} m/s, {m.bumped_again} things more than once"),
        ("too fast", f"{m.too_fast_s:.1f} s; towards something near {m.too_fast_near_s:.1f} s"),
        ("at rest after the end", "yes" if m.standing else "no"),
        ("walls of the map", _walls(m)),
        ("pose", f"{1000 * m.pose_rmse_m:.0f} mm off (RMSE)"),
        ("obstacles in the map", f"{_found(m.tall)}; low ones {_found(m.low)}, {m.low.untouched} before any touch"),
        ("loop", f"p50 {m.step_p50_ms:.1f} ms, p99 {m.step_p99_ms:.1f} ms"),
    ]


def _speed(cost: RunCost) -> str:
    return (
        f"{cost.sim_s:.1f} s simulated in {cost.wall_s:.1f} s (real-time factor {cost.real_time_factor:.2f}); "
        f"all nodes together need {cost.cores:.2f} cores to keep up with time"
    )


def _walls(m: Measures) -> str:
    if not m.wall.cells:
        return "none"
    return (
        f"{1000 * m.wall.mean_m:.0f} mm off on average, p95 {1000 * m.wall.p95_m:.0f} mm, "
        f"{100 * m.wall.spurious:.1f} % farther than 100 mm"
    )


def _found(obstacles: Obstacles) -> str:
    return f"{obstacles.detected} of {obstacles.count}"


def _seconds(at_s: float) -> str:
    return f"at {at_s:.0f} s" if math.isfinite(at_s) else "never"
