"""The TurtleBot in a room: standing, driving, stopping by itself, bumping, slipping, repeating."""

from __future__ import annotations

import hashlib
import math
from typing import Iterator, List

import numpy as np
import pytest

from support.rooms import block, room
from yarm.geometry import Pose2
from yarm.geometry.kinds import ContactKind
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper, BumperEvent
from yarm.sim.engine.room import RoomParams, RoomWorld
from yarm.sim.robots.errors import CommandError

EXACTLY = RoomParams(sensor_noise=False, odometry_noise=False)


@pytest.fixture
def empty() -> Iterator[RoomWorld]:
    with RoomWorld(room(), EXACTLY) as world:
        world.run(0.2)
        yield world


def drive(world: RoomWorld, v_mps: float, w_radps: float, seconds: float) -> None:
    for _ in range(round(10.0 * seconds)):
        world.drive(v_mps, w_radps)
        world.run(0.1)


def test_it_stands_level_and_still_for_a_minute(empty: RoomWorld) -> None:
    before = empty.truth
    empty.run(60.0)
    after, base = empty.truth, empty.robot.base()
    assert after.distance(before) < 1e-4
    assert abs(after.yaw_rad - before.yaw_rad) < 1e-4
    assert base[2, 3] == pytest.approx(turtlebot.BASE_LINK_Z_M, abs=2e-4)
    assert math.degrees(math.acos(base[2, 2])) < 0.05
    contacts = empty.contacts.take()
    links = {side.link for contact in contacts for side in (contact.a, contact.b)}
    assert links == {"floor", "left_wheel", "right_wheel", "back_caster"}
    assert all(contact.kind is ContactKind.ALLOWED for contact in contacts)
    assert empty.odometry.pose == Pose2(0.0, 0.0, empty.odometry.pose.yaw_rad)


def test_it_drives_and_turns_as_told_and_odometry_follows(empty: RoomWorld) -> None:
    drive(empty, 0.3, 0.0, 3.0)
    assert empty.robot.speed()[0] == pytest.approx(0.3, abs=0.003)
    drive(empty, 0.0, 0.0, 1.0)
    assert empty.truth.x == pytest.approx(0.9, abs=0.01)
    assert abs(empty.truth.y) < 0.005
    drive(empty, 0.0, 1.0, 2.0)
    drive(empty, 0.0, 0.0, 1.0)
    assert empty.truth.yaw_rad == pytest.approx(2.0, abs=0.03)
    assert empty.odometry.pose.distance(empty.truth) < 0.01
    assert empty.odometry.pose.yaw_rad == pytest.approx(empty.truth.yaw_rad, abs=1e-6)


def test_wheels_speed_up_no_faster_than_their_limit(empty: RoomWorld) -> None:
    speeds: List[float] = []
    for _ in range(30):
        empty.drive(0.7, 0.0)
        empty.tick()
        speeds.append(empty.robot.speed()[0])
    assert speeds[-1] == pytest.approx(0.3, abs=0.03)
    assert max(np.diff(speeds)) < 2.0 * turtlebot.ACCELERATION_MPS2 * 0.01


def test_it_stops_by_itself_when_nothing_is_said(empty: RoomWorld) -> None:
    drive(empty, 0.3, 0.0, 1.0)
    told_s = empty.time_s - 0.1
    while empty.time_s < told_s + turtlebot.COMMAND_TIMEOUT_S - 0.011:
        empty.tick()
    assert empty.robot.speed()[0] > 0.29
    empty.run(0.5)
    assert abs(empty.robot.speed()[0]) < 0.001


def test_commands_beyond_the_limits_are_clamped_and_nonsense_is_refused(empty: RoomWorld) -> None:
    assert not empty.drive(0.7, -math.pi)
    assert empty.drive(0.8, 0.0)
    assert empty.drive(0.0, 4.0)
    drive(empty, -9.0, 0.0, 1.0)
    assert empty.robot.speed()[0] == pytest.approx(-0.7, abs=0.01)
    for v, w in ((math.nan, 0.0), (0.0, math.inf)):
        with pytest.raises(CommandError, match="finite"):
            empty.drive(v, w)


