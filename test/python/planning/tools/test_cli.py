"""``plan_scene``: exit codes, JSON and text, and bad input answered in words."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys

import pytest

from yarm.planning.tools.cli import main
from yarm.resources import package_root, resource


def run(*arguments):
    out, err = io.StringIO(), io.StringIO()
    code = main([str(argument) for argument in arguments], out, err)
    return code, out.getvalue(), err.getvalue()


def scene(name):
    return resource("scenes", "planning", f"{name}.yaml")


def test_solved_scene_as_json():
    code, out, err = run(scene("one_robot"), "--json")
    report = json.loads(out)
    assert (code, err, report["status"]) == (0, "", "SOLVED")
    entry = report["robots"]["ankurbot_1"]
    assert entry["path"][-1]["cell"] == [23, 23] and entry["path"][0] == {"cell": [29, 45], "yaw_deg": 180.0}
    assert report["particles"] == 0, "the way is straight"
    assert entry["length_cells"] > 20.0 and entry["planning_ms"] > 0.0 and entry["goal"] == "goals[0]"


def test_stepping_adds_its_numbers():
    code, out, _ = run(scene("head_on"), "--steps", "--json")
    report = json.loads(out)
    assert code == 0 and report["status"] == "SOLVED"
    expected = {"steps", "sum_of_costs", "makespan", "min_clearance_cells", "replans", "ms_p50", "ms_p99"}
    assert expected <= set(report)
    assert report["sum_of_costs"] >= 42.0 and report["min_clearance_cells"] >= 1 and report["refused_steps"] == 0


def test_the_threshold_of_the_publication_says_how_many_particles():
    few, default, same = (
        json.loads(run(scene("one_robot"), "--json", "--planner", "original", *more)[1])
        for more in (["--threshold", "80"], [], ["--threshold", "5"])
    )
    paths = [report["robots"]["ankurbot_1"]["path"] for report in (few, default, same)]
    assert paths[1] == paths[2] != paths[0], "333 particles on 50 x 50 x 20 cells"


def test_goals_without_a_robot_are_shared_out():
    code, out, _ = run(scene("two_robots"), "--json")
    report = json.loads(out)
    assert code == 0
    assert {entry["goal"] for entry in report["robots"].values()} == {"goals[0]", "goals[1]"}


def test_same_seed_same_report():
    first, second = (json.loads(run(scene("three_robots"), "--json", "--seed", "3")[1]) for _ in range(2))
    for report in (first, second):
        report.pop("planning_ms")
        for entry in report["robots"].values():
            entry.pop("planning_ms")
    assert first == second


def test_infeasible_is_2_and_says_why():
    code, out, _ = run(scene("walled_in"))
    assert code == 2 and out.startswith("INFEASIBLE") and "cart_1" in out and "boxes" in out


@pytest.mark.parametrize("steps", [[], ["--steps"]])
def test_timeout_is_3_and_says_who(steps):
    code, out, _ = run(scene("head_on"), "--planner", "ma_astar", *steps)
    assert code == 3 and out.startswith("TIMEOUT: cart_1 found no way")


def test_turns_are_an_option():
    assert run(scene("narrow_gap"), "--turns", "0")[0] == 2
    assert run(scene("narrow_gap"), "--turns=-90,0,90")[0] == 0


@pytest.mark.parametrize("planner", ["original", "ma_astar"])
def test_other_planners(planner):
    code, out, _ = run(scene("one_robot"), "--planner", planner, "--particles", "100")
    assert code == 0 and out.startswith("SOLVED")


def test_plot_is_written(tmp_path):
    picture = tmp_path / "out.png"
    assert run(scene("head_on"), "--plot", picture, "--steps")[0] == 0
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


@pytest.mark.parametrize(
    "arguments,words",
    [
        (["--particles", "-5"], "particles = -5"),
        (["--particles", "many"], "particles = 'many'"),
        (["--threshold", "0"], "--threshold = 0: "),
        (["--threshold", "many"], "--threshold = many: "),
        (["--threshold", "5", "--particles", "20"], "--particles and --threshold"),
        (["--turns", "0,left"], "turns_deg"),
        (["--turns", "0,nan"], "turns_deg"),
        (["--seed", "-1"], "--seed = -1"),
        (["--planner", "psychic"], "psychic"),
        (["--no-such-option"], "--no-such-option"),
        (["--plot", "/no/such/folder/out.png"], "/no/such/folder"),
    ],
)
def test_wrong_options_are_4(arguments, words):
    code, out, err = run(scene("one_robot"), *arguments)
    assert code == 4 and words in err and "Traceback" not in err and out == ""


@pytest.mark.parametrize(
    "text,words",
    [
        ("grid: 1", "grid = 1"),
        ("[", "not readable as YAML"),
        ("{grid: {shape: [9, 9, 2], min: [0, 0, 0], max: [.nan, 1, 1]}, robots: []}", "grid.max"),
    ],
)
def test_wrong_scene_is_4(tmp_path, text, words):
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    code, _, err = run(path)
    assert code == 4 and words in err and str(path) in err


BASE = "grid: {{shape: [12, 12, 2], min: [0, 0, 0], max: [1.2, 1.2, 0.2]}}\nboxes: [[4, 6, 4, 6, 0, 2]]\n{rest}"


@pytest.mark.parametrize(
    "start,goal,status",
    [([4, 4], [9, 9], "INVALID_START"), ([1, 1], [5, 5], "INVALID_GOAL")],
)
def test_start_or_goal_in_a_box_is_4(tmp_path, start, goal, status):
    path = tmp_path / "scene.yaml"
    rest = f"robots: [{{name: cart, cell: {start}, cells: [[0, 0, 0]]}}]\n"
    rest += f"goals: [{{cell: {goal}, kind: Target, robot: cart}}]\n"
    path.write_text(BASE.format(rest=rest), encoding="utf-8")
    code, out, _ = run(path)
    assert code == 4 and out.startswith(status) and "boxes[0]" in out


def test_module_runs_without_ros():
    command = [sys.executable, "-m", "yarm.planning", str(scene("head_on"))]
    environment = {"PATH": os.environ["PATH"], "PYTHONPATH": str(package_root() / "src")}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0 and done.stdout.startswith("SOLVED"), done.stderr


def test_who_waits_for_whom_is_printed_and_carried_out():
    code, out, _ = run(scene("head_on"), "--waits")
    assert code == 0
    assert "cart_2 (18, 3) to (1, 3): after cart_1.1, cart_1.2, cart_1.3" in out
    assert "released_status SOLVED" in out and "released_refused 0" in out
