"""What a trial leaves behind in its worker: nothing. And trials in copies of this process."""

from __future__ import annotations

import gc
import os
import weakref
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Dict, Iterator, List, Mapping

import psutil
import pytest

from yarm.experiments.study.processes import copies
from yarm.experiments.study.runner import StudyError, TrialKind, attempt, load_trials, run_trials

PIECES, PIECE = 100_000, 2_000
"""So many pieces of so many bytes each, too small for pages of their own."""


class Knot:
    """Holds itself."""

    def __init__(self) -> None:
        self.me = self


@pytest.fixture
def no_collector() -> Iterator[None]:
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_collector")
def test_circles_of_references_are_freed_after_a_trial_even_when_it_fails() -> None:
    made: List[weakref.ref[Knot]] = []

    def run(fails: bool) -> int:
        made.append(weakref.ref(Knot()))
        if fails:
            raise ValueError("as asked")
        return 3

    assert attempt(run, False) == 3 and made[0]() is None
    assert isinstance(attempt(run, True), ValueError) and made[1]() is None


def test_freed_memory_goes_back_to_the_machine() -> None:
    """The last piece stays in use, so that what lies below it is not at the heap's end."""

    def run(_: int) -> bytes:
        pieces = [bytes(PIECE) for _ in range(PIECES)]
        return pieces[-1]

    process = psutil.Process()
    before = process.memory_info().rss
    last = attempt(run, 0)
    grown = process.memory_info().rss - before
    assert len(last) == PIECE
    assert grown < 0.5 * PIECES * PIECE, f"{grown / 1e6:.0f} MB more"


@dataclass(frozen=True)
class Asked:
    """A trial that says which process it ran in; told to it fails, or takes its process with it."""

    key: str
    does: str = ""


@dataclass(frozen=True)
class Told:
    """What it said."""

    spec: Asked
    process: int
    known: int

    def to_json(self) -> Dict[str, Any]:
        return {"key": self.spec.key, "process": self.process, "known": self.known}


RECKONED: List[int] = []


def told(spec: Asked) -> Told:
    if spec.does == "fails":
        raise ValueError("as asked")
    if spec.does == "ends":
        os._exit(3)
    return Told(spec, os.getpid(), len(RECKONED))


def read(values: Mapping[str, Any]) -> Told:
    return Told(Asked(values["key"]), values["process"], values["known"])


KIND = TrialKind(told, read)


@pytest.fixture
def reckoned() -> Iterator[None]:
    RECKONED.append(1)
    yield
    RECKONED.clear()


@pytest.mark.usefixtures("reckoned")
def test_copies_know_what_their_process_has_reckoned_and_end_with_the_context(tmp_path: Path) -> None:
    specs = [Asked(f"trial-{k}") for k in range(6)]
    with copies(2) as pool:
        found = run_trials(KIND, specs, tmp_path, pool=pool)
    assert [result.spec for result in found] == specs
    assert {result.known for result in found} == {1}
    processes = {result.process for result in found}
    assert os.getpid() not in processes
    assert not any(psutil.pid_exists(process) for process in processes)


def test_a_trial_that_fails_in_a_copy_is_named_and_the_others_are_kept(tmp_path: Path) -> None:
    specs = [Asked("good"), Asked("bad", "fails"), Asked("fine")]
    with copies(1) as pool, pytest.raises(StudyError, match="1 of 3 trials failed: bad: ValueError"):
        run_trials(KIND, specs, tmp_path, pool=pool)
    assert set(load_trials(KIND, tmp_path, specs)) == {"good", "fine"}


def test_a_copy_that_is_gone_is_told(tmp_path: Path) -> None:
    with copies(1) as pool, pytest.raises(StudyError, match=r"2 of 2 trials failed: .*BrokenProcessPool"):
        run_trials(KIND, [Asked("end", "ends"), Asked("after")], tmp_path, pool=pool)
