"""The study of random cells: what it runs, that it resumes, and what it writes."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from yarm.experiments.cells.outcome import CellResult, CellSpec
from yarm.experiments.cells.pictures import plot_cells
from yarm.experiments.cells.study import cell_command, run_cell, specs, write_cells
from yarm.experiments.run.writers import CUT_SHORT
from yarm.experiments.study.reproduce import parser
from yarm.experiments.study.runner import StudyError
from yarm.sim.scenes.random_cell import KINDS, random_cell
from yarm.sim.scenes.scene_file import scene_text

SPEC = CellSpec("unreachable", 5)


def results_of(tmp_path: Path, **changes: object) -> Path:
    """Results of a run of SPEC as they would be on disk: its one other goal was reached."""
    own = tmp_path / "random_unreachable" / "5"
    own.mkdir(parents=True)
    (own / "random_unreachable.yaml").write_text(scene_text(random_cell(SPEC.kind, SPEC.seed)))
    (own / "path.csv").write_text("robot,time_s,x_m,y_m\n")
    at_goal = {"reached": True, "declared_s": 9.0, "status": "reached", "reason": ""}
    given_up = {"reached": False, "declared_s": None, "status": "unreachable", "reason": "wall"}
    goals = {"debris_1": at_goal, "target_inside": given_up}
    values = {"goals": goals, "contacts": [], "outcome": "failed", "reason": "", "sim_s": 150.0, "faults": []}
    (own / "summary.yaml").write_text(yaml.safe_dump({**values, **changes}))
    return tmp_path


def test_kinds_take_turns() -> None:
    assert [spec.kind for spec in specs(len(KINDS) + 1)] == [*KINDS, KINDS[0]]
    assert len({spec.key for spec in specs(50)}) == 50
    assert parser().parse_args(["--study", "cells", "--cells", "12"]).cells == 12


def test_a_cell_is_run_in_lock_step(tmp_path: Path) -> None:
    words = cell_command(tmp_path, SPEC)
    assert " ".join(words[-8:]) == f"--case random --kind unreachable --seed 5 --results {tmp_path}"
    assert "--sync" in words


def test_results_that_are_there_are_judged_and_not_made_again(tmp_path: Path) -> None:
    result = run_cell(results_of(tmp_path), SPEC)
    assert result.success, result.faults
    assert (result.reached, result.refused) == (("debris_1",), ("target_inside",))


def test_a_row_a_kind_and_a_line_a_failure_are_written(tmp_path: Path) -> None:
    good = CellResult(CellSpec("plain", 0), (), ("target_1",), robots=2, sim_s=20.0)
    bad = CellResult(CellSpec("slips", 1), ("debris_1 was never seen by the Commander",), robots=1, sim_s=30.0)
    text = write_cells([good, bad, good], tmp_path)
    assert "| plain | 2 | 0 |" in text
    assert "| all | 3 | 1 | 33 % (6-79) |" in text
    assert "- random_slips-0001: FAILED: debris_1 was never seen" in text
    assert (tmp_path / "cells.md").read_text().strip() == text
    lines = (tmp_path / "cells.csv").read_text().splitlines()
    assert lines[2] == "slips,1,0,1,,,,,30.0,debris_1 was never seen by the Commander"


def test_a_study_without_a_failure_names_none(tmp_path: Path) -> None:
    assert "Failed" not in write_cells([CellResult(CellSpec("plain", 0), (), robots=1)], tmp_path)


def test_cells_are_drawn(tmp_path: Path) -> None:
    picture = plot_cells([random_cell(kind, 2) for kind in KINDS], tmp_path / "cells.png")
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size > 20_000


def test_a_run_that_was_cut_short_is_no_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = results_of(tmp_path, faults=[CUT_SHORT])
    monkeypatch.setattr("yarm.experiments.cells.study.cell_command", lambda folder, spec: ["true"])
    with pytest.raises(StudyError, match="random_unreachable-0005 was cut short"):
        run_cell(folder, SPEC)
