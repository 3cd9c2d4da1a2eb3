"""What if: forks of scenes, runs and live maps clear as the Commander clears, repeat by their seed, and compare."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import List

import numpy as np
import pytest
import yaml
from distributed import LocalCluster

from yarm.commander.params import CommanderParams
from yarm.commander.states import State
from yarm.experiments.study.processes import copies
from yarm.experiments.what_if.answer import answers, table
from yarm.experiments.what_if.ask import alternative, ask, combined, robot_numbers, specs_of
from yarm.experiments.what_if.cell import TUCKED, Cell, Placed, WhatIfError, cell_of_case, cell_of_run
from yarm.experiments.what_if.live import arms_of, cell_of_map
from yarm.experiments.what_if.picture import plot
from yarm.experiments.what_if.trial import WhatIfResult, WhatIfSpec, kinematic, params_of, run_fork
from yarm.experiments.what_if.world import Fork
from yarm.records import plain, read
from yarm.robots.hc10 import AT_ORIGIN, NAME, Station

LIMITS = {"bounded": False, "limit_s": 120.0}


@pytest.fixture(name="cell", scope="module")
def cell_fixture() -> Cell:
    return cell_of_case("1m1ma")


@pytest.fixture(name="results", scope="module")
def results_fixture(cell: Cell) -> List[WhatIfResult]:
    said: List[str] = []
    specs = specs_of(cell, [alternative(""), alternative("robots=2 particles=100")], 2, 5, LIMITS)
    found = ask(specs, kinematic(), said.append)
    assert "2 of 4 runs after" in said[0] and "as it is" in said[0], "the first answers come before the last run"
    assert said[-1].startswith("4 runs in")
    return found


def test_a_fork_clears_and_its_arm_pauses_for_what_lies_near_it(results: List[WhatIfResult]) -> None:
    assert [result.spec.name for result in results] == ["as it is", "robots=2 particles=100"] * 2
    for result in results:
        assert result.cleared and not result.reasons
        assert 3.0 < result.clear_s < 60.0
        assert result.pauses >= 1 and 0.0 < result.paused_s < 60.0
        assert 0.05 < result.least_m < 0.5


def test_the_same_seed_gives_the_same_run_and_another_one_another(results: List[WhatIfResult]) -> None:
    assert run_fork(results[0].spec) == results[0]
    assert results[2].clear_s != results[0].clear_s
    assert WhatIfResult.from_json(json.loads(json.dumps(results[0].to_json()))) == results[0]


def test_copies_of_the_process_find_what_it_finds_itself(results: List[WhatIfResult]) -> None:
    specs = [result.spec for result in results]
    with copies(2) as pool:
        assert ask(specs, kinematic(), lambda text: None, pool=pool) == results


def test_a_cluster_finds_what_this_process_finds(results: List[WhatIfResult]) -> None:
    """As ``--scheduler`` does, with two workers of a Dask cluster on this machine."""
    specs = [result.spec for result in results]
    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster:
        assert ask(specs, kinematic(), lambda text: None, cluster.scheduler_address) == results


def test_answers_stand_side_by_side_with_a_picture(results: List[WhatIfResult], tmp_path: Path) -> None:
    names = ["as it is", "robots=2 particles=100"]
    one, two = answers(results, names)
    times = sorted(result.clear_s for result in results if result.spec.name == names[0])
    assert (one.runs, one.cleared) == (2, 2)
    assert times[0] < one.clear_p50_s < one.clear_p90_s < times[1]
    assert one.least_clearance_m == min(r.least_m for r in results if r.spec.name == names[0])
    failed = replace(results[0], cleared=False, clear_s=math.nan, refusals=3, reasons=("nobody can reach it",))
    (mixed,) = answers([failed, failed, results[2]], names[:1])
    assert (mixed.cleared, mixed.refusals, mixed.reasons) == (1, 6, ("2 x nobody can reach it",))
    assert "as it is: 2 x nobody can reach it" in table([mixed, two])
    assert plot(results, names, tmp_path / "answer.png", "a test").stat().st_size > 5000


def test_a_loaded_hand_passes_over_the_part() -> None:
    """Robots with hands are higher: without, the load's cells were next to the part's, and nobody could leave it."""
    result = run_fork(WhatIfSpec(cell_of_case("2m1ma_bin"), "as it is", (), 1))
    assert result.cleared, result.reasons


def test_a_hand_carries_to_the_bin_which_takes_its_time() -> None:
    result = run_fork(WhatIfSpec(cell_of_case("1m1ma_bin"), "as it is", (), 3))
    assert result.cleared, result.reasons
    assert result.clear_s > 8.0


def test_what_nobody_can_reach_is_told_with_the_reason(cell: Cell) -> None:
    walls = tuple(Placed(f"wall_{k}", "Obstacle", 0.6, y, 0.5, 0.0, (4.0, 0.1, 1.0)) for k, y in enumerate((0.9, -0.9)))
    robots = (Placed("ankurbot_1", "", 0.6, 1.9, 0.0, math.pi),)
    shut = replace(cell, scene="", robots=robots, obstacles=walls)
    fork = Fork(shut, replace(params_of(shut, ()), give_up_s=1.0), 0.3, np.random.default_rng(0))
    assert "debris_1" in fork.run(State.BOUNDLESS, 20.0)
    assert math.isfinite(fork.least_m)


def test_a_live_map_is_forked_as_it_is(cell: Cell) -> None:
    """What a fork's own map shows is forked again: robots, stations, pieces and boxes are where they were."""
    box = Placed("crate", "Obstacle", 1.5, 0.5, 0.25, 0.0, (0.3, 0.3, 0.5))
    first = replace(cell_of_case("1m1ma_bin"), obstacles=(box,))
    fork = Fork(first, CommanderParams(), 0.3, np.random.default_rng(0))
    again = cell_of_map(fork._map(), {NAME: AT_ORIGIN}, (("removal", "bin"),))
    assert [robot.name for robot in again.robots] == [robot.name for robot in first.robots]
    for now, then in zip(again.robots, first.robots):
        assert (now.x, now.y, now.yaw_rad) == pytest.approx((then.x, then.y, then.yaw_rad))
    assert {f.name: f.kind for f in again.fixtures} == {f.name: f.kind for f in first.fixtures}
    assert [(g.name, round(g.x, 1), round(g.y, 1)) for g in again.goals] == [
        (g.name, round(g.x, 1), round(g.y, 1)) for g in first.goals
    ]
    (crate,) = again.obstacles
    assert abs(crate.x - box.x) < 0.1 and abs(crate.y - box.y) < 0.1 and crate.size[0] >= 0.3
    assert read(Cell, json.loads(json.dumps(plain(again)))) == again


