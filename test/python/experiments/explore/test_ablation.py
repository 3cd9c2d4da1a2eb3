"""The table and figure of `report` without each behaviour, from made-up results whose answers are known."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any, List, Tuple

import pytest

from python.experiments.explore_samples import ROOM, perfect_map, record_of
from yarm.experiments.explore.ablation import FrontierGain, ablation_table, frontier_gains, gain_table, write_ablation
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.measures import Measures, measure
from yarm.experiments.explore.study import ABLATED, by_variant
from yarm.experiments.explore.trial import ExploreResult, ExploreSpec

JUDGE = Judge(ROOM)
BASE: Measures = measure(record_of(perfect_map(JUDGE)), JUDGE)
KINDS = ("rooms", "corridors")


def result(
    arena: str, without: str = "", share: float = 1.0, curve: Tuple[float, ...] = (), **changes: Any
) -> ExploreResult:
    measures = replace(BASE, share=share, times=(50.0, 60.0, 80.0), **changes)
    return ExploreResult(ExploreSpec(arena, "report", 0, without), measures, 100.0, True, "", curve, 3.0)


def lines_of(table: str) -> List[List[str]]:
    return [[cell.strip() for cell in line.strip("| ").split("|")] for line in table.splitlines()]


def test_every_variant_has_a_line_and_every_kind_a_column() -> None:
    shares = {"rooms_0": 0.5, "rooms_1": 0.7, "corridors_0": 0.9}
    results = [result(arena, name, share) for name in ("", *ABLATED) for arena, share in shares.items()]
    header, _, *lines = lines_of(ablation_table(by_variant(results)))
    assert tuple(header[-2:]) == KINDS
    assert [line[0] for line in lines] == ["report", *(f"report without {name}" for name in ABLATED)]
    assert {"places", "search", "stop", "find_exit"} <= set(ABLATED)
    assert lines[0][1:] == ["3", "70.0 (60.0 to 80.0)", "60", "0.0", "60.0", "90.0"]


def test_a_kind_in_which_a_variant_never_ran_is_a_dash() -> None:
    lines = lines_of(ablation_table(by_variant([result("rooms_0"), result("corridors_0", "stop")])))
    assert lines[2][-2:] == ["100.0", "-"] and lines[3][-2:] == ["-", "100.0"]


def test_frontiers_count_from_where_the_runs_part() -> None:
    whole = [result("rooms_0", share=0.9, curve=(0.1, 0.3, 0.4, 0.9)), result("rooms_1", curve=(0.2, 1.0))]
    without = [
        result("rooms_1", "frontier", curve=(0.2, 1.0)),
        result("rooms_0", "frontier", 0.6, (0.1, 0.3, 0.35, 0.6)),
        result("clutter_0", "frontier", 0.1, (0.1,)),
    ]
    first, second = frontier_gains(whole, without)
    assert first == FrontierGain("rooms_0", 10.0, 0.3, 0.9, 0.6) and first.gain == pytest.approx(0.3)
    assert second.arena == "rooms_1" and math.isinf(second.from_s) and second.share_then == 1.0


def test_gains_are_told_by_what_was_mapped_then() -> None:
    gains = [
        FrontierGain("a", 100.0, 0.3, 0.6, 0.7),
        FrontierGain("b", 100.0, 0.5, 0.9, 0.7),
        FrontierGain("c", 100.0, 0.8, 0.9, 0.8),
        FrontierGain("d", math.inf, 1.0, 1.0, 1.0),
    ]
    assert [line[1:] for line in lines_of(gain_table(gains))[2:]] == [
        ["1", "-10.0", "0"],
        ["2", "+15.0", "2"],
        ["1", "+0.0", "0"],
    ]


def test_rows_of_all_kinds_are_written(tmp_path: Path) -> None:
    whole = [result(f"{kind}_0", share=0.9, curve=(0.5, 0.9)) for kind in KINDS]
    elsewhere = result("bricks_3", share=0.1)
    ablation = [result(f"{kind}_0", "frontier", 0.6, (0.5, 0.6), bumps=4) for kind in KINDS]
    text = write_ablation([*whole, elsewhere], ablation, tmp_path)
    assert text + "\n" == (tmp_path / "explore_ablation.md").read_text() and "median gain" in text
    with (tmp_path / "explore_ablation.csv").open() as stream:
        rows = {(row["variant"], row["kind"]): row for row in csv.DictReader(stream)}
    assert set(rows) == {(v, k) for v in ("report", "report without frontier") for k in ("all", *KINDS)}
    assert rows["report", "all"]["runs"] == "2" and rows["report", "all"]["share_median"] == "90.00"
    assert rows["report without frontier", "rooms"]["bumps_mean"] == "4.00"
    with (tmp_path / "explore_frontier_gain.csv").open() as stream:
        gains = list(csv.DictReader(stream))
    assert [(row["from_s"], row["share_then"]) for row in gains] == 2 * [("0.0000", "0.5000")]
    assert (tmp_path / "explore_ablation.png").stat().st_size > 5000
