"""Bodies in PyBullet: where their frames and solids are, and that what is loaded agrees with what is told."""

from __future__ import annotations

import math
from typing import Iterator

import numpy as np
import pybullet
import pytest

from yarm.geometry import quaternion_from_rpy, transform_matrix
from yarm.robots.hc10 import AT_ORIGIN, Station
from yarm.sim.engine import bodies
from yarm.sim.engine.things import fixture_body, thing_body
from yarm.sim.scenes.bodies import SEED_POINTS, Body, description
from yarm.sim.scenes.specs import FixtureSpec, ThingSpec

STATIONS = [AT_ORIGIN, Station(x=0.5, y=-0.4, yaw_rad=0.7)]


@pytest.fixture(name="client")
def client_fixture() -> Iterator[int]:
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


def bounds(client: int, uid: int) -> np.ndarray:
    """Lower and upper corner (2, 3) of all links of a body, metres, world."""
    links = [
        link
        for link in range(-1, pybullet.getNumJoints(uid, physicsClientId=client))
        if pybullet.getCollisionShapeData(uid, link, physicsClientId=client)
    ]
    boxes = np.array([pybullet.getAABB(uid, link, physicsClientId=client) for link in links])
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def told(body: Body, T_world_frame: np.ndarray) -> np.ndarray:
    """Lower and upper corner (2, 3) of the solids a body tells of, metres, world."""
    corners = []
    for item in body.solids:
        pose = T_world_frame @ item.T_frame_solid
        reach = np.abs(pose[:3, :3]) @ item.solid.half_extent
        corners += [pose[:3, 3] - reach, pose[:3, 3] + reach]
    return np.array([np.min(corners, axis=0), np.max(corners, axis=0)])


@pytest.mark.parametrize("station", STATIONS)
@pytest.mark.parametrize("kind", sorted(SEED_POINTS))
def test_a_fixture_is_where_its_solids_say(client: int, kind: str, station: Station) -> None:
    body = fixture_body(client, FixtureSpec("thing", kind, station))
    assert (body.kind, body.dynamic, body.seed_frame, body.registered) == ("Obstacle", False, "thing", True)
    pose = body.static_frames["thing"]
    assert pose == pytest.approx(station.pose @ transform_matrix(SEED_POINTS[kind], (0.0, 0.0, 0.0, 1.0)))
    assert told(body, pose) == pytest.approx(bounds(client, body.uids[0]), abs=2e-3)


@pytest.mark.parametrize("kind", sorted(SEED_POINTS))
def test_a_fixtures_seed_is_on_its_surface(client: int, kind: str) -> None:
    body = fixture_body(client, FixtureSpec("thing", kind))
    tops = [
        (body.static_frames["thing"] @ item.T_frame_solid)[2, 3] + item.solid.half_extent[2]
        for item in body.solids
        if item.solid.shape == "box"
    ]
    assert any(top == pytest.approx(SEED_POINTS[kind][2]) for top in tops)


def test_an_obstacle_is_a_box_under_its_frame(client: int) -> None:
    body = thing_body(client, ThingSpec("box", "Obstacle", 0.5, -1.0, 0.3, math.pi / 2, (0.2, 0.4, 0.6)))
    top = body.static_frames["box"]
    assert top[:3, 3] == pytest.approx([0.5, -1.0, 0.6])
    assert told(body, top) == pytest.approx(np.array([[0.3, -1.1, 0.0], [0.7, -0.9, 0.6]]))
    assert told(body, top) == pytest.approx(bounds(client, body.uids[0]), abs=2e-3)
    assert pybullet.getDynamicsInfo(body.uids[0], -1, physicsClientId=client)[0] == 0.0  # no mass: it stands


def test_an_unregistered_obstacle_is_a_body_nobody_is_told_of(client: int) -> None:
    spec = ThingSpec("ghost", "Obstacle", 0.0, 0.0, 0.2, size=(0.1, 0.1, 0.4), registered=False)
    body = thing_body(client, spec)
    assert not body.registered and len(body.uids) == 1


def test_debris_is_loose_and_its_solids_are_in_its_own_frame(client: int) -> None:
    body = thing_body(client, ThingSpec("debris_1", "Debris", 0.1, 0.2, 0.02, 0.5))
    assert body.dynamic and body.static_frames == {} and body.seed_frame == "debris_1"
    pose = transform_matrix((0.1, 0.2, 0.02), quaternion_from_rpy(0.0, 0.0, 0.5))
    assert told(body, pose) == pytest.approx(bounds(client, body.uids[0]), abs=3e-3)
    masses = [pybullet.getDynamicsInfo(body.uids[0], -1, physicsClientId=client)[0]]
    assert masses == pytest.approx([0.30])


def test_a_target_is_a_frame_without_a_body(client: int) -> None:
    body = thing_body(client, ThingSpec("target_1", "Target", 1.0, -1.0, 0.89, 0.3))
    assert (body.kind, body.uids, body.solids) == ("Target", (), ())
    assert body.static_frames["target_1"][:3, 3] == pytest.approx([1.0, -1.0, 0.89])


def test_the_root_link_is_put_where_it_is_asked_for_whatever_its_centre_of_mass(client: int) -> None:
    text, _ = description("debris.urdf.xacro")
    uid = bodies.load_urdf(client, text, (0.3, -0.4, 0.5), 1.2, fixed=True)
    position, quaternion = pybullet.getBasePositionAndOrientation(uid, physicsClientId=client)
    T_world_com = transform_matrix(position, quaternion)
    T_world_root = T_world_com @ np.linalg.inv(bodies.com_offset(client, uid))
    assert T_world_root == pytest.approx(transform_matrix((0.3, -0.4, 0.5), quaternion_from_rpy(0, 0, 1.2)), abs=1e-6)
    assert np.linalg.norm(np.array(position) - (0.3, -0.4, 0.5)) > 1e-3  # the handle's mass is not at its middle


def test_friction_is_that_of_the_links_name(client: int) -> None:
    text, _ = description("ankurbot.urdf.xacro")
    uid = bodies.load_urdf(client, text, (0.0, 0.0, 0.0), 0.0, fixed=False)
    wheels = [i for i, name in enumerate(bodies.link_names(client, uid)) if name.endswith("_wheel")]
    assert len(wheels) == 4
    frictions = {pybullet.getDynamicsInfo(uid, link, physicsClientId=client)[1] for link in wheels}
    assert frictions == {bodies.FRICTION["wheel"]}
    floor = bodies.load_floor(client)
    assert pybullet.getDynamicsInfo(floor, -1, physicsClientId=client)[1] == bodies.FRICTION["floor"]


def test_one_description_is_read_once() -> None:
    assert description("debris.urdf.xacro") is description("debris.urdf.xacro")
    assert description("cell.urdf.xacro", "table") is not description("cell.urdf.xacro", "stand")
