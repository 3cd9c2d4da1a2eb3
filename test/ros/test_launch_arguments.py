"""A launch argument out of range ends with one message and a non-zero exit code, before anything has started."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
import yaml

from yarm.commander.params import CommanderParams
from yarm.params import build
from yarm.planning.registry import PLANNER_NAMES
from yarm.resources import resource
from yarm.robots.hc10 import AT_ORIGIN
from yarm.ros.common.launch_arguments import faults
from yarm.ros.common.stations import station_of
from yarm.sim.scenes.scene import load_scene


@pytest.mark.parametrize(
    "word, expected",
    [
        ("scene:=nowhere", "no such scene; shipped: "),
        ("case:=nonsense", "; the rooms' cases are explore and inspect"),
        ("seed:=-5", "within -1 to 2147483647"),
        ("seed:=three", "whole number"),
        ("planner:=best", "one of yarm"),
        ("rviz:=yes", "one of true, false"),
        ("real_time_factor:=fast", "number within"),
        ("check_steps:=maybe", "one of true, false, report"),
        ("execution:=maybe", "one of steps, continuous"),
        ("replanning:=maybe", "one of true, false"),
        ("controller:=best", "one of explore_lite"),
        ("controller@inspection:=nearest", "one of yarm, report"),
        ("time_limit_s:=0", "within 1 to 36000"),
        ("return_to_start:=maybe", "one of true, false"),
        ("layout:=cupboard_3", "no such layout; known: practice, open_0"),
        ("boxes_known:=maybe", "one of true, false"),
        ("colour:=red", "unknown; known: scene"),
    ],
)
def test_a_wrong_argument_is_named(word, expected):
    (fault,) = faults(["scene:=2m1ma", word])
    assert word.split(":=")[0].split("@")[0] in fault
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


@pytest.mark.parametrize("mission", ["cell", "exploration", "inspection"])
def test_a_replay_shows_each_mission_with_its_own_picture(mission, tmp_path):
    (tmp_path / "run.bag").touch()
    assert faults([f"mission:={mission}"]) == []
    set_up = dumped("replay", f"bag:={tmp_path / 'run.bag'}", f"mission:={mission}", "rviz:=false")
    assert ("/robot_description" in set_up) == (mission != "cell")
    command = ["roslaunch", "--args", "rviz", "yarm", "replay.launch", f"bag:={tmp_path / 'run.bag'}"]
    environment = {**os.environ, "DISPLAY": ":0"}
    told = subprocess.run(
        [*command, f"mission:={mission}"], check=True, capture_output=True, text=True, timeout=60, env=environment
    ).stdout.split()
    assert Path(told[told.index("-d") + 1]).is_file()


def test_nothing_else_can_be_replayed():
    (fault,) = faults(["mission:=sanding"])
    assert "cell, exploration, inspection" in fault


def test_good_arguments_pass():
    assert faults(["scene:=2m1ma", "seed:=3", "planner:=yarm", "rviz:=false"]) == []
    assert faults(["layout:=practice"]) == faults(["layout:=wall_7"]) == faults(["layout:="]) == []
    assert faults([f"check_steps:={value}" for value in ("true", "false", "report")]) == []


@pytest.mark.parametrize(
    ("launch", "name", "said"),
    [
        ("simulation", "scene", "no such scene"),
        ("full_system", "scene", "no such scene"),
        ("experiment", "case", "no such scene"),
        ("exploration", "arena", "no such arena"),
        ("explore_experiment", "arena", "no such arena"),
        ("inspection", "layout", "no such layout"),
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


def test_every_manipulator_of_the_scene_needs_its_sander():
    (fault,) = faults(["scene:=2m2ma", "arms:=hc10_barc"])
    assert 'say arms:="hc10_barc hc10_barc_2"' in fault
    assert faults(["scene:=2m2ma", "arms:=hc10_barc hc10_barc_2", "sander:=true"]) == []
    assert faults(["scene:=2m2ma", "arms:=hc10_barc", "sander:=false"]) == []
    assert faults(["scene:=3m", "arms:=hc10_barc"]) == []


@pytest.mark.parametrize("arms", ["hc10_barc hc10_barc", "kuka", ""])
def test_arms_are_names_each_once(arms):
    (fault,) = faults(["scene:=single", f"arms:={arms}"])
    assert "names that begin with hc10_barc, each once" in fault


def dumped(launch, *arguments):
    """What a launch file would set: parameters by name."""
    command = ["roslaunch", "--dump-params", "yarm", f"{launch}.launch", *arguments]
    return yaml.safe_load(subprocess.run(command, check=True, capture_output=True, timeout=60).stdout)


def test_each_manipulator_gets_a_sander_with_its_own_station():
    params = dumped("full_system", "scene:=2m2ma", "arms:=hc10_barc hc10_barc_2", "sync:=true")
    assert params["/hc10_state_machine/arm"] == "hc10_barc"
    assert params["/hc10_state_machine_2/arm"] == "hc10_barc_2"
    for arm in load_scene("2m2ma").arms:
        assert station_of(params[f"/{arm.name}/station"], "") == arm.station
    sanders = ["hc10_state_machine", "hc10_state_machine_2"]
    assert params["/simulation/arm_participants"] == sanders
    assert params["/simulation/tick_participants"] == ["multi_robot_controls_server", *sanders]


def test_one_manipulator_is_what_nobody_has_to_ask_for():
    params = dumped("full_system")
    assert params["/simulation/tick_participants"] == ["multi_robot_controls_server", "hc10_state_machine"]
    assert [name for name in params if name.endswith("/arm")] == ["/hc10_state_machine/arm"]
    assert station_of(params["/hc10_barc/station"], "") == AT_ORIGIN


def test_the_console_comes_only_when_it_is_asked_for():
    assert not [name for name in dumped("full_system") if name.startswith("/console/")]
    for launch in ("full_system", "experiment", "explore_experiment", "inspect_experiment", "youbot", "real_cell"):
        wanted = ["cell:=1m1ma"] if launch == "real_cell" else []
        params = dumped(launch, "console:=true", "console_port:=0", "console_token:=/tmp/token", *wanted)
        assert (params["/console/port"], params["/console/token_file"]) == (0, "/tmp/token")
        assert params["/console/results"] == os.path.join(os.environ["PWD"], "results"), "not below ROS's own folder"
        assert dumped(launch, "console:=true", "console_results:=/a", *wanted)["/console/results"] == "/a"
        assert params["/console/host"] == "127.0.0.1"
    assert faults(["console:=perhaps", "console_port:=70000"]) == [
        "launch argument console = 'perhaps': must be one of true, false",
        "launch argument console_port = '70000': must be within 0 to 65535",
    ]


@pytest.mark.parametrize("launch", ["inspection", "inspect_experiment"])
def test_the_reports_detector_can_be_asked_for(launch):
    assert dumped(launch)["/inspector/report/detector"] == "sift"
    assert dumped(launch, "detector:=orb")["/inspector/report/detector"] == "orb"


@pytest.mark.parametrize("planner", PLANNER_NAMES)
def test_every_planner_there_is_can_be_launched(planner):
    assert faults([f"planner:={planner}"]) == []
    assert build(CommanderParams, {"planner": planner}).planner == planner


QUARTERS, EIGHTHS = [0.0, 90.0, -90.0], [0.0, 90.0, -90.0, 45.0, -45.0]
AS_PUBLISHED, TO_A_BIN = ("delete", False, QUARTERS), ("bin", True, EIGHTHS)


def debris_goes(launch, *arguments):
    """What becomes of debris by a launch file: the Commander's removal, whether robots have hands, and their turns."""
    params = dumped(launch, *arguments)
    return params["/commander/removal"], params["/simulation/hands"], params["/commander/turns_deg"]


