"""Trials with SLAM: both worlds, keys, files, digests."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from python.experiments.explore_samples import path_row
from yarm.experiments.explore import slam_trial
from yarm.experiments.explore.slam_trial import (
    SLAM_TRIALS,
    SlamResult,
    SlamSpec,
    code_of,
    controller_of,
    heading_rmse_rad,
    make_world,
    run_slam_trial,
)
from yarm.experiments.explore.trial import judge_of
from yarm.experiments.study.runner import load_trials, run_trials
from yarm.exploration.params import ExploreParams
from yarm.navigation import slam_native

SHORT = SlamSpec("clutter_1", "nearest", 3, time_limit_s=15.0)


def same_but_times(result: SlamResult) -> SlamResult:
    return replace(result, measures=replace(result.measures, step_p50_ms=0.0, step_p99_ms=0.0), slam_core=0.0)


@pytest.mark.parametrize("world", ["physics", "kinematic"])
def test_a_trial_maps_repeats_and_survives_json(world: str) -> None:
    spec = replace(SHORT, world=world)
    first, second = run_slam_trial(spec), run_slam_trial(spec)
    assert same_but_times(first) == same_but_times(second)
    assert SlamResult.from_json(json.loads(json.dumps(first.to_json()))) == first
    m = first.measures
    assert 0.15 < m.share < 1.0 and 0.0 < m.wall.mean_m < 0.04 and 0.0 < m.pose_rmse_m < 0.06
    assert 0.0 < first.heading_rmse_rad < 0.05 and m.pose_rmse_m <= first.worst_pose_m < 0.1
    assert 0.0 < first.slam_core < 0.2 and first.keyframes > 5
    with pytest.raises((TypeError, KeyError)):
        SlamResult.from_json({"spec": first.to_json()["spec"], "measures": {"share": 1.0}})


def test_keys_tell_trials_apart() -> None:
    specs = [
        SHORT,
        replace(SHORT, world="kinematic"),
        replace(SHORT, fast=True),
        replace(SHORT, time_limit_s=900.0),
        replace(SHORT, map_s=1.0),
        replace(SHORT, seed=4),
    ]
    assert len({spec.key for spec in specs}) == len(specs) and all(" " not in spec.key for spec in specs)


def test_only_report_is_fast_and_it_is() -> None:
    with pytest.raises(ValueError, match="only report has"):
        controller_of(replace(SHORT, fast=True), ExploreParams(controller="nearest"))
    top = {}
    for fast in (False, True):
        spec = SlamSpec("practice", "report", 1, "kinematic", fast, time_limit_s=40.0)
        record, _ = slam_trial.run_slam_record(spec, judge_of("practice"))
        top[fast] = max(row.speed for row in record.path)
    assert top == {False: pytest.approx(0.2, abs=0.005), True: pytest.approx(0.3, abs=0.005)}


def test_a_world_that_is_not_known_is_refused() -> None:
    with pytest.raises(ValueError, match="physics, kinematic"):
        make_world("dream", judge_of("practice").arena, 0)


def test_the_heading_error_goes_the_short_way_round() -> None:
    rows = [path_row(0.0, 0.0, 0.0), path_row(0.1, 0.0, 0.0)]
    rows = [replace(rows[0], true_yaw=3.1, yaw=-3.1), replace(rows[1], true_yaw=0.0, yaw=0.0)]
    assert heading_rmse_rad(rows) == pytest.approx((2 * math.pi - 6.2) / math.sqrt(2))


def test_trials_are_kept_and_run_again_when_the_library_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = replace(SHORT, world="kinematic", time_limit_s=5.0)
    run_trials(SLAM_TRIALS, [spec], tmp_path, workers=1)
    assert list(load_trials(SLAM_TRIALS, tmp_path, [spec])) == [spec.key]
    before = code_of(spec)
    other = tmp_path / slam_native.LIBRARY
    other.write_bytes(b"another")
    monkeypatch.setattr(slam_native, "library_path", lambda: other)
    assert code_of(spec) != before and load_trials(SLAM_TRIALS, tmp_path, [spec]) == {}