def test_every_manipulator_of_a_live_map_is_at_its_own_station() -> None:
    """One at work beside one that is folded; and one whose neighbour, the scene's first, is not told of."""
    first = cell_of_case("2m2ma")
    one, two = first.arms
    stations = {arm.name: Station(arm.x, arm.y, arm.yaw_rad) for arm in first.arms}
    joints = stations[one.name].folded
    folded = replace(first, arms=(replace(one, kind=TUCKED, size=joints), two))
    cell_map = Fork(folded, CommanderParams(), 0.3, np.random.default_rng(0))._map()
    assert arms_of(cell_map) == (one.name, two.name)
    again = cell_of_map(cell_map, stations)
    assert (again.arms, again.obstacles) == (folded.arms, ())
    assert sorted(f.name for f in again.fixtures) == sorted(f.name for f in first.fixtures)
    objects = {name: found for name, found in cell_map.objects.items() if name != one.name}
    alone_map = replace(cell_map, objects=objects)
    assert arms_of(alone_map) == (one.name, two.name), "the plain fixtures are of the first one's station"
    alone = cell_of_map(alone_map, stations)
    assert alone.arms == (two,)
    places = {f.name: (round(f.x, 3), round(f.y, 3)) for f in first.fixtures}
    assert {f.name: (round(f.x, 3), round(f.y, 3)) for f in alone.fixtures} == places


def test_robots_are_taken_away_or_added_where_there_is_room(cell: Cell) -> None:
    assert len(cell.with_robots(3).robots) == 3
    assert len(cell_of_case("3m").with_robots(1).robots) == 1
    for count in (0, 5):
        with pytest.raises(WhatIfError, match="must be within 1 to 4"):
            cell.with_robots(count)