def test_debris_is_carried_to_a_bin_where_the_scene_has_one(tmp_path):
    own = tmp_path / "mine_bin.yaml"
    own.write_text((resource("scenes", "cell") / "1m1ma_bin.yaml").read_text())
    assert debris_goes("full_system") == debris_goes("experiment") == TO_A_BIN
    assert debris_goes("full_system", f"scene:={own}") == TO_A_BIN
    assert debris_goes("full_system", "scene:=2m1ma") == debris_goes("experiment", "case:=2m1ma") == AS_PUBLISHED
    assert debris_goes("full_system", "removal:=delete") == AS_PUBLISHED
    assert debris_goes("full_system", "scene:=2m1ma", "hands:=true") == ("delete", True, QUARTERS)


@pytest.mark.parametrize(
    ("launch", "film_hz"),
    [("explore_experiment", "/run_exploration/film_hz"), ("inspect_experiment", "/inspector/run/film_hz")],
)
def test_a_run_in_a_room_that_a_page_shows_leaves_its_film(launch, film_hz):
    assert dumped(launch)[film_hz] == 0.0
    assert dumped(launch, "console:=true")[film_hz] == 5.0
    assert dumped(launch, "film_hz:=2.0")[film_hz] == 2.0


def test_scenes_with_bins_are_those_whose_names_say_so():
    scenes = {path.stem: load_scene(path.stem) for path in resource("scenes", "cell").glob("*.yaml")}
    assert {name for name, scene in scenes.items() if scene.bins} == {name for name in scenes if name.endswith("_bin")}


def test_nothing_is_carried_without_a_hand_or_a_bin(tmp_path):
    one_has = tmp_path / "one_has.yaml"
    text = (resource("scenes", "cell") / "2m1ma_bin.yaml").read_text()
    one_has.write_text(text.replace("type: ankurbot,", "type: ankurbot_hand,", 1))
    assert faults([f"scene:={one_has}", "hands:=false", "removal:=bin"]) == []
    assert faults(["scene:=2m1ma_bin", "hands:=true", "removal:=bin"]) == []
    assert faults(["scene:=2m1ma", "hands:=false", "removal:=delete"]) == []
    (fault,) = faults(["scene:=2m1ma_bin", "hands:=false", "removal:=bin"])
    assert fault.endswith("the robots need hands, and hands = 'false'; say hands:=true")
    (fault,) = faults(["scene:=2m1ma", "hands:=true", "removal:=bin"])
    assert "scene 2m1ma has no bins to carry debris to" in fault and "or say removal:=delete" in fault


def test_a_scene_files_experiment_is_recorded_beside_its_results():
    scene = resource("scenes", "cell") / "2m1ma_bin.yaml"
    words = [f"case:={scene}", "seed:=5", "bag:=true", "results:=/tmp/here"]
    command = ["roslaunch", "--args", "record", "yarm", "experiment.launch", *words]
    told = subprocess.run(command, check=True, capture_output=True, text=True, timeout=60).stdout
    assert " -O /tmp/here/2m1ma_bin/5/run.bag " in told
