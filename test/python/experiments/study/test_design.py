"""The study: trials that repeat, resumption after an interruption, and the table beside the published one."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path
from typing import List

import numpy as np
import pytest

from yarm.experiments.study import runner as study_runner
from yarm.experiments.study.design import PARTICLES, PUBLISHED, single_study, summarise, table_rows, table_study
from yarm.experiments.study.kinematic import KinematicWorld
from yarm.experiments.study.report import planning_times, plot_rates, write_table, write_trials
from yarm.experiments.study.reproduce import main
from yarm.experiments.study.runner import StudyError, load_results, run_specs
from yarm.experiments.study.trial import Trial, TrialResult, TrialSpec, run_trial
from yarm.geometry import GridSpec
from yarm.planning.baselines.original_planner import OriginalPlanner
from yarm.planning.model.params import PlannerParams
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, RobotPlan, Waypoint
from yarm.sim.scenes.scene import load_scene

TINY = [TrialSpec("single", "yarm", True, 20, 1, seed) for seed in range(2)]


def made_up(spec: TrialSpec, **changes: object) -> TrialResult:
    good = TrialResult(
        spec, True, True, 0.02, False, (), (), 0, 5, ((31, 45), (20, 40)), (3.0, 2.0), 5.1, 9.0, 0.12, "arrived"
    )
    return dataclasses.replace(good, **changes)  # type: ignore[arg-type]


def without_wall_times(result: TrialResult) -> TrialResult:
    return dataclasses.replace(result, planning_ms=())


def test_a_trial_reaches_its_goal_and_repeats_exactly() -> None:
    first, second = (run_trial(TINY[0]) for _ in range(2))
    assert first.solved
    assert first.clean
    assert first.first_path >= 1
    assert len(first.planning_ms) >= len(first.sent) >= 1
    assert 4.5 < first.path_m < 8.0
    assert without_wall_times(first) == without_wall_times(second)


def test_a_result_survives_json() -> None:
    result = made_up(TINY[0], hits_moving=("hc10_barc",))
    assert TrialResult.from_json(json.loads(json.dumps(result.to_json()))) == result
    with pytest.raises(TypeError):
        TrialResult.from_json({"solved": True})


def test_a_tiny_study_writes_everything(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--study", "planning_time", "--planner", "yarm", "--time-trials", "2", "--workers", "1"]
    assert main([*options, "--results", str(tmp_path)]) == 0
    assert "8/8" in capsys.readouterr().out
    assert len(list((tmp_path / "trials").glob("*.json"))) == 8
    for name in ("planning_time.csv", "planning_time.png", "planning_time_trials.csv"):
        assert (tmp_path / name).stat().st_size > 100


def test_trials_run_in_other_processes_as_in_this_one(tmp_path: Path) -> None:
    apart = run_specs(TINY, tmp_path / "apart", workers=2)
    here = run_specs(TINY, tmp_path / "here", workers=1)
    assert [without_wall_times(r) for r in apart] == [without_wall_times(r) for r in here]


def test_an_interrupted_study_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: List[TrialSpec] = []

    def fake(spec: TrialSpec) -> TrialResult:
        ran.append(spec)
        if len(ran) == 3:
            raise KeyboardInterrupt
        return made_up(spec)

    monkeypatch.setattr(study_runner, "run_trial", fake)
    specs = table_study(1).specs()
    with pytest.raises(KeyboardInterrupt):
        run_specs(specs, tmp_path, workers=1)
    assert len(load_results(tmp_path, specs)) == 2
    results = run_specs(specs, tmp_path, workers=1)
    assert [r.spec for r in results] == specs
    assert len(ran) == 1 + len(specs)


def test_a_broken_file_is_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_runner, "run_trial", made_up)
    run_specs(TINY, tmp_path, workers=1)
    (tmp_path / f"{TINY[1].key}.json").write_text("{")
    assert set(load_results(tmp_path, TINY)) == {TINY[0].key}
    assert len(run_specs(TINY, tmp_path, workers=1)) == 2


def test_results_of_other_code_are_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_runner, "run_trial", made_up)
    run_specs(TINY, tmp_path, workers=1)
    assert study_runner.of_other_code(tmp_path, TINY) == 0
    monkeypatch.setattr(study_runner, "code_fingerprint", lambda: "another")
    assert study_runner.of_other_code(tmp_path, TINY) == 2


def test_one_failing_trial_is_named_and_the_others_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fake(spec: TrialSpec) -> TrialResult:
        if spec.seed == 0:
            raise RuntimeError("no such scene")
        return made_up(spec)

    monkeypatch.setattr(study_runner, "run_trial", fake)
    with pytest.raises(StudyError, match=r"1 of 2 trials failed: single-yarm1-replanning-0020-0000.*no such scene"):
        run_specs(TINY, tmp_path, workers=1)
    assert set(load_results(tmp_path, TINY)) == {TINY[1].key}


@pytest.mark.parametrize("margin", [0, 1, 2])
def test_the_original_has_more_waypoints_with_more_particles_as_published(margin: int) -> None:
    """The order is the publication's; the counts themselves are not asserted, because the margin was fitted to them."""
    request = KinematicWorld(load_scene("single"), GridSpec(), None).request({"ankurbot_1": "target_1"})
    medians = []
    for particles in PARTICLES:
        planner = OriginalPlanner(PlannerParams(particles=particles, original_margin_cells=margin))
        counts = []
        for seed in range(5):
            planner.reset()
            counts.append(len(planner.plan(request, np.random.default_rng(seed)).robots["ankurbot_1"].path))
        medians.append(float(np.median(counts)))
    assert medians == sorted(set(medians)), medians


