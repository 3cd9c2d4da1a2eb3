"""Runs the trials of a study across processes (Dask distributed), one JSON file a trial, so that it can be resumed."""

from __future__ import annotations

import ctypes
import gc
import hashlib
import importlib
import json
import logging
import os
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, Generic, List, Mapping, Optional, Protocol, Sequence, Tuple, TypeVar

from yarm.experiments.study.trial import TrialResult, TrialSpec, run_trial
from yarm.resources import resource

Progress = Callable[[int, int, str], None]
"""Called with trials done, trials in all, and the key of the one just done."""


class Spec(Protocol):
    """What a trial is made of; equal specs give equal results."""

    @property
    def key(self) -> str:
        """Unique name, good for a file."""


class Result(Protocol):
    """What a trial came to."""

    @property
    def spec(self) -> Any:
        """What it was made of."""

    def to_json(self) -> Dict[str, Any]:
        """Plain values, which its kind reads back."""


S = TypeVar("S", bound=Spec)
R = TypeVar("R", bound=Result)


@dataclass(frozen=True)
class TrialKind(Generic[S, R]):
    """A sort of trials.

    Attributes:
        run: runs one; a function of a module, so that other processes find it.
        read: a result from plain values; raises TypeError, ValueError or KeyError when they are none.
        code: digest of all that a trial depends on; results of another digest are run again. Without one the digest is
            that of the whole package, and results of another are kept: ``of_other_code`` counts them.
    """

    run: Callable[[S], R]
    read: Callable[[Mapping[str, Any]], R]
    code: Optional[Callable[[S], str]] = None


def planning_kind() -> TrialKind[TrialSpec, TrialResult]:
    """The trials of the planners."""
    return TrialKind(run_trial, TrialResult.from_json)


DASK: Mapping[str, Any] = {
    "distributed.worker.profile.enabled": False,
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 1 << 27,
}
"""Settings of local workers. Their profiler looks at a trial a hundred times a second, and freed memory that goes back
at once makes every larger array a matter of page faults: a pass of the explorer took twice as long."""


class StudyError(RuntimeError):
    """Trials failed; the message names them and what was raised."""


PACKAGE = Path(__file__).resolve().parents[2]
NOT_CODE = ("ros", "msg", "srv")
"""Folders of the package that decide nothing of a trial."""
SUFFIXES = (".py", ".yaml", ".xacro", ".so")
DATA = ("config", "scenes", "urdf")
"""Folders of data that decide what a trial comes to, beside all sources of the package that are not ROS."""


@lru_cache(maxsize=1)
def code_fingerprint() -> str:
    """Short digest of the sources and data that decide what a trial comes to."""
    parts = [part for part in sorted(PACKAGE.iterdir()) if part.name not in NOT_CODE]
    return fingerprint([*parts, *(resource(folder) for folder in DATA)])


def fingerprint(paths: Sequence[Path]) -> str:
    """Short digest of files, and of every source and data file in folders however deep: names and contents."""
    digest = hashlib.sha256()
    for path in paths:
        for file in [path] if path.is_file() else sorted(path.rglob("*")):
            if file.suffix in SUFFIXES:
                digest.update(str(file.relative_to(path.parent)).encode() + file.read_bytes())
    return digest.hexdigest()[:12]


def of_other_code(folder: Path, specs: Sequence[Spec]) -> int:
    """How many of the results on disk were made by other sources than these."""
    count = 0
    for spec in specs:
        try:
            count += json.loads((folder / f"{spec.key}.json").read_text()).get("code") != code_fingerprint()
        except (FileNotFoundError, ValueError):
            continue
    return count


def load_results(folder: Path, specs: Sequence[TrialSpec]) -> Dict[str, TrialResult]:
    """Results on disk of the planners' trials, as ``load_trials`` gives them."""
    return load_trials(planning_kind(), folder, specs)


def load_trials(kind: TrialKind[S, R], folder: Path, specs: Sequence[S]) -> Dict[str, R]:
    """Results on disk of these trials, by key; a file that cannot be read, or is of other code, counts as not there."""
    found = {}
    for spec in specs:
        path = folder / f"{spec.key}.json"
        try:
            stored = json.loads(path.read_text())
            result = kind.read(stored["result"])
            known = kind.code is None or stored.get("code") == kind.code(spec)
        except (FileNotFoundError, ValueError, TypeError, KeyError):
            continue
        if known and result.spec == spec:
            found[spec.key] = result
    return found


