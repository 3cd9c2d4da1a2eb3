"""The map says what the arm can do: drawn points are reached, and what is outside is not."""

from __future__ import annotations

import math

import numpy as np

from yarm.manipulation.clearing.reachability import (
    CELL_M,
    CLEAR_M,
    DOWN,
    HALF_M,
    T_BASE_ARM,
    cup_poses,
    own_body,
    reach_map,
)
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.obstacles.collision import YoubotCollision
from yarm.robots.youbot import ARM_ON_BASE_XYZ_M

MAP = reach_map(0.04, 0.08)


def free_answers(x: float, y: float, z: float) -> int:
    collision = YoubotCollision(own_body())
    (pose,) = cup_poses(np.array((x, y, z)) - ARM_ON_BASE_XYZ_M, (DOWN,))
    return sum(collision.free(np.array(q), CLEAR_M) for q in inverse(pose).solutions)


def test_every_cell_is_what_the_arm_says() -> None:
    rng = np.random.default_rng(1)
    n = len(MAP.quality)
    for x, y in rng.integers(0, n, (60, 2)).tolist() + np.argwhere(MAP.quality > 0.0)[::9].tolist():
        at = MAP.lower + CELL_M * (np.array((x, y)) + 0.5)
        reached = all(free_answers(float(at[0]), float(at[1]), z) > 0 for z in (0.04, 0.12))
        assert reached == (MAP.quality[x, y] > 0.0)


def test_a_piece_on_the_floor_is_picked_beyond_the_bases_edge_only() -> None:
    points, ease = MAP.reached()
    assert len(points) > 100
    assert ease.max() == 1.0 and ease.min() > 0.0
    inside = (np.abs(points[:, 0]) < 0.285) & (np.abs(points[:, 1]) < 0.18)
    assert not inside.any()
    ahead = points[np.abs(points[:, 1]) < CELL_M]
    assert 0.30 < ahead[:, 0].min() < 0.37
    assert 0.42 < ahead[:, 0].max() < 0.50


def test_a_tool_aslant_reaches_over_rims_that_a_tool_down_does_not() -> None:
    assert not (reach_map(0.285).quality > 0.0).any()
    aslant = reach_map(0.285, 0.0, (DOWN, math.radians(150.0)))
    assert (aslant.quality > 0.0).sum() > 100


def test_the_arms_frame_is_where_the_robot_has_it() -> None:
    assert T_BASE_ARM[:3, 3].tolist() == list(ARM_ON_BASE_XYZ_M)
    assert reach_map(0.04, 0.08) is MAP
    assert MAP.lower.tolist() == [-HALF_M, -HALF_M]
