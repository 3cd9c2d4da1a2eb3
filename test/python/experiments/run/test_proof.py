"""The proof sheet, read back: every fact of the records stands in it, and a changed ledger shows."""

from __future__ import annotations

import dataclasses
import math
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Dict, List, Optional, Tuple

import numpy as np
import pytest

from python.experiments.run.test_results import made_up_record
from python.experiments.run_samples import SPEC
from yarm.experiments.run.ledger import LedgerError, difference, ledger_hash, read_ledger
from yarm.experiments.run.proof import write_proof
from yarm.experiments.run.record import RunRecord
from yarm.experiments.run.squares import PartSquares
from yarm.experiments.run.writers import write_run
from yarm.robots.hc10 import Station


class Sheet(HTMLParser):
    """Tables by their id, as rows of texts; addresses that a browser would fetch; points of the drawings."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.tables: Dict[str, List[List[str]]] = {}
        self.fetched: List[str] = []
        self.lines: Dict[str, str] = {}
        self.titles: List[str] = []
        self._table: List[List[str]] = []
        self._cell = self._title = False
        self.feed(path.read_text())

    def handle_starttag(self, tag: str, attrs: List[Tuple[str, Optional[str]]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.fetched += [values[name] for name in ("src", "href") if name in values]
        if tag == "table":
            self._table = self.tables.setdefault(values.get("id", ""), [])
        elif tag == "tr":
            self._table.append([])
        elif tag == "td":
            self._cell = True
            self._table[-1].append("")
        elif tag == "title":
            self._title = True
            self.titles.append("")
        elif tag == "polyline":
            self.lines[values["class"]] = values["points"]

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "title"):
            self._cell = self._title = False

    def handle_data(self, data: str) -> None:
        if self._cell:
            self._table[-1][-1] += data
        elif self._title:
            self.titles[-1] += data

    def facts(self, name: str) -> Dict[str, str]:
        return {row[0]: row[1] for row in self.tables[name] if len(row) == 2}


@pytest.fixture(name="record", scope="module")
def record_fixture() -> RunRecord:
    return made_up_record()


@pytest.fixture(name="sheet", scope="module")
def sheet_fixture(record: RunRecord, tmp_path_factory: pytest.TempPathFactory) -> Sheet:
    obstacles = np.zeros((50, 50), dtype=bool)
    obstacles[20:30, 19:31] = True
    return Sheet(write_proof(record, tmp_path_factory.mktemp("proof") / "proof.html", SPEC, obstacles))


def test_each_debris_is_told_from_first_sight_to_removal(record: RunRecord, sheet: Sheet) -> None:
    (goal,) = record.goals
    assert (goal.seen_s, goal.why) == (0.1, "31.0 cells of way; ankurbot_2 45.2")
    told = sheet.facts("goal-debris_1")
    assert told["first seen"] == f"0.1 s: {goal.cameras}" and "cameras 1, 3" in goal.cameras
    assert told["sent"] == f"ankurbot_1: {goal.why}"
    assert told["least clearance"] == "0.120 m, to table"
    assert told["removed"] == f"reached at {goal.declared_s:.1f} s, its deletion asked for at 10.0 s"
    driven = [row for row in record.path if 0.1 <= row.time_s <= goal.declared_s]
    assert len(sheet.lines["driven"].split()) == len(driven) == 10
    assert len(sheet.lines["planned"].split()) == len(record.planned[0].columns) == 11


def test_every_step_has_its_verdict_and_clearance(record: RunRecord, sheet: Sheet) -> None:
    rows = [row for row in sheet.tables["steps"] if row]
    assert [(float(row[0]), row[1], row[4]) for row in rows] == [
        (way.time_s, way.robot, way.verdict) for way in record.waypoints
    ]
    assert {row[4] for row in rows} == {"safe"}
    assert [row[5] for row in rows if row[5] != "-"] == ["0.120 to table"]


def test_every_square_is_told_when_how_fast_and_at_what_angle_or_why_not(record: RunRecord, sheet: Sheet) -> None:
    told = [row[1] for row in sheet.tables["part-hc10_barc"] if row]
    assert len(told) == len(record.squares) == 96
    sanded = [row for row in record.squares if math.isfinite(row.sanded_s)]
    assert 0 < len(sanded) < 20
    assert all(abs(row.speed_mps - 0.1) < 1e-6 and row.tilt_deg == 0.0 and not row.reason for row in sanded)
    assert sum("sanded at" in text and "0.100 m/s, tool 0.0 deg" in text for text in told) == len(sanded)
    assert sum("not sanded: the mission ended with 50 % of the raster done" in text for text in told) == 96 - len(
        sanded
    )
    assert set(told) <= set(sheet.titles), "the drawing says the same of every square"


def test_pauses_have_cause_and_length_and_all_decisions_are_there(record: RunRecord, sheet: Sheet) -> None:
    assert [row for row in sheet.tables["pauses"] if row] == [["hc10_barc", "6.0", "3.0", "ankurbot_1 at 0.21 m"]]
    assert [int(row[0]) for row in sheet.tables["decisions"] if row] == [row.number for row in record.decisions]
    assert sheet.facts("mission")["hash of all decisions"] == ledger_hash(record.decisions)
    assert not sheet.fetched, "the sheet opens offline"


def test_the_ledger_is_read_back_and_any_change_shows_in_its_hash(record: RunRecord, tmp_path: Path) -> None:
    write_run(record, tmp_path)
    read = read_ledger(tmp_path / "decisions.csv")
    assert read == record.decisions and ledger_hash(read) == ledger_hash(record.decisions)
    later = [dataclasses.replace(row, time_ms=row.time_ms + 500) for row in read]
    assert ledger_hash(later) == ledger_hash(read), "when the mission began does not count"
    changed = [*read[:2], dataclasses.replace(read[2], robot="ankurbot_2"), *read[3:]]
    assert ledger_hash(changed) != ledger_hash(read) != ledger_hash(read[:-1])
    assert not difference(read, later[:5])
    assert re.match("decision 3 is assign ankurbot_2 debris_1 .*, and was assign ankurbot_1", difference(read, changed))
    late = [*read[:4], dataclasses.replace(read[4], time_ms=read[4].time_ms + 33)]
    assert "+0.033 s" in difference(read, late)


def test_what_is_no_ledger_is_refused_with_its_name(record: RunRecord, tmp_path: Path) -> None:
    with pytest.raises(LedgerError, match=r"decisions\.csv: no ledger"):
        read_ledger(tmp_path / "decisions.csv")
    write_run(record, tmp_path)
    lines = (tmp_path / "decisions.csv").read_text().splitlines()
    (tmp_path / "decisions.csv").write_text("\n".join([*lines[:3], *lines[4:]]))
    with pytest.raises(LedgerError, match="numbered from 1"):
        read_ledger(tmp_path / "decisions.csv")


def test_a_tool_that_hovers_sands_nothing_and_a_station_elsewhere_is_seen_there() -> None:
    part = PartSquares("hc10_barc", Station(1.0, 0.5, math.pi / 2))
    for k in range(20):
        part.tool(0.1 * k, (1.25, 0.25, 0.88), (0.0, 0.0, -1.0))
    assert all(row.reason.startswith("the manipulator never came") for row in part.rows(()))
    for k in range(20):
        part.tool(10.0 + 0.1 * k, (0.988 + 0.005 * k, 0.25, 0.850), (0.1, 0.0, -math.sqrt(0.99)))
    sanded = [row for row in part.rows(()) if not row.reason]
    assert sanded and all(abs(row.y_m - 0.25) < 0.06 for row in sanded)
    assert sanded[0].tilt_deg == pytest.approx(5.74, abs=0.01)
    part.shift(-4.0)
    assert sanded[0].sanded_s - next(row for row in part.rows(()) if not row.reason).sanded_s == pytest.approx(4.0)
