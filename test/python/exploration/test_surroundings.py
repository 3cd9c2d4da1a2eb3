"""Low obstacles and bumps enter the map at once and stay; they are put where the robot was when it saw them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from yarm.exploration.model import LowView, Observation
from yarm.exploration.surroundings import CALM_S, Surroundings
from yarm.geometry import Pose2
from yarm.geometry.scans import Odometry
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import RADIUS_M, Bumper, BumperEvent

FREE = GridMap(np.zeros((120, 120), np.int8), 0.05, Pose2(-3.0, -3.0))
SAME = Pose2(0.0, 0.0)
BRICK = np.array([[1.0, 0.0]])


def seen(now_s, pose, map_count=1, low=None, T_map_odom=SAME, grid=FREE):
    return Observation(now_s, Odometry(now_s, pose), T_map_odom, map=grid, map_count=map_count, low=low)


def occupied(observation):
    return {observation.map.centre_of(*cell) for cell in np.argwhere(observation.map.occupied)}


def near(places, x, y, within=0.05):
    return any(math.hypot(px - x, py - y) <= within for px, py in places)


def test_without_marks_the_map_is_the_mapping_s_own():
    around = Surroundings()
    first = around.update(seen(1.0, Pose2(0.0, 0.0)), ())
    assert first.map is FREE
    again = around.update(seen(1.1, Pose2(0.0, 0.0)), ())
    assert again.map_count == first.map_count
    other = around.update(seen(1.2, Pose2(0.0, 0.0), map_count=2), ())
    assert other.map_count == first.map_count + 1


def test_a_low_obstacle_is_in_the_map_at_once_and_in_every_later_one():
    around = Surroundings()
    first = around.update(seen(1.0, Pose2(0.5, 0.5, math.pi / 2), low=LowView(1.0, BRICK)), ())
    assert near(occupied(first), 0.5, 1.5)
    bigger = GridMap(np.zeros((200, 200), np.int8), 0.05, Pose2(-5.0, -5.0))
    later = around.update(seen(9.0, Pose2(-2.0, 0.0), map_count=2, grid=bigger), ())
    assert near(occupied(later), 0.5, 1.5)
    assert later.map.columns == 200


def test_an_image_is_placed_where_the_robot_was_when_it_was_taken():
    around = Surroundings()
    around.update(seen(1.0, Pose2(0.0, 0.0, 0.0)), ())
    turned = seen(1.1, Pose2(0.0, 0.0, 0.2), low=LowView(1.05, 2.0 * BRICK))
    places = occupied(around.update(turned, ()))
    assert near(places, 2.0 * math.cos(0.1), 2.0 * math.sin(0.1))
    assert not near(places, 2.0 * math.cos(0.2), 2.0 * math.sin(0.2))


@pytest.mark.parametrize("stamp_s, x", [(0.2, 1.0), (5.0, 1.1)])
def test_an_image_from_before_or_after_all_that_is_known_takes_the_nearest(stamp_s, x):
    around = Surroundings()
    around.update(seen(1.0, Pose2(0.0, 0.0)), ())
    places = occupied(around.update(seen(1.1, Pose2(0.1, 0.0), low=LowView(stamp_s, BRICK)), ()))
    assert near(places, x, 0.0)


def test_a_bump_marks_what_was_touched_in_the_map_frame():
    around = Surroundings()
    pressed = (BumperEvent(Bumper.CENTER, True),)
    T_map_odom = Pose2(1.0, 0.0, math.pi)
    places = occupied(around.update(seen(1.0, Pose2(0.5, 0.0), T_map_odom=T_map_odom), pressed))
    assert near(places, 0.5 - RADIUS_M - 0.03, 0.0)
    let_go = Surroundings().update(seen(1.0, Pose2(0.5, 0.0)), (BumperEvent(Bumper.CENTER, False),))
    assert occupied(let_go) == set()


def test_a_new_map_frame_voids_the_marks():
    around = Surroundings()
    around.update(seen(1.0, Pose2(0.0, 0.0), low=LowView(1.0, BRICK)), ())
    around.forget()
    assert occupied(around.update(seen(1.1, Pose2(0.0, 0.0)), ())) == set()


def test_before_the_first_map_nothing_is_marked():
    around = Surroundings()
    blind = Observation(1.0, Odometry(1.0, Pose2(0.0, 0.0)), low=LowView(1.0, BRICK))
    assert around.update(blind, ()) is blind


def test_a_robot_that_pushes_takes_no_floor_for_bricks():
    around = Surroundings()
    place = Pose2(0.0, 0.0)
    pressed, released = BumperEvent(Bumper.CENTER, True), BumperEvent(Bumper.CENTER, False)
    around.update(seen(1.0, place), (pressed,))
    for now_s in (1.0, 2.5, 3.0):
        marked = around.update(seen(now_s, place, low=LowView(now_s, BRICK)), (released,) if now_s == 3.0 else ())
        assert not near(occupied(marked), 1.0, 0.0)
    calm_s = 3.0 + CALM_S
    assert near(occupied(around.update(seen(calm_s, place, low=LowView(calm_s, BRICK)), ())), 1.0, 0.0)


def test_a_tilted_floor_is_no_obstacle():
    floor = np.stack(np.meshgrid(np.arange(1.0, 2.0, 0.05), np.arange(-0.5, 0.5, 0.05)), axis=-1).reshape(-1, 2)
    marked = Surroundings().update(seen(1.0, Pose2(0.0, 0.0), low=LowView(1.0, floor)), ())
    assert occupied(marked) == set()
