"""A result folder is complete and says what happened."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import numpy as np
import yaml

from python.experiments.run_samples import SPEC, START_S, TOUCH, good_run
from yarm.experiments.run.cases import CASES, case_of
from yarm.experiments.run.plots import PLOTS, plot_run
from yarm.experiments.run.record import NodeUsage, RunInfo, RunRecord
from yarm.experiments.run.tables import markdown_table, summary_table
from yarm.experiments.run.writers import FILES, TABLES, write_run

PNG = b"\x89PNG\r\n\x1a\n"


def made_up_record(spoilt: bool = False) -> RunRecord:
    recorder = good_run()
    if spoilt:
        recorder.contacts(START_S + 1.0, [TOUCH])
    info = RunInfo(
        "1m1ma",
        3,
        "boundless",
        "succeeded",
        "",
        12.0,
        15.0,
        0.8,
        360,
        {"physics": 4.5},
        {"python": "3"},
        {"a": [1]},
        {"ankurbot_1": {"x": 2.0, "y": 1.5, "heading_deg": 170.0}},
    )
    recorder.step(safe=True)
    recorder.step(safe=False)
    usage = [NodeUsage("commander", 0.2, 6.7, 80.0, 81.0), NodeUsage("simulation", 0.9, 30.0, 300.0, 301.0)]
    return recorder.finish(info, case_of("1m1ma"), 0.12, usage)


def test_a_result_folder_is_complete(tmp_path: Path) -> None:
    record = made_up_record()
    write_run(record, tmp_path)
    obstacles = np.zeros((50, 50), dtype=bool)
    obstacles[20:30, 19:31] = True
    written = plot_run(record, tmp_path, SPEC, obstacles)
    assert {p.name for p in tmp_path.iterdir()} == {*FILES, *PLOTS, "map_ankurbot_1.png"}
    assert all(path.read_bytes().startswith(PNG) and path.stat().st_size > 5000 for path in written)
    for name in TABLES:
        rows = getattr(record, name)
        with (tmp_path / f"{name}.csv").open() as stream:
            read = list(csv.DictReader(stream))
        assert len(read) == len(rows) > 0
        assert list(read[0]) == [f.name for f in dataclasses.fields(rows[0])]


def test_the_summary_holds_what_was_promised(tmp_path: Path) -> None:
    write_run(made_up_record(), tmp_path)
    summary = yaml.safe_load((tmp_path / "summary.yaml").read_text())
    assert summary["success"] is True
    assert summary["robots"]["ankurbot_1"]["goals"] == ["debris_1"]
    assert summary["robots"]["ankurbot_1"]["planning_p50_ms"] == 7.0
    assert summary["real_time_factor"] == 0.8
    near = "ankurbot_1 at 0.21 m"
    assert summary["pauses"] == [{"manipulator": "hc10_barc", "start_s": 6.0, "end_s": 9.0, "cause": near}]
    assert [node["node"] for node in summary["nodes"]] == ["simulation", "commander"]
    assert summary["steps"] == {"planned": 2, "refused": 1}
    assert summary["layout"]["ankurbot_1"] == {"x": 2.0, "y": 1.5, "heading_deg": 170.0}
    assert list(summary)[-3:] == ["layout", "versions", "parameters"]


def test_a_failed_run_says_so_everywhere(tmp_path: Path) -> None:
    record = made_up_record(spoilt=True)
    write_run(record, tmp_path)
    summary = yaml.safe_load((tmp_path / "summary.yaml").read_text())
    assert summary["success"] is False
    assert summary["contacts"][0]["kind"] == "failure"
    text = summary_table(record)
    assert "FAILED" in text
    assert "wrong: ankurbot_1 (arm) touched table" in text


def test_the_summary_table_names_times_nodes_and_pauses() -> None:
    text = summary_table(made_up_record())
    for piece in (
        "SUCCESS",
        "ankurbot_1",
        "debris_1",
        "7.0/11.9",
        "hc10_barc 6.0-9.0 s",
        "simulation",
        "90 %",
        "checker: 1 of 2",
    ):
        assert piece in text


def test_a_run_without_anything_can_be_written_and_drawn(tmp_path: Path) -> None:
    record = RunRecord(RunInfo("x", 0, "boundless"), False, ("nothing happened",))
    write_run(record, tmp_path)
    plot_run(record, tmp_path, SPEC)
    assert (tmp_path / "waypoints.csv").read_text().startswith("time_s,robot,goal")
    assert "nothing happened" in summary_table(record)


def test_every_published_case_is_there() -> None:
    assert set(CASES) - {"soak"} == {
        "1m1ma",
        "2m1ma",
        "1m1ma_bin",
        "2m1ma_bin",
        "3m6_bin",
        "2m2ma",
        "3m",
        "single",
        "1m1ma_target",
    }
    assert CASES["1m1ma"].min_pauses == 1
    assert CASES["2m1ma"].min_replans == 1


def test_markdown_tables_have_a_rule() -> None:
    assert markdown_table(("a", "b"), [("1", "2")]).splitlines()[1] == "| --- | --- |"
