"""The first scan laid on the map tells where a round began; one that shows nothing changes nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from yarm.experiments.inspect.eyes import boxes_of
from yarm.experiments.inspect.given import room_map
from yarm.geometry import Pose2, wrap_angle
from yarm.inspection.start_place import fitted
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import GridMap
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.layout_maker import make_layout


@pytest.mark.parametrize("seed", [0, 1, 2, 3])
@pytest.mark.parametrize("turn_rad", [0.08, -0.08])
def test_a_heading_that_odometry_has_lost_is_found_again(seed: int, turn_rad: float) -> None:
    layout = make_layout("open", seed)
    grid = with_bodies(room_map(layout), [box.corners() for box in boxes_of(layout)])
    world = KinematicWorld(layout.arena, 1)
    guess = layout.start.compose(Pose2(0.02, -0.01, turn_rad))
    found = fitted(guess, world.scan(), grid)
    assert abs(wrap_angle(found.yaw_rad - layout.start.yaw_rad)) < 0.03
    assert found.distance(layout.start) < 0.05


def test_a_map_without_surfaces_changes_nothing() -> None:
    layout = make_layout("open", 0)
    empty = GridMap(np.zeros((120, 120), np.int8), 0.05, Pose2(-3.0, -3.0))
    found = fitted(layout.start, KinematicWorld(layout.arena, 1).scan(), empty)
    assert found.distance(layout.start) < 1e-6


def test_without_points_the_guess_stays() -> None:
    layout = make_layout("open", 0)
    scan = KinematicWorld(layout.arena, 1).scan()
    blind = replace(scan, ranges=np.full(len(scan.ranges), np.nan, np.float32))
    assert fitted(layout.start, blind, room_map(layout)) == layout.start
