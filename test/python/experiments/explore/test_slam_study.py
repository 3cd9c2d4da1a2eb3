"""The study with SLAM: which trials it is made of, what its tables and figures say of made-up results, a short run."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from python.experiments.explore_samples import ROOM, perfect_map, record_of
from yarm.experiments.explore import slam_study
from yarm.experiments.explore.judge import Judge, WallError
from yarm.experiments.explore.measures import Measures, measure
from yarm.experiments.explore.slam_study import Twins, speed_specs, twin_specs, twin_targets, write_speeds, write_twins
from yarm.experiments.explore.slam_trial import SlamResult, SlamSpec
from yarm.experiments.explore.trial import ExploreResult, ExploreSpec
from yarm.experiments.study.reproduce import main
from yarm.sim.scenes.arena_maker import benchmark_names

JUDGE = Judge(ROOM)
GOOD: Measures = replace(
    measure(record_of(perfect_map(JUDGE)), JUDGE),
    times=(50.0, 60.0, 80.0),
    share=0.998,
    wall=WallError(0.020, 0.05, 0.004, 900),
    pose_rmse_m=0.012,
)


def mapped(spec: SlamSpec, heading_rad: float = 0.01, core: float = 0.004, **changes: Any) -> SlamResult:
    curve = tuple([0.5] * 45 + [1.0] * 46)
    return SlamResult(spec, replace(GOOD, **changes), 100.0, True, "", curve, heading_rad, 0.05, core, 300, 1)


def twins(arena: str = "rooms_0", core: float = 0.004, **physics: Any) -> Twins:
    plain, one, rare, real = next(row for row in twin_specs(10, "yarm") if row[0].arena == arena)
    first = ExploreResult(plain, GOOD, 100.0, True, "", mapped(one).curve, 3.0)
    return Twins(first, mapped(one), mapped(rare, times=(55.0, 70.0, 90.0)), mapped(real, core=core, **physics))


def test_ten_arenas_of_all_kinds_and_pairs_of_the_same_arena_and_seed() -> None:
    rows = twin_specs(10, "yarm")
    arenas = [row[0].arena for row in rows]
    assert len(set(arenas)) == 10 and set(arenas) < set(benchmark_names())
    assert {arena.rsplit("_", 1)[0] for arena in arenas} == {"rooms", "corridors", "clutter", "bricks"}
    for plain, *others in rows:
        assert isinstance(plain, ExploreSpec) and {other.arena for other in others} == {plain.arena}
        assert {(other.controller, other.seed) for other in others} == {("yarm", 0)}
        assert [(other.world, other.map_s) for other in others] == [
            ("kinematic", 1.0),
            ("kinematic", 5.0),
            ("physics", 5.0),
        ]
    speeds = speed_specs(30, "kinematic")
    assert len({spec.key for spec in speeds}) == 60 and [spec.fast for spec in speeds[:2]] == [False, True]
    assert speeds[0].seed == speeds[1].seed and {spec.controller for spec in speeds} == {"report"}


def test_twins_are_alike_within_two_points_and_a_tenth() -> None:
    assert twins().share_kept and twins().time_kept
    assert twins(share=0.979).share_kept and not twins(share=0.977).share_kept
    assert twins(times=(50.0, 66.0, 80.0)).time_kept and not twins(times=(50.0, 66.1, 80.0)).time_kept
    assert not twins(times=(50.0, math.inf, math.inf)).time_kept
    never = replace(twins(), plain=replace(twins().plain, measures=replace(GOOD, times=(math.inf,) * 3)))
    assert not never.time_kept
    assert replace(never, physics=mapped(never.physics.spec, times=(math.inf,) * 3)).time_kept


def test_targets_count_runs_and_name_the_worst() -> None:
    bad = twins("corridors_2", core=0.02, wall=WallError(0.031, 0.08, 0.02, 900), pose_rmse_m=0.04, share=0.9)
    lines = twin_targets([twins(), bad])
    assert [line.split(": ")[1].split(",")[0] for line in lines] == ["1 of 2", "2 of 2", *["1 of 2"] * 5]
    assert (
        "worst 31.0" in lines[2] and "worst 80.0" in lines[3] and "worst 2.00" in lines[4] and "worst 40.0" in lines[5]
    )


def test_the_twins_table_has_a_row_an_arena_and_the_csv_a_line_a_trial(tmp_path: Path) -> None:
    late = twins("corridors_2", times=(50.0, math.inf, math.inf))
    text = write_twins([twins(), late], tmp_path)
    row = next(line for line in text.splitlines() if "corridors_2" in line)
    assert "99.8, 99.8" in row and "| 60 | 60 | 70 | - |" in row and "20.0, 50.0" in row
    assert (tmp_path / "explore_twins.md").read_text().startswith(text[:40])
    with (tmp_path / "explore_twins.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 6 and rows[2]["world"] == "physics" and rows[2]["map_s"] == "5.0"
    assert float(rows[0]["wall_mean_m"]) == 0.02 and rows[5]["t95_s"] == "inf"
    assert (tmp_path / "explore_twins.png").stat().st_size > 5000


def test_the_speeds_are_compared_seed_by_seed(tmp_path: Path) -> None:
    results = [
        mapped(
            spec,
            heading_rad=math.radians(2.0 if spec.fast else 1.0),
            wall=WallError(0.02 + 0.001 * spec.seed + 0.004 * spec.fast, 0.05, 0.01, 900),
        )
        for spec in speed_specs(5, "kinematic")
    ]
    text = write_speeds(results, tmp_path)
    assert "median of 5 runs, kinematic" in text
    assert "| wall error, mm | 22.00 | 26.00 | +4.00 (+4.00 to +4.00) |" in text
    assert "| heading RMSE, deg | 1.00 | 2.00 | +1.00 (+1.00 to +1.00) |" in text
    with (tmp_path / "explore_speeds.csv").open() as stream:
        assert [row["fast"] for row in csv.DictReader(stream)] == ["0", "1"] * 5
    assert (tmp_path / "explore_speeds.png").stat().st_size > 5000


@pytest.mark.parametrize("world", ["kinematic", "physics"])
def test_a_short_study_runs_and_goes_on_where_it_was(
    world: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        slam_study, "speed_specs", lambda n, w: [replace(s, time_limit_s=4.0) for s in speed_specs(n, w)]
    )
    asked = ["--study", "explore_slam", "--twins", "0", "--speed-seeds", "1", "--speed-world", world]
    asked += ["--map-seconds", "0", "--workers", "1", "--results", str(tmp_path)]
    assert main(asked) == 0
    assert f"median of 1 runs, {world}" in capsys.readouterr().out
    files = sorted((tmp_path / "explore_slam_trials").iterdir())
    assert len(files) == 2
    written = [file.read_bytes() for file in files]
    assert main(asked) == 0 and [file.read_bytes() for file in files] == written
