"""config/ and docs/ against the parameter classes and tables of the nodes."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from yarm.params import ParamError, build, infos
from yarm.ros.exploration.params import ExplorerParams, explorer_params
from yarm.ros.navigation.params import MoveBaseNodeParams, move_base_params
from yarm.ros.node_params import NODE_PARAMS

ROOT = Path(__file__).resolve().parents[2]


def plain(value):
    return list(value) if isinstance(value, tuple) else value


def shipped_text(node):
    (path,) = (ROOT / "config").glob(f"*/{node}.yaml")
    return path.read_text()


@pytest.mark.parametrize("node", sorted(NODE_PARAMS))
def test_yaml_holds_every_parameter_with_its_default(node):
    shipped = yaml.safe_load(shipped_text(node))
    assert shipped == {name: plain(default) for name, default, _ in infos(NODE_PARAMS[node])}


@pytest.mark.parametrize("node", sorted(NODE_PARAMS))
def test_a_wrong_key_is_refused_by_name(node):
    with pytest.raises(ParamError, match="no_such_parameter: unknown"):
        build(NODE_PARAMS[node], {"no_such_parameter": 1})


@pytest.mark.parametrize("node", sorted(NODE_PARAMS))
def test_yaml_comments_unit_or_range_of_every_parameter(node):
    lines = shipped_text(node).splitlines()
    bare = [line for line in lines if ":" in line.split("#")[0] and "#" not in line]
    assert bare == []


def test_generated_pages_are_up_to_date():
    check = subprocess.run(
        [sys.executable, str(ROOT / "tools" / "generate_docs.py"), "--check"],
        capture_output=True,
        check=False,
        text=True,
        timeout=120,
    )
    assert check.returncode == 0, check.stdout + check.stderr


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"drive": "wheels"}, "drive = 'wheels': must be one of 'mux', 'move_base'"),
        ({"drive": "move_base", "controller": "report"}, "controller 'report' has no goals that it could send"),
    ],
)
def test_who_drives_must_fit_the_controller(values, said, tmp_path):
    with pytest.raises(ParamError) as caught:
        explorer_params({**values, "map_path": str(tmp_path / "map")}, "explorer")
    assert said in str(caught.value)
    good = {"drive": "move_base", "controller": "nearest", "sync": True, "map_path": str(tmp_path / "map")}
    assert explorer_params(good, "explorer")[0].drive == "move_base"


def test_wrong_explorer_parameters_are_told_in_whole_sentences():
    with pytest.raises(ParamError) as caught:
        explorer_params({"max_speed": "quick", "slam": 1, "report": {"speedy": 3, "speed": "slow"}}, "explorer")
    said = str(caught.value)
    assert said.startswith("explorer: slam: unknown parameter; known: controller, ")
    assert "; max_speed = 'quick': must be of type float; " in said
    assert "; report.speedy: unknown parameter; known: off, " in said
    assert said.endswith("; report.speed = 'slow': must be of type float")


def test_limits_that_contradict_each_other_and_a_map_without_a_place_are_refused_together(tmp_path):
    (tmp_path / "file").write_text("in place of a folder")
    values = {"near_speed": 0.4, "controller": "roomba", "map_path": str(tmp_path / "file" / "map")}
    with pytest.raises(ParamError) as caught:
        explorer_params(values, "explorer")
    said = str(caught.value)
    assert "near_speed = 0.4 m/s is above max_speed = 0.3 m/s" in said
    assert "controller = 'roomba': must be one of explore_lite, nearest, report, report_printed, yarm" in said
    assert f"map_path = {values['map_path']!r}: " in said


def test_nothing_is_drawn_unless_asked_for_and_the_launch_file_asks():
    assert not ExplorerParams().visualize, "explore_lite's default"
    launched = ElementTree.parse(ROOT / "launch" / "exploration" / "exploration.launch")
    drawn = [node.find("param[@name='visualize']") for node in launched.iter("node") if node.get("type") == "explorer"]
    assert [param is not None and param.get("value") for param in drawn] == ["true"]


def test_a_full_disk_is_noticed_before_the_start(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ParamError, match="No space left on device"):
        explorer_params({"map_path": str(tmp_path / "map")}, "explorer")


def test_move_base_takes_a_configuration_of_the_platforms_and_says_what_has_no_effect():
    planner = {"max_vel_x": 0.25, "sim_time": 3.0}
    values = {
        "base_global_planner": "navfn/NavfnROS",
        "global_costmap": {"robot_radius": 0.18},
        "DWAPlannerROS": planner,
    }
    params, told = move_base_params(values, "/move_base")
    assert params == MoveBaseNodeParams(robot_radius=0.18, max_vel_x=0.25)
    assert told == (
        "taken from the platform's names: robot_radius = 0.18 (global_costmap/robot_radius), "
        "max_vel_x = 0.25 (DWAPlannerROS/max_vel_x)",
        "set, but without effect here (the platform's own costmaps, planners and recovery): "
        "DWAPlannerROS/sim_time, base_global_planner",
    )
    assert move_base_params({"robot_radius": 0.3}, "/move_base") == (MoveBaseNodeParams(robot_radius=0.3), ())


def test_move_base_refuses_typos_and_values_by_the_names_that_were_set_all_at_once():
    values = {"robot_raduis": 0.2, "global_costmap": {"robot_radius": 3.0, "width": 4.0, "widht": 4.0}}
    with pytest.raises(ParamError) as caught:
        move_base_params({**values, "yaw_goal_tolerance": 4.0}, "/move_base")
    said = str(caught.value)
    assert said.startswith("/move_base: robot_raduis: unknown parameter; known: controller_frequency, ")
    assert "; global_costmap/robot_radius = 3.0: must be finite and within 0.05 to 1 m; " in said
    assert "; yaw_goal_tolerance = 4.0: must be " in said
    assert "; global_costmap/widht: unknown parameter; known: always_send_full_costmap, " in said
