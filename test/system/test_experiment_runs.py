"""``run_experiment`` from end to end: it launches everything, writes everything, and its exit code is the verdict."""

from __future__ import annotations

import csv
import re
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Dict, List, Tuple

import pytest
import yaml

from support.launched import ROOT, Launched, LaunchedTestError, run
from yarm.console.film import Film, unpack
from yarm.console.wire import decode
from yarm.experiments.run.ledger import difference, ledger_hash, read_ledger
from yarm.ros.common.names import ee_frame
from yarm.ros.experiment.ports import free_port

LIMIT_S = 900.0
MISSION = [sys.executable, str(ROOT / "scripts" / "run_experiment"), "--sync", "--speed", "0"]
CALL = [*MISSION, "--case", "single"]
LOOK = """
import rospy
from yarm.msg import CommanderStatus
from yarm.ros.common.names import COMMANDER_STATUS
from yarm.ros.common.start import init_node
init_node("who_looks", anonymous=True, disable_rostime=True)
said = rospy.wait_for_message(COMMANDER_STATUS, CommanderStatus, timeout=60.0)
print({"state": said.state_name, "tasks": [task.goal for task in said.tasks], "stamp": said.header.stamp.to_sec()})
"""
"""What a tool of ROS sees of a cell that stands still."""
ENDING_S = 0.2
"""How long after the mission's last moment poses may still come in, s; when the recording ends is wall time's say."""


@pytest.fixture(name="single", scope="module")
def single_fixture(tmp_path_factory: pytest.TempPathFactory) -> Tuple[Path, str]:
    """Folder and output of a mission that succeeds."""
    results = tmp_path_factory.mktemp("single")
    output = run([*CALL, "--seed", "1", "--results", str(results)], "experiment_single", LIMIT_S)
    return results / "single" / "1", output


def test_a_success_leaves_everything_and_ends_with_0(single: Tuple[Path, str]) -> None:
    folder, output = single
    tables = {"summary.yaml", "waypoints.csv", "path.csv", "timing.csv", "decisions.csv", "squares.csv"}
    tables |= {"proof.html", "arguments.yaml"}
    pictures = {"map.png", "map_ankurbot_1.png", "planning_time.png", "timing.png"}
    assert {path.name for path in folder.iterdir()} == tables | pictures | {"run.log", "run.film"}
    film = Film.read(folder / "run.film")
    last = len(film.index()["blocks"]) - 1
    shown = {header["kind"]: (header, arrays) for header, arrays in (decode(m) for _, m in unpack(film.block(last)))}
    place = shown["state"][1]["poses"][shown["scene"][0]["frames"].index(ee_frame("ankurbot_1"))]
    with (folder / "path.csv").open() as file:
        end = list(csv.DictReader(file))[-1]
    assert abs(place[0] - float(end["x_m"])) < 0.1, "the film shows the robot where it was at the end"
    assert abs(place[1] - float(end["y_m"])) < 0.1
    assert shown["state"][0]["commander"]["state"] == "BOUNDLESS"
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is True
    robot = summary["robots"]["ankurbot_1"]
    assert robot["goals"] == ["target_1"]
    assert robot["planning_p50_ms"] > 0.0
    assert 4.5 < robot["path_m"] < 8.0
    assert summary["goals"]["target_1"]["distance_m"] < 0.12
    assert {"simulation", "perception", "commander"} <= {node["node"] for node in summary["nodes"]}
    assert summary["parameters"]["commander"]["planner"] == "yarm"
    assert "single, seed 1, boundless: SUCCESS" in output
    assert str(folder) in output
    assert "REQUIRED process" not in output
    assert "PARAMETERS" not in output
    assert "PARAMETERS" in (folder / "run.log").read_text()


def test_a_failure_says_why_and_ends_with_1(tmp_path: Path) -> None:
    with pytest.raises(LaunchedTestError, match="exit code 1"):
        run([*CALL, "--seed", "2", "--limit", "1.0", "--results", str(tmp_path)], "experiment_too_short", LIMIT_S)
    summary = yaml.safe_load((tmp_path / "single" / "2" / "summary.yaml").read_text())
    assert summary["success"] is False
    assert "did not end within" in summary["faults"][0]
    assert summary["goals"]["target_1"]["reached"] is False


def test_the_published_planner_moves_and_what_the_checker_refuses_is_counted(tmp_path: Path) -> None:
    """Planned once with 20 particles its way leads along the table, nearer than the checker allows: it is sent."""
    published = ["--unguarded", "--planned-once", "--planner", "original", "--particles", "20", "--limit", "60"]
    call = [*MISSION, "--case", "1m1ma_target", "--seed", "22", *published, "--results", str(tmp_path)]
    with suppress(LaunchedTestError):  # whether it arrives is not what is asked here
        run(call, "experiment_original", LIMIT_S)
    folder = tmp_path / "1m1ma_target" / "22"
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["parameters"]["commander"]["check_steps"] == "report"
    assert summary["parameters"]["commander"]["replanning"] is False
    assert summary["robots"]["ankurbot_1"]["waypoints"] >= 1
    assert summary["robots"]["ankurbot_1"]["path_m"] > 0.5
    assert 1 <= summary["steps"]["refused"] <= summary["steps"]["planned"]
    assert "a step was sent that the checker refuses: " in (folder / "run.log").read_text()