@pytest.mark.parametrize(
    ("start", "sector"),
    [
        (Pose2(-1.2, 0.0, math.pi), Bumper.CENTER),
        (Pose2(-1.2, 0.0, math.pi - 0.9), Bumper.LEFT),
        (Pose2(-1.2, 0.0, math.pi + 0.9), Bumper.RIGHT),
    ],
)
def test_a_wall_presses_the_sector_that_meets_it(start: Pose2, sector: Bumper) -> None:
    with RoomWorld(room(start=start), EXACTLY) as world:
        while not world.take_bumps() and world.time_s < 8.0:
            drive(world, 0.2, 0.0, 0.1)
            touching = [c for c in world.contacts.take() if c.kind is ContactKind.FAILURE]
        assert world.time_s < 8.0
        assert world.pressed == {sector}
        assert {c.a.body for c in touching} | {c.b.body for c in touching} == {turtlebot.TYPE, "west"}
        assert world.truth.x == pytest.approx(-2.0 + turtlebot.RADIUS_M, abs=0.004)
        drive(world, -0.1, 0.0, 1.0)
        assert world.take_bumps()[-1].pressed is False


def test_the_back_has_no_bumper_and_odometry_slips_there() -> None:
    with RoomWorld(room(start=Pose2(-1.7, 0.0)), EXACTLY) as world:
        drive(world, -0.1, 0.0, 6.0)
        assert world.take_bumps() == ()
        assert world.truth.x == pytest.approx(-2.0 + turtlebot.RADIUS_M, abs=0.004)
        # Told to back for 0.6 m, of which 0.124 m were there.
        assert world.odometry.pose.x == pytest.approx(-0.6, abs=0.02)


def test_a_low_brick_that_the_scan_cannot_see_stops_it() -> None:
    brick = block("brick", 0.8, 0.0, (0.2, 0.6, 0.06), "low")
    with RoomWorld(room(brick), EXACTLY) as world:
        drive(world, 0.2, 0.0, 6.0)
        assert BumperEvent(Bumper.CENTER, True) in world.take_bumps()
        assert world.truth.x == pytest.approx(0.7 - turtlebot.RADIUS_M, abs=0.01)
        assert world.odometry.pose.x > 1.0


def test_a_start_in_contact_is_told_of_only_when_it_lets_go() -> None:
    against = Pose2(2.0 - turtlebot.RADIUS_M, 0.0)
    with RoomWorld(room(start=against), EXACTLY) as world:
        drive(world, 0.05, 0.0, 1.0)
        assert world.take_bumps() == ()
        drive(world, -0.1, 0.0, 1.0)
        assert world.take_bumps() == (BumperEvent(Bumper.CENTER, False),)


def test_a_seed_repeats_to_the_last_bit_and_another_differs() -> None:
    def digest(seed: int) -> str:
        sums = hashlib.sha256()
        with RoomWorld(room(block("pillar", 0.9, 0.1, (0.2, 0.2, 0.6))), seed=seed) as world:
            for i in range(60):
                drive(world, 0.2, 0.4 * math.sin(i), 0.1)
                sums.update(world.robot.base().tobytes() + world.scan().ranges.tobytes())
                sums.update(repr((world.odometry, world.take_bumps())).encode())
        return sums.hexdigest()

    first = digest(3)
    assert digest(3) == first
    assert digest(4) != first


def test_scans_are_numbered_by_time_so_that_a_moment_said_again_has_the_same_number(empty: RoomWorld) -> None:
    numbers = set()
    for _ in range(40):
        empty.tick()
        if empty.scan_due():
            numbers.add((empty.frame, round(empty.time_s * 20)))
    assert len(numbers) == 8
    assert all(frame == moment for frame, moment in numbers)
