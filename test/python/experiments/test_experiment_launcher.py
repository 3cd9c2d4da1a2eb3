"""The launcher's verdict and its roslaunch call (nothing is launched)."""

from __future__ import annotations

from pathlib import Path

import pytest

from yarm.ros.experiment_launcher import command, free_port, parser, verdict


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
    launch = (Path(__file__).parents[3] / "launch" / "experiment.launch").read_text()
    assert all(f'<arg name="{name}" default=' in launch for name in given)


def test_a_free_port_is_free() -> None:
    assert 1024 < free_port() < 65536
