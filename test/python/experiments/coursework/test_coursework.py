"""The demo runs through, says what it did, draws its pictures, and fails when something is not as it must be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import List

import numpy as np
import pytest
import yaml

from yarm.console.film import Film
from yarm.console.floor_film import FloorFilm
from yarm.console.results import FILM
from yarm.experiments.coursework.clearing import clearing
from yarm.experiments.coursework.cli import Keeping, main, run
from yarm.experiments.coursework.tasks import TaskResult, floors, kinematics, obstacles, tours
from yarm.geometry import transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.coverage.spanning_tree import visits
from yarm.manipulation.motion.checkpoints import Obstacle, load_arm_scene
from yarm.manipulation.motion.tour import Order
from yarm.resources import resource
from yarm.sim.scenes.youbot_floor import FloorPiece, load_floor_scene

TOUR = load_arm_scene(resource("scenes", "manipulation", "checkpoints.yaml"))
FLOOR = load_floor_scene(resource("scenes", "manipulation", "youbot_floor.yaml"))
AMONG = load_arm_scene(resource("scenes", "manipulation", "arm_obstacles.yaml"))


def cell(result: TaskResult, row: str, column: int) -> str:
    """One entry of a table."""
    return next(cells for cells in result.rows if cells[0] == row)[column]


def test_the_whole_demo_succeeds_and_leaves_pictures_and_a_summary(tmp_path: Path) -> None:
    said: List[str] = []
    keeping = Keeping(film=FloorFilm("floor"))
    results = run(TOUR, AMONG, replace(FLOOR, debris=FLOOR.debris[1:2]), 3, tmp_path, said.append, keeping)
    assert [fault for result in results for fault in result.faults] == []
    text = "\n".join(said)
    assert "coursework, seed 3: SUCCESS" in text
    for name in ("tour.png", "obstacles.png", "coverage.png", "clearing.png"):
        assert (tmp_path / name).stat().st_size > 20_000
        assert f"picture: {tmp_path / name}" in text
    summary = yaml.safe_load((tmp_path / "summary.yaml").read_text())
    assert summary["success"] is True
    (piece, together) = summary["tasks"]["the youBot's floor, in physics"]
    assert (piece["1 pieces"], piece["by ground truth"]) == ("debris_2", "in the bin")
    assert together["most on the cup"].endswith(" N")
    assert f"film: {tmp_path / FILM}" in text
    film = Film.read(tmp_path / FILM).index()
    begun = {event["text"]: event["time_s"] for event in film["events"]}
    assert begun["tour of 8 checkpoints"] == 0.0 < begun["among obstacles"] < begun["the floor"]
    floor_s = film["blocks"][-1]["last_s"] - begun["the floor"]
    assert floor_s == pytest.approx(float(together["by ground truth"].split()[0]), abs=1.0)
    rows = {row["method"]: row for row in summary["tasks"]["obstacle task, in physics"]}
    assert rows["yarm"]["reached"] == "5 of 5"
    assert rows["yarm"]["touches"] == "0"
    assert rows["potential_field"]["reached"] != "5 of 5"
    assert rows["turn_extend_retract, obstacles yield"]["reached"] == "5 of 5"


def test_the_printed_formulas_solve_nothing_until_they_are_mended() -> None:
    result = kinematics(5)
    assert cell(result, "closed form, every branch", 1) == "100.0 %"
    assert cell(result, "printed formulas, on their own forward kinematics", 1) == "0.0 %"
    assert 50.0 < float(cell(result, "the same, gamma and theta5 mended", 1).split()[0]) < 80.0


def test_the_tour_is_straight_and_keeps_its_limits() -> None:
    result = tours(TOUR)
    assert not result.task.faults
    assert result.tours[Order.EXACT].length_rad < result.tours[Order.GREEDY].length_rad
    assert len(result.lines) == len(TOUR.checkpoints)


def test_a_checkpoint_that_is_walled_in_is_a_fault() -> None:
    ball = Obstacle(
        "ball", Solid(Shape.SPHERE, (0.05,), transform_matrix(AMONG.checkpoints[1].pose[:3, 3], (0, 0, 0, 1)))
    )
    result = obstacles(replace(AMONG, checkpoints=AMONG.checkpoints[1:3], obstacles=(ball,)), 0)
    assert "reached 1 checkpoints only" in result.task.faults


def test_the_floor_is_covered_and_the_field_is_caught() -> None:
    result = floors()
    assert not result.task.faults
    entered = visits(result.coverage.cells, result.floor.free.shape)
    assert np.array_equal(entered > 0, result.floor.free)
    assert result.ways["potential field"].reached < len(result.goals)
    assert result.ways["planned"].reached == len(result.goals)


def test_a_scene_that_cannot_be_read_ends_with_its_faults(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text("checkpoints: []\n")
    assert main(["--checkpoints", str(bad), "--results", str(tmp_path)]) == 2
    assert "holds 0 checkpoints" in capsys.readouterr().err
    far = tmp_path / "far.yaml"
    far.write_text("checkpoints:\n  - {name: far, xyz: [1.5, 0, 0.2], tilt_deg: 0}\n")
    assert main(["--checkpoints", str(far), "--results", str(tmp_path)]) == 1
    assert "none of 1 checkpoints can be reached" in capsys.readouterr().err


def test_a_floor_that_is_not_cleared_is_a_fault() -> None:
    heavy = FloorPiece("debris_1", 0.5, 1.0, 0.0, mass_kg=3.0)
    result = clearing(replace(FLOOR, debris=(heavy,)), 0, lambda text: None)
    assert result.task.faults == ("debris_1: debris_1 weighs 3.00 kg, 29.4 N: the cup holds 20 N",)
    assert result.task.rows[0][1] == "not in the bin"
