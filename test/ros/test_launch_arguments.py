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


def test_good_arguments_pass():
    assert faults(["scene:=2m1ma", "seed:=3", "planner:=yarm", "rviz:=false"]) == []


@pytest.mark.parametrize("launch", ["simulation", "full_system", "experiment"])
def test_roslaunch_itself_refuses_an_unknown_scene(launch):
    name = "case" if launch == "experiment" else "scene"
    ended = subprocess.run(
        ["roslaunch", "--port", "11399", "yarm", f"{launch}.launch", f"{name}:=nowhere"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert ended.returncode != 0
    assert "nowhere" in ended.stderr + ended.stdout
    assert "no such scene" in ended.stderr + ended.stdout
