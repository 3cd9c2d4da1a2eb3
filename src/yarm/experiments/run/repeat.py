"""What is kept of a mission so that it can be repeated: what it was launched with, beside its ledger."""

from __future__ import annotations

from pathlib import Path
from typing import List, Sequence

import yaml

from yarm.experiments.run.ledger import LedgerError, read_ledger

ARGUMENTS, RESULT = "arguments.yaml", "replay.yaml"
OWN = ("results", "rviz", "bag", "speed", "console", "console_port", "console_token", "console_results")
"""Launch arguments that decide nothing of a mission."""


def write_arguments(folder: Path, call: Sequence[str]) -> None:
    """Keep what a mission was launched with beside its results."""
    (folder / ARGUMENTS).write_text(yaml.safe_dump({"arguments": [word for word in call if ":=" in word]}))


def recorded_arguments(folder: Path) -> List[str]:
    """What decides of the mission in a folder of results.

    Raises:
        LedgerError: nothing was kept, or the mission was not in lock-step.
    """
    path = folder / ARGUMENTS
    try:
        arguments = [str(word) for word in yaml.safe_load(path.read_text())["arguments"]]
    except (OSError, KeyError, TypeError, yaml.YAMLError) as error:
        text = "a mission of the cell that run_experiment has run leaves it; is this the folder of its results?"
        raise LedgerError(f"{path}: not to be read ({error}): {text}") from error
    if "sync:=true" not in arguments:
        raise LedgerError(f"{folder}: this mission was not in lock-step, so it does not repeat: run it with --sync")
    return [word for word in arguments if word.partition(":=")[0] not in OWN]


def decision_at(folder: Path, number: int) -> int:
    """The number, when the ledger in a folder has such a decision.

    Raises:
        LedgerError: it has not, or there is none.
    """
    rows = read_ledger(folder / "decisions.csv")
    if not 1 <= number <= len(rows):
        raise LedgerError(f"decision {number}: {folder} has the decisions 1 to {len(rows)}")
    return number
