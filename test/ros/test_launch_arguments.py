"""A launch argument out of range ends with one message and a non-zero exit code, before anything has started."""

from __future__ import annotations

import subprocess

import pytest

from yarm.ros.launch_arguments import faults


@pytest.mark.parametrize(
    "word, expected",
    [
        ("scene:=nowhere", "no such scene; shipped: "),
        ("seed:=-5", "within -1 to 2147483647"),
        ("seed:=three", "whole number"),
        ("planner:=best", "one of yarm"),
        ("rviz:=yes", "one of true, false"),
        ("real_time_factor:=fast", "number within"),
        ("colour:=red", "unknown; known: scene"),
    ],
)
def test_a_wrong_argument_is_named(word, expected):
    (fault,) = faults(["scene:=2m1ma", word])
    assert word.split(":=")[0] in fault
    assert expected in fault


@pytest.mark.parametrize("word", ["rviz:=true", "gui:=true"])
def test_a_window_needs_a_screen(word, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    (fault,) = faults([word])
    assert "needs a screen, and DISPLAY is not set" in fault
    monkeypatch.setenv("DISPLAY", ":7")
    assert faults([word]) == []


def test_a_recording_is_a_file(tmp_path):
    (tmp_path / "run.bag").touch()
    assert faults([f"recording:={tmp_path / 'run.bag'}", "rate:=2.0", "start:=0.0", "loop:=false"]) == []
    (fault,) = faults(["recording:=nowhere.bag"])
    assert "no such file" in fault


def test_good_arguments_pass():
    assert faults(["scene:=2m1ma", "seed:=3", "planner:=yarm", "rviz:=false"]) == []


@pytest.mark.parametrize(
    ("launch", "name", "said"),
    [
        ("simulation", "scene", "no such scene"),
        ("full_system", "scene", "no such scene"),
        ("experiment", "case", "no such scene"),
        ("replay", "bag", "no such file"),
    ],
)
def test_roslaunch_itself_refuses_what_is_not_there(launch, name, said):
    ended = subprocess.run(
        ["roslaunch", "--port", "11399", "yarm", f"{launch}.launch", f"{name}:=nowhere"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode != 0
    assert "nowhere" in ended.stderr + ended.stdout
    assert said in ended.stderr + ended.stdout
