"""``run_experiment --case inspect`` from end to end, in physics and lock-step: four boxes, and too little time."""

from __future__ import annotations

import csv
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Tuple

import pytest
import yaml

from support.launched import ROOT, Launched, LaunchedTestError, run
from yarm.experiments.inspect.writers import FILES, REPORT_FILES
from yarm.inspection.model import OURS, PRINTED, REPORT
from yarm.ros.experiment.launcher import INTERRUPTED
from yarm.ros.experiment.ports import free_port
from yarm.ros.inspection.experiment import CUT_SHORT

pytestmark = pytest.mark.xdist_group("inspection_runs")  # they look at the files of one run
LIMIT_S = 600.0
LAYOUT = Path(__file__).with_name("inspected_room.yaml")
TAGS = {1: "5", 2: "blank", 3: "11", 4: "2"}
CALL = [
    sys.executable,
    str(ROOT / "scripts" / "run_experiment"),
    "--case",
    "inspect",
    "--layout",
    str(LAYOUT),
    "--seed",
    "1",
]


def folder_of(results: Path, controller: str = OURS) -> Path:
    """Of a run's results."""
    return results / "inspect" / "inspected_room" / controller / "1"


def inspect(results: Path, name: str, *more: str) -> Tuple[Path, str]:
    """One run of ours; its folder and what it printed."""
    output = run([*CALL, *more, "--results", str(results)], name, LIMIT_S)
    return folder_of(results), output


@pytest.fixture(scope="module")
def inspected(tmp_path_factory: pytest.TempPathFactory) -> Tuple[Path, str]:
    """One run of ours, for every test that looks at one: its folder and what it printed."""
    return inspect(tmp_path_factory.mktemp("inspected"), "inspect_room")


def test_the_same_seed_gives_the_same_round(inspected: Tuple[Path, str], tmp_path: Path) -> None:
    """Byte for byte: what happened and when, where the robot was, what it saw in each image, what it read."""
    again, _ = inspect(tmp_path, "inspect_again")
    for name in ("events.csv", "orders.csv", "path.csv", "views.csv", "result.csv", "result.txt", "touches.csv"):
        assert (again / name).read_bytes() == (inspected[0] / name).read_bytes(), name


def test_it_reads_four_of_four_and_is_home(inspected: Tuple[Path, str]) -> None:
    folder, output = inspected
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is True and summary["faults"] == []
    assert (summary["right"], summary["named_wrong"], summary["bumps"]) == (4, 0, 0)
    assert summary["home_m"] < 0.10 and summary["home_rad"] < 0.1 and summary["end_s"] < 120.0
    assert summary["parameters"]["inspector"]["controller"] == "yarm"
    lines = (folder / "result.txt").read_text().splitlines()
    assert lines[0] == "Tag is 0 means blank" and len(lines) == 5
    found = dict(re.match(r"boxNumber: (\d) tag is (\w+) x: ", line).groups() for line in lines[1:])  # type: ignore[union-attr]
    assert {int(box): tag for box, tag in found.items()} == TAGS
    assert {"proof.html", "views.csv", "events.csv", "path.csv", "result.csv"} <= {p.name for p in folder.iterdir()}
    with (folder / "path.csv").open() as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) == pytest.approx(10 * summary["end_s"], abs=12)
    assert "inspected_room, yarm, seed 1: SUCCESS" in output
    assert re.search(r"s \| x\d\.\d\d \| drive box \d \| \d of 4 boxes.* \| \d+ s left \| \d+ s home", output)


def test_too_little_time_brings_it_home_with_a_reason_for_every_box_that_is_left(tmp_path: Path) -> None:
    with pytest.raises(LaunchedTestError, match="exit code 1"):
        inspect(tmp_path, "inspect_short", "--limit", "45")
    folder = folder_of(tmp_path)
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is False and summary["kept"] is True and summary["end_s"] <= 45.0
    assert summary["home_m"] < 0.10
    with (folder / "result.csv").open() as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) == 4 and 1 <= summary["right"] < 4
    left = [row for row in rows if row["read"] == "none"]
    events = (folder / "events.csv").read_text()
    assert all(f",hopeless,box={row['box']} " in events for row in left), events
    assert left and all("time" in row["reason"] for row in left)


