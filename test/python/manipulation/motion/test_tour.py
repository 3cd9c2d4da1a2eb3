"""Tours: the exact one is the least of all, straight lines are straight, and bad checkpoints are named."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from yarm.manipulation.kinematics.forward import forward, forward_many
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.motion.checkpoints import (
    ArmScene,
    Checkpoint,
    CheckpointError,
    checked_checkpoints,
    checkpoint,
    load_arm_scene,
    moved_obstacles,
)
from yarm.manipulation.motion.tour import LineStatus, Order, TourError, plan_tour, straight_line
from yarm.resources import resource
from yarm.robots.youbot import random_joints, within_limits
from yarm.yaml_fields import SceneError

SEED = 23


def shipped() -> ArmScene:
    return load_arm_scene(resource("scenes", "manipulation", "checkpoints.yaml"))


def test_the_exact_tour_is_the_least_of_all_orders_and_branches() -> None:
    points = shipped().checkpoints[:4]
    start = np.array(shipped().start)
    tour = plan_tour(start, points, Order.EXACT)
    branches = [np.array(inverse(point.pose).solutions) for point in points]
    least = min(
        float(np.linalg.norm(np.diff(np.vstack([start, *way]), axis=0), axis=1).sum())
        for order in itertools.permutations(range(4))
        for way in itertools.product(*(branches[index] for index in order))
    )
    assert tour.length_rad == pytest.approx(least, abs=1e-9)
    assert sorted(tour.names) == sorted(point.name for point in points)
    for name, joints in zip(tour.names, tour.joints):
        pose = next(point.pose for point in points if point.name == name)
        assert np.max(np.abs(forward(joints) - pose)) < 1e-9


def test_the_greedy_tour_visits_all_and_is_never_shorter() -> None:
    scene = shipped()
    greedy, exact = (plan_tour(scene.start, scene.checkpoints, order) for order in (Order.GREEDY, Order.EXACT))
    assert sorted(greedy.names) == sorted(exact.names)
    assert not greedy.unreachable
    assert exact.length_rad <= greedy.length_rad
    assert np.all(within_limits(exact.joints))


def test_what_is_out_of_reach_is_left_out_and_named() -> None:
    far = checkpoint("far", (1.5, 0.0, 0.2), (0.0, 0.0, 0.0, 1.0))
    tour = plan_tour((0.0,) * 5, [*shipped().checkpoints[:2], far], Order.EXACT)
    assert len(tour.names) == 2
    assert "beyond what joints 2 and 3 reach" in tour.unreachable["far"]
    with pytest.raises(TourError, match="none of 1 checkpoints"):
        plan_tour((0.0,) * 5, [far], Order.GREEDY)


def test_too_many_for_the_exact_order_are_refused() -> None:
    poses = forward_many(random_joints(np.random.default_rng(SEED), 13))
    points = [Checkpoint(str(index), pose) for index, pose in enumerate(poses)]
    with pytest.raises(TourError, match="12 checkpoints at most, not 13"):
        plan_tour((0.0,) * 5, points, Order.EXACT)
    assert len(plan_tour((0.0,) * 5, points, Order.GREEDY).names) == 13


def test_a_straight_line_is_straight_and_keeps_its_branch() -> None:
    rng = np.random.default_rng(SEED)
    straight = 0
    for start, goal in zip(random_joints(rng, 120), random_joints(rng, 120)):
        line = straight_line(start, goal)
        assert line.joints.shape == (7, 5)
        assert line.joints[0] == pytest.approx(start)
        assert line.joints[-1] == pytest.approx(goal, abs=1e-6)
        if line.status is LineStatus.BROKEN:
            assert line.reason
            continue
        straight += 1
        assert np.all(within_limits(line.joints))
        xyz = forward_many(line.joints)[:, :3, 3]
        way = xyz[-1] - xyz[0]
        shares = (xyz - xyz[0]) @ way / (way @ way)
        assert shares == pytest.approx(np.linspace(0.0, 1.0, 7), abs=1e-6)
        assert np.max(np.abs(xyz - xyz[0] - shares[:, None] * way)) < 1e-6
        tilt = line.joints[:, 1:4].sum(axis=1)
        assert np.diff(tilt) == pytest.approx(np.full(6, (tilt[-1] - tilt[0]) / 6), abs=1e-6)
    assert straight > 10


def test_a_line_through_axis_one_is_broken_with_the_reason() -> None:
    ahead = np.array([0.0, 0.9, 0.5, 0.3, 0.0])
    behind = np.array([0.0, -0.9, -0.5, -0.6, 0.0])
    line = straight_line(ahead, behind)
    assert line.status is LineStatus.BROKEN
    assert "ahead of axis 1 at one end" in line.reason


def test_the_tilt_of_a_checkpoint_is_what_it_says() -> None:
    for point in shipped().checkpoints:
        assert inverse(point.pose).solutions
    low = next(point for point in shipped().checkpoints if point.name == "ahead_low")
    assert math.degrees(math.acos(low.pose[2, 2])) == pytest.approx(170.0)


@pytest.mark.parametrize(
    ("quaternion", "says"),
    [
        ((0.0, 0.0, 0.0, 2.0), "length 2, not 1"),
        ((0.0, 0.0, 0.0, math.nan), "finite numbers"),
        ((0.0,) * 4, "length 0"),
    ],
)
def test_a_quaternion_that_is_none_is_refused(quaternion: tuple, says: str) -> None:
    with pytest.raises(CheckpointError, match=says):
        checkpoint("a", (0.1, 0.2, 0.3), quaternion)


def test_no_checkpoints_and_equal_ones_are_refused() -> None:
    one = checkpoint("a", (0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0))
    with pytest.raises(CheckpointError, match="here: holds 0 checkpoints"):
        checked_checkpoints([], "here")
    with pytest.raises(CheckpointError, match="called a"):
        checked_checkpoints([one, one], "here")
    with pytest.raises(
        CheckpointError, match=r"a and b are the same pose, 0 m and 0 rad apart; 0\.0001 m or 0\.001 rad"
    ):
        checked_checkpoints([one, Checkpoint("b", one.pose)], "here")


def test_a_file_with_faults_names_them_all(tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(
        "start_deg: [0, 200, 0, 0, 0]\n"
        "checkpoints:\n"
        "  - {name: a, xyz: [0.1, 0.2], tilt_deg: 10}\n"
        "  - {name: b, xyz: [0.1, 0.2, 0.3], quaternion: [0, 0, 0, 0.5]}\n"
        "  - {name: c, xyz: [0.1, 0.2, 0.3]}\n"
        "obstacles:\n"
        "  - {name: wall, shape: cone, size: [1, 1, 1], xyz: [0, 0, 0]}\n"
    )
    with pytest.raises(SceneError) as error:
        load_arm_scene(path)
    text = str(error.value)
    for part in ("start_deg", "checkpoints[0].xyz", "length 0.5", "checkpoints[2].tilt_deg is missing", "cone"):
        assert part in text, text
    path.write_text("checkpoints: []\n")
    with pytest.raises(CheckpointError, match="holds 0 checkpoints"):
        load_arm_scene(path)
    for text in ("", "checkpoints:\n"):
        path.write_text(text)
        with pytest.raises(SceneError, match=r"bad\.yaml"):
            load_arm_scene(path)


def test_obstacles_are_moved_sideways_only(tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(
        "checkpoints:\n  - {name: c, xyz: [0.1, 0.2, 0.3], tilt_deg: 0}\n"
        "obstacles:\n  - {name: ball, shape: sphere, size: [0.05], xyz: [0.3, 0, 0.1]}\n"
    )
    (ball,) = moved_obstacles(load_arm_scene(path).obstacles, np.random.default_rng(SEED), 0.01)
    assert ball.solid.pose[2, 3] == 0.1
    assert 0.0 < np.max(np.abs(ball.solid.pose[:2, 3] - (0.3, 0.0))) <= 0.01
