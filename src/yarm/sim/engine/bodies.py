"""Bodies of the world: what a body is made of, and loading it into PyBullet."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Dict, List, Sequence, Tuple

import numpy as np
import numpy.typing as npt
import pybullet

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.urdf import LinkSolid, UrdfError, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource

FRICTION = {"wheel": 1.0, "caster": 0.0, "floor": 1.0, "debris": 0.7, "table": 0.7, "part": 0.7, "sander": 0.2}
"""Lateral friction by link name or its ending; PyBullet multiplies the two of a contact."""


@dataclass(frozen=True, eq=False)
class FramedSolid:
    """A known solid fixed to a tf frame: pose of its centre in that frame (4, 4), metres."""

    frame: str
    solid: LinkSolid
    T_frame_solid: FloatArray


@dataclass(eq=False)
class Body:
    """One object of the cell.

    Attributes:
        name: unique name.
        kind: "Mobile", "Manipulator", "Debris", "Target" or "Obstacle".
        dynamic: whether it can move.
        seed_frame: tf frame of its seed.
        link_frames: tf frames of its rigid links.
        solids: its known solids, each in one of those frames.
        uids: its PyBullet bodies; none for a target.
        static_frames: frames that never move: T_world_frame (4, 4).
        registered: whether anybody is told of it; what is not can only be seen.
    """

    name: str
    kind: str
    dynamic: bool
    seed_frame: str
    link_frames: Tuple[str, ...]
    solids: Tuple[FramedSolid, ...] = ()
    uids: Tuple[int, ...] = ()
    static_frames: Dict[str, FloatArray] = field(default_factory=dict)
    registered: bool = True


@lru_cache(maxsize=None)
def description(file: str, part: str = "", system: str = "cell", hand: bool = False) -> Tuple[str, UrdfModel]:
    """URDF text and content of a file in a folder of urdf/, with the xacro arguments ``part`` and ``hand`` if given."""
    words = {**({"part": part} if part else {}), **({"hand": "true"} if hand else {})}
    text = expand_xacro(resource("urdf", system, file), **words)
    return text, parse_urdf(text)


def open_engine(steps_per_second: int, gui: bool = False) -> int:
    """PyBullet with gravity and a fixed step; the number of its client."""
    client = int(pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT))
    pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
    pybullet.setPhysicsEngineParameter(
        fixedTimeStep=1.0 / steps_per_second,
        numSolverIterations=50,
        deterministicOverlappingPairs=1,
        physicsClientId=client,
    )
    return client


def rigid_solids(model: UrdfModel) -> Tuple[Tuple[LinkSolid, FloatArray], ...]:
    """The solids of a thing in one piece, each with its pose (4, 4) in the root link's frame.

    Raises:
        UrdfError: the thing has no solids, or joints that move.
    """
    if not model.solids or model.moving_joints:
        moving = ", ".join(joint.name for joint in model.moving_joints) or "none"
        raise UrdfError(
            f"{model.name}: must be one rigid thing with collision solids; "
            f"it has {len(model.solids)}, and joints that move: {moving}"
        )
    return tuple((solid, model.rigid_group(solid.link)[1] @ solid.pose) for solid in model.solids)


def load_urdf(
    client: int, text: str, position: npt.ArrayLike, yaw_rad: float, fixed: bool, round_sides: bool = False
) -> int:
    """Put a URDF's text into PyBullet with its root link at a pose; the body's number.

    Cylinders become prisms of many sides, which rest steadily; with ``round_sides`` they stay round.
    """
    with tempfile.TemporaryDirectory(prefix="yarm_urdf_") as folder:
        path = Path(folder) / "body.urdf"
        path.write_text(text, encoding="utf-8")
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | (pybullet.URDF_USE_IMPLICIT_CYLINDER if round_sides else 0)
        uid = pybullet.loadURDF(str(path), useFixedBase=fixed, flags=flags, physicsClientId=client)
    set_root_pose(client, uid, position, yaw_rad)
    _set_friction(client, uid)
    return int(uid)


def set_root_pose(client: int, uid: int, position: npt.ArrayLike, yaw_rad: float) -> None:
    """Place a body's root link; PyBullet itself speaks of the centre of mass."""
    T_world_com = transform_matrix(position, quaternion_from_rpy(0.0, 0.0, yaw_rad)) @ com_offset(client, uid)
    quaternion = quaternion_from_rpy(0.0, 0.0, yaw_rad)
    pybullet.resetBasePositionAndOrientation(
        uid, T_world_com[:3, 3].tolist(), quaternion.tolist(), physicsClientId=client
    )


def com_offset(client: int, uid: int) -> FloatArray:
    """T_root_com (4, 4) of a body."""
    info = pybullet.getDynamicsInfo(uid, -1, physicsClientId=client)
    return transform_matrix(info[3], info[4])


def link_names(client: int, uid: int) -> List[str]:
    """Link names by PyBullet's index; the root is the last item, so that index -1 finds it."""
    names = [
        pybullet.getJointInfo(uid, i, physicsClientId=client)[12].decode()
        for i in range(pybullet.getNumJoints(uid, physicsClientId=client))
    ]
    root = pybullet.getBodyInfo(uid, physicsClientId=client)[0].decode()
    return [*names, root]


def _set_friction(client: int, uid: int) -> None:
    names = link_names(client, uid)
    for index in range(-1, len(names) - 1):
        for ending, friction in FRICTION.items():
            if names[index].endswith(ending):
                pybullet.changeDynamics(uid, index, lateralFriction=friction, physicsClientId=client)
        if names[index].endswith("wheel"):
            # Without an anchor a standing robot whose casters are turned creeps round by up to 2 deg/s.
            pybullet.changeDynamics(uid, index, frictionAnchor=1, physicsClientId=client)


def load_box(client: int, size: Sequence[float], position: npt.ArrayLike, yaw_rad: float) -> int:
    """A static box of full size x, y, z, metres, centred at a position."""
    half = [0.5 * s for s in size]
    shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client)
    visual = pybullet.createVisualShape(
        pybullet.GEOM_BOX, halfExtents=half, rgbaColor=(0.7, 0.7, 0.7, 1.0), physicsClientId=client
    )
    uid = pybullet.createMultiBody(
        0.0,
        shape,
        visual,
        basePosition=np.asarray(position, dtype=float).tolist(),
        baseOrientation=quaternion_from_rpy(0.0, 0.0, yaw_rad).tolist(),
        physicsClientId=client,
    )
    return int(uid)


def load_floor(client: int) -> int:
    """The floor, z = 0."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    uid = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
    pybullet.changeDynamics(uid, -1, lateralFriction=FRICTION["floor"], physicsClientId=client)
    return int(uid)
