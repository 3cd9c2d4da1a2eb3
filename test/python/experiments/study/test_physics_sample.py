"""The sample in full physics: the run that repeats a trial, and how agreement is judged (nothing is launched)."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
import yaml

from python.experiments.study.test_design import made_up
from yarm.experiments.study.design import PUBLISHED
from yarm.experiments.study.physics_sample import (
    PhysicsResult,
    command,
    compare,
    read_result,
    sample_specs,
    summary_file,
    write_sample,
)
from yarm.experiments.study.trial import TrialSpec, raster_share
from yarm.ros.experiment.launcher import parser as run_parser

SPECS = sample_specs(32, ("original", "yarm"))


def test_the_sample_is_taken_from_every_cell_of_the_table_evenly() -> None:
    assert len(set(SPECS)) == 32
    cells = Counter((spec.planner, spec.replanning, spec.particles) for spec in SPECS)
    assert set(cells) == {(planner, *cell) for planner in ("original", "yarm") for cell in PUBLISHED}
    assert set(cells.values()) == {2}
    assert {spec.seed for spec in SPECS} == {0, 1}
    assert all(0.0 <= raster_share(spec.seed) < 1.0 for spec in SPECS)
    assert {spec.planner for spec in sample_specs(9, ["original"])} == {"original"}


def test_the_run_repeats_the_trial(tmp_path: Path) -> None:
    spec = TrialSpec("1m1ma_target", "original", False, 20, 2, 1)
    call = command(tmp_path, spec)
    first = call.index("--case")
    assert "run_experiment" in {Path(word).name for word in call[:first]}
    assert {"--sync", "--unguarded", "--planned-once"} <= set(call)
    options = dict(zip(call[first::2], call[first + 1 :: 2]))
    assert (options["--planner"], options["--seed"], options["--particles"]) == ("original", "1", "20")
    assert (options["--execution"], options["--hidden"]) == ("steps", "free")
    assert float(options["--raster"]) == pytest.approx(raster_share(1), abs=1e-4)
    guarded = command(tmp_path, TrialSpec("1m1ma_target", "yarm", True, 20, 1, 1))
    assert not {"--unguarded", "--planned-once"} & set(guarded)
    run_options = run_parser().parse_args(call[call.index("--sync") :])
    assert run_options.planned_once
    assert summary_file(tmp_path, spec).parent == Path(run_options.results) / spec.scene / str(spec.seed)


@pytest.mark.parametrize(("kind", "reached", "solved", "clean"), [("allowed", True, True, True)])
def test_results_are_read(tmp_path: Path, kind: str, reached: bool, solved: bool, clean: bool) -> None:
    summary = summary_file(tmp_path, SPECS[0])
    summary.parent.mkdir(parents=True)
    values = {
        "robots": {"ankurbot_1": {"path_m": 5.0, "waypoints": 3}},
        "goals": {"target_1": {"reached": reached}},
        "contacts": [{"kind": kind}],
        "steps": {"planned": 5, "refused": 2},
        "faults": [],
    }
    summary.write_text(yaml.safe_dump(values))
    result = read_result(SPECS[0], summary)
    assert (result.solved, result.clean, result.path_m, result.waypoints) == (solved, clean, 5.0, 3)
    assert result.refused == 2
    values["contacts"] = [{"kind": "failure"}]
    summary.write_text(yaml.safe_dump(values))
    assert read_result(SPECS[0], summary).clean is False
    assert read_result(SPECS[1], tmp_path / "nothing.yaml").solved is False


def test_agreement_is_judged_by_points_and_length(tmp_path: Path) -> None:
    kinematic = [made_up(spec, path_m=5.0) for spec in SPECS]
    physics = [PhysicsResult(spec, True, True, 5.1, 2, 0, ()) for spec in SPECS]
    rows = compare(physics, kinematic)
    assert [row[:3] for row in rows] == [(p, r, "8") for p in ("original", "yarm") for r in ("no", "yes")]
    assert [row[-1] for row in rows] == ["yes: 0 points, 2.0 %"] * 4
    longer = [PhysicsResult(spec, True, True, 5.4, 2, 0, ()) for spec in SPECS]
    assert compare(longer, kinematic)[0][-1] == "no: 0 points, 8.0 %"
    fewer = [PhysicsResult(spec, spec.particles > 20, True, 5.0, 2, 0, ()) for spec in SPECS]
    assert compare(fewer, kinematic)[1][-1] == "no: 25 points, 0.0 %"
    assert compare(fewer, kinematic)[1][5] == "75 % (41-93)"
    assert "original" in write_sample(physics, kinematic, tmp_path)
    assert len((tmp_path / "physics.csv").read_text().splitlines()) == 33
