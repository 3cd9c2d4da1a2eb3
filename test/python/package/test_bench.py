"""The benchmark's page says what its raw rows say, and a run that was stopped goes on where it was."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Callable, Dict, List, Optional

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "bench"))

import faults_page  # noqa: E402
import kinematics  # noqa: E402 (bench is no package)
import localisation  # noqa: E402
import missions  # noqa: E402
import planning  # noqa: E402
import planning_hands  # noqa: E402
from missions import write_csv  # noqa: E402
from planning_report import write_report  # noqa: E402
from planning_table import Table, read_rows  # noqa: E402

from yarm.experiments.run.cases import expected_goals  # noqa: E402
from yarm.planning.cspace.cell_sets import Layout  # noqa: E402
from yarm.planning.cspace.footprint import turned_columns  # noqa: E402
from yarm.sim.scenes.random_cell import random_cell  # noqa: E402
from yarm.sim.scenes.scene_file import scene_text  # noqa: E402


def test_the_page_is_drawn_from_the_rows_that_are_committed(tmp_path: Path) -> None:
    def lines(page: Path) -> List[str]:
        return [line for line in page.read_text(encoding="utf-8").splitlines() if not line.startswith("Measured on")]

    page = write_report(ROOT / "bench" / "data", tmp_path)
    assert lines(page) == lines(ROOT / "bench" / "planning.md"), "run: python3 bench/planning.py report"


def test_the_page_of_faults_is_drawn_from_the_rows_that_are_committed() -> None:
    rows = faults_page.known_rows(ROOT / "bench" / "data" / "faults.csv")
    assert rows
    page = (ROOT / "bench" / "faults.md").read_text(encoding="utf-8")
    assert faults_page.written(rows) == page, "run: python3 bench/faults.py --report"


def test_a_cold_plan_has_no_table_of_turns() -> None:
    turned_columns((0.0, 1.0, 0.1, 0.1), Layout((4, 4, 4), 3))
    assert turned_columns.cache_info().currsize > 0
    planning.forget_tables()
    assert turned_columns.cache_info().currsize == 0


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


def test_the_table_of_planning_with_hands_is_of_the_rows() -> None:
    taken: Dict[str, List[Optional[List[float]]]] = {kind: [] for kind in planning_hands.KINDS}
    for row in read_rows(ROOT / "bench" / "data" / "planning_hands.csv"):
        errands = taken[row["robots"]]
        if row["plan"] in ("", "0"):
            errands.append([] if row["plan"] else None)
        if row["plan"]:
            errands[int(row["errand"])].append(float(row["ms"]))  # type: ignore[union-attr]
    page = (ROOT / "bench" / "README.md").read_text(encoding="utf-8").splitlines()
    assert [line for line in planning_hands.lines(taken) if line not in page] == []


def test_what_is_said_of_the_hand_is_of_the_rows() -> None:
    picks: Dict[str, List[Dict[str, str]]] = {}
    for row in read_rows(ROOT / "bench" / "data" / "hand_picks.csv"):
        picks.setdefault(row["error_m"], []).append(row)
    taken = {error: sum(row["taken"] == "True" for row in rows) for error, rows in picks.items()}
    page = (ROOT / "docs" / "manipulation.md").read_text(encoding="utf-8")
    for error, said in (("0.01", "tip is within 1 cm"), ("0.03", "within the 3 cm")):
        (line,) = [line for line in page.splitlines() if said in line]
        assert f"| {taken[error]} of {len(picks[error])}" in line
    for error, said in (("aligned", "rows `aligned`"), ("seen", "rows `seen`")):
        (line,) = [line for line in page.splitlines() if said in line]
        first = sum(row["taken"] == "True" and row["tries"] == "1" for row in picks[error])
        assert f"| {first} of {len(picks[error])} at the first try" in line and taken[error] == len(picks[error])


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


@pytest.mark.parametrize(("contacts", "code"), [([], 0), (["failure"], 1)])
def test_random_cells_that_are_on_disk_are_judged_and_a_failure_is_named_with_its_seed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], contacts: List[str], code: int
) -> None:
    scene = random_cell("plain", 0)
    own = tmp_path / "cells" / "random_plain" / "0"
    own.mkdir(parents=True)
    (own / "random_plain.yaml").write_text(scene_text(scene))
    (own / "path.csv").write_text("robot,time_s,x_m,y_m\n")
    goals = {
        name: {"reached": True, "declared_s": 9.0, "status": "reached", "reason": ""} for name in expected_goals(scene)
    }
    touched = [
        {"kind": kind, "pair": ["ankurbot_1", "table"], "links": ["base", "top"], "depth_m": 0.01, "first_s": 9.0}
        for kind in contacts
    ]
    values = {"goals": goals, "contacts": touched, "outcome": "succeeded", "reason": "", "sim_s": 60.0, "faults": []}
    (own / "summary.yaml").write_text(yaml.safe_dump(values))
    words = ["--cells", "1", "--workers", "1", "--results", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["missions.py", *words])
    assert missions.main() == code
    said = capsys.readouterr().out
    assert "| plain | 1 |" in said
    assert ("random_plain-0000: FAILED: ankurbot_1 (base) touched table (top) at 9.0 s" in said) == bool(contacts)


def test_cells_without_physics_are_run_once_and_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    words = ["--cells", "1", "--kinematic", "--workers", "1", "--results", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["missions.py", *words])
    assert missions.main() == 0
    said = capsys.readouterr().out
    assert "Random cells without physics" in said
    assert "| plain | 1 | 0 |" in said
    page = (tmp_path / "kinematic" / "cells.md").read_text(encoding="utf-8")

    def never(spec: object) -> None:
        raise AssertionError(f"{spec} is on disk")

    monkeypatch.setattr(missions, "run_cell", never)
    assert missions.main() == 0
    assert (tmp_path / "kinematic" / "cells.md").read_text(encoding="utf-8") == page
