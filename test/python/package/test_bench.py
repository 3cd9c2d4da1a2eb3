"""The benchmark's page says what its raw rows say, and a run that was stopped goes on where it was."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Callable, Dict, List

import pytest

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "bench"))

import kinematics  # noqa: E402 (bench is no package)
import localisation  # noqa: E402
from missions import write_csv  # noqa: E402
from planning_report import write_report  # noqa: E402
from planning_table import Table, read_rows  # noqa: E402


def test_the_page_is_drawn_from_the_rows_that_are_committed(tmp_path: Path) -> None:
    def lines(page: Path) -> List[str]:
        return [line for line in page.read_text(encoding="utf-8").splitlines() if not line.startswith("Measured on")]

    page = write_report(ROOT / "bench" / "data", tmp_path)
    assert lines(page) == lines(ROOT / "bench" / "planning.md"), "run: python3 bench/planning.py report"


def test_all_planners_of_the_fleets_were_given_the_same_instances() -> None:
    instances: Dict[str, set] = {}
    for row in read_rows(ROOT / "bench" / "data" / "planning_fleets.csv"):
        instances.setdefault(row["planner"], set()).add((row["family"], row["seed"], row["robots"]))
    assert len(instances) > 5
    assert all(found == instances["yarm"] for found in instances.values())


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("localisation_starts.csv", localisation.start_line),
        ("localisation_tours.csv", localisation.tour_line),
    ],
)
def test_the_tables_of_the_localisation_are_of_the_rows(file: str, line: Callable[[str, List[Dict[str, str]]], str]):
    sets: Dict[str, List[Dict[str, str]]] = {}
    for row in read_rows(ROOT / "bench" / "data" / file):
        sets.setdefault(row["set"], []).append(row)
    page = (ROOT / "bench" / "localisation.md").read_text(encoding="utf-8").splitlines()
    assert len(sets) >= 2
    assert [line(name, rows) for name, rows in sets.items() if line(name, rows) not in page] == []


def test_the_table_of_the_kinematics_is_of_the_rows() -> None:
    methods: Dict[str, List[Dict[str, object]]] = {}
    for row in read_rows(ROOT / "bench" / "data" / "kinematics.csv"):
        numbers = {key: float(value) if value else "" for key, value in row.items() if key != "method"}
        methods.setdefault(row["method"], []).append(numbers)
    page = (ROOT / "bench" / "kinematics.md").read_text(encoding="utf-8").splitlines()
    assert set(methods) == set(kinematics.TITLES)
    for name, rows in methods.items():
        assert f"| {' | '.join(kinematics.line(kinematics.TITLES[name], rows))} |" in page


def test_what_is_said_of_the_hand_is_of_the_rows() -> None:
    picks: Dict[str, List[Dict[str, str]]] = {}
    for row in read_rows(ROOT / "bench" / "data" / "hand_picks.csv"):
        picks.setdefault(row["error_m"], []).append(row)
    taken = {error: sum(row["taken"] == "True" for row in rows) for error, rows in picks.items()}
    page = (ROOT / "docs" / "manipulation.md").read_text(encoding="utf-8")
    for error, said in (("0.01", "tip is within 1 cm"), ("0.03", "within the 3 cm")):
        (line,) = [line for line in page.splitlines() if said in line]
        assert f"| {taken[error]} of {len(picks[error])}" in line


def test_a_row_is_made_once_and_survives_a_stop(tmp_path: Path) -> None:
    def table() -> Table:
        return Table(tmp_path / "rows.csv", ("name", "seed"), ("ms",))

    made = []

    def make() -> Dict[str, float]:
        made.append(1)
        return {"ms": 1.5}

    assert table().add({"name": "a, b", "seed": 1}, make) is not None
    assert table().add({"name": "a, b", "seed": 1}, make) is None
    assert table().add({"name": "a, b", "seed": 2}, make) is not None
    assert len(made) == 2
    rows = read_rows(tmp_path / "rows.csv")
    assert [row["seed"] for row in rows] == ["1", "2"]
    assert {row["ms"] for row in rows} == {"1.5"}
    with pytest.raises(ValueError, match="remove it"):
        Table(tmp_path / "rows.csv", ("name",), ("ms",))


def test_missions_leave_a_row_a_run_those_without_results_too(tmp_path: Path) -> None:
    robots = {"a": {"waypoints": 3, "path_m": 3.2, "min_clearance_m": 0.12}}
    robots["b"] = {"waypoints": 4, "path_m": 2.3, "min_clearance_m": None}
    good = {"seed": 1, "success": True, "faults": [], "sim_s": 24.5, "robots": robots, "pauses": [{"start_s": 9.8}]}
    lost = {"seed": 2, "success": False, "faults": ["no results were written"]}
    write_csv(tmp_path / "missions.csv", "seed", {"2m1ma": [good, lost]})
    first, second = read_rows(tmp_path / "missions.csv")
    assert (first["waypoints"], first["path_m"], first["clearance_m"], first["pauses"]) == ("7", "5.5", "0.12", "1")
    assert (second["success"], second["sim_s"], second["faults"]) == ("False", "", "no results were written")
