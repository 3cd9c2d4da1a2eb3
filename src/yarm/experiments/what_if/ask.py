"""Asks what if: alternatives from options, their runs through the studies' engine, and answers as they come."""

from __future__ import annotations

import itertools
import tempfile
import time
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple

from yarm.experiments.study.runner import TrialKind, load_trials, run_trials
from yarm.experiments.what_if.answer import answers, table
from yarm.experiments.what_if.cell import Cell, Placed, Settings, WhatIfError
from yarm.experiments.what_if.trial import ROBOTS, WhatIfResult, WhatIfSpec, params_of

AS_IT_IS = "as it is"
MOST_RUNS, MOST_ALTERNATIVES = 200, 24
TOLD_EVERY_S = 2.0
Alternative = Tuple[str, Settings]
ANY_CELL = Cell("a cell that is not there yet", (), fixtures=(Placed("bin_1", "bin", 0.0, 0.0),))
"""Refuses only what every cell would refuse."""


def alternative(text: str) -> Alternative:
    """One alternative from ``NAME=VALUE NAME=VALUE``; nothing is the cell as it is.

    Raises:
        WhatIfError: a word is not of that form, or a name stands twice.
    """
    pairs: List[Tuple[str, str]] = []
    for word in text.split():
        name, separator, value = word.partition("=")
        if not separator or not name or not value:
            raise WhatIfError(f"{word!r}: a setting is NAME=VALUE, such as planner=lacam")
        if name in dict(pairs):
            raise WhatIfError(f"{text!r}: {name} stands twice")
        pairs.append((name, value))
    return (" ".join(f"{name}={value}" for name, value in pairs) or AS_IT_IS), tuple(pairs)


def combined(choices: Mapping[str, Sequence[str]]) -> List[Alternative]:
    """The cell as it is, and every combination of the values that are asked for."""
    asked = {name: values for name, values in choices.items() if values}
    rows = itertools.product(*([(name, value) for value in values] for name, values in asked.items())) if asked else []
    return [alternative(""), *(alternative(" ".join(f"{n}={v}" for n, v in row)) for row in rows)]


def robot_numbers(text: str) -> List[str]:
    """``2``, ``1,3`` or ``1..4`` as a list.

    Raises:
        WhatIfError: it is something else.
    """
    low, dots, high = text.partition("..")
    parts = [low, high] if dots else text.split(",")
    if not all(part.isdigit() for part in parts):
        raise WhatIfError(f"--robots {text!r}: a number, numbers separated by commas, or FIRST..LAST")
    return [str(n) for n in range(int(low), int(high) + 1)] if dots else parts


def check_question(cell: Cell, alternatives: Sequence[Alternative], runs: int, in_physics: bool = False) -> None:
    """Whether it can be asked, as far as that does not hang on what is in the cell.

    Args:
        cell: its bins and settings count; ``ANY_CELL`` where it is not there yet.
        alternatives: as ``alternative`` gives them.
        runs: of each.
        in_physics: they run in full physics.

    Raises:
        WhatIfError: too much, too little, or faulty settings.
    """
    if not 1 <= runs <= MOST_RUNS:
        raise WhatIfError(f"runs = {runs}: must be within 1 to {MOST_RUNS}")
    if not 1 <= len(alternatives) <= MOST_ALTERNATIVES:
        raise WhatIfError(f"{len(alternatives)} alternatives: must be within 1 to {MOST_ALTERNATIVES}")
    if len({name for name, _ in alternatives}) < len(alternatives):
        raise WhatIfError("an alternative stands twice: " + ", ".join(name for name, _ in alternatives))
    for _, settings in alternatives:
        params_of(cell, settings, in_physics=in_physics)


def specs_of(
    cell: Cell,
    alternatives: Sequence[Alternative],
    runs: int,
    seed: int,
    more: Mapping[str, Any],
    in_physics: bool = False,
) -> List[WhatIfSpec]:
    """What is to be run, the first run of every alternative first.

    Raises:
        WhatIfError: too much, too little, or faulty settings.
    """
    check_question(cell, alternatives, runs, in_physics)
    if not cell.robots:
        raise WhatIfError(f"{cell.source}: it has no mobile robots")
    if not cell.goals and not cell.scene:
        raise WhatIfError(
            f"{cell.source}: it has no debris and no target, so there is nothing to clear: ask when it has"
        )
    for _, settings in alternatives:
        if ROBOTS in dict(settings):
            cell.with_robots(int(dict(settings)[ROBOTS]))
    return [WhatIfSpec(cell, name, settings, seed + k, **more) for k in range(runs) for name, settings in alternatives]


def ask(
    specs: Sequence[WhatIfSpec],
    kind: TrialKind[WhatIfSpec, WhatIfResult],
    say: Callable[[str], None],
    scheduler: str = "",
    pool: Optional[Executor] = None,
) -> List[WhatIfResult]:
    """Run them all; the answers so far are told every two seconds, once every alternative has one.

    Alternatives that come to the same, as the cell as it is and the number of robots that it has, are run once.

    Args:
        specs: as ``specs_of`` gives them.
        kind: kinematic or physics.
        say: takes lines for a person.
        scheduler: address of a Dask scheduler; empty for this machine.
        pool: local processes; without them, and without a scheduler, this one runs all.

    Raises:
        StudyError: runs raised.
    """
    names = list(dict.fromkeys(spec.name for spec in specs))
    of = {spec.key: same for spec, same in zip(specs, _same_runs(specs))}
    different = list({run.key: run for run in of.values()}.values())
    began = told = time.monotonic()
    first = True

    def all_of(results: Sequence[WhatIfResult]) -> List[WhatIfResult]:
        """A result for each spec whose run has one."""
        found = {result.spec.key: result for result in results}
        have = [spec for spec in specs if of[spec.key].key in found]
        return [replace(found[of[spec.key].key], spec=spec) for spec in have]

    with tempfile.TemporaryDirectory(prefix="yarm-what-if-") as folder:

        def on_progress(done: int, total: int, key: str) -> None:
            nonlocal told, first
            if done in (0, total) or (not first and time.monotonic() - told < TOLD_EVERY_S):
                return
            so_far = all_of(list(load_trials(kind, Path(folder), different).values()))
            found = answers(so_far, names)
            if len(found) == len(names):
                told, first = time.monotonic(), False
                say(f"{len(so_far)} of {len(specs)} runs after {told - began:.1f} s:\n{table(found)}\n")

        results = all_of(run_trials(kind, different, Path(folder), scheduler, 1, on_progress, pool))
    say(f"{len(specs)} runs in {time.monotonic() - began:.1f} s:\n{table(answers(results, names))}")
    return results


def _same_runs(specs: Sequence[WhatIfSpec]) -> List[WhatIfSpec]:
    """For each spec the first one that comes to the same: parameters of the Commander, and number of robots."""
    comes_to: Dict[str, Tuple[str, int]] = {}
    for name, one in {spec.name: spec for spec in specs}.items():
        params = params_of(one.cell, one.settings, in_physics=True)
        comes_to[name] = repr(params), int(dict(one.settings).get(ROBOTS, len(one.cell.robots)))
    first: Dict[Tuple[Tuple[str, int], int], WhatIfSpec] = {}
    return [first.setdefault((comes_to[spec.name], spec.seed), spec) for spec in specs]