def run_specs(
    specs: Sequence[TrialSpec],
    folder: Path,
    scheduler: str = "",
    workers: int = 0,
    on_progress: Optional[Progress] = None,
) -> List[TrialResult]:
    """Run the planners' trials, as ``run_trials`` does."""
    return run_trials(planning_kind(), specs, folder, scheduler, workers, on_progress)


def run_trials(
    kind: TrialKind[S, R],
    specs: Sequence[S],
    folder: Path,
    scheduler: str = "",
    workers: int = 0,
    on_progress: Optional[Progress] = None,
    pool: Optional[Executor] = None,
) -> List[R]:
    """Run what is not on disk yet and give back everything, in the order of the specs.

    Args:
        kind: of the trials.
        specs: the trials.
        folder: one JSON file for each trial; made when missing.
        scheduler: address of a Dask scheduler; empty for local processes.
        workers: local processes; 0 for one a core, 1 for none at all (in this process).
        on_progress: called after each trial.
        pool: processes that are there already, which then run all of it; see ``processes``.

    Raises:
        StudyError: trials raised; all others are on disk.
    """
    folder.mkdir(parents=True, exist_ok=True)
    done = load_trials(kind, folder, specs)
    todo = [spec for spec in specs if spec.key not in done]
    faults: List[str] = []

    def keep(spec: S, outcome: Any) -> None:
        if isinstance(outcome, BaseException):
            faults.append(f"{spec.key}: {outcome!r}")
        else:
            _store(folder, outcome, code_fingerprint() if kind.code is None else kind.code(spec))
            done[spec.key] = outcome
        if on_progress is not None:
            on_progress(len(done) + len(faults), len(specs), spec.key)

    if on_progress is not None:
        on_progress(len(done), len(specs), "")
    if pool is not None:
        _run_pooled(todo, kind.run, pool, keep)
    elif todo and workers == 1 and not scheduler:
        for spec in todo:
            keep(spec, attempt(kind.run, spec))
    elif todo:
        _run_distributed(todo, kind.run, (scheduler, workers), keep)
    if faults:
        raise StudyError(f"{len(faults)} of {len(specs)} trials failed: " + "; ".join(faults[:5]))
    return [done[spec.key] for spec in specs]


def attempt(run: Callable[[S], R], spec: S) -> Any:
    """The trial's result, or the exception it raised; what else the trial has used is free again afterwards."""
    try:
        return run(spec)
    except Exception as error:  # whatever it is, the other trials go on
        return error
    finally:
        give_back()


def give_back() -> None:
    """Free what hangs in circles of references, and give freed memory back to the machine.

    A worker's threads keep the pieces that a trial has freed: 0.3 GB more after each round of inspection.
    """
    gc.collect()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc has it
    if trim is not None:
        trim(0)


def _run_pooled(todo: Sequence[S], run: Callable[[S], R], pool: Executor, keep: Callable[[S, Any], None]) -> None:
    futures = {pool.submit(attempt, run, spec): spec for spec in todo}
    try:
        for future in as_completed(futures):
            keep(futures[future], future.exception() or future.result())
    finally:
        for future in futures:
            future.cancel()


def _run_distributed(
    todo: Sequence[S], run: Callable[[S], R], where: Tuple[str, int], keep: Callable[[S, Any], None]
) -> None:
    scheduler, workers = where
    dask: Any = importlib.import_module("distributed")
    logging.getLogger("distributed").setLevel(logging.ERROR)
    cluster = None
    if not scheduler:
        importlib.import_module("dask").config.set(DASK)
        cluster = dask.LocalCluster(
            n_workers=workers or os.cpu_count() or 1,
            threads_per_worker=1,
            dashboard_address="127.0.0.1:0",
            memory_limit=0,
        )
    client = dask.Client(scheduler or cluster)
    try:
        futures = {client.submit(attempt, run, spec, key=spec.key, pure=False): spec for spec in todo}
        for future in dask.as_completed(list(futures)):
            outcome = future.exception() if future.status == "error" else future.result()
            keep(futures[future], outcome)
            future.release()
    finally:
        client.close()
        if cluster is not None:
            cluster.close()


def _store(folder: Path, result: Result, code: str) -> None:
    """Write the file whole or not at all."""
    path = folder / f"{result.spec.key}.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps({"code": code, "result": result.to_json()}))
    part.replace(path)
