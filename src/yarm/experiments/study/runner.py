"""Runs the trials of a study across processes (Dask distributed), one JSON file a trial, so that it can be resumed."""

from __future__ import annotations

import hashlib
import importlib
import json
import logging
import os
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence

from yarm.experiments.trial import TrialResult, TrialSpec, run_trial

Progress = Callable[[int, int, str], None]
"""Called with trials done, trials in all, and the key of the one just done."""


class StudyError(RuntimeError):
    """Trials failed; the message names them and what was raised."""


CODE = ("geometry", "planning", "control", "experiments")
"""Parts of the package that decide what a trial comes to."""


@lru_cache(maxsize=1)
def code_fingerprint() -> str:
    """Short digest of the sources that decide what a trial comes to."""
    digest = hashlib.sha256()
    for part in CODE:
        for file in sorted((Path(__file__).parents[1] / part).glob("*.py")):
            digest.update(file.name.encode() + file.read_bytes())
    return digest.hexdigest()[:12]


def of_other_code(folder: Path, specs: Sequence[TrialSpec]) -> int:
    """How many of the results on disk were made by other sources than these."""
    count = 0
    for spec in specs:
        try:
            count += json.loads((folder / f"{spec.key}.json").read_text()).get("code") != code_fingerprint()
        except (FileNotFoundError, ValueError):
            continue
    return count


def load_results(folder: Path, specs: Sequence[TrialSpec]) -> Dict[str, TrialResult]:
    """Results on disk of these trials, by key; a file that cannot be read counts as not there."""
    found = {}
    for spec in specs:
        path = folder / f"{spec.key}.json"
        try:
            result = TrialResult.from_json(json.loads(path.read_text())["result"])
        except (FileNotFoundError, ValueError, TypeError, KeyError):
            continue
        if result.spec == spec:
            found[spec.key] = result
    return found


def run_specs(
    specs: Sequence[TrialSpec],
    folder: Path,
    scheduler: str = "",
    workers: int = 0,
    on_progress: Optional[Progress] = None,
) -> List[TrialResult]:
    """Run what is not on disk yet and give back everything, in the order of the specs.

    Args:
        specs: the trials.
        folder: one JSON file for each trial; made when missing.
        scheduler: address of a Dask scheduler; empty for local processes.
        workers: local processes; 0 for one a core, 1 for none at all (in this process).
        on_progress: called after each trial.

    Raises:
        StudyError: trials raised; all others are on disk.
    """
    folder.mkdir(parents=True, exist_ok=True)
    done = load_results(folder, specs)
    todo = [spec for spec in specs if spec.key not in done]
    faults: List[str] = []

    def keep(spec: TrialSpec, outcome: Any) -> None:
        if isinstance(outcome, TrialResult):
            _store(folder, outcome)
            done[spec.key] = outcome
        else:
            faults.append(f"{spec.key}: {outcome!r}")
        if on_progress is not None:
            on_progress(len(done) + len(faults), len(specs), spec.key)

    if on_progress is not None:
        on_progress(len(done), len(specs), "")
    if todo and workers == 1 and not scheduler:
        for spec in todo:
            keep(spec, attempt(spec))
    elif todo:
        _run_distributed(todo, scheduler, workers, keep)
    if faults:
        raise StudyError(f"{len(faults)} of {len(specs)} trials failed: " + "; ".join(faults[:5]))
    return [done[spec.key] for spec in specs]


def attempt(spec: TrialSpec) -> Any:
    """The trial's result, or the exception it raised."""
    try:
        return run_trial(spec)
    except Exception as error:  # whatever it is, the other trials go on
        return error


def _run_distributed(
    todo: Sequence[TrialSpec], scheduler: str, workers: int, keep: Callable[[TrialSpec, Any], None]
) -> None:
    dask: Any = importlib.import_module("distributed")
    logging.getLogger("distributed").setLevel(logging.ERROR)
    cluster = None
    if not scheduler:
        cluster = dask.LocalCluster(
            n_workers=workers or os.cpu_count() or 1, threads_per_worker=1, dashboard_address=":0", memory_limit=0
        )
    client = dask.Client(scheduler or cluster)
    try:
        futures = {client.submit(attempt, spec, key=spec.key, pure=False): spec for spec in todo}
        for future in dask.as_completed(list(futures)):
            outcome = future.exception() if future.status == "error" else future.result()
            keep(futures[future], outcome)
            future.release()
    finally:
        client.close()
        if cluster is not None:
            cluster.close()


def _store(folder: Path, result: TrialResult) -> None:
    """Write the file whole or not at all."""
    path = folder / f"{result.spec.key}.json"
    part = path.with_suffix(".part")
    part.write_text(json.dumps({"code": code_fingerprint(), "result": result.to_json()}))
    part.replace(path)
