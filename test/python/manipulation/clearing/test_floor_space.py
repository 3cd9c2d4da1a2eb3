"""Where the base may be, and its ways: checked against exact distances, and against a search of our own."""

from __future__ import annotations

import math

import fcl
import numpy as np
import pytest

from yarm.geometry import Pose2, quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.clearing.arm_work import base_outline, carry_joints, held_solid
from yarm.manipulation.clearing.floor_space import (
    ARM_X_M,
    ARM_Y_M,
    BASE_X_M,
    BASE_Y_M,
    MARGIN_M,
    FloorSpace,
    Standing,
    standing,
)
from yarm.manipulation.clearing.reachability import T_BASE_ARM
from yarm.manipulation.obstacles.collision import arm_description, link_poses
from yarm.manipulation.obstacles.fcl_bodies import fcl_geometry, fcl_object
from yarm.sim.scenes.youbot_floor import RIM_M

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
BASE = Solid(Shape.BOX, (0.58, 0.38, 0.2), transform_matrix((0.0, 0.0, 0.1), UPRIGHT))
WALL = Solid(Shape.BOX, (0.1, 2.6, 0.1), transform_matrix((0.0, -0.7, 0.05), UPRIGHT))


def box(x: float, y: float, yaw: float, size: tuple) -> Solid:
    return Solid(Shape.BOX, size, transform_matrix((x, y, 0.5 * size[2]), quaternion_from_rpy(0.0, 0.0, yaw)))


def exact_gap(pose: Pose2, thing: Solid) -> float:
    """Distance of the base's box at a pose to a thing by FCL, metres."""
    at = transform_matrix((pose.x, pose.y, 0.0), quaternion_from_rpy(0.0, 0.0, pose.yaw_rad)) @ BASE.pose
    placed = [fcl_object(fcl_geometry(solid), where) for solid, where in ((BASE, at), (thing, thing.pose))]
    result = fcl.DistanceResult()
    return float(fcl.distance(placed[0], placed[1], fcl.DistanceRequest(), result))


def test_the_outline_holds_the_base_and_the_arm_with_a_piece() -> None:
    (x_low, x_high), (y_low, y_high) = base_outline()
    assert BASE_X_M[0] <= x_low and x_high <= BASE_X_M[1]
    assert BASE_Y_M[0] <= y_low and y_high <= BASE_Y_M[1]
    _, model = arm_description()
    for rim in (0.1, 0.2, RIM_M):
        rotations, origins = link_poses(np.array(carry_joints(rim)))
        solids = [(int(s.link[9]) if s.link.startswith("arm_link_") else 5, s) for s in model.solids]
        for link, solid in [*solids, (5, held_solid())]:
            half = solid.half_extent
            corners = np.array([(x, y, z, 0.0) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])[:, :3] * half
            in_link = corners @ solid.pose[:3, :3].T + solid.pose[:3, 3]
            placed = in_link @ rotations[link].T + origins[link] + T_BASE_ARM[:3, 3]
            assert placed[:, 0].max() <= ARM_X_M[1]
            ahead = placed[placed[:, 0] > ARM_X_M[0]]
            assert not len(ahead) or np.abs(ahead[:, 1]).max() <= ARM_Y_M[1]


def test_a_free_pose_keeps_the_margin_by_exact_distances() -> None:
    rng = np.random.default_rng(4)
    for _ in range(30):
        thing = box(*rng.uniform(-0.6, 0.6, 2), rng.uniform(-3, 3), tuple(rng.uniform(0.05, 0.6, 3)))
        space = FloorSpace(2.5, [standing("thing", thing)], 1.0)
        poses = np.column_stack([rng.uniform(-0.9, 0.9, (40, 2)), rng.uniform(-3, 3, 40)])
        free = space.free(poses)
        really = np.array([exact_gap(Pose2(*pose), thing) >= MARGIN_M for pose in poses.tolist()])
        assert not np.any(free & ~really)
        # Only past a corner is the bound less than the distance.
        assert np.mean(free == really) > 0.9


def test_tall_things_keep_the_arm_off_and_low_ones_do_not() -> None:
    ahead = Standing("thing", Pose2(0.42, 0.0), (0.02, 0.02), 0.3)
    pose = np.zeros((1, 3))
    assert not FloorSpace(2.5, [ahead], 0.2).free(pose)[0]
    assert FloorSpace(2.5, [ahead], 0.3).free(pose)[0]


def test_ways_go_round_a_wall_and_keep_the_margin() -> None:
    space = FloorSpace(2.0, [standing("wall", WALL)], 0.2)
    start, goal = Pose2(-1.0, -1.0, 0.0), Pose2(1.0, -1.0, math.pi / 2)
    ways = space.ways_from(start)
    way = ways.to(goal)
    assert way[0] == start and way[-1] == goal
    assert len(way) > 2
    for a, b in zip(way[:-1], way[1:]):
        for share in np.linspace(0.0, 1.0, 40):
            at = a.towards(b, float(share))
            assert space.gaps(np.array([(at.x, at.y, at.yaw_rad)]))[0] > 0.6 * MARGIN_M
    length = sum(a.distance(b) for a, b in zip(way[:-1], way[1:]))
    assert 3.5 < length < 5.0
    assert ways.lengths_to(np.array([(1.0, -1.0, math.pi / 2)]))[0] == pytest.approx(length + 0.3 * 1.57, abs=0.6)


def test_no_way_leads_through_a_closed_wall_and_off_the_floor() -> None:
    closed = Solid(Shape.BOX, (0.1, 4.0, 0.1), transform_matrix((0.0, 0.0, 0.05), UPRIGHT))
    space = FloorSpace(2.0, [standing("wall", closed)], 0.2)
    ways = space.ways_from(Pose2(-1.0, 0.0))
    assert ways.to(Pose2(1.0, 0.0)) == ()
    assert math.isinf(ways.lengths_to(np.array([(1.0, 0.0, 0.0)]))[0])
    assert math.isinf(ways.lengths_to(np.array([(9.0, 0.0, 0.0)]))[0])
    assert "wall is 0.000 m away, 0.05 m is kept" in space.in_the_way(Pose2(0.1, 0.0))
    assert "the floor's edge" in space.in_the_way(Pose2(1.9, 0.0))


def test_a_base_with_something_at_its_front_backs_off_first() -> None:
    piece = Standing("piece", Pose2(0.31, 0.0), (0.03, 0.075), 0.04)
    space = FloorSpace(2.0, [piece], 0.2)
    start, goal = Pose2(0.0, 0.0), Pose2(1.2, 0.1)
    assert not space.free(np.zeros((1, 3)))[0]
    way = space.ways_from(start).to(goal)
    assert way[0] == start and way[-1] == goal
    assert way[1].x < -0.05
    for a, b in zip(way[1:-1], way[2:]):
        assert space.straight(a, b)
