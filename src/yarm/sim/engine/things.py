"""Bodies that are not robots: fixtures, debris, targets, obstacles."""

from __future__ import annotations

from typing import Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Shape
from yarm.geometry.urdf import LinkSolid, UrdfError, UrdfModel
from yarm.robots import bin as bins
from yarm.sim.engine.bodies import Body, FramedSolid, description, load_box, load_urdf, rigid_solids
from yarm.sim.scenes.specs import FixtureSpec, ThingSpec

Solids = Tuple[Tuple[LinkSolid, FloatArray], ...]
SEED_POINTS = {"table": (0.20, 0.0, 0.70), "stand": (-0.95, 0.0, 0.70), bins.NAME: (0.0, 0.0, bins.RIM_M)}
"""A point of each fixture's top that the cameras see, metres, frame of its station; a bin's is amid its rim."""


class SpawnError(ValueError):
    """An object cannot be put into the cell or taken out; the message names it and why."""


def fixture_body(client: int, spec: FixtureSpec) -> Body:
    """The table with its workpiece, the stand, or a bin."""
    name, station = spec.name, spec.station
    text, model = description("cell.urdf.xacro", spec.type)
    uid = load_urdf(client, text, (station.x, station.y, 0.0), station.yaw_rad, fixed=True)
    seed = transform_matrix(SEED_POINTS[spec.type], (0.0, 0.0, 0.0, 1.0))
    inverse = np.linalg.inv(seed)
    solids = tuple(
        FramedSolid(name, solid, inverse @ model.rigid_group(solid.link)[1] @ solid.pose) for solid in model.solids
    )
    return Body(name, ObjectKind.OBSTACLE, False, name, (name,), solids, (uid,), {name: station.pose @ seed})


def thing_body(client: int, spec: ThingSpec) -> Body:
    """Debris, target or obstacle.

    Raises:
        SpawnError: its description cannot be used.
    """
    if spec.model:
        try:
            return _drawn(client, spec, *description(spec.model))
        except UrdfError as error:
            raise SpawnError(f"{spec.name}: {error}") from error
    if spec.kind == ObjectKind.DEBRIS:
        text, model = description("debris.urdf.xacro")
        return _debris(client, spec, text, rigid_solids(model))
    quaternion = quaternion_from_rpy(0.0, 0.0, spec.yaw_rad)
    pose = transform_matrix((spec.x, spec.y, spec.z), quaternion)
    if spec.kind == ObjectKind.TARGET:
        return Body(spec.name, ObjectKind.TARGET, False, spec.name, (spec.name,), static_frames={spec.name: pose})
    return _obstacle(client, spec)


def _drawn(client: int, spec: ThingSpec, text: str, model: UrdfModel) -> Body:
    """A thing drawn by a description: debris or an obstacle."""
    solids = rigid_solids(model)
    if spec.kind == ObjectKind.DEBRIS:
        return _debris(client, spec, text, solids)
    uid = load_urdf(client, text, (spec.x, spec.y, spec.z), spec.yaw_rad, fixed=True)
    height = max(float(pose[2, 3] + np.abs(pose[2, :3]) @ solid.half_extent) for solid, pose in solids)
    return _fixed(spec, uid, height, solids)


def _debris(client: int, spec: ThingSpec, text: str, solids: Solids) -> Body:
    uid = load_urdf(client, text, (spec.x, spec.y, spec.z), spec.yaw_rad, fixed=False)
    # Without anchors, friction lets a body at rest creep by some mm a minute.
    pybullet.changeDynamics(uid, -1, frictionAnchor=1, physicsClientId=client)
    framed = tuple(FramedSolid(spec.name, solid, pose) for solid, pose in solids)
    return Body(spec.name, ObjectKind.DEBRIS, True, spec.name, (spec.name,), framed, (uid,))


def _obstacle(client: int, spec: ThingSpec) -> Body:
    """A fixed box."""
    size = (spec.size[0], spec.size[1], spec.size[2])
    uid = load_box(client, size, (spec.x, spec.y, spec.z), spec.yaw_rad)
    return _fixed(spec, uid, 0.5 * size[2], ((LinkSolid(Shape.BOX, size, np.eye(4), spec.name), np.eye(4)),))


def _fixed(spec: ThingSpec, uid: int, height: float, solids: Solids) -> Body:
    """An obstacle; its frame is above its root link, as high as its top, which the cameras see."""
    top = transform_matrix((spec.x, spec.y, spec.z + height), quaternion_from_rpy(0.0, 0.0, spec.yaw_rad))
    below = transform_matrix((0.0, 0.0, -height), (0.0, 0.0, 0.0, 1.0))
    framed = tuple(FramedSolid(spec.name, solid, below @ pose) for solid, pose in solids)
    return Body(
        spec.name,
        ObjectKind.OBSTACLE,
        False,
        spec.name,
        (spec.name,),
        framed,
        (uid,),
        {spec.name: top},
        spec.registered,
    )
