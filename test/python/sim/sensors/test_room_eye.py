"""The TurtleBot's scan and depth image against walls whose distance is known, and against the engine's own rays."""

from __future__ import annotations

import math
from typing import Iterator

import numpy as np
import pybullet
import pytest

from support.rooms import block, room
from yarm.geometry import Pose2, transform_points
from yarm.robots import turtlebot
from yarm.sim.engine.room import RoomParams, RoomWorld
from yarm.sim.sensors.room_eye import CAMERA, SLICE_TOP, beam_columns, optical_mount

EXACTLY = RoomParams(sensor_noise=False, odometry_noise=False)
ARENA = room(
    block("pillar", 1.2, 0.4, (0.2, 0.2, 0.6)),
    block("brick", 1.0, -0.3, (0.2, 0.1, 0.1), "low"),
    start=Pose2(-0.5, 0.0),
)


@pytest.fixture(scope="module")
def world() -> Iterator[RoomWorld]:
    with RoomWorld(ARENA, EXACTLY) as world:
        world.run(0.2)
        yield world


def test_beams_run_from_right_to_left() -> None:
    columns = beam_columns()
    assert (columns[0], columns[-1]) == (CAMERA.width - 1, 0)
    assert np.all(np.diff(columns) <= 0)
    bearings = np.linspace(-0.5, 0.5, turtlebot.SCAN_BEAMS) * turtlebot.SCAN_FOV_RAD
    seen = np.arctan((0.5 * CAMERA.width - columns - 0.5) / CAMERA.focal_px)
    assert np.max(np.abs(seen - bearings)) < 0.55 / CAMERA.focal_px


def test_the_scan_agrees_with_the_engines_own_rays(world: RoomWorld) -> None:
    scan = world.scan()
    assert len(scan.ranges) == 640
    assert math.degrees(scan.angle_min_rad) == pytest.approx(-30.0)
    sensor = world.truth.compose(scan.sensor)
    directions = np.stack([np.cos(scan.angles() + sensor.yaw_rad), np.sin(scan.angles() + sensor.yaw_rad)], axis=1)
    starts = np.column_stack([np.full(640, sensor.x), np.full(640, sensor.y), np.full(640, turtlebot.CAMERA_Z_M)])
    ends = starts + 8.0 * np.column_stack([directions, np.zeros(640)])
    true = 8.0 * np.array(
        [hit[2] for hit in pybullet.rayTestBatch(starts.tolist(), ends.tolist(), physicsClientId=world.client)]
    )
    error = np.abs(scan.ranges - true)
    assert np.median(error) < 0.002
    # A beam on an edge may see either side of it.
    assert np.mean(error > 0.02) < 0.02


def test_the_scan_passes_over_what_is_low_and_the_depth_image_shows_it(world: RoomWorld) -> None:
    depth = world.depth()
    rows, columns = np.nonzero(np.isfinite(depth))
    u = (columns + 0.5 - 0.5 * CAMERA.width) / CAMERA.focal_px
    v = (rows + 0.5 - 0.5 * CAMERA.height) / CAMERA.focal_px
    z = depth[rows, columns]
    optical = np.stack([u * z, v * z, z], axis=1)
    points = transform_points(world.robot.base() @ optical_mount(), optical)
    on_brick = (np.abs(points[:, 0] - 0.9) < 0.005) & (np.abs(points[:, 1] + 0.3) < 0.045) & (points[:, 2] < 0.1)
    assert np.count_nonzero(on_brick) > 300
    assert np.min(points[:, 2]) == pytest.approx(0.0, abs=0.003)
    ahead = world.scan().points() + np.array([world.truth.x, world.truth.y])
    assert not np.any((np.abs(ahead[:, 0] - 0.9) < 0.05) & (np.abs(ahead[:, 1] + 0.3) < 0.05))


def test_the_robots_own_plate_hides_the_lowest_rows(world: RoomWorld) -> None:
    depth = world.depth()
    assert np.all(np.isnan(depth[turtlebot.HIDDEN_ROWS_FROM :]))
    assert np.count_nonzero(np.isfinite(depth[turtlebot.HIDDEN_ROWS_FROM - 1])) > 600


def test_too_near_is_not_a_number() -> None:
    with RoomWorld(room(block("near", 0.4, 0.0, (0.1, 0.2, 0.6))), EXACTLY) as world:
        scan = world.scan()
    # The block's face is 0.437 m ahead of the camera.
    assert np.all(np.isnan(scan.ranges[300:340]))
    assert np.isfinite(scan.ranges[0])
    assert not scan.valid()[320]


def test_noise_shortens_and_scatters_the_ranges_and_loses_single_beams() -> None:
    with RoomWorld(room(), RoomParams()) as world:
        scans = []
        for _ in range(200):
            world.ticks += 5
            scans.append(world.scan().ranges)
    ranges = np.array(scans)
    lost = np.mean(np.isnan(ranges))
    assert 0.004 < lost < 0.006
    middle = ranges[:, 320]
    depth = 2.0 + 0.087
    sigma = 0.0012 + 0.0019 * (depth - 0.4) ** 2
    # Of ten independent draws the least is 1.54 deviations below the mean, and scatters by 0.59.
    assert np.nanmean(middle) == pytest.approx(depth - 1.54 * sigma, abs=0.2 * sigma)
    assert np.nanstd(middle) == pytest.approx(0.59 * sigma, rel=0.2)


def test_the_scan_is_the_nearest_of_the_images_middle_rows() -> None:
    with RoomWorld(ARENA, RoomParams()) as world:
        world.run(0.5)
        scan, depth = world.scan(), world.depth()
    nearest = np.nanmin(depth[SLICE_TOP : SLICE_TOP + turtlebot.SCAN_ROWS], axis=0)[beam_columns()]
    bearings = scan.angles()
    seen = np.isfinite(scan.ranges)
    assert np.count_nonzero(seen) > 600
    assert scan.ranges[seen] * np.cos(bearings[seen]) == pytest.approx(nearest[seen], abs=0.004)
