"""A mission ends well though who records it is killed in its midst, and then the simulation, its whole world."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import yaml

from support.launched import ROOT, Launched

LIMIT_S = 600.0
CALL = [sys.executable, str(ROOT / "scripts" / "run_experiment"), "--case", "1m1ma", "--seed", "3", "--cleanup"]


def test_the_recorder_and_the_simulation_are_killed(tmp_path: Path) -> None:
    folder = tmp_path / "1m1ma_bin" / "3"
    with Launched([*CALL, "--results", str(tmp_path)], "deaths", {}, ROOT) as mission:

        def until(words: str, file: Path) -> None:
            deadline = time.monotonic() + LIMIT_S
            while not file.is_file() or words not in file.read_text(errors="replace"):
                assert mission.running() and time.monotonic() < deadline, f"no {words!r}: {mission.output()[-4000:]}"
                time.sleep(0.1)

        until("debris_1 moving", folder / "run.log")
        mission.kill("--node", "__name:=run_experiment")
        until("this process had died", folder / "run.log")
        mission.kill("__name:=simulation")
        until("the mission begins anew", folder / "run.log")
        assert mission.ended(LIMIT_S) == 0, mission.output()[-4000:]
        said = mission.output()
    assert "the cell began anew 1 times: its simulation was started again" in said
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert (summary["success"], summary["begun_again"], summary["unrecorded_s"]) == (True, 1, 0.0)
    assert not (folder / "run.saved").exists()
