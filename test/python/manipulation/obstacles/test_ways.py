"""The obstacle task: each method does what is said of it, and physics is the judge."""

from __future__ import annotations

import itertools
import time
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from yarm.geometry import transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.kinematics.forward import forward
from yarm.manipulation.motion.checkpoints import Obstacle, checkpoint, load_arm_scene, moved_obstacles
from yarm.manipulation.motion.trajectory import arm_limits, check_limits, quintic
from yarm.manipulation.obstacles.collision import YoubotCollision
from yarm.manipulation.obstacles.fields import FieldStatus, NavigationField, control_points, descend, straight_pull
from yarm.manipulation.obstacles.physics import ArmWorld, TaskPlayed, play_task
from yarm.manipulation.obstacles.ways import RETRACTED, Variant, Ways, plan_ways, timed_path
from yarm.resources import resource
from yarm.robots.youbot import random_joints

SEED = 6
SCENE = load_arm_scene(resource("scenes", "manipulation", "arm_obstacles.yaml"))


@lru_cache(maxsize=None)
def ways(variant: Variant) -> Ways:
    return plan_ways(SCENE, variant, SEED)


@lru_cache(maxsize=None)
def played(variant: Variant, solid: bool = True) -> TaskPlayed:
    return play_task(SCENE, ways(variant), solid)


def test_planned_ways_reach_all_without_a_touch() -> None:
    result = played(Variant.YARM)
    assert result.reached == 5
    assert result.touches == 0
    assert result.tracking_rad < 0.02
    collision = YoubotCollision(SCENE.obstacles)
    for leg in ways(Variant.YARM).legs:
        for motion in leg.motions:
            assert check_limits(motion, arm_limits()).kept
            assert all(collision.free(q, 0.004) for q in motion.sampled(0.01)[1])


