"""The kinematic world: a disc stops where it touches, tells its bumper's changes, slips, and sees what it should."""

from __future__ import annotations

import math
from typing import List, Tuple

import numpy as np
import pytest

from yarm.geometry import Pose2
from yarm.robots.turtlebot import RADIUS_M, Bumper, BumperEvent
from yarm.sim.kinematic.wheel_odometry import OdometryNoise
from yarm.sim.kinematic.world import TOUCH_M, KinematicWorld
from yarm.sim.scenes.arena import Arena, Block

HOME = Pose2(0.0, 0.0)
EXACT = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
WALL = Block("wall", "wall", Pose2(1.025, 0.0), (0.05, 4.0, 0.6))
BRICK = Block("brick", "low", Pose2(1.1, 0.0), (0.2, 0.4, 0.1))


def world_of(*blocks: Block, start: Pose2 = HOME, noise: OdometryNoise = EXACT) -> KinematicWorld:
    return KinematicWorld(Arena("t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), blocks, start), 7, noise)


def test_it_drives_an_arc() -> None:
    world = world_of()
    for _ in range(10):
        world.step(0.2, 0.5, 0.1)
    angle = 0.5
    assert world.truth.x == pytest.approx(0.4 * math.sin(angle), abs=1e-4)
    assert world.truth.y == pytest.approx(0.4 * (1 - math.cos(angle)), abs=1e-4)
    assert world.truth.yaw_rad == pytest.approx(angle)
    assert world.odometry().pose.x == pytest.approx(world.truth.x) and world.time_s == pytest.approx(1.0)


def test_a_wall_stops_it_and_odometry_goes_on() -> None:
    world = world_of(WALL)
    for _ in range(60):
        world.step(0.2, 0.0, 0.1)
    assert 1.0 - RADIUS_M - TOUCH_M <= world.truth.x <= 1.0 - RADIUS_M + 1e-9
    assert world.odometry().pose.x == pytest.approx(1.2)
    assert world.take_bumps() == (BumperEvent(Bumper.CENTER, True),) and world.take_bumps() == ()
    (touch,) = world.touches
    assert touch.block == "wall" and touch.speed_mps == 0.2 and touch.bearing_rad == pytest.approx(0.0)


def test_it_slides_along_a_wall_it_meets_aslant() -> None:
    world = world_of(WALL, start=Pose2(0.75, 0.0, math.radians(60.0)))
    for _ in range(50):
        world.step(0.1, 0.0, 0.1)
    assert world.truth.x == pytest.approx(1.0 - RADIUS_M, abs=TOUCH_M)
    assert 0.3 < world.truth.y < 0.5
    assert world.take_bumps() == (BumperEvent(Bumper.RIGHT, True),)


def test_low_things_stop_it_too() -> None:
    world = world_of(BRICK)
    for _ in range(60):
        world.step(0.2, 0.0, 0.1)
    assert world.truth.x == pytest.approx(1.0 - RADIUS_M, abs=TOUCH_M)


def test_a_robot_that_starts_in_contact_is_told_only_when_it_lets_go() -> None:
    world = world_of(WALL, start=Pose2(1.0 - RADIUS_M - 0.0005, 0.0))
    world.step(0.0, 0.0, 0.1)
    assert world.take_bumps() == () and world.pressed == {Bumper.CENTER}
    world.step(-0.1, 0.0, 0.1)
    assert world.take_bumps() == (BumperEvent(Bumper.CENTER, False),) and world.touches == []


def test_the_back_has_no_bumper() -> None:
    world = world_of(WALL, start=Pose2(0.7, 0.0, math.pi))
    for _ in range(20):
        world.step(-0.1, 0.0, 0.1)
    assert world.take_bumps() == () and abs(world.touches[0].bearing_rad) == pytest.approx(math.pi)


def test_a_start_inside_a_block_is_refused() -> None:
    with pytest.raises(ValueError, match="starts inside wall"):
        world_of(WALL, start=Pose2(0.9, 0.0))


def test_a_bump_makes_odometry_slip() -> None:
    world = world_of(WALL, noise=OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.02, 0.02))
    for _ in range(60):
        world.step(0.2, 0.0, 0.1)
    slip = world.odometry().pose
    assert 0.001 < abs(slip.y) < 0.2 and 0.001 < abs(slip.yaw_rad) < 0.1


def test_odometry_drifts_by_its_noise() -> None:
    ends = []
    for seed in range(20):
        world = KinematicWorld(Arena("t", "custom", 0, (-30.0, -3.0), (30.0, 3.0), (), Pose2(0, 0)), seed)
        for _ in range(500):
            world.step(0.2, 0.0, 0.1)
        ends.append((world.odometry().pose.x - 10.0, world.odometry().pose.yaw_rad))
    spread = np.std(ends, axis=0)
    assert 0.05 < spread[0] < 0.3, "2 % of scale and 3 % a root metre over 10 m"
    assert 0.02 < spread[1] < 0.12, "1 % a metre over 10 m"


def test_the_scan_sees_walls_with_noise_and_not_what_is_low_or_too_near() -> None:
    scan = world_of(WALL, BRICK).scan()
    middle = scan.ranges[300:340]
    assert np.nanmean(middle) == pytest.approx(1.087, abs=0.01), "the sensor is 0.087 m behind the base"
    assert np.nanstd(middle) > 1e-4
    assert scan.angle_min_rad == pytest.approx(-math.radians(30.0)) and len(scan.ranges) == 640
    assert np.all(np.isnan(world_of(start=Pose2(0.0, 0.0)).scan().ranges)), "nothing there"
    assert np.all(np.isnan(world_of(WALL, start=Pose2(0.7, 0.0)).scan().ranges[320:])), "nearer than 0.45 m"


def test_single_beams_are_lost() -> None:
    world = world_of(WALL)
    lost = [int(np.isnan(world.scan().ranges).sum()) for _ in range(200)]
    assert 2.5 < np.mean(lost) < 4.0, "0.5 % of 640"


@pytest.mark.parametrize(("gap_m", "shown"), [(0.70, True), (0.62, False)])
def test_a_brick_of_a_decimetre_shows_from_065_m(gap_m: float, shown: bool) -> None:
    camera_to_base = 0.087
    world = world_of(BRICK, start=Pose2(1.0 - gap_m + camera_to_base, 0.0))
    points = world.low_view()
    assert (len(points) > 0) == shown
    if shown:
        assert np.median(points[:, 0]) == pytest.approx(gap_m - camera_to_base, abs=0.01)


def test_walls_and_nearer_bricks_hide_bricks() -> None:
    behind = Block("behind", "low", Pose2(2.0, 0.0), (0.2, 0.4, 0.1))
    taller = Block("taller", "low", Pose2(2.0, 0.0), (0.2, 0.4, 0.29))
    assert len(world_of(WALL, behind).low_view()) == 0
    assert np.all(world_of(BRICK, Block("flat", "low", Pose2(1.4, 0.0), (0.1, 0.2, 0.05))).low_view()[:, 0] < 1.2)
    assert np.any(world_of(BRICK, taller).low_view()[:, 0] > 1.5)


def test_the_same_seed_gives_the_same_world() -> None:
    def run() -> Tuple[List[float], Pose2]:
        world = world_of(WALL, BRICK, noise=OdometryNoise())
        for _ in range(80):
            world.step(0.2, 0.1, 0.1)
        return [*world.scan().ranges[:5], *world.low_view().ravel()[:4]], world.odometry().pose

    first, second = run(), run()
    assert np.array_equal(first[0], second[0], equal_nan=True) and first[1] == second[1]
