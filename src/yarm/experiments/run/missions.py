"""Whole missions in full physics for the published figures: heat map of waypoints and the path really driven."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path
from typing import Any, Callable, List, Mapping, Sequence, TextIO

import yaml

from yarm.commander.params import Execution, Removal
from yarm.experiments.run.writers import is_finished
from yarm.planning.model.hidden import HiddenPolicy
from yarm.resources import package_root

CASES = ("2m1ma", "3m")
SEED = 3
WALL_LIMIT_S = 1800
STOP_LIMIT_S = 60.0


def run_missions(folder: Path, on_progress: Callable[[int, int, str], None], cases: Sequence[str] = CASES) -> str:
    """Run each case that has no results yet; one line on each, with where its figures are."""
    lines: List[str] = []
    for done, case in enumerate(cases):
        on_progress(done, len(cases), case)
        own = folder / case / str(SEED)
        if not is_finished(own):
            own.mkdir(parents=True, exist_ok=True)
            with (own / "console.txt").open("w") as log:
                launch(mission_command(folder, case), log)
        lines.append(mission_line(case, own))
    on_progress(len(cases), len(cases), "")
    return "\n".join(lines)


def launch(command: Sequence[str], log: TextIO) -> None:
    """Run a command to its end, its output into a file; an interrupt is handed on, so that nothing is left running."""
    child = subprocess.Popen(list(command), stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT)
    try:
        child.wait()
    except KeyboardInterrupt:
        child.send_signal(signal.SIGINT)
        child.wait(timeout=STOP_LIMIT_S)
        raise


def mission_command(folder: Path, case: str) -> List[str]:
    """The run of one case, as its scene file lays it out and as published.

    In steps, reached debris is deleted, and what no camera sees is free.
    """
    published = ["--nominal", "--removal", Removal.DELETE.value, "--execution", Execution.STEPS.value]
    published += ["--hidden", HiddenPolicy.FREE.value]
    return [*experiment_command(), *published, "--case", case, "--seed", str(SEED), "--results", str(folder)]


def experiment_command() -> List[str]:
    """How ``run_experiment`` is called: in lock-step, so that a busy machine changes nothing but the wall time.

    The checkout's own script, or the installed one by rosrun.
    """
    script = package_root() / "scripts" / "run_experiment"
    call = [sys.executable, str(script)] if script.is_file() else ["rosrun", "yarm", "run_experiment"]
    return [*call, "--sync", "--speed", "0", "--wall-limit", str(WALL_LIMIT_S)]


def mission_line(case: str, own: Path) -> str:
    """What a case came to, and its figures; or where to look when it left no results."""
    try:
        values: Mapping[str, Any] = yaml.safe_load((own / "summary.yaml").read_text())
    except FileNotFoundError:
        return f"{case}: no results; see {own / 'run.log'}"
    verdict = "success" if values["success"] else "FAILED: " + "; ".join(values["faults"])
    maps = ", ".join(path.name for path in sorted(own.glob("map*.png")))
    return f"{case}: {verdict}; figures in {own}: {maps}"