def test_interrupted_it_leaves_the_result_so_far(tmp_path: Path) -> None:
    """That the robot stands then is seen where the simulation goes on: ``test/ros/inspector_ends_test.py``."""
    with Launched([*CALL, "--results", str(tmp_path)], "inspect_interrupted", {}, ROOT) as child:
        ended = time.monotonic() + LIMIT_S
        while not re.search(r"\| [12] of 4 boxes: ", child.output()):
            assert child.running() and time.monotonic() < ended, child.output()
            time.sleep(0.2)
        assert child.interrupt(LIMIT_S) == INTERRUPTED
    folder = folder_of(tmp_path)
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is False and CUT_SHORT in summary["faults"]
    assert 1 <= len(summary["verdicts"]) < 4 and summary["right"] == len(summary["verdicts"])
    assert (folder / "result.txt").read_text().count("boxNumber: ") == len(summary["verdicts"])
    assert {"proof.html", "path.csv", "events.csv"} <= {path.name for path in folder.iterdir()}
    log = (folder / "run.log").read_text()
    assert "Traceback" not in log, log[-4000:]


@pytest.mark.parametrize("controller, header", [(REPORT, "Tag is 0 means blank"), (PRINTED, "boxNumnber: ")])
def test_the_reports_rounds_end_and_leave_their_files(tmp_path: Path, controller: str, header: str) -> None:
    """Whether they read every box is their own affair; what they say they have read is in their files."""
    try:
        run([*CALL, "--controller", controller, "--results", str(tmp_path)], f"inspect_{controller}", LIMIT_S)
        ended_well = True
    except LaunchedTestError as error:
        assert "exit code 1" in str(error), error
        ended_well = False
    folder = folder_of(tmp_path, controller)
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is ended_well and summary["controller"] == controller
    assert summary["stage"] == "done" and len(summary["verdicts"]) == 4 and summary["end_s"] < 480.0
    assert summary["right"] >= 1 and summary["images"] == 4 * 21
    texts = {name: (folder / name).read_text() for name in REPORT_FILES}
    assert texts["changeEngine.txt"].startswith(header)
    said = sum(line.startswith("boxNumnber: ") for line in texts["changeEngine.txt"].splitlines())
    assert said + texts["changeEngine.txt"].count("unmatched: ") == 4
    assert texts["MapText.txt"].count("CONNECTOR") == summary["images"]


def test_the_launch_file_alone_judges_the_first_round_and_goes_on(tmp_path: Path) -> None:
    port = free_port()
    environment = {"PWD": str(tmp_path), "ROS_MASTER_URI": f"http://localhost:{port}"}
    call = ["roslaunch", "-p", str(port), "yarm", "inspection.launch", f"layout:={LAYOUT}", "seed:=1"]
    with Launched([*call, "sync:=true", "real_time_factor:=0"], "inspect_alone", environment, tmp_path) as child:
        ended = time.monotonic() + LIMIT_S
        while "results, pictures and proof sheets: " not in child.output():
            assert child.running() and time.monotonic() < ended, child.output()[-4000:]
            time.sleep(0.5)
        output = child.output()
        assert "inspected_room, yarm, seed 1: SUCCESS" in output
        assert re.search(r"drive box \d \| \d of 4 boxes.* \| \d+ s left \| \d+ s home", output)
        again = ["rosservice", "call", "/inspector/start"]
        answer = subprocess.run(
            again, env={**os.environ, **environment}, capture_output=True, text=True, timeout=60, check=False
        )
        assert "success: True" in answer.stdout, answer.stdout + answer.stderr
    folder = folder_of(tmp_path / "results")
    assert set(FILES) <= {path.name for path in folder.iterdir()}
    assert (tmp_path / "inspection_result.txt").read_text() == (folder / "result.txt").read_text()
