"""A room in full physics behind the kinematic world's interface: the two say the same of the same drive."""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import Iterator

import numpy as np
import pytest

from support.rooms import block, room
from yarm.geometry import Pose2
from yarm.navigation.low_obstacles import low_obstacles
from yarm.robots.turtlebot import RADIUS_M, Bumper, BumperEvent
from yarm.sim.engine.physics_world import PhysicsWorld
from yarm.sim.engine.room import RoomParams
from yarm.sim.kinematic.wheel_odometry import EXACT
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.robots.errors import CommandError
from yarm.sim.room_robot import RoomRobot
from yarm.sim.scenes.arena import Arena

BOTH = ("physics", "kinematic")
EXACTLY = RoomParams(sensor_noise=False, odometry_noise=False)


@contextmanager
def made(kind: str, arena: Arena, exact: bool = True) -> Iterator[RoomRobot]:
    if kind == "kinematic":
        with KinematicWorld(arena, 5, *([EXACT] if exact else [])) as plain:
            yield plain
    else:
        with PhysicsWorld(arena, 5, low_obstacles, EXACTLY if exact else None) as world:
            yield world


def drive(world: RoomRobot, v_mps: float, w_radps: float, seconds: float) -> None:
    for _ in range(round(10.0 * seconds)):
        world.step(v_mps, w_radps, 0.1)


@pytest.mark.parametrize("kind", BOTH)
def test_it_drives_turns_and_says_so(kind: str) -> None:
    with made(kind, room()) as world:
        drive(world, 0.2, 0.0, 3.0)
        assert world.true_speed_mps == pytest.approx(0.2, abs=0.002)
        drive(world, 0.0, 0.5, 2.0)
        drive(world, 0.0, 0.0, 0.5)
        assert world.time_s == pytest.approx(5.5) and world.true_speed_mps < 0.005
        assert (world.truth.x, world.truth.y) == pytest.approx((0.6, 0.0), abs=0.03)
        assert world.truth.yaw_rad == pytest.approx(1.0, abs=0.05)
        assert world.odometry().pose.distance(world.truth) < 0.01
        assert world.odometry().stamp_s == pytest.approx(world.time_s)
        assert world.scan().stamp_s == pytest.approx(world.time_s)
        assert len(world.touches) == 0 and world.take_bumps() == () and world.pressed == frozenset()


@pytest.mark.parametrize("kind", BOTH)
def test_a_wall_is_one_touch_with_place_bearing_and_speed(kind: str) -> None:
    with made(kind, room(start=Pose2(-1.2, 0.0, math.pi))) as world:
        drive(world, 0.2, 0.0, 6.0)
        (touch,) = world.touches
        assert touch.block == "west" and touch.height_m == 0.6
        assert (touch.x, touch.y) == pytest.approx((-2.0, 0.0), abs=0.02)
        assert touch.bearing_rad == pytest.approx(0.0, abs=0.1) and touch.speed_mps == pytest.approx(0.2, abs=0.01)
        assert touch.t_s == pytest.approx((0.8 - RADIUS_M) / 0.2, abs=0.4)
        assert world.pressed == {Bumper.CENTER} and world.take_bumps() == (BumperEvent(Bumper.CENTER, True),)
        assert world.truth.x == pytest.approx(-2.0 + RADIUS_M, abs=0.004)
        assert world.odometry().pose.x > 1.0, "the wheels went on"
        drive(world, -0.1, 0.0, 2.0)
        drive(world, 0.1, 0.0, 3.0)
        assert [touch.block for touch in world.touches] == ["west", "west"]


@pytest.mark.parametrize("kind", BOTH)
def test_a_low_brick_is_in_the_low_view_and_not_in_the_scan(kind: str) -> None:
    brick = block("brick", 1.2, 0.2, (0.2, 0.4, 0.12), "low")
    with made(kind, room(brick)) as world:
        drive(world, 0.0, 0.0, 0.2)
        low = world.low_view()
        assert len(low) >= 3 and np.all(np.abs(low[:, 0] - 1.15) < 0.12) and np.all(np.abs(low[:, 1] - 0.2) < 0.25)
        assert np.nanmin(world.scan().ranges) > 1.9
    with made(kind, room()) as world:
        drive(world, 0.0, 0.0, 0.2)
        assert len(world.low_view()) == 0


def test_both_worlds_scan_the_same_room_alike() -> None:
    arena = room(block("pillar", 0.9, 0.1, (0.2, 0.2, 0.6)))
    with made("physics", arena) as one, made("kinematic", arena) as other:
        drive(one, 0.0, 0.0, 0.2)
        a, b = one.scan(), other.scan()
        both = a.valid() & b.valid()
        assert both.sum() > 600 and np.median(np.abs(a.ranges[both] - b.ranges[both])) < 0.03
        assert (a.angle_min_rad, len(a.ranges), a.sensor) == pytest.approx((b.angle_min_rad, len(b.ranges), b.sensor))


def test_the_same_seed_gives_the_same_run() -> None:
    def run() -> object:
        with made("physics", room(block("pillar", 0.9, 0.1, (0.2, 0.2, 0.6))), exact=False) as world:
            drive(world, 0.2, 0.1, 5.0)
            return world.truth, world.odometry(), world.scan().ranges.tobytes(), list(world.touches)

    assert run() == run()


def test_steps_that_physics_cannot_make_and_nonsense_are_refused() -> None:
    with made("physics", room()) as world:
        for dt_s in (0.0, 0.015, 0.004):
            with pytest.raises(ValueError, match="multiple"):
                world.step(0.1, 0.0, dt_s)
        with pytest.raises(CommandError, match="finite"):
            world.step(math.nan, 0.0, 0.1)
        assert world.time_s == 0.0