def test_in_lock_step_a_mission_repeats_decision_for_decision(tmp_path: Path) -> None:
    call = [*MISSION, "--case", "2m1ma", "--removal", "delete", "--seed", "3", "--results"]
    run([*call, str(tmp_path / "quiet")], "experiment_quiet", LIMIT_S)
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        run([*call, str(tmp_path / "busy")], "experiment_busy", LIMIT_S)
    finally:
        busy.kill()
        busy.wait()
    quiet, busy_one = (tmp_path / name / "2m1ma" / "3" for name in ("quiet", "busy"))
    waypoints = _rows(quiet / "waypoints.csv")
    assert {row["robot"] for row in waypoints} == {"ankurbot_1", "ankurbot_2"}
    assert waypoints == _rows(busy_one / "waypoints.csv")
    assert _decisions(quiet) == _decisions(busy_one)
    ledgers = [read_ledger(folder / "decisions.csv") for folder in (quiet, busy_one)]
    assert not difference(*ledgers)
    sums = [yaml.safe_load((folder / "summary.yaml").read_text())["decisions"] for folder in (quiet, busy_one)]
    assert sums[0] == sums[1] == {"count": len(ledgers[0]), "hash": ledger_hash(ledgers[1])}
    assert sums[0]["hash"] in (quiet / "proof.html").read_text()
    paths = [_rows(folder / "path.csv") for folder in (quiet, busy_one)]
    end_s = min(float(rows[-1]["time_s"]) for rows in paths) - ENDING_S
    assert end_s > 10.0
    before = [[row for row in rows if float(row["time_s"]) < end_s] for rows in paths]
    assert before[0] == before[1]


def test_a_mission_is_brought_to_one_of_its_decisions_again_and_another_is_not_taken_for_it(
    single: Tuple[Path, str], tmp_path: Path
) -> None:
    folder = Path(shutil.copytree(single[0], tmp_path / "run"))
    sent = [row for row in read_ledger(folder / "decisions.csv") if row.kind == "send"]
    call = [sys.executable, str(ROOT / "scripts" / "replay_to"), "--run", str(folder), "--end", "--decision"]
    output = run([*call, str(sent[1].number)], "replay", LIMIT_S)
    assert f"decision {sent[1].number}, send ankurbot_1 target_1" in output
    result = yaml.safe_load((folder / "replay" / "single" / "1" / "replay.yaml").read_text())
    assert result["reached"] and result["hash"] == ledger_hash(read_ledger(folder / "decisions.csv")[: sent[1].number])
    ledger = folder / "decisions.csv"
    ledger.write_text(ledger.read_text().replace(sent[0].text, sent[0].text.replace("; safe", "; refused: made up")))
    with pytest.raises(LaunchedTestError, match="exit code 1"):
        run([*call, str(sent[1].number)], "replay_of_another", LIMIT_S)
    result = yaml.safe_load((folder / "replay" / "single" / "1" / "replay.yaml").read_text())
    assert f"decision {sent[0].number} is send ankurbot_1" in result["reason"]
    assert "made up" in result["reason"]


def test_a_moment_of_a_run_is_forked_into_the_whole_system(single: Tuple[Path, str], tmp_path: Path) -> None:
    """What if, in physics: its robot begins where it was, and has the rest of its way to go."""
    folder, _ = single
    at_s = 6.0
    call = [sys.executable, str(ROOT / "scripts" / "what_if"), "--physics", "--run", str(folder), "--at", str(at_s)]
    call += ["--alternative", "particles=200", "--runs", "1", "--results", str(tmp_path)]
    output = run(call, "what_if_in_physics", LIMIT_S)
    assert "particles=200  1 of 1" in output, output[-4000:]
    whole_s = yaml.safe_load((folder / "summary.yaml").read_text())["goals"]["target_1"]["declared_s"]
    left_s = float(re.search(r"1 of 1 +([0-9.]+)", output).group(1))
    assert 1.0 < left_s < whole_s - 0.5 * at_s, (left_s, whole_s)
    assert (tmp_path / "what_if" / "answer.png").is_file()


def test_the_cell_stands_at_a_decision_for_whoever_looks_until_ctrl_c(single: Tuple[Path, str], tmp_path: Path) -> None:
    """Without ``--end``: what it says and answers is of that moment, and stays so."""
    folder = Path(shutil.copytree(single[0], tmp_path / "run"))
    sent = [row for row in read_ledger(folder / "decisions.csv") if row.kind == "send"][1]
    port = free_port()
    call = [sys.executable, str(ROOT / "scripts" / "replay_to"), "--run", str(folder), "--port", str(port)]
    uri = f"http://localhost:{port}"
    with Launched([*call, "--decision", str(sent.number)], "replay_held", {}, ROOT) as held:
        deadline = time.monotonic() + LIMIT_S
        while "the cell stands still" not in held.output():
            assert held.running() and time.monotonic() < deadline, held.output()[-4000:]
            time.sleep(0.2)
        looks = [
            run(["env", f"ROS_MASTER_URI={uri}", sys.executable, "-c", LOOK], "replay_look", 60.0) for _ in range(2)
        ]
        first, later = (yaml.safe_load(re.findall(r"^\{.*\}$", look, re.M)[-1]) for look in looks)
        assert first == later and first["state"] == "BOUNDLESS" and first["tasks"] == ["target_1"]
        why = ["env", f"ROS_MASTER_URI={uri}", "rosservice", "call", "/commander/why", "subject: target_1"]
        assert "ankurbot_1" in run(why, "replay_why", 60.0), "its services answer"
        assert held.running()
        assert held.interrupt(LIMIT_S) == 0
    result = yaml.safe_load((folder / "replay" / "single" / "1" / "replay.yaml").read_text())
    assert result["reached"] and result["decision"] == sent.number


def _rows(path: Path) -> List[Dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def _decisions(folder: Path) -> List[Dict[str, str]]:
    rows = _rows(folder / "timing.csv")
    return [{name: value for name, value in row.items() if not name.endswith("_ms")} for row in rows]
