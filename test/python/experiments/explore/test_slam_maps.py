"""Figure 1 with SLAM: what lies outside the room, and short runs of the three controllers in physics."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path

import pytest

from python.experiments.explore_samples import ROOM, perfect_map, record_of
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.slam_maps import outside
from yarm.experiments.study.reproduce import main
from yarm.geometry import Pose2

JUDGE = Judge(ROOM)


def test_a_true_map_lies_inside_and_a_shifted_one_as_far_outside_as_it_was_shifted() -> None:
    record = record_of(perfect_map(JUDGE))
    true = outside(record, JUDGE)
    assert true.share == 0.0 and true.farthest_m < 0.1
    moved = replace(record, world_from_map=Pose2(0.2, 0.0).compose(record.world_from_map))
    shifted = outside(moved, JUDGE)
    assert shifted.farthest_m == pytest.approx(true.farthest_m + 0.2, abs=0.051) and 0.05 < shifted.share < 0.5


def test_without_a_map_nothing_is_outside() -> None:
    none = outside(replace(record_of(perfect_map(JUDGE)), map=None), JUDGE)
    assert math.isnan(none.share) and none.farthest_m == 0.0


def test_the_maps_of_practice_are_drawn_and_each_has_a_row(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["--study", "explore_slam", "--twins", "0", "--speed-seeds", "0", "--map-seconds", "12"]
    assert main([*asked, "--results", str(tmp_path)]) == 0
    printed = capsys.readouterr().out
    with (tmp_path / "explore_practice_slam_table.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [row["controller"] for row in rows] == ["report_printed", "report", "yarm"]
    for row in rows:
        assert f"| {row['controller']} | {row['share, %']} |" in printed and 0.0 < float(row["share, %"]) < 60.0
        assert float(row["pose RMSE, mm"]) < 50.0
    assert (tmp_path / "explore_practice_slam.png").stat().st_size > 5000
    with (tmp_path / "explore_practice_slam.csv").open() as stream:
        assert {row["controller"] for row in csv.DictReader(stream)} == {"report_printed", "report", "yarm"}
