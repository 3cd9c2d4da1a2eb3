"""Writes one exploration's results: summary, map, tables; the same files for kinematic runs and for physics."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, Dict, Mapping, Optional, Sequence, Tuple

import yaml

from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.measures import SHARES, Measures
from yarm.experiments.explore.record import CoverageRow, ExploreRecord, PathRow, TouchRow
from yarm.experiments.run.writers import plain_values, write_events, write_rows
from yarm.navigation.map_file import write_map

TABLES = ("coverage", "path", "bumps", "events")
FILES = ("summary.yaml", "map.pgm", "map.yaml", *(f"{name}.csv" for name in TABLES))
TARGET_SHARE = SHARES[-1]


def write_exploration(
    record: ExploreRecord,
    measures: Measures,
    folder: Path,
    parameters: Optional[Mapping[str, Any]] = None,
    versions: Optional[Mapping[str, str]] = None,
    faults: Sequence[str] = (),
    cost: Optional[RunCost] = None,
) -> None:
    """Write all files of a run into a folder, which is made when missing.

    Args:
        record: of the run.
        measures: what it comes to.
        folder: where to.
        parameters: of everybody who took part.
        versions: of what it ran on.
        faults: what went wrong besides: a run that broke off is no success.
        cost: of the run; None where nobody measured it.

    Raises:
        MapFileError: the map cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    summary = summary_of(record, measures, parameters or {}, versions or {}, faults, cost)
    (folder / "summary.yaml").write_text(yaml.safe_dump(summary, sort_keys=False, width=120))
    if record.map is not None:
        write_map(record.map, folder / "map")
    write_rows(folder / "coverage.csv", CoverageRow, record.coverage)
    write_rows(folder / "path.csv", PathRow, record.path)
    write_rows(folder / "bumps.csv", TouchRow, record.touches)
    write_events(record.events, folder / "events.csv")


def faults_of(measures: Measures) -> Tuple[str, ...]:
    """Rules that the run did not keep, and a target that it missed; none when it succeeded."""
    if measures.share >= TARGET_SHARE:
        return measures.broken_rules
    missed = f"{100 * measures.share:.1f} % of the mappable area, the target is {100 * TARGET_SHARE:.0f} %"
    return (*measures.broken_rules, missed)


def success(measures: Measures) -> bool:
    """The run kept the rules and mapped enough."""
    return not faults_of(measures)


def summary_of(
    record: ExploreRecord,
    measures: Measures,
    parameters: Mapping[str, Any],
    versions: Mapping[str, str],
    faults: Sequence[str] = (),
    cost: Optional[RunCost] = None,
) -> Dict[str, Any]:
    """What summary.yaml holds: plain values, null for what is not a finite number."""
    wrong = [*faults, *faults_of(measures)]
    values = dataclasses.asdict(measures)
    times = values.pop("times")
    return {
        "case": "explore",
        "arena": record.arena,
        "controller": record.controller,
        "seed": record.seed,
        "mode": record.mode,
        "success": not wrong,
        "outcome": record.outcome.value,
        "faults": wrong,
        "end_s": plain_values(record.end_s),
        "done": record.done,
        "reason": record.reason,
        **{f"time_to_{100 * share:.0f}_s": plain_values(time) for share, time in zip(SHARES, times)},
        **plain_values(values),
        "behaviours_s": plain_values({name: round(s, 1) for name, s in sorted(record.behaviours.items())}),
        "obstacles_first_seen_s": plain_values(record.first_seen),
        "bump_list": [plain_values(dataclasses.asdict(touch)) for touch in record.touches],
        "cost": None if cost is None else _cost_of(cost),
        "versions": dict(versions),
        "parameters": plain_values(parameters),
    }


def _cost_of(cost: RunCost) -> Dict[str, Any]:
    rates = {"real_time_factor": cost.real_time_factor, "cores": cost.cores}
    values: Dict[str, Any] = plain_values({**rates, **dataclasses.asdict(cost)})
    return values
