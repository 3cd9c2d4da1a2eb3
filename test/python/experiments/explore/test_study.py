"""The study's table, targets and figures, from made-up results whose answers are known."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any, List, Sequence

import pytest

from python.experiments.explore_samples import ROOM, path_row, perfect_map, record_of
from yarm.experiments.explore.figures import plot_final_maps, write_study
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.measures import Measures, Obstacles, measure
from yarm.experiments.explore.study import (
    ABLATED,
    MENDED,
    ablation_specs,
    known_controllers,
    median,
    median_text,
    mended_specs,
    paired_times,
    starts_in_contact,
    table_rows,
    table_specs,
    targets,
)
from yarm.experiments.explore.trial import ExploreResult, ExploreSpec
from yarm.experiments.study.reproduce import main
from yarm.exploration.registry import CONTROLLERS

JUDGE = Judge(ROOM)
BASE: Measures = measure(record_of(perfect_map(JUDGE)), JUDGE)
GOOD = replace(BASE, times=(50.0, 60.0, 80.0), low=Obstacles(2, 2, 2), step_p99_ms=5.0, step_p50_ms=1.0)


def result(arena: str, controller: str, without: str = "", **changes: Any) -> ExploreResult:
    spec = ExploreSpec(arena, controller, 0, without)
    return ExploreResult(spec, replace(GOOD, **changes), 100.0, True, "", tuple([0.5] * 45 + [1.0] * 46), 3.0)


def met(results: Sequence[ExploreResult]) -> List[str]:
    return [target.text for target in targets(results) if not target.met]


ARENAS = [f"rooms_{i}" for i in range(5)]


def test_every_controller_meets_every_arena_and_report_is_taken_apart() -> None:
    specs = table_specs(8, known_controllers())
    assert set(known_controllers()) == set(CONTROLLERS) and len(specs) == 8 * len(CONTROLLERS)
    assert {spec.arena.split("_")[0] for spec in specs} == {"rooms", "corridors", "clutter", "bricks"}
    parts = [*ablation_specs(8), *mended_specs(8)]
    assert len({spec.key for spec in [*specs, *parts]}) == len(specs) + 8 * (len(ABLATED) + len(MENDED))


def test_a_median_counts_what_was_never_reached() -> None:
    assert median([1.0, math.inf, 3.0]) == 3.0 and median([1.0, 2.0]) == 1.5 and math.isnan(median([]))
    assert median_text([1.0, math.inf, math.inf], False) == "-"
    assert median_text([5.0] * 9, True) == "5 (5 to 5)"


def test_good_runs_meet_every_target_and_bad_ones_name_theirs() -> None:
    slow = {"times": (100.0, 200.0, math.inf)}
    rivals = [result(a, c, **slow) for a in ARENAS for c in ("explore_lite", "nearest", "report")]
    assert met([*(result(a, "yarm") for a in ARENAS), *rivals]) == []
    cases = {
        "share >= 99 %": {"share": 0.95},
        "share never below": {"share": 0.80},
        "every obstacle at scan height": {"tall": Obstacles(3, 2, 2)},
        "low obstacles detected": {"low": Obstacles(2, 1, 1)},
        "before any touch": {"low": Obstacles(2, 2, 0)},
        "same thing twice": {"bumped_again": 1},
        "bumps: median": {"bumps": 4},
        "no bump above": {"fastest_bump": 0.2},
        "standing still": {"standing": False},
        "no early end": {"early": True},
        "speed rules": {"too_fast_near_s": 0.1},
        "p99": {"step_p99_ms": 21.0},
        "time to 95 % shorter": {"times": (1.0, 250.0, 300.0)},
        "below explore_lite": {"times": (1.0, 170.0, 300.0)},
    }
    for text, changes in cases.items():
        missed = met([*(result(a, "yarm", **changes) for a in ARENAS), *rivals])
        assert any(text in line for line in missed), text
    assert targets(rivals) == []


def test_pairs_are_of_the_same_arena() -> None:
    ours = [result("rooms_0", "yarm"), result("rooms_1", "yarm")]
    theirs = [result("rooms_1", "nearest", times=(1.0, 2.0, 3.0)), result("rooms_7", "nearest")]
    assert paired_times(ours, theirs) == [(60.0, 2.0)]


def test_the_table_has_a_row_for_each_variant() -> None:
    rows = table_rows([result("rooms_0", "yarm"), result("rooms_0", "report"), result("rooms_0", "report", "frontier")])
    assert [row[0] for row in rows] == ["yarm", "report", "report without frontier"]
    assert rows[0][5] == "60 (60 to 60)" and rows[0][10] == "100 % (34-100), 100 % (34-100)"


def test_everything_is_written(tmp_path: Path) -> None:
    results = [result(a, c) for a in (*ARENAS, "rooms_10") for c in ("report_printed", "report", "yarm")]
    ablation = [result(a, "report", "frontier", share=0.6) for a in ARENAS]
    mended = [result(a, "report_printed", "side_bump", share=0.7) for a in ARENAS]
    text = write_study(results, ablation, mended, tmp_path)
    assert "share never below 90 %" in text and "report_printed" in text
    for name in ("table", "trials", "coverage", "faults", "contact_starts", "ablation", "fault_costs"):
        assert (tmp_path / f"explore_{name}.csv").stat().st_size > 60, name
    for name in ("coverage", "faults", "contact_starts", "ablation", "fault_costs"):
        assert (tmp_path / f"explore_{name}.png").stat().st_size > 5000, name
    with (tmp_path / "explore_ablation.csv").open() as stream:
        rows = {row["variant"]: row for row in csv.DictReader(stream) if row["kind"] == "all"}
    assert float(rows["report without frontier"]["share_median"]) == 60.0 and rows["report"]["runs"] == "5"
    with (tmp_path / "explore_fault_costs.csv").open() as stream:
        rows = {row["variant"]: row for row in csv.DictReader(stream) if row["kind"] == "all"}
    assert set(rows) == {"report_printed", "report_printed without side_bump"}
    assert rows["report_printed without side_bump"]["share_median"] == "70.00"
    with (tmp_path / "explore_contact_starts.csv").open() as stream:
        assert {row["arena"] for row in csv.DictReader(stream)} == {"rooms_0", "rooms_10"}


def test_starts_in_contact_are_known() -> None:
    assert starts_in_contact("rooms_0") and not starts_in_contact("rooms_1")


def test_final_maps_are_drawn_side_by_side(tmp_path: Path) -> None:
    path = tuple(path_row(0.1 * i, 0.02 * i, 0.2) for i in range(21))
    record = replace(record_of(perfect_map(JUDGE)), arena="practice", path=path)
    assert plot_final_maps([record, record], tmp_path / "maps.png").stat().st_size > 5000
    with (tmp_path / "maps.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert record.map is not None
    assert sum(row["what"] == "occupied" for row in rows) == 2 * int(record.map.occupied.sum())
    way = [(row["controller"], row["t_s"], row["x"]) for row in rows if row["what"] == "way"]
    assert way == 2 * [("made_up", "0.0", "0.000"), ("made_up", "1.0", "0.200"), ("made_up", "2.0", "0.400")]


def test_reproduce_runs_the_study_and_goes_on_where_it_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--study", "explore", "--arenas", "1", "--controller", "explore_lite", "--workers", "1"]
    for _ in range(2):
        assert main([*options, "--results", str(tmp_path)]) == 0
        assert "| explore_lite | 1 |" in capsys.readouterr().out
    trials = list((tmp_path / "explore_trials").glob("*.json"))
    assert [path.name for path in trials] == ["rooms_0-explore_lite-0000.json"]
    assert (tmp_path / "explore_table.csv").is_file() and not (tmp_path / "explore_practice.png").exists()