def test_every_combination_is_an_alternative_beside_the_cell_as_it_is() -> None:
    named = [name for name, _ in combined({"robots": robot_numbers("1..2"), "planner": ["yarm", "lacam"]})]
    assert named == ["as it is"] + [f"robots={r} planner={p}" for r in (1, 2) for p in ("yarm", "lacam")]
    assert robot_numbers("1,3") == ["1", "3"]


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ("planner=nonsense", "planner = 'nonsense'"),
        ("speed=3", "speed: unknown parameter"),
        ("particles=1 pause_distance_m=-1", "particles = 1.*pause_distance_m = -1"),
        ("removal=bin", "the cell has no bins"),
        ("hidden=occupied seed=3", "no cameras.*each run has its own"),
        ("robots=two", "robots = 'two'"),
        ("robots=9", "robots = 9: must be within 1 to 4"),
        ("planner", "a setting is NAME=VALUE"),
        ("planner=yarm planner=lacam", "planner stands twice"),
    ],
)
def test_a_faulty_setting_is_refused_with_what_is_allowed(cell: Cell, settings: str, words: str) -> None:
    with pytest.raises(WhatIfError, match=words):
        specs_of(cell, [alternative(settings)], 1, 1, LIMITS)


def test_faulty_questions_are_refused(cell: Cell, tmp_path: Path) -> None:
    for runs in (0, 201):
        with pytest.raises(WhatIfError, match="must be within 1 to 200"):
            specs_of(cell, [alternative("")], runs, 1, LIMITS)
    with pytest.raises(WhatIfError, match="stands twice"):
        specs_of(cell, [alternative(""), alternative("")], 1, 1, LIMITS)
    with pytest.raises(WhatIfError, match="no mobile robots"):
        specs_of(replace(cell, robots=()), [alternative("")], 1, 1, LIMITS)
    with pytest.raises(WhatIfError, match="nothing to clear"):
        specs_of(replace(cell, goals=(), scene=""), [alternative("")], 1, 1, LIMITS)
    with pytest.raises(WhatIfError, match="no such scene"):
        cell_of_case("nowhere")
    with pytest.raises(WhatIfError, match="no results of a mission"):
        cell_of_run(tmp_path, 1.0)
    with pytest.raises(WhatIfError, match="or FIRST"):
        robot_numbers("many")


def test_a_moment_of_a_recorded_run_is_the_cell_as_it_was(tmp_path: Path) -> None:
    """Robots at their newest rows, what was reached left out, what was sanded counted, the run's own settings."""
    whole = cell_of_case("2m1ma")
    first, second = whole.robots
    reached, left = whole.goals
    goals = {reached.name: {"declared_s": 12.0}, left.name: {"declared_s": None}}
    (tmp_path / "summary.yaml").write_text(yaml.safe_dump({"sim_s": 30.0, "goals": goals}))
    said = ["case:=2m1ma", "seed:=2", "vary:=false", "particles:=100", "bag:=false"]
    (tmp_path / "arguments.yaml").write_text(yaml.safe_dump({"arguments": said}))
    rows = [(first.name, 5.0, 1.0, 1.5, 0.1), (first.name, 12.5, 0.9, 1.4, 0.2), (first.name, 12.6, 0.0, 0.0, 0.0)]
    lines = [",".join(map(str, row)) for row in rows]
    (tmp_path / "path.csv").write_text("\n".join(["robot,time_s,x_m,y_m,yaw_rad", *lines]) + "\n")
    (tmp_path / "squares.csv").write_text("sanded_s\n3.0\n9.0\n20.0\n40.0\n")
    found = cell_of_run(tmp_path, 12.5)
    assert [(r.name, r.x, r.y, r.yaw_rad) for r in found.robots] == [
        (first.name, 0.9, 1.4, 0.2),
        (second.name, second.x, second.y, second.yaw_rad),
    ], "the newest row by then; one that has none yet stands at its start"
    assert [goal.name for goal in found.goals] == [left.name]
    assert found.share == 0.5 and ("particles", "100") in found.settings
    assert [goal.name for goal in cell_of_run(tmp_path, 11.9).goals] == [reached.name, left.name]
    with pytest.raises(WhatIfError, match=r"has a mission of 30\.0 s"):
        cell_of_run(tmp_path, 30.1)
    (one,) = [run_fork(spec) for spec in specs_of(found, [alternative("")], 1, 1, LIMITS)]
    assert one.cleared
