"""Tables for people, and summaries for programs: what is not a number never looks like one."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from python.experiments.run_samples import good_run
from yarm.experiments.run.cases import CASES, Case, case_of
from yarm.experiments.run.record import NodeUsage, PathRow, PauseRecord, RunInfo, RunRecord
from yarm.experiments.run.scoring import refused
from yarm.experiments.run.tables import markdown_table, summary_table, text_table, usage_table
from yarm.experiments.run.writers import summary_of, write_rows


@pytest.fixture(name="record")
def record_fixture() -> RunRecord:
    info = RunInfo("1m1ma", 3, "boundless", "succeeded", "", 12.0, 15.0, 0.8, 360)
    return good_run().finish(info, case_of("1m1ma"), 0.12)


def test_columns_are_as_wide_as_their_widest_cell() -> None:
    lines = text_table(("robot", "m"), [("a", "1.00"), ("ankurbot_1", "2")]).splitlines()
    assert lines == ["robot       m", "----------  ----", "a           1.00", "ankurbot_1  2"]


def test_a_table_without_rows_is_its_header() -> None:
    assert text_table(("a", "bc"), []).splitlines() == ["a  bc", "-  --"]
    assert markdown_table(("a", "bc"), []).splitlines() == ["| a | bc |", "| --- | --- |"]


def test_numbers_that_are_none_are_dashes(record: RunRecord) -> None:
    idle = replace(record.robots[0], time_s=math.nan, min_clearance_m=math.inf, goals=(), reached=False, nearest="")
    row = next(line for line in summary_table(replace(record, robots=(idle,))).splitlines() if "ankurbot_1" in line)
    assert "nan" not in row and "inf" not in row
    assert row.split()[:3] == ["ankurbot_1", "nothing", "-"]


def test_many_names_are_cut_and_counted(record: RunRecord) -> None:
    goals = tuple(f"debris_{n}" for n in range(1, 8))
    text = summary_table(replace(record, robots=(replace(record.robots[0], goals=goals),)))
    assert "debris_1, debris_2, debris_3 and 4 more" in text and "debris_4" not in text


def test_a_pause_without_an_end_is_shown_open(record: RunRecord) -> None:
    text = summary_table(replace(record, pauses=(PauseRecord("hc10_barc", 4.0),)))
    assert "manipulator pauses: 1 (hc10_barc 4.0-- s)" in text


def test_shares_are_per_cent_of_a_core() -> None:
    text = usage_table([NodeUsage("simulation", 0.914, math.nan, 300.4, 301.0)], "pass")
    assert "ms a pass" in text.splitlines()[0]
    assert text.splitlines()[-1].split() == ["simulation", "91", "%", "-", "300", "-", "301"]


def test_a_summary_is_plain_yaml_without_numbers_that_are_none(record: RunRecord) -> None:
    idle = replace(record.robots[0], time_s=math.nan, min_clearance_m=math.inf)
    summary = summary_of(replace(record, robots=(idle,)))
    assert summary["robots"]["ankurbot_1"]["time_s"] is None
    assert summary["robots"]["ankurbot_1"]["min_clearance_m"] is None
    assert yaml.safe_load(yaml.safe_dump(summary)) == summary


def test_rows_are_written_with_six_digits_and_a_header(tmp_path: Path) -> None:
    path = tmp_path / "path.csv"
    write_rows(path, PathRow, [PathRow(1.0 / 3.0, "a", 1e-9, 2.0, 0.0, 3.0, 123456.789)])
    with path.open() as stream:
        (row,) = csv.DictReader(stream)
    assert (row["time_s"], row["x_m"], row["robot"], row["column_y"]) == ("0.333333", "1e-09", "a", "123457")
    write_rows(path, PathRow, [])
    assert path.read_text().strip() == "time_s,robot,x_m,y_m,yaw_rad,column_x,column_y"


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"declared_s": math.nan, "status": "unreachable", "reason": "the table is in the way"}, True),
        ({"declared_s": math.nan, "status": "unreachable", "reason": ""}, False),
        ({"declared_s": math.nan, "status": "assigned", "reason": "waits"}, False),
        ({"declared_s": 3.0, "status": "failed", "reason": "late"}, False),
    ],
)
def test_a_refusal_has_a_reason_and_was_never_declared(record: RunRecord, changes: Any, expected: bool) -> None:
    assert refused(replace(record.goals[0], **changes)) is expected


def test_every_case_has_a_title_and_a_limit() -> None:
    for name, case in CASES.items():
        assert isinstance(case, Case)
        assert case.name == name and case.title and case.limit_s > 0.0
