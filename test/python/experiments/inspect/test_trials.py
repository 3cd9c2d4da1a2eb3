"""Which trials of the inspection and of the rendered views are run again when a file of the package changes."""

from __future__ import annotations

from pathlib import Path
from typing import Set

import pytest

from yarm.experiments.inspect import trials
from yarm.experiments.inspect.fault_trial import FaultSpec
from yarm.experiments.inspect.trial import InspectSpec
from yarm.experiments.inspect.trials import INSPECT_TRIALS, OWN, code_of, fault_code_of
from yarm.experiments.study import tag_study
from yarm.experiments.study.sources import PACKAGE, files_of
from yarm.experiments.study.tag_study import PIECES, Piece
from yarm.inspection.model import CONTROLLERS, OURS, PRINTED, REPORT

FAULT, VIEWS = "fault", "views"
EVERYTHING = {*CONTROLLERS, FAULT, VIEWS}


def digests() -> dict[str, str]:
    trials.digest.cache_clear()
    tag_study._code.cache_clear()
    found = {name: code_of(InspectSpec("open", 0, name, 0)) for name in CONTROLLERS}
    return {**found, FAULT: fault_code_of(FaultSpec("open_0", "sleeps", 0)), VIEWS: tag_study.code_of(Piece(0, 2, 0))}


def changed_with(monkeypatch: pytest.MonkeyPatch, file: str) -> Set[str]:
    """Whose digests change with a file of the package."""
    before, read, path = digests(), Path.read_bytes, PACKAGE / file
    assert path.is_file()
    monkeypatch.setattr(Path, "read_bytes", lambda at: read(at) + (b"# other" if at == path else b""))
    after = digests()
    monkeypatch.undo()
    digests()
    return {name for name in before if before[name] != after[name]}


@pytest.mark.parametrize(
    "file, concerned",
    [
        ("inspection/round.py", {OURS}),
        ("inspection/tour_plan.py", {OURS}),
        ("tags/chance.py", {OURS}),
        ("tags/evidence.py", {OURS}),
        ("inspection/printed_round.py", {PRINTED, FAULT}),
        ("inspection/report_round.py", {REPORT, PRINTED, FAULT}),
        ("tags/recogniser.py", {OURS, VIEWS}),
        ("tags/report.py", EVERYTHING),
        ("sim/sensors/rgb_camera.py", EVERYTHING),
        ("sim/kinematic/world.py", EVERYTHING - {VIEWS}),
        ("experiments/inspect/fault_trial.py", {FAULT}),
        ("experiments/inspect/writers.py", set()),
        ("experiments/study/tag_views.py", {VIEWS}),
    ],
)
def test_a_file_concerns_the_trials_that_use_it(
    file: str, concerned: Set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert changed_with(monkeypatch, file) == concerned


def test_nothing_compiled_decides_a_trial() -> None:
    own = sorted(frozenset().union(*OWN.values()))
    assert not [file for file in files_of([trials.TRIAL, *own]) if "ctypes" in file.read_text()]


def test_the_studies_store_their_digests() -> None:
    assert INSPECT_TRIALS.code is code_of and PIECES.code is tag_study.code_of
