"""The Commander's ledger of a recorded mission: its hash, what it tells of the rest, and reading it back."""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

from yarm.commander.events import DecisionKind
from yarm.experiments.run.record import DecisionRow, GoalRecord, PauseRecord, WaypointRow

PAUSE_HEARD_S = 0.5
"""A manipulator is heard to be switched within this of the decision, s."""


class LedgerError(ValueError):
    """A ledger that cannot be used; the message names the file and what is wrong."""


def ledger_hash(rows: Sequence[DecisionRow]) -> str:
    """SHA-256 over all entries in order, in hex; of times those since the first entry count."""
    digest = hashlib.sha256()
    for row in rows:
        values = (row.number, row.time_ms - rows[0].time_ms, row.kind, row.robot, row.goal, row.text)
        digest.update((json.dumps(values) + "\n").encode())
    return digest.hexdigest()


def read_ledger(path: Path) -> Tuple[DecisionRow, ...]:
    """The entries of a ``decisions.csv``.

    Raises:
        LedgerError: there is none, or it is not one.
    """
    try:
        with path.open(newline="") as stream:
            rows = [_row(values) for values in csv.DictReader(stream)]
    except (OSError, KeyError, TypeError, ValueError) as error:
        raise LedgerError(f"{path}: no ledger of a mission: {error}") from error
    if [row.number for row in rows] != list(range(1, len(rows) + 1)):
        raise LedgerError(f"{path}: its entries are not numbered from 1 on, one after the other")
    return tuple(rows)


def _row(values: Dict[str, str]) -> DecisionRow:
    number, time_ms = int(values["number"]), int(values["time_ms"])
    return DecisionRow(number, time_ms, values["kind"], values["robot"], values["goal"], values["text"])


def difference(before: Sequence[DecisionRow], now: Sequence[DecisionRow]) -> str:
    """The first entry in which a ledger differs from what it repeats, as far as it goes; empty when in none."""
    for old, new in zip(before, now):
        fields = [field.name for field in dataclasses.fields(DecisionRow) if field.name != "time_ms"]
        changed = [name for name in fields if getattr(old, name) != getattr(new, name)]
        late_ms = (new.time_ms - now[0].time_ms) - (old.time_ms - before[0].time_ms)
        if changed or late_ms:
            when = f", {late_ms / 1e3:+.3f} s" if late_ms else ""
            return f"decision {old.number} is {words(new)}{when}, and was {words(old)}"
    return ""


def words(row: DecisionRow) -> str:
    """An entry in words."""
    return " ".join(part for part in (row.kind, row.robot, row.goal) if part) + (f" ({row.text})" if row.text else "")


class Told:
    """What a ledger tells of goals, waypoints and pauses."""

    def __init__(self, rows: Sequence[DecisionRow]) -> None:
        """Of a whole mission."""
        self._seen: Dict[str, DecisionRow] = {}
        self._given: Dict[Tuple[str, str], str] = {}
        self._verdicts: Dict[str, List[str]] = {}
        self._paused: Dict[str, List[DecisionRow]] = {}
        for row in rows:
            if row.kind == DecisionKind.SEEN:
                self._seen.setdefault(row.goal, row)
            elif row.kind == DecisionKind.ASSIGN:
                self._given[row.robot, row.goal] = row.text
            elif row.kind == DecisionKind.SEND and ";" in row.text:
                self._verdicts.setdefault(row.robot, []).append(row.text.partition("; ")[2])
            elif row.kind == DecisionKind.SWITCH:
                self._paused.setdefault(row.robot, []).append(row)

    def of_goal(self, goal: GoalRecord) -> GoalRecord:
        """A goal with when it was first seen, and why its robot was sent."""
        seen, why = self._seen.get(goal.name), self._given.get((goal.robot, goal.name), "")
        if seen is None:
            return replace(goal, why=why)
        return replace(goal, seen_s=seen.time_ms / 1e3, cameras=seen.text, why=why)

    def of_waypoint(self, row: WaypointRow) -> WaypointRow:
        """A waypoint with the checker's verdict: a robot's n-th one is of its n-th step."""
        verdicts = self._verdicts.get(row.robot, [])
        return replace(row, verdict=verdicts[row.index]) if row.index < len(verdicts) else row

    def of_pause(self, pause: PauseRecord) -> PauseRecord:
        """A pause with its cause."""
        latest_ms = 1e3 * (pause.start_s + PAUSE_HEARD_S)
        switched = [row for row in self._paused.get(pause.manipulator, []) if row.time_ms <= latest_ms]
        last: Optional[DecisionRow] = switched[-1] if switched else None
        if last is None or not last.text.startswith("OFF"):
            return pause
        return replace(pause, cause=last.text.partition("; ")[2])
