"""The study of random cells: every kind in turn, in full physics and lock-step, and how often one goes wrong."""

from __future__ import annotations

import argparse
import csv
import os
from functools import partial
from pathlib import Path
from typing import Callable, List, Sequence

from yarm.experiments.cells.outcome import CellResult, CellSpec, cell_line, kind_of, read_cell
from yarm.experiments.run.cases import CELL_PREFIX
from yarm.experiments.run.missions import experiment_command, launch
from yarm.experiments.run.tables import markdown_table
from yarm.experiments.run.writers import is_finished
from yarm.experiments.statistics import Proportion
from yarm.experiments.study.runner import Progress, StudyError, TrialKind, of_other_code, run_trials
from yarm.sim.checks.cell_check import unreachable_goals
from yarm.sim.scenes.random_cell import KINDS
from yarm.sim.scenes.scene import load_scene

HEADER = ("kind", "cells", "failed", "share, 95 %", "goals reached", "refused, confirmed", "walked into", "simulated s")
COLUMNS = ("kind", "seed", "success", "robots", "reached", "refused", "walked_into", "odd", "sim_s", "faults")


def add_options(options: argparse.ArgumentParser) -> None:
    """Options of the study."""
    options.add_argument("--cells", type=int, default=9, help="random cells, kinds in turn; each launches everything")


def specs(count: int) -> List[CellSpec]:
    """So many cells: seeds from 0 on, every kind in turn."""
    return [CellSpec(kind_of(seed), seed) for seed in range(count)]


def run_cell(folder: Path, spec: CellSpec) -> CellResult:
    """Run a cell in full physics below a folder, unless its results are there, and judge it.

    Raises:
        StudyError: it was cut short, so that nothing can be said of it.
    """
    own = (folder / f"{CELL_PREFIX}{spec.kind}" / str(spec.seed)).resolve()
    if not is_finished(own):
        own.mkdir(parents=True, exist_ok=True)
        with (own / "console.txt").open("w") as log:
            launch(cell_command(folder, spec), log)
    scene = load_scene(own / f"{CELL_PREFIX}{spec.kind}.yaml")
    result = read_cell(scene, own, unreachable_goals(scene))
    if (own / "summary.yaml").is_file() and not is_finished(own):
        raise StudyError(f"{spec.key} was cut short; see {own / 'run.log'}")
    return result


def cell_command(folder: Path, spec: CellSpec) -> List[str]:
    """The run of a cell."""
    options = {"--case": "random", "--kind": spec.kind, "--seed": spec.seed, "--results": folder}
    return [*experiment_command(), *(str(word) for option in options.items() for word in option)]


def cells(options: argparse.Namespace, folder: Path, progress: Callable[[str], Progress]) -> str:
    """Run what is not on disk yet and write ``cells.md`` and ``cells.csv``; the text to print.

    Raises:
        StudyError: cells were cut short or could not be run; all others are on disk.
    """
    # A cell keeps two cores busy.
    workers = options.workers or max(1, (os.cpu_count() or 1) // 2)
    return run_study(partial(run_cell, folder / "cells"), options, folder, workers, progress("cells"))


def run_study(
    run: Callable[[CellSpec], CellResult],
    options: argparse.Namespace,
    folder: Path,
    workers: int,
    progress: Progress,
    about: str = "",
) -> str:
    """Run what is not on disk yet and write ``cells.md`` and ``cells.csv``; the text to print.

    Args:
        run: runs one cell; a function of a module, so that other processes find it.
        options: with ``cells``, how many, and ``scheduler``.
        folder: of the results.
        workers: cells at a time.
        progress: called after each cell.
        about: what stands first on the page.

    Raises:
        StudyError: cells were cut short or could not be run; all others are on disk.
    """
    wanted, trials = specs(options.cells), folder / "cell_trials"
    others = of_other_code(trials, wanted)
    kind = TrialKind(run, CellResult.from_json)
    results = run_trials(kind, wanted, trials, options.scheduler, workers, progress)
    text = write_cells(results, folder, about)
    note = f"\n\n{others} cells were run with another version of the code; delete {trials} to run them again"
    return text + note if others else text


def write_cells(results: Sequence[CellResult], folder: Path, about: str = "") -> str:
    """``cells.csv``, a row a cell, and ``cells.md``, a row a kind and a line on each cell that failed; the latter.

    ``about`` says first what was run.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "cells.csv").open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(COLUMNS)
        for r in results:
            named = [" ".join(names) for names in (r.reached, r.refused, r.walked_into, r.odd)]
            counted = [r.spec.kind, r.spec.seed, int(r.success), r.robots]
            writer.writerow([*counted, *named, f"{r.sim_s:.1f}", "; ".join(r.faults)])
    by_kind = [[r for r in results if r.spec.kind == kind] for kind in KINDS]
    rows = [_row(of_kind[0].spec.kind, of_kind) for of_kind in by_kind if of_kind]
    sections = [about, markdown_table(HEADER, [*rows, _row("all", results)])]
    failed = [result for result in results if not result.success]
    odd = [result for result in results if result.success and result.odd]
    for title, found in (("Failed:", failed), ("Odd:", odd)):
        sections += [title, "\n".join(f"- {cell_line(result)}" for result in found)] if found else []
    text = "\n\n".join(section for section in sections if section)
    (folder / "cells.md").write_text(text + "\n")
    return text


def _row(kind: str, results: Sequence[CellResult]) -> Sequence[str]:
    failed = Proportion(sum(not result.success for result in results), len(results))
    counts = [sum(map(len, lists)) for lists in zip(*((r.reached, r.refused, r.walked_into) for r in results))]
    seconds = sum(result.sim_s for result in results)
    shown = [str(count) for count in counts or (0, 0, 0)]
    return (kind, str(failed.trials), str(failed.hits), failed.text(), *shown, f"{seconds:.0f}")
