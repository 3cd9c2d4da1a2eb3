"""Bodies that are not robots: fixtures, debris, targets, obstacles."""

from __future__ import annotations

import numpy as np
import pybullet

from yarm.geometry import quaternion_from_rpy, transform_matrix
from yarm.geometry.urdf import Solid
from yarm.sim.bodies import Body, FramedSolid, description, load_box, load_urdf
from yarm.sim.scene import ThingSpec

SEED_POINTS = {"table": (0.20, 0.0, 0.70), "stand": (-0.95, 0.0, 0.70)}
"""A point of each fixture's top that the cameras see, metres, world."""


class SpawnError(ValueError):
    """An object cannot be put into the cell or taken out; the message names it and why."""


def fixture_body(client: int, name: str) -> Body:
    """The table with its workpiece, or the stand."""
    text, model = description("cell.urdf.xacro", name)
    uid = load_urdf(client, text, (0.0, 0.0, 0.0), 0.0, fixed=True)
    pose = transform_matrix(SEED_POINTS[name], (0.0, 0.0, 0.0, 1.0))
    inverse = np.linalg.inv(pose)
    solids = tuple(
        FramedSolid(name, solid, inverse @ model.rigid_group(solid.link)[1] @ solid.T_link_solid)
        for solid in model.solids
    )
    return Body(name, "Obstacle", False, name, (name,), solids, (uid,), {name: pose})


def thing_body(client: int, spec: ThingSpec) -> Body:
    """Debris, target or obstacle."""
    if spec.kind == "Debris":
        return _debris(client, spec)
    quaternion = quaternion_from_rpy(0.0, 0.0, spec.yaw_rad)
    pose = transform_matrix((spec.x, spec.y, spec.z), quaternion)
    if spec.kind == "Target":
        return Body(spec.name, "Target", False, spec.name, (spec.name,), static_frames={spec.name: pose})
    return _obstacle(client, spec)


def _debris(client: int, spec: ThingSpec) -> Body:
    text, model = description("debris.urdf.xacro")
    uid = load_urdf(client, text, (spec.x, spec.y, spec.z), spec.yaw_rad, fixed=False)
    # Without anchors, friction lets a body at rest creep by some mm a minute.
    pybullet.changeDynamics(uid, -1, frictionAnchor=1, physicsClientId=client)
    solids = tuple(FramedSolid(spec.name, solid, solid.T_link_solid) for solid in model.solids)
    return Body(spec.name, "Debris", True, spec.name, (spec.name,), solids, (uid,))


def _obstacle(client: int, spec: ThingSpec) -> Body:
    """A fixed box; its frame is the middle of its top, which the cameras see."""
    size = (spec.size[0], spec.size[1], spec.size[2])
    uid = load_box(client, size, (spec.x, spec.y, spec.z), spec.yaw_rad)
    top = transform_matrix((spec.x, spec.y, spec.z + 0.5 * size[2]), quaternion_from_rpy(0.0, 0.0, spec.yaw_rad))
    below = transform_matrix((0.0, 0.0, -0.5 * size[2]), (0.0, 0.0, 0.0, 1.0))
    solid = FramedSolid(spec.name, Solid("box", size, spec.name, np.eye(4)), below)
    return Body(
        spec.name, "Obstacle", False, spec.name, (spec.name,), (solid,), (uid,), {spec.name: top}, spec.registered
    )
