"""The kinematic world: exact distances, and robots that move by the real control law."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.control.base.controller import Outcome
from yarm.experiments.study.clearance import (
    ANKURBOT,
    FAR_M,
    Upright,
    box,
    cloud_of,
    distance,
    flat_distance,
    points_distance,
)
from yarm.experiments.study.kinematic import FIXTURES, KinematicWorld, solid_cells
from yarm.geometry import GridSpec, Pose2
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.ankurbot import ankurbot_mask
from yarm.sim.scenes.scene import load_scene

SPEC = GridSpec()
number = st.floats(-2.0, 2.0)
angle = st.floats(-math.pi, math.pi)


def dense_points(solid: Upright) -> np.ndarray:
    """Points all over an upright box or disc."""
    n = 41
    if solid.radius:
        r, a = np.meshgrid(np.linspace(0, solid.radius, n), np.linspace(0, 2 * math.pi, 4 * n))
        x, y = (r * np.cos(a)).ravel(), (r * np.sin(a)).ravel()
    else:
        x, y = (v.ravel() for v in np.meshgrid(*(np.linspace(-h, h, n) for h in solid.half)))
    c, s = math.cos(solid.centre.yaw_rad), math.sin(solid.centre.yaw_rad)
    flat = np.column_stack([solid.centre.x + c * x - s * y, solid.centre.y + s * x + c * y])
    return np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in np.linspace(*solid.z, 25)])


@settings(max_examples=60, deadline=None)
@given(number, number, angle, number, number, angle, st.floats(-1, 1))
def test_distance_agrees_with_dense_points(
    ax: float, ay: float, ayaw: float, bx: float, by: float, byaw: float, z: float
) -> None:
    a = box(ax, ay, ayaw, (1.2, 0.3, 0.5), 0.0)
    b = box(bx, by, byaw, (0.4, 0.7, 0.4), z)
    exact, sampled = distance(a, b), points_distance([a], cloud_of(dense_points(b)))
    if exact > FAR_M:
        assert sampled > FAR_M
    elif exact > 0.0:
        assert exact - 1e-9 <= sampled <= exact + 0.03
    else:
        assert sampled <= 0.03


def test_distances_by_hand() -> None:
    disc = Upright(Pose2(2.0, 0.0), (0.0, 0.0), 0.35, (0.1, 0.55))
    table = box(0.0, 0.0, 0.0, (0.9, 1.2, 0.7), 0.0)
    assert distance(disc.at(Pose2(-0.8, 0.0)), table) == pytest.approx(0.4)
    assert distance(disc.at(Pose2(-1.3, 0.0)), table) == pytest.approx(-0.1)
    beam = box(0.0, 0.0, 0.3, (1.3, 0.08, 0.08), 0.85)
    assert distance(beam, table) == pytest.approx(0.15)
    assert points_distance([disc], cloud_of(np.array([[2.0, 0.5, 0.3], [5.0, 5.0, 5.0]]))) == pytest.approx(0.15)
    assert points_distance([disc], cloud_of(np.zeros((0, 3)))) == math.inf
    assert flat_distance([disc, table], 2.0, 0.5) == pytest.approx(0.15)
    assert flat_distance([table], 0.0, 0.0) == pytest.approx(-0.45)


def test_the_robot_has_the_same_cells_here_as_in_planning() -> None:
    pose = Pose2(0.33, 0.41, 0.7)
    column = SPEC.column_of((pose.x, pose.y))
    centre = SPEC.column_centre(column)
    mask = ankurbot_mask(SPEC, pose.yaw_rad, (pose.x - centre[0], pose.y - centre[1]))
    planned = {tuple(cell) for cell in mask.at(column)}
    points = np.concatenate([dense_points(solid.at(pose)) for solid in ANKURBOT])
    cells, inside = SPEC.cells_of(points)
    seen = {tuple(cell) for cell in cells[inside]}
    assert seen <= planned
    assert len(planned - seen) <= 0.1 * len(planned)


@pytest.mark.parametrize("name", sorted(FIXTURES))
def test_fixtures_are_those_of_the_robot_description(name: str) -> None:
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "cell.urdf.xacro"), part=name))
    assert len(model.solids) == len(FIXTURES[name])
    for solid, ours in zip(model.solids, FIXTURES[name]):
        _, pose = model.rigid_group(solid.link)
        centre = (pose @ solid.pose)[:3, 3]
        assert (ours.centre.x, ours.centre.y) == pytest.approx(tuple(centre[:2]))
        assert ours.z == pytest.approx((centre[2] - solid.size[2] / 2, centre[2] + solid.size[2] / 2))
        assert (2 * ours.half[0], 2 * ours.half[1]) == pytest.approx(solid.size[:2])


def test_the_table_fills_its_cells() -> None:
    cells = solid_cells(SPEC, FIXTURES["table"])
    assert {tuple(c) for c in cells[cells[:, 2] == 5]} == {(x, y, 5) for x in range(20, 30) for y in range(19, 31)}
    assert cells[:, 2].max() == 11


def test_stations_stand_where_the_scene_puts_them() -> None:
    statics = KinematicWorld(load_scene("2m2ma"), SPEC).statics
    assert set(statics) == {"table", "stand", "hc10_barc_2_table", "hc10_barc_2_stand"}
    ((stand,), (_, part)) = statics["hc10_barc_2_stand"], statics["hc10_barc_2_table"]
    assert (stand.centre.x, stand.centre.y) == pytest.approx((2.1, -1.1))
    assert (part.centre.x, part.centre.y) == pytest.approx((1.25, -1.1))


def run_until_done(world: KinematicWorld, limit_s: float) -> None:
    robot = world.robots["ankurbot_1"]
    while robot.outcome is Outcome.ACTIVE and world.now_s < limit_s:
        world.advance()


def test_a_robot_reaches_a_free_pose_and_touches_nothing() -> None:
    world = KinematicWorld(load_scene("single"), SPEC)
    robot = world.robots["ankurbot_1"]
    assert (robot.pose.x, robot.pose.y) == pytest.approx((0.7, 2.0))
    target = Pose2(0.05, 1.55, math.pi)
    robot.send(target)
    run_until_done(world, 20.0)
    assert robot.outcome is Outcome.SUCCEEDED
    assert robot.pose.distance(target) < 0.03
    assert robot.path_m == pytest.approx(0.79, abs=0.05)
    assert not robot.touches.stationary
    assert robot.touches.least_m > 0.1


def test_a_robot_that_drives_into_the_table_stops_there_and_it_is_counted() -> None:
    world = KinematicWorld(load_scene("single"), SPEC)
    robot = world.robots["ankurbot_1"]
    robot.send(Pose2(-1.3, 0.0, math.pi))
    run_until_done(world, 60.0)
    assert robot.touches.stationary == {"table"}
    assert robot.blocked
    assert robot.outcome is Outcome.ABORTED
    assert robot.touches.least_m > -0.1


def test_a_request_shows_robots_and_fixtures() -> None:
    world = KinematicWorld(load_scene("1m1ma_target"), SPEC)
    request = world.request({"ankurbot_1": "target_1"})
    (robot,) = request.robots
    assert not request.occupied[tuple(robot.cells.T)].any()
    assert request.occupied[25, 25, 5]
    assert request.goals["target_1"].column == SPEC.column_of((-1.9, -1.6))
    assert set(request.objects) == {"table", "stand"}
    assert world.free_at(world.robots["ankurbot_1"].pose, besides="ankurbot_1")
    assert not world.free_at(world.robots["ankurbot_1"].pose)
    assert not world.free_at(Pose2(-1.3, 0.0, math.pi), besides="ankurbot_1")
