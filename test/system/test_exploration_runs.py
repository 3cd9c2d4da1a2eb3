"""``run_experiment --case explore`` from end to end, in physics and lock-step: start against a wall, a low brick."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from pathlib import Path
from typing import List, Tuple

import numpy as np
import numpy.typing as npt
import pytest
import yaml

from support.launched import ROOT, Launched, LaunchedTestError, run
from yarm.ros.experiment.ports import free_port

LIMIT_S = 600.0
ARENA = Path(__file__).with_name("explored_room.yaml")
CALL = [
    sys.executable,
    str(ROOT / "scripts" / "run_experiment"),
    "--case",
    "explore",
    "--arena",
    str(ARENA),
    "--seed",
    "1",
]
TABLES = {"coverage.csv", "path.csv", "bumps.csv", "events.csv", "summary.yaml"}
FILES = {*TABLES, "map.pgm", "map.yaml", "map.png", "coverage.png", "run.log"}


def explore(results: Path, name: str, *more: str) -> Tuple[Path, str]:
    """One run; its folder and what it printed."""
    output = run([*CALL, *more, "--results", str(results)], name, LIMIT_S)
    return results / "explore" / "explored_room" / "yarm" / "1", output


def picture(path: Path) -> npt.NDArray[np.uint8]:
    """A binary PGM of 8 bits by the format's own description: P5, width, height, 255, one byte a pixel."""
    data = path.read_bytes()
    head = re.match(rb"P5\s(?:#[^\n]*\n)*(\d+)\s(\d+)\s255\s", data)
    assert head is not None
    columns, rows = int(head[1]), int(head[2])
    return np.frombuffer(data, np.uint8, rows * columns, head.end()).reshape(rows, columns)


def shade_at(shades: npt.NDArray[np.uint8], about: dict, x: float, y: float) -> int:  # type: ignore[type-arg]
    """Shade of the pixel over a place of the map, metres; its first row is the top one."""
    column = int((x - about["origin"][0]) / about["resolution"])
    row = len(shades) - 1 - int((y - about["origin"][1]) / about["resolution"])
    return int(shades[row, column])


def test_it_maps_the_room_from_a_start_against_a_wall(tmp_path: Path) -> None:
    folder, output = explore(tmp_path, "explore_room")
    assert {path.name for path in folder.iterdir()} == FILES
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is True
    assert summary["share"] >= 0.99
    assert summary["low"] == {"count": 1, "detected": 1, "untouched": 1}
    assert summary["standing"] is True
    assert summary["wall"]["p95_m"] < 0.10
    assert summary["parameters"]["explorer"]["controller"] == "yarm"
    cost = summary["cost"]
    assert cost["sim_s"] > 0.0 and cost["real_time_factor"] > 0.0 and cost["cores"] > 0.0
    shares = {node["node"]: node["cpu_share"] for node in cost["nodes"]}
    assert all(shares[name] > 0.0 for name in ("room_simulation", "slam_gmapping", "explorer"))
    assert "explored_room, yarm, seed 1: SUCCESS" in output
    assert re.search(r"x\d\.\d\d \|.*% mapped \|.*s left \| exploring: \w+ \| bumps: \d", output)
    check_files(folder)


def check_files(folder: Path) -> None:
    """The map in the robot's own frame: it starts at the origin, and the brick lies ahead to the right."""
    about = yaml.safe_load((folder / "map.yaml").read_text())
    assert about["image"] == "map.pgm"
    shades = picture(folder / "map.pgm")
    assert set(np.unique(shades)) == {0, 205, 254}
    assert shade_at(shades, about, 0.0, 0.0) == 254
    x, y = 0.5 + 1.32, -0.7 + 0.4  # the brick's centre
    around: List[int] = [
        shade_at(shades, about, x + i * 0.05, y + j * 0.05) for i in range(-3, 4) for j in (-2, -1, 0, 1, 2)
    ]
    assert 0 in around


def test_the_same_seed_gives_the_same_run(tmp_path: Path) -> None:
    """Byte for byte in lock-step, beside other work too: what was decided and when, what was touched, the map."""
    folders = []
    for name, others in (("quiet", 0), ("busy", 6)):
        busy = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(others)]
        try:
            with pytest.raises(LaunchedTestError, match="exit code 1"):
                explore(tmp_path / name, f"explore_{name}", "--limit", "15")
        finally:
            for process in busy:
                process.kill()
                process.wait()
        folders.append(tmp_path / name / "explore" / "explored_room" / "yarm" / "1")
    for name in ("events.csv", "bumps.csv", "map.pgm"):
        assert (folders[0] / name).read_bytes() == (folders[1] / name).read_bytes(), name
    rows = [(folder / "path.csv").read_text().splitlines()[:150] for folder in folders]
    assert len(rows[0]) == 150 and rows[0] == rows[1], "where it was in the first 15 s"
    assert len((folders[0] / "events.csv").read_text().splitlines()) > 3


def test_too_little_time_ends_with_1_and_says_so(tmp_path: Path) -> None:
    with pytest.raises(LaunchedTestError, match="exit code 1"):
        explore(tmp_path, "explore_short", "--limit", "6")
    folder = tmp_path / "explore" / "explored_room" / "yarm" / "1"
    summary = yaml.safe_load((folder / "summary.yaml").read_text())
    assert summary["success"] is False
    assert "the target is 99 %" in summary["faults"][-1]
    assert summary["reason"] == "the time is over"
    assert summary["standing"] is True
    assert summary["end_s"] == 6.0


def test_the_launch_file_alone_tells_judges_and_stays(tmp_path: Path) -> None:
    call = ["roslaunch", "-p", str(free_port()), "yarm", "exploration.launch", f"arena:={ARENA}", "seed:=1"]
    with Launched(
        [*call, "sync:=true", "real_time_factor:=0"], "explore_alone", {"PWD": str(tmp_path)}, tmp_path
    ) as it:
        ended = time.monotonic() + LIMIT_S
        while "results and pictures: " not in it.output():
            assert it.running() and time.monotonic() < ended, it.output()[-4000:]
            time.sleep(0.5)
        assert "explored_room, yarm, seed 1: SUCCESS" in it.output()
        assert re.search(r"% mapped \|.*s left \| exploring: \w+ \| bumps: \d", it.output())
        assert "m2 known |" not in it.output(), "told twice"
        assert it.running()
    folder = tmp_path / "results" / "explore" / "explored_room" / "yarm" / "1"
    assert {path.name for path in folder.iterdir()} == FILES - {"run.log"}
    assert yaml.safe_load((folder / "summary.yaml").read_text())["success"] is True
    assert (tmp_path / "map.pgm").is_file()