def test_the_margins_of_the_original_stand_beside_each_other() -> None:
    specs = [TrialSpec("1m1ma_target", "original", True, 20, margin, 0) for margin in (2, 0, 1)]
    assert len({spec.key for spec in specs}) == 3
    rows = table_rows(summarise([made_up(spec) for spec in specs]))
    assert [row[:2] for row in rows] == [("original", "0"), ("original", "1"), ("original", "2")]


class StraightToTheGoal:
    """Plans one step, whatever is on the way, that ends on the goal."""

    def plan(self, request: PlanRequest, rng: np.random.Generator) -> FleetPlan:
        (robot,) = request.robots
        path = tuple(Waypoint(column, robot.yaw_rad) for column in (robot.column, request.goals["target_1"].column))
        return FleetPlan(
            PlanStatus.SOLVED, "", {robot.name: RobotPlan(robot.name, "target_1", PlanStatus.SOLVED, "", path, path[1])}
        )

    def reset(self) -> None:
        """Nothing is remembered."""


@pytest.mark.parametrize("table", [True, False])
def test_the_original_declares_only_after_a_drive_that_succeeded(table: bool) -> None:
    world = KinematicWorld(load_scene("single"), GridSpec())
    if not table:
        world.statics.clear()
    result = Trial(TrialSpec("single", "original", True, 20, 2, 0), world, StraightToTheGoal()).run()
    assert result.declared is not table
    assert result.stuck is table
    assert result.hits_stationary == (("table",) if table else ())
    assert not result.declared_elsewhere


def test_the_study_covers_the_published_table_at_least_30_times() -> None:
    specs = table_study(30).specs()
    assert len(specs) == len(set(specs)) == 4 * len(PUBLISHED) * 30 == 960
    assert {(s.replanning, s.particles) for s in specs} == set(PUBLISHED)
    assert {(s.planner, s.margin_cells) for s in specs} == {*(("original", m) for m in (0, 1, 2)), ("yarm", 1)}
    assert {s.particles for s in single_study(1).specs()} == set(PARTICLES)


def test_ours_stands_beside_the_published_values(tmp_path: Path) -> None:
    specs = [TrialSpec("1m1ma_target", "original", False, 20, 2, seed) for seed in range(30)]
    results = [made_up(s, hits_stationary=("table",), solved=s.seed < 3, stuck=s.seed >= 20) for s in specs]
    (row,) = table_rows(summarise(results))
    assert row[:5] == ("original", "2", "no", "20", "30")
    assert row[5] == "5 (5-5) (5-8)"
    assert row[6] == "100 % (89-100) (yes)"
    assert row[8] == "33 % (19-51) (yes)"
    assert row[9] == "10 % (3-26) (sometimes)"
    assert row[10] == "0 % (0-11)"
    assert row[11] == "90 % (74-97)"
    text = write_table(results, tmp_path)
    assert "100 % (89-100) (yes)" in text
    with (tmp_path / "table.csv").open() as stream:
        (read,) = csv.DictReader(stream)
    assert float(read["stuck_rate"]) == pytest.approx(1 / 3, abs=1e-4)
    write_trials(results, tmp_path / "trials.csv")
    assert len((tmp_path / "trials.csv").read_text().splitlines()) == 31
    plot_rates(results, tmp_path / "table.png")


def test_planning_times_are_gathered_by_waypoint_as_far_as_half_the_trials_go() -> None:
    spec = TrialSpec("single", "yarm", True, 20, 1, 0)
    results = [made_up(spec, planning_ms=(1.0, 5.0)), made_up(spec, planning_ms=(3.0,))]
    results += [made_up(spec, planning_ms=times) for times in ((1.0, 5.0, 9.0), (3.0,))]
    results.append(made_up(spec, solved=False, stuck=True, planning_ms=(50.0,) * 100))
    assert planning_times(results) == {("yarm", 20): [(2.0, 1.0, 3.0), (5.0, 5.0, 5.0)]}


def test_the_fingerprint_reaches_every_file_however_deep(tmp_path):
    deep = tmp_path / "part" / "sub" / "deep.py"
    deep.parent.mkdir(parents=True)
    deep.write_text("A = 1\n")
    (tmp_path / "part" / "notes.txt").write_text("no source")
    before = study_runner.fingerprint([tmp_path / "part"])
    (tmp_path / "part" / "notes.txt").write_text("still none")
    assert study_runner.fingerprint([tmp_path / "part"]) == before
    deep.write_text("A = 2\n")
    changed = study_runner.fingerprint([tmp_path / "part"])
    assert changed != before
    deep.rename(deep.with_name("renamed.py"))
    assert study_runner.fingerprint([tmp_path / "part"]) not in (before, changed)
