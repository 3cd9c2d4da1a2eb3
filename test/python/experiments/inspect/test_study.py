"""The inspection study: its trials, results as plain values and back, the table and its rows."""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
from pathlib import Path
from typing import Dict, Tuple

import pytest

from yarm.experiments.inspect.study import controllers_of, rounds, saved, specs_of, table, write_rows
from yarm.experiments.inspect.trial import NUMBERS, PHYSICS, InspectResult, InspectSpec, run_trial

NUMBERS_OF_ONE: Dict[str, float] = dict.fromkeys(NUMBERS, 1.0)


def result(controller: str, right: int, end_s: float, unread: Tuple[Tuple[int, str], ...] = ()) -> InspectResult:
    numbers = {**NUMBERS_OF_ONE, "right": float(right), "end_s": end_s}
    return InspectResult(InspectSpec("open", 0, controller, 0), True, 10, numbers, unread)


def test_trials_are_paired_and_kinds_alternate() -> None:
    specs = specs_of(5)
    assert [spec.kind for spec in specs[::2]] == ["open", "wall", "cluster", "corridor", "open"]
    assert [spec.controller for spec in specs[:2]] == ["report", "yarm"]
    assert len({spec.key for spec in specs_of(100)}) == 200


def test_results_come_back_from_plain_values() -> None:
    before = result("yarm", 9, 120.0, ((4, "in doubt after 3 views"),))
    assert InspectResult.from_json(json.loads(json.dumps(before.to_json()))) == before


def test_the_table_counts_rounds_and_names_what_was_not_read() -> None:
    text = table([result("report", 8, 300.0), result("yarm", 10, 100.0), result("yarm", 9, 120.0, ((4, "in doubt"),))])
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert rows[2].split(" | ")[1:4] == ["1", "0", "8 of 10"]
    assert rows[3].split(" | ")[1:4] == ["2", "1", "19 of 20"]
    assert "open_0-yarm-0000, box 4: in doubt" in text


def test_errors_of_the_place_are_given_as_median_and_worst_of_the_rounds_that_had_a_belief() -> None:
    one = result("yarm", 10, 100.0)
    rounds_told = [
        dataclasses.replace(
            one, numbers={**one.numbers, "place_p95_m": off_m, "place_p95_deg": 0.5, "slowest_look_s": look_s}
        )
        for off_m, look_s in ((0.010, 0.3), (0.012, 0.4), (0.020, 0.9), (math.nan, 0.0))
    ]
    (row,) = [line for line in table(rounds_told).splitlines() if line.startswith("| yarm")]
    assert "| 12.0, 20.0; 0.5, 0.5 |" in row and row.split(" | ")[-2] == "0.9"
    lost = dataclasses.replace(rounds_told[0], numbers={**rounds_told[0].numbers, "place_p95_m": math.nan})
    assert "| -; 0.5, 0.5 |" in table([lost])


def test_physics_rounds_are_other_trials_of_the_same_layouts() -> None:
    both = [*specs_of(4), *specs_of(4, world=PHYSICS)]
    assert len({spec.key for spec in both}) == 16
    assert [(s.kind, s.layout, s.controller) for s in both[:8]] == [(s.kind, s.layout, s.controller) for s in both[8:]]


def test_what_is_saved_is_told_of_pairs_alone() -> None:
    (line,) = saved([result("report", 10, 300.0), result("yarm", 10, 120.0)])
    assert "1 pairs: ours is shorter by 60 % (median)" in line
    assert saved([result("yarm", 10, 120.0)]) == []


def test_rows_are_written(tmp_path: Path) -> None:
    write_rows([result("yarm", 10, 100.0)], tmp_path / "rows.csv")
    header, row = (tmp_path / "rows.csv").read_text().splitlines()
    assert header.startswith("layout,controller,seed,kept,boxes,right") and row.startswith("open_0,yarm,0,1,10,10")


def test_a_trial_of_ours(tmp_path: Path) -> None:
    spec = InspectSpec("corridor", 1, "yarm", 0)
    found = run_trial(spec)
    assert found.spec == spec and found.kept and found.boxes == 10 and found.numbers["named_wrong"] == 0.0
    assert dataclasses.asdict(found)["numbers"].keys() == set(NUMBERS)
    kept = tmp_path / "inspect_trials"
    kept.mkdir()
    options = argparse.Namespace(layouts=0, scheduler="", workers=1)
    assert "controller" in rounds(options, tmp_path, lambda done, whole, key: None, [])


@pytest.mark.parametrize(
    "asked, taken", [(None, ["report", "yarm"]), (["yarm"], ["yarm"]), (["nearest", "report"], ["report"])]
)
def test_only_the_controllers_that_are_asked_for_are_run(asked: list, taken: list) -> None:
    assert controllers_of(argparse.Namespace(controller=asked)) == taken
