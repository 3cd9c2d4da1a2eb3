"""Facts of the TurtleBot: sectors of its bumper, and how far its scan reads short."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import pytest
import yaml

from yarm.geometry import Pose2
from yarm.resources import resource
from yarm.robots.turtlebot import DEPTH_CAMERA, SCAN_BIAS_PER_M, Bumper, bumper_at
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena, Block


@pytest.mark.parametrize(
    "bearing_deg, sector",
    [
        *((0, Bumper.CENTER), (29, Bumper.CENTER), (-29, Bumper.CENTER)),
        *((31, Bumper.LEFT), (89, Bumper.LEFT), (-31, Bumper.RIGHT), (-89, Bumper.RIGHT)),
        *((91, None), (180, None), (-91, None)),
    ],
)
def test_a_contact_presses_the_sector_it_is_in(bearing_deg: float, sector: Bumper) -> None:
    assert bumper_at(math.radians(bearing_deg)) == sector


@pytest.mark.parametrize("file", [("inspection", "amcl.yaml"), ("exploration", "slam_gmapping.yaml")])
def test_the_nodes_take_out_what_the_scan_reads_short(file: Tuple[str, str]) -> None:
    assert yaml.safe_load(resource("config", *file).read_text())["bias_slope"] == SCAN_BIAS_PER_M


@pytest.mark.parametrize("away_m", [2.0, 3.0, 4.5])
def test_a_scan_with_that_taken_out_is_right(away_m: float) -> None:
    wall = Block("wall", "wall", Pose2(away_m + 0.025, 0.0), (0.05, 8.0, 0.6))
    world = KinematicWorld(Arena("t", "custom", 0, (-5.0, -5.0), (5.0, 5.0), (wall,), Pose2(0.0, 0.0)), 3)
    scans = [world.scan() for _ in range(20)]
    middle = slice(300, 340)  # square to the wall, so that all of them read its distance
    ranges = np.concatenate([scan.ranges[middle] for scan in scans]).astype(float)
    lengthened = ranges + SCAN_BIAS_PER_M * ranges**2
    assert np.nanmean(lengthened) == pytest.approx(away_m - DEPTH_CAMERA.x, abs=0.004)
    assert np.nanmean(ranges) < away_m - DEPTH_CAMERA.x - 0.008
