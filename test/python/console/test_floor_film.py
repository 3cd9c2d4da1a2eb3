"""The film of the youBot's floor: what a page shows is where the physics has it."""

from __future__ import annotations

import numpy as np
import pytest

from yarm.console.film import Film, unpack
from yarm.console.floor_film import FloorFilm
from yarm.console.reel import HAND, PERIOD_S, hand_way
from yarm.console.results import FILM
from yarm.console.wire import decode
from yarm.geometry import quaternion_from_rpy, transform_matrix
from yarm.manipulation.clearing.mission import Command
from yarm.manipulation.clearing.play import FloorRobot
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.kinematics.forward import forward
from yarm.manipulation.motion.trajectory import arm_limits, quintic
from yarm.resources import resource
from yarm.robots.youbot import NAME
from yarm.sim.engine.youbot_floor import YoubotFloor
from yarm.sim.scenes.youbot_floor import CUP_FRAME, load_floor_scene

BEGIN = np.array([0.2, 0.4, 0.9, 0.9, 0.0])
END = np.array([-0.4, 0.3, 1.1, 0.8, 0.3])
TICKS = 60
NEAR_M = 0.07
"""The cup's link lies so far from the hand that the formulas speak of, and two points of its trace from each other."""


@pytest.fixture
def taken(tmp_path):
    """A film of a robot that drives ahead and moves its arm, and the world at the end."""
    film, motion = FloorFilm("floor"), quintic(BEGIN, END, arm_limits())
    scene = load_floor_scene(resource("scenes", "manipulation", "youbot_floor.yaml"))
    with YoubotFloor(scene, BEGIN) as world:
        robot = FloorRobot(world, 1)
        for tick in range(TICKS):
            command = Command(np.array([0.2, 0.0, 0.0]), motion if tick == 0 else None)
            robot.tell(command)
            film(world, command)
        film.reel._next_s = 0.0
        film(world, Command())
        read = Film.read(film.write(tmp_path))
        assert (tmp_path / FILM).is_file()
        blocks = [read.block(i) for i in range(len(read.index()["blocks"]))]
        yield world, motion, [decode(message) for block in blocks for _, message in unpack(block)]


def test_every_body_is_where_the_physics_has_it(taken):
    world, _, messages = taken
    scene = next(header for header, _ in messages if header["kind"] == "scene")
    poses = dict(zip(scene["frames"], messages[-1][1]["poses"]))
    bodies = {body["name"]: scene["frames"][body["frame"]] for body in scene["bodies"]}
    assert set(bodies) == {NAME, "bin", *(p.name for p in world.scene.debris), *(n for n, _ in world.scene.obstacles)}
    base = world.robot.pose()
    np.testing.assert_allclose(poses[bodies[NAME]][:2], (base.x, base.y), atol=1e-5)
    for piece in world.scene.debris:
        found = poses[bodies[piece.name]]
        np.testing.assert_allclose(transform_matrix(found[:3], found[3:]), world.piece(piece.name), atol=1e-5)
    assert abs(base.x - world.scene.start.x) > 0.05, "it has driven"
    shapes = [solid for solid in scene["solids"] if scene["bodies"][solid["body"]]["name"] == NAME]
    assert {scene["frames"][solid["frame"]] for solid in shapes} >= {f"arm_link_{n}" for n in range(1, 6)} | {CUP_FRAME}


def test_pictures_come_in_time_and_tell_the_arms_way(taken):
    world, motion, messages = taken
    states = [message for message in messages if message[0]["kind"] == "state"]
    times = [header["time_s"] for header, _ in states]
    assert np.diff(times[:-1]).min() >= PERIOD_S - 1e-6
    assert len(times) == pytest.approx(world.time_s / PERIOD_S, abs=2)
    header, arrays = states[-1]
    assert header["room"]["facts"][0] == ["in the bin", f"0 of {len(world.scene.debris)} pieces"]
    first, ways = 0, {}
    for line in header["lines"]:
        ways[line["layer"], line["name"]] = arrays["points"][first : first + line["count"]]
        first += line["count"]
    assert set(ways) == {("driven", NAME), ("driven", HAND), ("path", HAND)}
    base = world.robot.pose()
    at = transform_matrix((base.x, base.y, 0.0), quaternion_from_rpy(0.0, 0.0, base.yaw_rad)) @ T_BASE_ARM
    np.testing.assert_allclose(ways["path", HAND][-1], (at @ forward(END))[:3, 3], atol=1e-5)
    np.testing.assert_allclose(hand_way(motion)[0], forward(BEGIN)[:3, 3], atol=1e-6)
    assert np.linalg.norm(ways["path", HAND] - ways["driven", HAND][-1], axis=1).min() < NEAR_M
