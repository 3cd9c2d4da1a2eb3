"""Bodies that are not robots, put into PyBullet: fixtures, debris, targets, obstacles."""

from __future__ import annotations

from dataclasses import replace

import pybullet

from yarm.geometry.kinds import ObjectKind
from yarm.sim.engine.bodies import load_box, load_urdf
from yarm.sim.scenes import bodies
from yarm.sim.scenes.bodies import DEBRIS_FILE, Body, description
from yarm.sim.scenes.specs import FixtureSpec, ThingSpec


def fixture_body(client: int, spec: FixtureSpec) -> Body:
    """The table with its workpiece, the stand, or a bin."""
    text, _ = description("cell.urdf.xacro", spec.type)
    uid = load_urdf(client, text, (spec.station.x, spec.station.y, 0.0), spec.station.yaw_rad, fixed=True)
    return replace(bodies.fixture_body(spec), uids=(uid,))


def thing_body(client: int, spec: ThingSpec) -> Body:
    """Debris, target or obstacle.

    Raises:
        SpawnError: its description cannot be used.
    """
    body = bodies.thing_body(spec)
    if spec.kind == ObjectKind.TARGET:
        return body
    place = (spec.x, spec.y, spec.z)
    if spec.kind == ObjectKind.OBSTACLE and not spec.model:
        return replace(body, uids=(load_box(client, spec.size, place, spec.yaw_rad),))
    loose = spec.kind == ObjectKind.DEBRIS
    uid = load_urdf(client, description(spec.model or DEBRIS_FILE)[0], place, spec.yaw_rad, fixed=not loose)
    if loose:
        # Without anchors, friction lets a body at rest creep by some mm a minute.
        pybullet.changeDynamics(uid, -1, frictionAnchor=1, physicsClientId=client)
    return replace(body, uids=(uid,))
