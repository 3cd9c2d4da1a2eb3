"""Trials are stored with a digest of what they depend on; those of another digest are run again, and only those."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from yarm.experiments.explore import trials
from yarm.experiments.explore.trial import ExploreSpec
from yarm.experiments.explore.trials import EXPLORE_TRIALS, code_of
from yarm.experiments.study import runner
from yarm.experiments.study.runner import load_trials, run_trials
from yarm.experiments.study.sources import PACKAGE, files_of
from yarm.exploration.registry import CONTROLLERS

SHORT = ExploreSpec("clutter_1", "report", 3, time_limit_s=4.0)


def test_trials_are_kept_and_not_run_again(tmp_path: Path) -> None:
    results = run_trials(EXPLORE_TRIALS, [SHORT], tmp_path, workers=1)
    assert (tmp_path / f"{SHORT.key}.json").is_file()
    stored = load_trials(EXPLORE_TRIALS, tmp_path, [SHORT])[SHORT.key]
    assert stored == results[0] == run_trials(EXPLORE_TRIALS, [SHORT], tmp_path, workers=1)[0]


def test_results_of_other_code_are_run_again(tmp_path: Path) -> None:
    run_trials(EXPLORE_TRIALS, [SHORT], tmp_path, workers=1)
    file = tmp_path / f"{SHORT.key}.json"
    stored = json.loads(file.read_text())
    assert stored["code"] == code_of(SHORT)
    file.write_text(json.dumps({**stored, "code": "another"}))
    assert load_trials(EXPLORE_TRIALS, tmp_path, [SHORT]) == {}
    run_trials(EXPLORE_TRIALS, [SHORT], tmp_path, workers=1)
    assert json.loads(file.read_text())["code"] == code_of(SHORT)


def digests_with_another(monkeypatch: pytest.MonkeyPatch, *changed: str) -> set[str]:
    """Which controllers' digests change with these files of the package."""
    before = {name: code_of(ExploreSpec("rooms_0", name, 0)) for name in CONTROLLERS}
    read = Path.read_bytes
    files = {PACKAGE / file for file in changed}
    assert all(file.is_file() for file in files)
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + (b"# other" if path in files else b""))
    trials._code_of.cache_clear()
    after = {name: code_of(ExploreSpec("rooms_0", name, 0)) for name in CONTROLLERS}
    monkeypatch.undo()
    trials._code_of.cache_clear()
    return {name for name in CONTROLLERS if before[name] != after[name]}


def test_a_controllers_own_file_concerns_it_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert digests_with_another(monkeypatch, "exploration/yarm.py") == {"yarm"}
    assert digests_with_another(monkeypatch, "exploration/views.py") == {"yarm"}
    assert digests_with_another(monkeypatch, "exploration/move_base.py") == {"explore_lite"}
    assert digests_with_another(monkeypatch, "exploration/driver.py") == {"yarm", "nearest", "explore_lite"}
    assert digests_with_another(monkeypatch, "exploration/report/printed.py") == {"report_printed"}


@pytest.mark.parametrize(
    "file", ["sim/kinematic/world.py", "experiments/explore/measures.py", "exploration/params.py", "geometry/poses.py"]
)
def test_what_is_common_concerns_all(file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert digests_with_another(monkeypatch, file) == set(CONTROLLERS)


def test_nothing_compiled_decides_a_trial() -> None:
    own = [make.__module__ for make in CONTROLLERS.values()]
    files = files_of([trials.TRIAL, *own])
    assert not [file for file in files if "ctypes" in file.read_text()]
    assert runner.fingerprint(files) == runner.fingerprint(files)
