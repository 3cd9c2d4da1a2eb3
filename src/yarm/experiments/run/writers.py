"""Writes one experiment's results: ``summary.yaml`` and the tables."""

from __future__ import annotations

import csv
import dataclasses
import math
from pathlib import Path
from typing import Any, Dict, Mapping, Protocol, Sequence, Tuple, Type

import yaml

from yarm.experiments.run.ledger import ledger_hash
from yarm.experiments.run.record import DecisionRow, PathRow, RunRecord, SquareRow, TimingRow, WaypointRow

TABLES = ("waypoints", "path", "timing", "decisions", "squares")
FILES = ("summary.yaml", *(f"{name}.csv" for name in TABLES))

CUT_SHORT = "ROS is shutting down"
"""Says in the faults of a run that it did not end by itself."""


def is_finished(folder: Path) -> bool:
    """Whether a run has left its results in a folder and was not cut short: else a study runs it again."""
    summary = folder / "summary.yaml"
    return summary.is_file() and CUT_SHORT not in summary.read_text()


def explore_folder(results: Path, arena: str, controller: str, seed: int) -> Path:
    """Folder of a run below the results: explore/<arena>/<controller>/<seed>; of a file's arena its stem."""
    return results / "explore" / _stem(arena) / controller / str(seed)


def inspect_folder(results: Path, layout: str, controller: str, seed: int) -> Path:
    """Folder of a run below the results: inspect/<layout>/<controller>/<seed>; of a file's layout its stem."""
    return results / "inspect" / _stem(layout) / controller / str(seed)


def _stem(room: str) -> str:
    return Path(room).stem if room.endswith(".yaml") else room


def write_run(record: RunRecord, folder: Path) -> None:
    """Write all files of a run into a folder, which is made when missing."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "summary.yaml").write_text(yaml.safe_dump(summary_of(record), sort_keys=False, width=120))
    write_rows(folder / "waypoints.csv", WaypointRow, record.waypoints)
    write_rows(folder / "path.csv", PathRow, record.path)
    write_rows(folder / "timing.csv", TimingRow, record.timing)
    write_rows(folder / "decisions.csv", DecisionRow, record.decisions)
    write_rows(folder / "squares.csv", SquareRow, record.squares)


def write_rows(path: Path, cls: Type[Any], rows: Sequence[Any]) -> None:
    """Write dataclass instances of one class as CSV; the header stands there even without rows."""
    names = [f.name for f in dataclasses.fields(cls)]
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(names)
        writer.writerows([_cell(getattr(row, name)) for name in names] for row in rows)


class TimedEvent(Protocol):
    """Something that happened in a mission."""

    @property
    def t_s(self) -> float:
        """When, since its start."""

    @property
    def kind(self) -> str:
        """One word."""

    @property
    def details(self) -> Sequence[Tuple[str, Any]]:
        """Names with values."""


def write_events(events: Sequence[TimedEvent], path: Path) -> None:
    """One line an event: time, kind, and its details as name=value."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["t_s", "kind", "details"])
        for event in events:
            details = " ".join(f"{name}={_cell(value)}" for name, value in event.details)
            writer.writerow([f"{event.t_s:.1f}", event.kind, details])


def summary_of(record: RunRecord) -> Dict[str, Any]:
    """Everything but the tables, as plain values for YAML; what is not a finite number becomes null."""
    info = plain_values(dataclasses.asdict(record.info))
    head = {
        "case": info.pop("case"),
        "seed": info.pop("seed"),
        "success": record.success,
        "faults": list(record.faults),
    }
    tail = {name: info.pop(name) for name in ("layout", "versions", "parameters")}
    return {
        **head,
        **info,
        "robots": {robot.name: _named(robot) for robot in record.robots},
        "goals": {goal.name: _named(goal) for goal in record.goals},
        "contacts": [plain_values(dataclasses.asdict(tally)) for tally in record.contacts],
        "pauses": [plain_values(dataclasses.asdict(pause)) for pause in record.pauses],
        "steps": plain_values(dataclasses.asdict(record.steps)),
        "decisions": {"count": len(record.decisions), "hash": ledger_hash(record.decisions)},
        "nodes": [plain_values(dataclasses.asdict(usage)) for usage in record.usage],
        **tail,
    }


def _named(row: Any) -> Dict[str, Any]:
    values: Dict[str, Any] = plain_values(dataclasses.asdict(row))
    del values["name"]
    return values


def plain_values(value: Any) -> Any:
    """Lists, mappings and numbers as YAML has them; what is not a finite number becomes None."""
    if isinstance(value, Mapping):
        return {str(key): plain_values(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain_values(item) for item in value]
    if isinstance(value, (bool, int, str)) or value is None:
        return value
    number = float(value)
    return round(number, 6) if math.isfinite(number) else None


def _cell(value: Any) -> Any:
    return f"{value:.6g}" if isinstance(value, float) else value
