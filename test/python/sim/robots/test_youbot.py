"""The youBot in full physics: it drives with slip, stands while its arm moves, picks up, carries and lets go."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Iterator, Optional

import numpy as np
import pytest

from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.motion.tour import straight_line
from yarm.manipulation.motion.trajectory import Trajectory, arm_limits, jerk_limited, through_waypoints
from yarm.resources import resource
from yarm.robots.youbot import ARM_ON_BASE_XYZ_M
from yarm.sim.engine.youbot_floor import STEPS_PER_SECOND, YoubotFloor
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.youbot import FASTEST_MPS, SLIP
from yarm.sim.scenes.youbot_floor import FloorPiece, load_floor_scene

SCENE = load_floor_scene(resource("scenes", "manipulation", "youbot_floor.yaml"))
PIECE = "debris_1"
GRIP = np.array((-0.015, 0.0, 0.02, 1.0))


def down_at(xyz: FloatArray, near: Optional[FloatArray] = None) -> FloatArray:
    """Joints that hold the tool straight down at a point, arm's frame."""
    upright = quaternion_from_rpy(0.0, math.pi, math.atan2(float(xyz[1]), float(xyz[0])))
    found = [np.array(q) for q in inverse(transform_matrix(xyz, upright)).solutions]
    return min(found, key=lambda q: 0.0 if near is None else float(np.linalg.norm(q - near)))


CARRY = down_at(np.array((0.22, 0.0, 0.09)))


@pytest.fixture
def world() -> Iterator[YoubotFloor]:
    """The robot at the origin, one piece before it."""
    scene = replace(SCENE, start=Pose2(0.0, 0.0), debris=(FloorPiece(PIECE, 0.42, 0.03, 0.4),), obstacles=())
    with YoubotFloor(scene, CARRY, seed=3) as built:
        run(built, 0.3)
        yield built


def run(world: YoubotFloor, seconds: float) -> None:
    for _ in range(round(seconds * STEPS_PER_SECOND)):
        world.step()


def play(world: YoubotFloor, motion: Trajectory) -> float:
    """Follow a motion, no further than until something is taken; the greatest force on the cup."""
    most = 0.0
    taken = world.robot.cup.grasping
    for step in range(math.ceil((motion.duration_s + 0.2) * STEPS_PER_SECOND)):
        q, speed, _ = motion.evaluate(np.array([min((step + 1) / STEPS_PER_SECOND, motion.duration_s)]))
        world.robot.follow(q[0], speed[0])
        world.step()
        most = max([most, *world.robot.cup.press_n().values()])
        if world.robot.cup.grasping and not taken:
            break
    return most


def pick(world: YoubotFloor) -> float:
    """Pick the piece up, as far as it is under the tool; the greatest force on the cup."""
    T_world_arm = transform_matrix(ARM_ON_BASE_XYZ_M, (0.0, 0.0, 0.0, 1.0))
    top = (np.linalg.inv(T_world_arm) @ world.piece(PIECE) @ GRIP)[:3]
    above = down_at(top + np.array((0.0, 0.0, 0.06)), CARRY)
    below = down_at(top - np.array((0.0, 0.0, 0.006)), above)
    play(world, jerk_limited(CARRY, above, arm_limits()))
    most = play(world, through_waypoints(straight_line(above, below).joints, arm_limits(0.1)))
    play(world, jerk_limited(world.robot.joints(), above, arm_limits(0.4)))
    play(world, jerk_limited(above, CARRY, arm_limits(0.4)))
    return most


def test_the_base_loses_to_slip_what_is_said_and_stops(world: YoubotFloor) -> None:
    for direction, axis in ((np.array((0.3, 0.0, 0.0)), 0), (np.array((0.0, 0.3, 0.0)), 1)):
        world.robot.drive(direction)
        run(world, 0.5)
        before = world.robot.pose()
        run(world, 2.0)
        way = before.inverse().compose(world.robot.pose())
        assert (way.x, way.y)[axis] == pytest.approx(0.6 * (1.0 - SLIP[axis]), abs=0.02)
        assert abs((way.x, way.y)[1 - axis]) < 0.05
    world.robot.drive(np.zeros(3))
    run(world, 0.5)
    before = world.robot.pose()
    run(world, 1.0)
    assert world.robot.pose().distance(before) < 1e-3


def test_commands_beyond_the_base_are_cut_and_what_is_no_number_is_refused(world: YoubotFloor) -> None:
    world.robot.drive(np.array((-3.0, 0.0, 0.0)))
    run(world, 0.5)
    before = world.robot.pose()
    run(world, 1.0)
    assert world.robot.pose().distance(before) == pytest.approx(FASTEST_MPS * (1.0 - SLIP[0]), abs=0.02)
    for wrong in ((math.nan, 0.0, 0.0), (0.0, 0.0)):
        with pytest.raises(CommandError, match="3 finite numbers"):
            world.robot.drive(np.array(wrong))


def test_a_piece_is_picked_carried_and_let_go(world: YoubotFloor) -> None:
    world.robot.cup.on()
    assert pick(world) > 2.0
    assert world.held() == PIECE
    assert world.piece(PIECE)[2, 3] > 0.1
    assert world.robot.pose().distance(Pose2(0.0, 0.0)) < 5e-3
    world.robot.drive(np.array((-0.3, 0.0, 0.5)))
    run(world, 2.0)
    assert world.held() == PIECE
    assert world.robot.cup.lost == 0
    world.robot.drive(np.zeros(3))
    run(world, 0.5)
    world.robot.cup.off()
    run(world, 1.0)
    assert world.held() == ""
    assert world.piece(PIECE)[2, 3] < 0.05
    assert not world.in_bin(PIECE)
    assert world.wrong_touches() == []


def test_without_suction_nothing_is_held(world: YoubotFloor) -> None:
    pick(world)
    assert world.held() == ""
    assert world.piece(PIECE)[2, 3] < 0.05


def test_what_must_not_be_touched_is_named() -> None:
    wall = (FloorPiece(PIECE, 0.33, 0.0, 0.0),)
    scene = replace(SCENE, start=Pose2(0.0, 0.0), debris=wall, obstacles=())
    with YoubotFloor(scene, CARRY) as world:
        world.robot.drive(np.array((0.3, 0.0, 0.0)))
        run(world, 1.0)
        assert any("debris_1" in touch for touch in world.wrong_touches())
