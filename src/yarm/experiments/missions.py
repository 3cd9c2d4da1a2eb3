"""Whole missions in full physics for the published figures: heat map of waypoints and the path really driven."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any, Callable, List, Mapping, Sequence

import yaml

CASES = ("2m1ma", "3m")
SEED = 3


def run_missions(folder: Path, on_progress: Callable[[int, int, str], None], cases: Sequence[str] = CASES) -> str:
    """Run each case that has no results yet; one line on each, with where its figures are."""
    lines: List[str] = []
    for done, case in enumerate(cases):
        on_progress(done, len(cases), case)
        own = folder / case / str(SEED)
        if not (own / "summary.yaml").is_file():
            own.mkdir(parents=True, exist_ok=True)
            with (own / "run.log").open("w") as log:
                subprocess.run(mission_command(folder, case), stdout=log, stderr=subprocess.STDOUT, check=False)
        lines.append(mission_line(case, own))
    on_progress(len(cases), len(cases), "")
    return "\n".join(lines)


def mission_command(folder: Path, case: str) -> List[str]:
    """The run of one case."""
    return ["rosrun", "yarm", "run_experiment", "--case", case, "--seed", str(SEED), "--results", str(folder)]


def mission_line(case: str, own: Path) -> str:
    """What a case came to, and its figures; or where to look when it left no results."""
    try:
        values: Mapping[str, Any] = yaml.safe_load((own / "summary.yaml").read_text())
    except FileNotFoundError:
        return f"{case}: no results; see {own / 'run.log'}"
    verdict = "success" if values["success"] else "FAILED: " + "; ".join(values["faults"])
    maps = ", ".join(path.name for path in sorted(own.glob("map*.png")))
    return f"{case}: {verdict}; figures in {own}: {maps}"