def test_a_machine_that_stands_still_costs_no_way(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(time, "monotonic", itertools.count(0, 1000).__next__)
    assert [leg.reason for leg in plan_ways(SCENE, Variant.YARM, SEED).legs] == [""] * 5


def test_planned_ways_stand_obstacles_that_are_a_little_elsewhere() -> None:
    scene = replace(SCENE, obstacles=tuple(moved_obstacles(SCENE.obstacles, np.random.default_rng(SEED), 0.005)))
    result = play_task(scene, plan_ways(scene, Variant.YARM, SEED + 1))
    assert (result.reached, result.touches) == (5, 0)


def test_the_plain_field_is_caught_and_says_where() -> None:
    result = played(Variant.POTENTIAL_FIELD)
    assert 0 < result.reached < 5
    caught = [leg for leg in result.legs if not leg.reached]
    assert all("a local minimum holds the hand at" in leg.reason for leg in caught)


def test_the_navigation_function_gets_round_what_catches_the_plain_field() -> None:
    """No field knows the arm's other links: one may be grazed."""
    result = played(Variant.NAVIGATION_FIELD)
    assert result.reached == 5
    names = {obstacle.name for obstacle in SCENE.obstacles}
    assert not [pair for leg in result.legs for pair in leg.touches if names & set(pair.split(" and "))]


def test_turning_without_looking_reaches_all_and_hits() -> None:
    """Through obstacles that yield it reaches everything and touches; where they stand firm they stop it."""
    through = played(Variant.TURN_EXTEND_RETRACT, solid=False)
    assert through.reached == 5
    assert through.touches >= 5
    stopped = played(Variant.TURN_EXTEND_RETRACT)
    assert stopped.reached < 5
    assert stopped.touches > 0


def test_the_retracted_arm_is_clear_whatever_its_heading() -> None:
    collision = YoubotCollision(SCENE.obstacles)
    assert all(collision.free(np.array((heading, *RETRACTED)), 0.01) for heading in np.linspace(-2.9, 2.9, 60))


def test_a_start_and_a_goal_in_collision_are_refused_with_the_pair_and_the_number() -> None:
    walled = replace(SCENE, start=(0.0, 0.8, 0.9, 0.2, 0.0))
    refused = plan_ways(walled, Variant.YARM, SEED).refused
    assert len(refused) == 5
    assert all("at the start" in reason and "0.01 m is kept" in reason for reason in refused.values())
    ball = Obstacle(
        "ball", Solid(Shape.SPHERE, (0.05,), transform_matrix(SCENE.checkpoints[0].pose[:3, 3], (0, 0, 0, 1)))
    )
    blocked = plan_ways(replace(SCENE, obstacles=(*SCENE.obstacles, ball)), Variant.YARM, SEED)
    assert list(blocked.refused) == [SCENE.checkpoints[0].name]
    assert "ball" in blocked.refused[SCENE.checkpoints[0].name]
    assert len(blocked.legs) == 4


def test_nothing_within_reach_is_said() -> None:
    far = checkpoint("far", (1.5, 0.0, 0.2), (0.0, 0.0, 0.0, 1.0))
    refused = plan_ways(replace(SCENE, checkpoints=(far,)), Variant.YARM, SEED).refused
    assert "none of 1 checkpoints can be reached" in refused["far"]


def test_a_spline_that_would_touch_gives_way_to_straight_pieces() -> None:
    corners = np.array([[0.0, 0.0, 0.5, 0.5, 0.0], [0.6, 0.0, 0.5, 0.5, 0.0], [0.6, 0.6, 0.5, 0.5, 0.0]])
    assert len(timed_path(corners, YoubotCollision([]), arm_limits())) == 1
    # A ball in the corner that a spline rounds, but for what straight pieces leave free.
    inner = forward((0.57, 0.03, 0.5, 0.5, 0.0))[:3, 3]
    pieces = timed_path(corners, Catching(inner), arm_limits())
    assert [motion.method for motion in pieces] == ["jerk-limited"] * 2


class Catching(YoubotCollision):
    """Nothing is in the way but a point that only the exact corner avoids."""

    def __init__(self, point: np.ndarray) -> None:
        super().__init__([])
        self._point = point

    def free(self, q: np.ndarray, margin_m: float) -> bool:
        return bool(np.linalg.norm(forward(q)[:3, 3] - self._point) > 0.5) and super().free(q, margin_m)


def test_the_shortest_way_of_the_hand_has_no_minimum_but_its_goal() -> None:
    field = NavigationField(SCENE.obstacles)
    goal = SCENE.checkpoints[2].pose[:3, 3]
    ways_left = field.ways(goal)
    known = np.isfinite(ways_left)
    assert known.sum() > 1000
    for cell in np.argwhere(known)[::37]:
        low, high = np.maximum(cell - 1, 0), cell + 2
        around = ways_left[low[0] : high[0], low[1] : high[1], low[2] : high[2]]
        assert ways_left[tuple(cell)] == 0.0 or around.min() < ways_left[tuple(cell)]


def test_a_field_without_obstacles_arrives() -> None:
    goal = np.array([0.25, 0.1, 0.25])
    way = descend((0.0, -0.5, 1.2, 0.7, 0.0), goal, straight_pull(goal), ())
    assert way.status is FieldStatus.ARRIVED
    assert np.linalg.norm(forward(way.joints[-1])[:3, 3] - goal) == pytest.approx(way.left_m, abs=1e-9)


def test_the_control_points_jacobians_are_what_a_small_step_does() -> None:
    for q in random_joints(np.random.default_rng(SEED), 10):
        _, jacobians, _ = control_points(q)
        assert control_points(q)[0][-1] == pytest.approx(forward(q)[:3, 3], abs=1e-12)
        for joint in range(5):
            step = np.eye(5)[joint] * 1e-6
            numeric = (control_points(q + step)[0] - control_points(q - step)[0]) / 2e-6
            assert jacobians[:, :, joint] == pytest.approx(numeric, abs=1e-7)


def test_the_motors_bring_the_hand_where_it_was_sent() -> None:
    scene = replace(SCENE, obstacles=())
    goal = np.array([0.5, 0.4, 0.8, 0.3, -0.6])
    with ArmWorld(scene) as world:
        touches, hand = world.play([quintic(SCENE.start, goal, arm_limits())])
        assert touches == {}
        assert world.hand_pose() == pytest.approx(forward(goal), abs=2e-3)
        assert world.joints() == pytest.approx(goal, abs=2e-3)
        assert hand[-1] == pytest.approx(forward(goal)[:3, 3], abs=2e-3)
