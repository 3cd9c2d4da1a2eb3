"""The sample in full physics: the run that repeats a trial, and how agreement is judged (nothing is launched)."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from python.experiments.test_study import made_up
from yarm.experiments.physics_sample import (
    PhysicsResult,
    command,
    compare,
    read_result,
    sample_specs,
    summary_file,
    write_sample,
)
from yarm.experiments.trial import raster_share

SPECS = sample_specs(20, ("original", "yarm"))


def test_a_sample_has_the_same_trials_for_each_planner() -> None:
    assert len(SPECS) == len(set(SPECS)) == 20
    assert {spec.seed for spec in SPECS if spec.planner == "yarm"} == set(range(10))
    assert all(0.0 <= raster_share(spec.seed) < 1.0 for spec in SPECS)


def test_the_run_repeats_the_trial(tmp_path: Path) -> None:
    call = command(tmp_path, SPECS[3])
    first = call.index("--case")
    assert "run_experiment" in {Path(word).name for word in call[:first]}
    assert "--sync" in call
    options = dict(zip(call[first::2], call[first + 1 :: 2]))
    assert (options["--planner"], options["--seed"], options["--particles"]) == ("yarm", "1", "333")
    assert float(options["--raster"]) == pytest.approx(raster_share(1), abs=1e-4)


@pytest.mark.parametrize(("kind", "reached", "solved", "clean"), [("allowed", True, True, True)])
def test_results_are_read(tmp_path: Path, kind: str, reached: bool, solved: bool, clean: bool) -> None:
    summary = summary_file(tmp_path, SPECS[0])
    summary.parent.mkdir(parents=True)
    values = {
        "robots": {"ankurbot_1": {"path_m": 5.0, "waypoints": 3}},
        "goals": {"target_1": {"reached": reached}},
        "contacts": [{"kind": kind}],
        "faults": [],
    }
    summary.write_text(yaml.safe_dump(values))
    result = read_result(SPECS[0], summary)
    assert (result.solved, result.clean, result.path_m, result.waypoints) == (solved, clean, 5.0, 3)
    values["contacts"] = [{"kind": "failure"}]
    summary.write_text(yaml.safe_dump(values))
    assert read_result(SPECS[0], summary).clean is False
    assert read_result(SPECS[1], tmp_path / "nothing.yaml").solved is False


def test_agreement_is_judged_by_points_and_length(tmp_path: Path) -> None:
    kinematic = [made_up(spec, path_m=5.0) for spec in SPECS]
    physics = [PhysicsResult(spec, True, True, 5.1, 2, ()) for spec in SPECS]
    assert [row[-1] for row in compare(physics, kinematic)] == ["yes: 0 points, 2.0 %"] * 2
    longer = [PhysicsResult(spec, True, True, 5.4, 2, ()) for spec in SPECS]
    assert compare(longer, kinematic)[0][-1] == "no: 0 points, 8.0 %"
    fewer = [PhysicsResult(spec, spec.seed > 0, True, 5.0, 2, ()) for spec in SPECS]
    assert compare(fewer, kinematic)[1][-1] == "no: 10 points, 0.0 %"
    assert "original" in write_sample(physics, kinematic, tmp_path)
    assert len((tmp_path / "physics.csv").read_text().splitlines()) == 21
