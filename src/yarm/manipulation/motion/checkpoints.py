"""Checkpoints of the arm and obstacles about it: a scene for the arm alone, from YAML or from poses that a bag held.

    start_deg: [0, 0, 0, 0, 0]              # mechanical angles; the candle when absent
    checkpoints:
      - {name: bin, xyz: [0.3, 0.1, 0.2], tilt_deg: 180}                # tool in the plane of axis 1, straight down
      - {name: shelf, xyz: [0.2, 0, 0.4], quaternion: [0, 0.7071068, 0, 0.7071068]}
    obstacles:
      - {name: wall, shape: box, size: [0.02, 0.3, 0.3], xyz: [0.25, 0, 0.15], yaw_deg: 20}

Metres, the arm's frame (``yarm.robots.youbot``). ``tilt_deg`` is the tool's angle from straight up, ``spin_deg`` joint
5's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import List, Optional, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.manipulation.kinematics.forward import pose_error
from yarm.robots.youbot import LOWER_RAD, N_JOINTS, UPPER_RAD, Joints, within_limits
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

MOST_CHECKPOINTS = 50
MOST_OBSTACLES = 100
UNIT_LENGTH_TOLERANCE = 1e-3
SAME_M, SAME_RAD = 1e-4, 1e-3
FAR_M = 2.0
SIZES = {Shape.BOX: 3, Shape.CYLINDER: 2, Shape.SPHERE: 1}


class CheckpointError(ValueError):
    """Checkpoints that cannot be used; the message names the checkpoint, the number and the limit."""


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """A pose (4, 4) of the end effector that has a name, metres, arm's frame."""

    name: str
    pose: FloatArray


@dataclass(frozen=True, eq=False)
class Obstacle:
    """A solid that has a name; its pose is in the arm's frame."""

    name: str
    solid: Solid


@dataclass(frozen=True, eq=False)
class ArmScene:
    """What the arm is asked to do, and what stands in its way.

    Attributes:
        name: of the scene.
        start: joints, rad.
        checkpoints: in the order of the file.
        obstacles: in the order of the file.
    """

    name: str
    start: Joints
    checkpoints: Tuple[Checkpoint, ...]
    obstacles: Tuple[Obstacle, ...]


def checkpoint(name: str, translation: npt.ArrayLike, quaternion: npt.ArrayLike) -> Checkpoint:
    """A checkpoint as a bag's geometry_msgs/Transform has it.

    Args:
        name: of the checkpoint.
        translation: (3,), metres.
        quaternion: (4,) x, y, z, w, of length 1.

    Raises:
        CheckpointError: not finite, or the quaternion is not of length 1.
    """
    xyz, turn = np.asarray(translation, dtype=float), np.asarray(quaternion, dtype=float)
    if xyz.shape != (3,) or turn.shape != (4,) or not (np.all(np.isfinite(xyz)) and np.all(np.isfinite(turn))):
        raise CheckpointError(f"checkpoint {name}: needs 3 and 4 finite numbers, not {xyz.tolist()}, {turn.tolist()}")
    length = float(np.linalg.norm(turn))
    if abs(length - 1.0) > UNIT_LENGTH_TOLERANCE:
        raise CheckpointError(
            f"checkpoint {name}: its quaternion has length {length:.4g}, not 1 within {UNIT_LENGTH_TOLERANCE:g}; "
            "normalise it"
        )
    return Checkpoint(name, transform_matrix(xyz, turn))


def checked_checkpoints(checkpoints: Sequence[Checkpoint], where: str) -> Tuple[Checkpoint, ...]:
    """The checkpoints, when there are any and no two are alike.

    Args:
        checkpoints: to look at.
        where: file or topic they come from, for messages.

    Raises:
        CheckpointError: none, more than ``MOST_CHECKPOINTS``, a name or a pose given twice.
    """
    if not 1 <= len(checkpoints) <= MOST_CHECKPOINTS:
        raise CheckpointError(f"{where}: holds {len(checkpoints)} checkpoints; 1 to {MOST_CHECKPOINTS} can be used")
    for index, one in enumerate(checkpoints):
        for other in checkpoints[:index]:
            error = pose_error(one.pose, other.pose)
            if one.name == other.name:
                raise CheckpointError(f"{where}: two checkpoints are called {one.name}")
            if np.linalg.norm(error[:3]) < SAME_M and np.linalg.norm(error[3:]) < SAME_RAD:
                raise CheckpointError(
                    f"{where}: checkpoints {other.name} and {one.name} are the same pose, "
                    f"{np.linalg.norm(error[:3]):.2g} m and {np.linalg.norm(error[3:]):.2g} rad apart; "
                    f"{SAME_M:g} m or {SAME_RAD:g} rad are needed"
                )
    return tuple(checkpoints)


