"""Where the youBot's cup gets to from a base that stands still, and how well: the map that stands are chosen from.

After F. Zacharias, Ch. Borst, G. Hirzinger, "Capturing robot workspace structure: representing robot capabilities",
IROS 2007, with the poses that are asked of this arm only: a cup that points down, or a little aslant, at one height.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Iterator, List, Sequence, Tuple

import numpy as np

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.manipulation.kinematics.inverse import inverse
from yarm.manipulation.kinematics.singularity import MARGIN as SINGULAR
from yarm.manipulation.kinematics.singularity import singularity
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.obstacles.collision import YoubotCollision
from yarm.resources import resource
from yarm.robots.youbot import ARM_ON_BASE_XYZ_M, LOWER_RAD, UPPER_RAD, Joints

CELL_M = 0.025
HALF_M = 0.75
"""Half the map's side; the arm ends 0.68 m ahead of the base's middle."""
CLEAR_M = 0.01
"""Distance that the arm keeps to everything."""
DOWN = math.pi
"""Tilt of a tool that points straight down."""
EASY_RAD = 0.35
"""A joint so far from its limits is counted as free of them."""
EASY_SINGULAR = 5.0 * SINGULAR
"""A least singular value from which on a configuration counts as well-conditioned."""
FLOOR_M = 6.0
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)
T_BASE_ARM = transform_matrix(ARM_ON_BASE_XYZ_M, _UPRIGHT)
"""The arm's frame in the base's: origin on the floor under the base's middle, x ahead."""


@dataclass(frozen=True, eq=False)
class ReachMap:
    """How well the cup gets to points of one height, seen from the base.

    Attributes:
        height_m: of the cup's face over the floor.
        lower: (2,) corner of the map, metres, base.
        quality: (n, n) along x and y: 0 out of reach, 1 far from limits and singular configurations.
    """

    height_m: float
    lower: FloatArray
    quality: FloatArray

    def reached(self) -> Tuple[FloatArray, FloatArray]:
        """Points (m, 2), metres, base, that are reached, and their quality (m,)."""
        cells = np.argwhere(self.quality > 0.0)
        return self.lower + CELL_M * (cells + 0.5), self.quality[self.quality > 0.0]


def base_solids() -> Tuple[Solid, ...]:
    """Collision solids of the base without its arm, base frame, as urdf/manipulation/youbot.urdf.xacro has them."""
    model = parse_urdf(expand_xacro(resource("urdf", "manipulation", "youbot.urdf.xacro")))
    parents = {joint.child: joint for joint in model.joints.values()}
    found: List[Solid] = []
    for solid in model.solids:
        pose, link = solid.pose, solid.link
        if link.startswith("arm_") or link == "suction_cup":
            continue
        while link in parents:
            pose, link = parents[link].T_parent_child @ pose, parents[link].parent
        found.append(Solid(solid.shape, solid.size, pose))
    return tuple(found)


@lru_cache(maxsize=1)
def own_body() -> Tuple[Obstacle, ...]:
    """What the arm has under itself wherever it goes, arm's frame: its own base and the floor."""
    T_arm_base = np.linalg.inv(T_BASE_ARM)
    floor = Solid(Shape.BOX, (FLOOR_M, FLOOR_M, 0.02), transform_matrix((0.0, 0.0, -0.01), _UPRIGHT))
    own = [Obstacle("base", solid.seen_from(T_arm_base)) for solid in base_solids()]
    return (*own, Obstacle("floor", floor.seen_from(T_arm_base)))


def cup_poses(xyz: FloatArray, tilts: Sequence[float]) -> Iterator[FloatArray]:
    """Poses (4, 4) of the cup's face at a point (3,), arm's frame, leaning from the arm's axis by each tilt, rad."""
    heading = math.atan2(float(xyz[1]), float(xyz[0]))
    for tilt in tilts:
        yield transform_matrix(xyz, quaternion_from_rpy(0.0, tilt, heading))


def quality(q: Joints) -> float:
    """How far a configuration is from the limits of joints 1 to 4 and from a singular one, 0 to 1."""
    room = min(min(v - low, high - v) for v, low, high in zip(q[:4], LOWER_RAD, UPPER_RAD))
    return min(1.0, room / EASY_RAD, singularity(q).sigma_min / EASY_SINGULAR)


@lru_cache(maxsize=None)
def reach_map(height_m: float, lift_m: float = 0.0, tilts: Tuple[float, ...] = (DOWN,)) -> ReachMap:
    """The map of one height; the model alone decides, so that it is made once.

    Args:
        height_m: of the cup's face over the floor.
        lift_m: the same cup must be held so much higher too.
        tilts: of the tool that will do, rad.
    """
    collision = YoubotCollision(own_body())
    count = round(2.0 * HALF_M / CELL_M)
    lower = np.full(2, -HALF_M)
    found = np.zeros((count, count))
    for x, y in np.ndindex(count, count):
        point = np.array([*(lower + CELL_M * (np.array((x, y)) + 0.5)), height_m]) - ARM_ON_BASE_XYZ_M
        if math.hypot(point[0], point[1]) < HALF_M:
            found[x, y] = min(_best(collision, point + np.array((0.0, 0.0, up)), tilts) for up in sorted({0.0, lift_m}))
    return ReachMap(height_m, lower, found)


def _best(collision: YoubotCollision, xyz: FloatArray, tilts: Sequence[float]) -> float:
    answers = [q for pose in cup_poses(xyz, tilts) for q in inverse(pose).solutions]
    return max((quality(q) for q in answers if collision.free(np.array(q), CLEAR_M)), default=0.0)
