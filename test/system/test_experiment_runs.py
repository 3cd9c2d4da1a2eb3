"""``run_experiment`` from end to end: it launches everything, writes everything, and its exit code is the verdict."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
import yaml

from support.launched import ROOT, LaunchedTestError, run

LIMIT_S = 900.0
CALL = [sys.executable, str(ROOT / "scripts" / "run_experiment"), "--case", "single", "--sync", "--speed", "0"]


def test_a_success_leaves_everything_and_ends_with_0(tmp_path: Path) -> None:
    output = run([*CALL, "--seed", "1", "--results", str(tmp_path)], "experiment_single", LIMIT_S)
    folder = tmp_path / "single" / "1"
    tables = {"summary.yaml", "waypoints.csv", "path.csv", "timing.csv"}
    pictures = {"map.png", "map_ankurbot_1.png", "planning_time.png", "timing.png"}
    assert {path.name for path in folder.iterdir()} == tables | pictures
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


def test_a_failure_says_why_and_ends_with_1(tmp_path: Path) -> None:
    with pytest.raises(LaunchedTestError, match="exit code 1"):
        run([*CALL, "--seed", "2", "--limit", "1.0", "--results", str(tmp_path)], "experiment_too_short", LIMIT_S)
    summary = yaml.safe_load((tmp_path / "single" / "2" / "summary.yaml").read_text())
    assert summary["success"] is False
    assert "did not end within" in summary["faults"][0]
    assert summary["goals"]["target_1"]["reached"] is False
