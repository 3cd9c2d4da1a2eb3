"""Distances against the URDF's chain, PyBullet and samples of the solids' surfaces."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import pybullet
import pytest

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid, surface_points
from yarm.manipulation.clearing.arm_work import held_solid
from yarm.manipulation.motion.checkpoints import Obstacle, load_arm_scene
from yarm.manipulation.obstacles.clearance_native import ArmBody, NativeClearance, library_path
from yarm.manipulation.obstacles.collision import YoubotCollision, arm_description, link_poses, separate_links
from yarm.manipulation.obstacles.distance import nearest_obstacle, signed_distance
from yarm.manipulation.obstacles.physics import ArmWorld
from yarm.resources import resource
from yarm.robots.youbot import JOINT_NAMES, random_joints, urdf_angles

SEED = 12
SCENE = load_arm_scene(resource("scenes", "manipulation", "arm_obstacles.yaml"))


def chain(readings: FloatArray) -> FloatArray:
    """Pose (4, 4) of arm_link_5 by multiplying out the URDF."""
    _, model = arm_description()
    pose = model.rigid_group("arm_link_0")[1]
    for name, angle in zip(JOINT_NAMES, readings):
        joint = model.joints[name]
        x, y, z = joint.axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(4)
        turn[:3, :3] += math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
        pose = pose @ joint.T_parent_child @ turn
    return np.asarray(pose)


def test_the_links_are_where_the_urdf_has_them() -> None:
    for q in random_joints(np.random.default_rng(SEED), 100):
        rotations, origins = link_poses(q)
        wanted = chain(urdf_angles(q))
        assert np.max(np.abs(rotations[5] - wanted[:3, :3])) < 1e-12
        assert np.max(np.abs(origins[5] - wanted[:3, 3])) < 1e-12


def test_every_link_is_where_physics_has_it() -> None:
    for q in random_joints(np.random.default_rng(SEED), 5):
        with ArmWorld(load_scene_at(q)) as world:
            rotations, origins = link_poses(q)
            for number in range(1, 6):
                state = pybullet.getLinkState(
                    world._arm, world._links.index(f"arm_link_{number}"), True, physicsClientId=world._client
                )
                assert origins[number] == pytest.approx(state[4], abs=1e-6)
                turn = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
                assert np.max(np.abs(rotations[number] - turn)) < 1e-6


def load_scene_at(q: FloatArray):
    """The shipped scene with the arm at joints (5,) and nothing in its way."""
    return type(SCENE)("bare", tuple(q.tolist()), SCENE.checkpoints, ())


def test_distances_are_those_of_another_engine() -> None:
    collision = YoubotCollision(SCENE.obstacles)
    compared = 0
    for q in random_joints(np.random.default_rng(SEED), 40):
        least = collision.clearance(q, 0.5)
        scene = type(SCENE)("here", tuple(q.tolist()), SCENE.checkpoints, SCENE.obstacles)
        with ArmWorld(scene) as world:
            found = [
                point[8]
                for obstacle in world._obstacles
                for point in pybullet.getClosestPoints(world._arm, obstacle, 0.5, physicsClientId=world._client)
                if world._links[point[3]] != "arm_link_0"
            ]
            found += [
                point[8]
                for a, b in world._own_pairs
                for point in pybullet.getClosestPoints(world._arm, world._arm, 0.5, a, b, physicsClientId=world._client)
            ]
        if min(found) > 0.002:
            compared += 1
            assert least.distance_m == pytest.approx(min(found), abs=0.002)
        elif min(found) < -0.002:
            assert least.distance_m == 0.0
    assert compared > 5


@pytest.mark.skipif(library_path() is None, reason="the package is not built")
@pytest.mark.parametrize("within_m", [0.01, 0.3])
def test_the_library_finds_the_distances_that_python_finds(within_m: float) -> None:
    round_things = [
        Obstacle("ball", Solid(Shape.SPHERE, (0.06,), transform_matrix((0.25, 0.1, 0.4), (0, 0, 0, 1)))),
        Obstacle("post", Solid(Shape.CYLINDER, (0.03, 0.5), transform_matrix((-0.2, 0.1, 0.3), (0, 0, 0, 1)))),
    ]
    overlapping = 0
    for obstacles in (SCENE.obstacles, round_things, ()):
        collision = YoubotCollision(obstacles)
        assert collision._native is not None
        for q in random_joints(np.random.default_rng(SEED), 300):
            wanted = collision.clearance(q, within_m).distance_m
            assert collision._native.clearance(urdf_angles(q), within_m) == pytest.approx(wanted, abs=5e-4)
            if abs(wanted - 0.005) > 5e-4:
                assert collision.free(q, 0.005) == (wanted > 0.005)
            overlapping += wanted == 0.0
    assert 50 < overlapping < 850


@pytest.mark.skipif(library_path() is None, reason="the package is not built")
def test_a_solid_of_another_shape_is_refused_by_name() -> None:
    with pytest.raises(KeyError, match="cone"):
        NativeClearance(library_path(), BARE, [Solid("cone", (0.1, 0.2), np.eye(4))])


BARE = ArmBody(np.eye(4)[None], np.array([[0.0, 0.0, 1.0]]), (), np.zeros(0, dtype=int), np.zeros((0, 2), dtype=int))


def test_the_pair_is_named_and_the_bolted_link_counts_with_the_arm_alone() -> None:
    wall = Obstacle("wall", Solid(Shape.BOX, (0.02, 0.4, 0.6), transform_matrix((0.12, 0.0, 0.4), (0, 0, 0, 1))))
    under = Obstacle("under", Solid(Shape.BOX, (1.0, 1.0, 0.02), transform_matrix((0.0, 0.0, -0.02), (0, 0, 0, 1))))
    upright = np.zeros(5)
    assert YoubotCollision([wall]).clearance(upright, 0.5).between.endswith("and wall")
    assert YoubotCollision([under]).free(upright, 0.01)
    assert not YoubotCollision([wall]).free(upright, 0.2)
    folded = np.radians([0.0, -65.0, -150.0, -100.0, 0.0])
    assert YoubotCollision([]).clearance(folded, 0.1).distance_m == 0.0


def test_what_hangs_on_the_cup_counts_as_part_of_the_arm() -> None:
    load = held_solid()
    wall = Obstacle("wall", Solid(Shape.BOX, (0.02, 0.4, 0.6), transform_matrix((0.12, 0.0, 0.4), (0, 0, 0, 1))))
    upright = np.zeros(5)
    shelf = Obstacle("shelf", Solid(Shape.BOX, (0.3, 0.3, 0.02), transform_matrix((0.0, 0.0, 0.67), (0, 0, 0, 1))))
    assert YoubotCollision([shelf]).clearance(upright, 0.1).distance_m > 0.02
    assert YoubotCollision([shelf], load=load).clearance(upright, 0.1).between in ("load and shelf", "shelf and load")
    carried, empty = YoubotCollision([wall], load=load), YoubotCollision([wall])
    nearer = 0
    for q in random_joints(np.random.default_rng(SEED), 200):
        with_load, without = (one.clearance(q, 0.2) for one in (carried, empty))
        assert with_load.distance_m <= without.distance_m + 1e-9
        nearer += with_load.distance_m < without.distance_m - 0.001 and "load" in with_load.between
        if abs(with_load.distance_m - 0.005) > 5e-4:
            assert carried.free(q, 0.005) == (with_load.distance_m > 0.005)
    assert nearer > 5


def test_neighbours_are_no_pairs() -> None:
    _, model = arm_description()
    pairs = separate_links(model)
    assert ("arm_link_0", "arm_link_2") in pairs
    assert ("arm_link_2", "arm_link_3") not in pairs
    assert ("arm_link_5", "suction_cup") not in pairs
    assert ("arm_link_4", "suction_cup") not in pairs


@pytest.mark.parametrize(("shape", "size"), [("box", (0.2, 0.1, 0.3)), ("cylinder", (0.1, 0.3)), ("sphere", (0.15,))])
def test_the_signed_distance_is_that_of_the_surface(shape: str, size: Tuple[float, ...]) -> None:
    rng = np.random.default_rng(SEED)
    solid = Solid(shape, size, transform_matrix((0.1, -0.2, 0.3), quaternion_from_rpy(0.3, -0.4, 0.5)))
    surface = surface_points([solid], 0.004)
    points = rng.uniform((-0.3, -0.6, -0.1), (0.5, 0.2, 0.7), (300, 3))
    distance, away = signed_distance(solid, points)
    nearest = np.array([np.linalg.norm(surface - point, axis=1).min() for point in points])
    assert np.abs(distance) == pytest.approx(nearest, abs=0.004)
    assert np.linalg.norm(away, axis=1) == pytest.approx(np.ones(300))
    further, _ = signed_distance(solid, points + 1e-4 * away)
    assert np.median((further - distance) / 1e-4) == pytest.approx(1.0, abs=1e-3)
    assert (distance < 0).any() and (distance > 0).any()


def test_the_nearest_of_several_counts_and_none_is_far() -> None:
    balls = [
        Obstacle(str(x), Solid(Shape.SPHERE, (0.1,), transform_matrix((x, 0.0, 0.0), (0, 0, 0, 1)))) for x in (0.0, 1.0)
    ]
    distance, away = nearest_obstacle(balls, np.array([[0.7, 0.0, 0.0]]))
    assert distance[0] == pytest.approx(0.2)
    assert away[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert math.isinf(nearest_obstacle([], np.zeros((1, 3)))[0][0])