def load_arm_scene(path: Path) -> ArmScene:
    """Read a scene of the arm.

    Raises:
        SceneError: the file's faults, all of them.
        CheckpointError: checkpoints that are fine one by one and not together.
    """
    faults = Faults(str(path))
    fields = Fields(load_yaml(path), "", faults)
    degrees = fields.numbers("start_deg", N_JOINTS, -360.0, 360.0, default=(0.0,) * N_JOINTS)
    start: Joints = tuple(math.radians(angle) for angle in degrees)  # type: ignore[assignment]
    if not within_limits(start):
        low, high = (np.degrees(limits).round(1).tolist() for limits in (LOWER_RAD, UPPER_RAD))
        faults.add("start_deg", list(degrees), f"angles within {low} to {high}")
    checkpoints = [_checkpoint(entry) for entry in fields.entries("checkpoints", MOST_CHECKPOINTS)]
    obstacles = [_obstacle(entry) for entry in fields.entries("obstacles", MOST_OBSTACLES)]
    fields.finish()
    faults.raise_if_any()
    names = [obstacle.name for obstacle in obstacles if obstacle is not None]
    if len(set(names)) < len(names):
        raise SceneError(f"{path}: two obstacles have the same name: {sorted(names)}")
    found = checked_checkpoints([point for point in checkpoints if point is not None], str(path))
    return ArmScene(path.stem, start, found, tuple(obstacle for obstacle in obstacles if obstacle is not None))


def _checkpoint(fields: Fields) -> Optional[Checkpoint]:
    name = fields.text("name")
    xyz = fields.numbers("xyz", 3, -FAR_M, FAR_M)
    by_tilt = not fields.has("quaternion")
    tilt = fields.number("tilt_deg", -180.0, 180.0, "deg", default=None if by_tilt else 0.0)
    spin = fields.number("spin_deg", -180.0, 180.0, "deg", default=0.0)
    turn = fields.numbers("quaternion", 4, -2.0, 2.0, default=(0.0, 0.0, 0.0, 1.0))
    if not by_tilt and (fields.has("tilt_deg") or fields.has("spin_deg")):
        fields.faults.add(fields.path("quaternion"), list(turn), "either a quaternion or tilt_deg and spin_deg")
    fields.finish()
    if by_tilt:
        upright = quaternion_from_rpy(0.0, math.radians(tilt), math.atan2(xyz[1], xyz[0]))
        pose = transform_matrix(xyz, upright) @ transform_matrix(
            (0.0, 0.0, 0.0), quaternion_from_rpy(0.0, 0.0, -math.radians(spin))
        )
        return Checkpoint(name, pose)
    try:
        return checkpoint(name, xyz, turn)
    except CheckpointError as error:
        fields.faults.add(fields.path("quaternion"), list(turn), f"a unit quaternion ({error})")
        return None


def _obstacle(fields: Fields) -> Optional[Obstacle]:
    name = fields.text("name")
    shape = fields.text("shape", choices=tuple(Shape))
    size: Tuple[float, ...] = fields.numbers("size", SIZES[Shape(shape)] if shape else 3, 0.001, FAR_M)
    xyz = fields.numbers("xyz", 3, -FAR_M, FAR_M)
    yaw = fields.number("yaw_deg", -180.0, 180.0, "deg", default=0.0)
    fields.finish()
    if not shape:
        return None
    return Obstacle(
        name, Solid(Shape(shape), size, transform_matrix(xyz, quaternion_from_rpy(0.0, 0.0, math.radians(yaw))))
    )


def moved_obstacles(obstacles: Sequence[Obstacle], rng: np.random.Generator, spread_m: float) -> List[Obstacle]:
    """The obstacles, each pushed aside at random by up to a distance along each horizontal axis."""
    moved = []
    for obstacle in obstacles:
        pose = obstacle.solid.pose.copy()
        pose[:2, 3] += rng.uniform(-spread_m, spread_m, 2)
        moved.append(Obstacle(obstacle.name, Solid(obstacle.solid.shape, obstacle.solid.size, pose)))
    return moved
