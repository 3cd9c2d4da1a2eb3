"""The launcher's verdict and its roslaunch call (nothing is launched)."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from yarm.ros.experiment_launcher import Family, command, free_port, parser, verdict, wall_limit_s


@pytest.mark.parametrize(
    ("text", "code"), [("success: true\n", 0), ("success: false\n", 1), ("success: 'true'\n", 1), ("{}\n", 1)]
)
def test_only_success_is_zero(tmp_path: Path, text: str, code: int) -> None:
    summary = tmp_path / "summary.yaml"
    summary.write_text(text)
    assert verdict(summary) == code


def test_no_results_are_a_failure_that_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert verdict(tmp_path / "summary.yaml") == 1
    assert "summary.yaml was not written" in capsys.readouterr().err


def test_every_option_becomes_a_launch_argument_that_exists(tmp_path: Path) -> None:
    options = parser().parse_args(["--case", "3m", "--seed", "7", "--sync", "--results", str(tmp_path)])
    call = command(options, 12345)
    assert call[:5] == ["roslaunch", "-p", "12345", "yarm", "experiment.launch"]
    given = dict(argument.split(":=") for argument in call[5:])
    assert (given["case"], given["seed"], given["sync"], given["rviz"]) == ("3m", "7", "true", "false")
    assert (given["sander"], given["guarded"]) == ("false", "true")
    launch = (Path(__file__).parents[3] / "launch" / "experiment.launch").read_text()
    assert all(f'<arg name="{name}" default=' in launch for name in given)


def test_the_sander_is_left_out_where_there_is_no_manipulator() -> None:
    assert "sander:=false" in command(parser().parse_args(["--case", "single"]), 1)
    assert "sander:=true" in command(parser().parse_args(["--case", "no_such_scene"]), 1)


def test_a_soak_has_the_time_it_needs() -> None:
    assert wall_limit_s(parser().parse_args([])) == 900.0
    assert wall_limit_s(parser().parse_args(["--soak", "3600"])) == 900.0 + 4 * 3600.0
    assert wall_limit_s(parser().parse_args(["--soak", "3600", "--wall-limit", "60"])) == 60.0


def test_a_free_port_is_free() -> None:
    assert 1024 < free_port() < 65536


def test_orphans_of_the_child_are_ended_too() -> None:
    sleeper = "import time; time.sleep(600)"
    spawning = (
        f"import subprocess, sys; print(subprocess.Popen([sys.executable, '-c', '{sleeper}']).pid, flush=True); input()"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", spawning],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,
        text=True,
    )
    assert child.stdin is not None
    assert child.stdout is not None
    orphan = psutil.Process(int(child.stdout.readline()))
    family = Family(child)  # type: ignore[arg-type]
    family.look()
    child.stdin.close()
    child.wait(timeout=30)
    assert orphan.is_running()
    family.stop()
    deadline = time.monotonic() + 30.0
    while orphan.is_running() and orphan.status() != psutil.STATUS_ZOMBIE and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not orphan.is_running() or orphan.status() == psutil.STATUS_ZOMBIE
