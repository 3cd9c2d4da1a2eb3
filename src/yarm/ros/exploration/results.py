"""Writes what an exploration leaves behind, and says whether it succeeded."""

from __future__ import annotations

from pathlib import Path
from typing import Optional, Tuple

from yarm.experiments.explore.cost import RunCost
from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.measures import measure
from yarm.experiments.explore.pictures import plot_exploration
from yarm.experiments.explore.record import ExploreRecord
from yarm.experiments.explore.shown import summary_table
from yarm.experiments.explore.writers import faults_of, write_exploration
from yarm.ros.experiment.results import parameters, versions


def write_results(
    record: ExploreRecord, judge: Judge, folder: Path, fault: str, cost: Optional[RunCost]
) -> Tuple[bool, str]:
    """Write all files and pictures of a run.

    Args:
        record: of the run.
        judge: of its arena.
        folder: where to; made when missing.
        fault: why it broke off; empty when it did not.
        cost: of the run; None when it never began.

    Returns:
        whether it succeeded, and the table for the person at the terminal.
    """
    measures = measure(record, judge)
    faults = (fault,) if fault else ()
    write_exploration(record, measures, folder, parameters(), versions(), faults, cost)
    plot_exploration(record, judge.arena, folder)
    wrong = (*faults, *faults_of(measures))
    return not wrong, summary_table(record, measures, wrong, cost)
