"""Trials of the study: they repeat, are stored and read back, and know what they switch off."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from python.experiments.explore_samples import path_row
from yarm.experiments.explore.measures import measure
from yarm.experiments.explore.record import CoverageRow
from yarm.experiments.explore.trial import (
    ExploreResult,
    ExploreSpec,
    controller_of,
    curve_of,
    freed_s,
    judge_of,
    run_record,
    run_trial,
)
from yarm.experiments.explore.writers import write_exploration
from yarm.exploration.params import ExploreParams
from yarm.exploration.registry import CONTROLLERS

SHORT = ExploreSpec("clutter_1", "report", 3, time_limit_s=4.0)


def same_but_times(result: ExploreResult) -> ExploreResult:
    return replace(result, measures=replace(result.measures, step_p50_ms=0.0, step_p99_ms=0.0))


def test_a_trial_repeats_and_survives_json() -> None:
    first, second = run_trial(SHORT), run_trial(SHORT)
    assert same_but_times(first) == same_but_times(second)
    again = ExploreResult.from_json(json.loads(json.dumps(first.to_json())))
    assert again == first and again.measures.times == (math.inf,) * 3 and 0.0 < again.measures.share < 0.5
    with pytest.raises((TypeError, KeyError)):
        ExploreResult.from_json({"spec": first.to_json()["spec"], "measures": {"share": 1.0}})


@pytest.mark.parametrize("name", sorted(CONTROLLERS))
def test_the_same_run_writes_the_same_events_byte_for_byte(name: str, tmp_path: Path) -> None:
    judge = judge_of("practice")
    written = []
    for attempt in ("first", "second"):
        record = run_record(ExploreSpec("practice", name, 7, time_limit_s=5.0), judge)
        write_exploration(record, measure(record, judge), tmp_path / attempt)
        written.append(tmp_path / attempt)
    for file in ("events.csv", "path.csv", "coverage.csv", "bumps.csv", "map.pgm", "map.yaml"):
        assert (written[0] / file).read_bytes() == (written[1] / file).read_bytes(), file
    assert len((written[0] / "events.csv").read_text().splitlines()) > 1


def test_keys_tell_trials_apart() -> None:
    specs = [SHORT, replace(SHORT, without="frontier"), replace(SHORT, time_limit_s=900.0), replace(SHORT, seed=4)]
    assert len({spec.key for spec in specs}) == 4 and all(" " not in spec.key for spec in specs)


def test_only_the_reports_have_something_to_go_without() -> None:
    params = ExploreParams(controller="nearest")
    with pytest.raises(ValueError, match="only the reports have"):
        controller_of(ExploreSpec("practice", "nearest", 0, "frontier"), params)
    assert controller_of(ExploreSpec("practice", "report", 0, "frontier"), replace(params, controller="report"))
    spec = ExploreSpec("practice", "report_printed", 0, "side_bump+deaf")
    assert controller_of(spec, replace(params, controller="report_printed"))
    with pytest.raises(ValueError, match="faults rust are not known"):
        controller_of(replace(spec, without="side_bump+rust"), params)


def test_a_curve_holds_the_newest_share_and_stays_after_the_end() -> None:
    rows = [CoverageRow(0.0, 1.0, 0.1), CoverageRow(9.0, 1.0, 0.4), CoverageRow(12.0, 2.0, 0.8)]
    assert curve_of(rows, 40.0) == (0.1, 0.4, 0.8, 0.8, 0.8)


def test_a_robot_is_free_when_it_is_away_from_its_start() -> None:
    rows = [path_row(0.0, 1.0, 0.0), path_row(1.0, 1.2, 0.2), path_row(2.0, 1.31, 0.2)]
    assert freed_s(rows) == 2.0 and freed_s(rows[:2]) == math.inf
