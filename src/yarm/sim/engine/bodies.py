"""Loading bodies into PyBullet."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import List, Sequence

import numpy as np
import numpy.typing as npt
import pybullet

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix

FRICTION = {"wheel": 1.0, "caster": 0.0, "floor": 1.0, "debris": 0.7, "table": 0.7, "part": 0.7, "sander": 0.2}
"""Lateral friction by link name or its ending; PyBullet multiplies the two of a contact."""


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
