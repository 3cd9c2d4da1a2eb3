"""docs/extending.md: its files are written to a folder as they stand there, and run."""

from __future__ import annotations

import importlib
import io
import math
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from yarm.msg import MoveRobotGoal

from yarm.commander.params import CommanderParams
from yarm.control.base.controller import Outcome
from yarm.geometry import quaternion_from_rpy
from yarm.params import build
from yarm.planning.tools import cli
from yarm.ros.common.bodies import registry_entry
from yarm.ros.common.launch_arguments import faults
from yarm.ros.controls import node, robots
from yarm.ros.controls.params import ControlsServerParams
from yarm.ros.controls.robots import SeedPose
from yarm.sim.checks.cell_check import check_scene
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import load_scene

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "extending.md"
FILES = dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.S | re.M))
WAVEFRONT = "my_cell.wavefront:Wavefront"
TICK_S = 1.0 / 30.0


@pytest.fixture(name="folder")
def folder_fixture(tmp_path, monkeypatch):
    """The page's files in a folder that Python looks for modules in; gone again afterwards."""
    for name, text in FILES.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in [name for name in sys.modules if name.split(".")[0] == "my_cell"]:
        del sys.modules[name]


def test_the_page_has_the_files_it_speaks_of():
    assert sorted(FILES) == [
        "my_cell/barrel.urdf",
        "my_cell/barrel.yaml",
        "my_cell/cart.py",
        "my_cell/wavefront.py",
    ]


@pytest.mark.parametrize("scene", ["one_robot", "two_robots"])
def test_the_planner_brings_shipped_scenes_to_their_goals(folder, scene):
    out, err = io.StringIO(), io.StringIO()
    path = ROOT / "scenes" / "planning" / f"{scene}.yaml"
    code = cli.main([str(path), "--planner", WAVEFRONT, "--steps"], out, err)
    assert (code, err.getvalue()) == (0, ""), out.getvalue()


def test_the_planner_passes_the_contract(folder):
    environment = {**os.environ, "YARM_PLANNERS": WAVEFRONT}
    environment["PYTHONPATH"] = os.pathsep.join([str(folder), environment.get("PYTHONPATH", "")])
    suite = str(ROOT / "test" / "contract" / "test_planner_contract.py")
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", suite, "-k", "Wavefront"],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert run.returncode == 0, run.stdout + run.stderr
    passed = re.search(r"(\d+) passed", run.stdout)
    assert passed is not None and int(passed.group(1)) >= 15, run.stdout


def test_the_planner_has_a_name_wherever_one_is_asked_for(folder):
    assert build(CommanderParams, {"planner": WAVEFRONT}).planner == WAVEFRONT
    assert faults([f"planner:={WAVEFRONT}"]) == []


class Wire:
    """In place of a publisher: keeps what is sent."""

    sent: ClassVar[dict] = {}

    def __init__(self, topic, message_type, **_):
        self._topic = topic

    def get_num_connections(self):
        return 1

    def publish(self, message):
        Wire.sent.setdefault(self._topic, []).append(message)

    def unregister(self):
        pass


@pytest.fixture(name="cart")
def cart_fixture(folder, monkeypatch):
    """The unit that the server makes for a robot called cart_1."""
    monkeypatch.setattr(node, "ROBOT_TYPES", dict(node.ROBOT_TYPES))
    monkeypatch.setattr(robots.rospy, "Publisher", Wire)
    Wire.sent = {}
    assert node.robot_type("cart_1") is None
    module = importlib.import_module("my_cell.cart")
    make = node.robot_type("cart_1")
    assert make is module.CartUnit
    return make("cart_1", ControlsServerParams(), lambda name: None, lambda: None)


def goal(x, y, yaw_rad, action="False"):
    return MoveRobotGoal(
        action=action, target=Pose(Point(x, y, 0.0), Quaternion(*quaternion_from_rpy(0.0, 0.0, yaw_rad)))
    )


@pytest.mark.parametrize("target", [(1.0, 0.5, 1.0), (-0.7, 0.2, math.pi), (0.0, 0.0, -1.5)])
def test_the_cart_drives_to_its_target(cart, target):
    assert cart.refusal(goal(*target)) == ""
    cart.start(goal(*target))
    x, y, yaw = 0.0, 0.0, 0.3
    for tick in range(900):
        quaternion = np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)])
        end = cart.tick(SeedPose(np.array([x, y, 0.4]), quaternion, tick * TICK_S), tick * TICK_S)
        if end is not None:
            break
        twist = Wire.sent["cart_1/cmd_vel"][-1]
        x += twist.linear.x * math.cos(yaw) * TICK_S
        y += twist.linear.x * math.sin(yaw) * TICK_S
        yaw += twist.angular.z * TICK_S
    assert end is not None and end[0] is Outcome.SUCCEEDED, (x, y, yaw)
    assert math.hypot(x - target[0], y - target[1]) <= 0.02
    assert abs(math.remainder(yaw - target[2], math.tau)) <= 0.02
    last = Wire.sent["cart_1/cmd_vel"][-1]
    assert (last.linear.x, last.angular.z) == (0.0, 0.0)
    assert cart.simulator_commands == len(Wire.sent["cart_1/cmd_vel"])


def test_the_cart_refuses_what_is_not_a_place_and_stops_when_told(cart):
    assert "finite" in cart.refusal(goal(math.nan, 0.0, 0.0))
    cart.start(goal(1.0, 0.0, 0.0))
    pose = SeedPose(np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.0)
    assert cart.tick(pose, 0.0) is None and Wire.sent["cart_1/cmd_vel"][-1].linear.x > 0.0
    cart.cancel("somebody stands there")
    assert Wire.sent["cart_1/cmd_vel"][-1].linear.x == 0.0
    assert cart.tick(pose, 0.1) is None


def test_a_calibration_needs_solids(cart):
    cart.start(goal(0.0, 0.0, 0.0, action="CALIBRATION"))
    outcome, reason = cart.tick(SimpleNamespace(), 0.0)
    assert outcome is Outcome.ABORTED and "cart_1" in reason


def test_a_pattern_is_registered_once(cart):
    with pytest.raises(ValueError, match=r"'cart_\*' is registered already"):
        node.register_robot_type("cart_*", type(cart))


def test_the_barrel_stands_in_the_cell_and_the_registry(folder):
    scene = load_scene(folder / "my_cell" / "barrel.yaml")
    findings = check_scene(scene)
    assert all(finding.holds for finding in findings), [f.text for f in findings if not f.holds]
    with SimWorld(scene) as world:
        entry = registry_entry(world.bodies["barrel_1"])
        top = world.transforms()["barrel_1"]
        world.run(1.0)
        assert world.transforms()["barrel_1"] == pytest.approx(top)
    assert (entry.object, entry.type, entry.seed_frame) == ("Obstacle", "static", "barrel_1")
    assert [tuple(shape.dimensions) for shape in entry.shapes] == [(0.50, 0.20), (0.02, 0.22)]
    assert top[:3, 3] == pytest.approx([1.2, -1.4, 0.25 + 0.27])
    assert [pose.position.z for pose in entry.shape_poses] == pytest.approx([-0.27, -0.01])
