"""What the youBot's arm must not touch, obstacles and itself: distances by FCL (Pan, Chitta, Manocha, ICRA 2012).

Where the package is built, the question planners ask most, whether a configuration is free, is answered in C++
(``clearance_native``): the same FCL on the same solids, without the way through Python.

The links are the collision solids of urdf/manipulation/youbot.urdf.xacro. Obstacles stand in a tree of boxes, so that a
configuration costs about as much among ten of them as among one.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Tuple

import fcl
import numpy as np

from yarm.control.arm.collision import Clearance
from yarm.geometry import FloatArray
from yarm.geometry.solids import Solid
from yarm.geometry.urdf import UrdfModel, expand_xacro, parse_urdf
from yarm.manipulation.motion.checkpoints import Obstacle
from yarm.manipulation.obstacles.clearance_native import ArmBody, NativeClearance, library_path
from yarm.manipulation.obstacles.fcl_bodies import fcl_geometry, fcl_manager, fcl_object
from yarm.resources import resource
from yarm.robots.youbot import (
    FOREARM_M,
    JOINT_NAMES,
    SHOULDER_AHEAD_M,
    SHOULDER_HEIGHT_M,
    UPPER_ARM_M,
    WRIST_ASIDE_M,
    urdf_angles,
)

LINK_2_OVER_LINK_1_M = 0.019
LINK_5_OVER_LINK_4_M = 0.130
"""Between origins of the URDF's links where the kinematics need none."""

LOAD = "load"
"""Name of what hangs on the cup, in answers."""
LINK_4 = 4


@lru_cache(maxsize=1)
def arm_description() -> Tuple[str, UrdfModel]:
    """URDF text and content of the arm alone; its root is the arm's frame."""
    text = expand_xacro(resource("urdf", "manipulation", "youbot.urdf.xacro"), base="false")
    return text, parse_urdf(text)


def separate_links(model: UrdfModel) -> Tuple[Tuple[str, str], ...]:
    """Pairs of links with solids that are neither one rigid body nor neighbours: those that must not touch."""
    order = _order(model)
    place = {solid.link: order.index(model.rigid_group(solid.link)[0]) for solid in model.solids}
    return tuple((a, b) for a, b in combinations(place, 2) if abs(place[a] - place[b]) > 1)


def _order(model: UrdfModel) -> List[str]:
    """The arm's frame, and the links that each joint moves."""
    return [model.rigid_group("arm_link_0")[0], *(model.joints[name].child for name in JOINT_NAMES)]


class YoubotCollision:
    """Distances of the arm to obstacles and to itself. Not thread-safe."""

    def __init__(
        self, obstacles: Sequence[Obstacle], library: Optional[Path] = None, load: Optional[Solid] = None
    ) -> None:
        """Build both.

        Args:
            obstacles: in the arm's frame; they stay where they are.
            library: of the C++ distances; None for the one that is built, if any is.
            load: what hangs on the cup, in arm_link_5's frame.
        """
        _, model = arm_description()
        order = _order(model)
        self._names: Dict[int, str] = {}
        self._links: List[Tuple[int, FloatArray, Any]] = []
        for solid in model.solids:
            group, T_group_link = model.rigid_group(solid.link)
            self._links.append((order.index(group), T_group_link @ solid.pose, self._object(solid, solid.link)))
        carried: List[Solid] = list(model.solids)
        if load is not None:
            self._links.append((len(order) - 1, load.pose, self._object(load, LOAD)))
            carried.append(load)
        self._order = np.array([index for index, _, _ in self._links])
        self._solids = np.array([pose for _, pose, _ in self._links])
        separate = separate_links(model)
        owners = [solid.link for solid in model.solids]
        self._pairs = np.array(
            [(a, b) for a, b in combinations(range(len(owners)), 2) if (owners[a], owners[b]) in separate]
        )
        if load is not None:
            # Link 4 is a hand's length off, and what hangs on link 5 moves with it.
            own = [(index, len(owners)) for index, place in enumerate(self._order[:-1]) if place < LINK_4]
            self._pairs = np.vstack([self._pairs, own])
        radii = np.array([np.linalg.norm(solid.half_extent) for solid in carried])
        self._pair_radii = radii[self._pairs].sum(axis=1)
        # What is bolted down stands where it stands: it is no obstacle's fault.
        self._arm = fcl_manager([item for index, _, item in self._links if index > 0])
        self._obstacles = fcl_manager([self._object(obstacle.solid, obstacle.name) for obstacle in obstacles])
        self._empty = not obstacles
        path = library or library_path()
        self._native = (
            None if path is None else NativeClearance(path, self._body(model, carried), [o.solid for o in obstacles])
        )

    def clearance(self, q: FloatArray, within_m: float) -> Clearance:
        """Least distance at a configuration, 0 where something overlaps.

        Args:
            q: joints (5,), rad.
            within_m: distances above this are not looked for.
        """
        centres = self._set(q)
        least = Clearance(within_m, "")
        if not self._empty:
            data = fcl.DistanceData()
            self._arm.distance(self._obstacles, data, fcl.defaultDistanceCallback)
            least = self._less(least, data.result)
        request = fcl.DistanceRequest()
        between = centres[self._pairs[:, 0]] - centres[self._pairs[:, 1]]
        gaps = np.sqrt(np.einsum("ij,ij->i", between, between)) - self._pair_radii
        for a, b in self._pairs[gaps < least.distance_m]:
            result = fcl.DistanceResult()
            fcl.distance(self._links[a][2], self._links[b][2], request, result)
            least = self._less(least, result)
        return least

    def free(self, q: FloatArray, margin_m: float) -> bool:
        """Whether everything is further away than a margin."""
        if self._native is not None:
            return self._native.clearance(urdf_angles(q), margin_m) >= margin_m
        return self.clearance(q, margin_m).distance_m >= margin_m

    def _body(self, model: UrdfModel, carried: Sequence[Solid]) -> ArmBody:
        joints = [model.joints[name] for name in JOINT_NAMES]
        placed = [joint.T_parent_child for joint in joints]
        placed[0] = model.rigid_group(joints[0].parent)[1] @ placed[0]
        solids = [Solid(s.shape, s.size, pose) for s, pose in zip(carried, self._solids)]
        axes = np.array([joint.axis for joint in joints], dtype=float)
        return ArmBody(np.array(placed), axes, solids, self._order, self._pairs)

    def _less(self, least: Clearance, result: Any) -> Clearance:
        distance = max(float(result.min_distance), 0.0)
        if distance >= least.distance_m:
            return least
        names = [self._names.get(id(geometry), "?") for geometry in (result.o1, result.o2)]
        return Clearance(distance, " and ".join(names))

    def _object(self, solid: Solid, name: str) -> Any:
        geometry = fcl_geometry(solid)
        self._names[id(geometry)] = name
        return fcl_object(geometry, solid.pose)

    def _set(self, q: FloatArray) -> FloatArray:
        """Put every solid where it is; their centres (n, 3)."""
        rotations, origins = (part[self._order] for part in link_poses(q))
        turned = rotations @ self._solids[:, :3, :3]
        moved = np.einsum("nij,nj->ni", rotations, self._solids[:, :3, 3]) + origins
        for (_, _, item), rotation, origin in zip(self._links, turned, moved):
            item.setTransform(fcl.Transform(rotation, origin))
        self._arm.update()
        return np.asarray(moved)


def link_poses(q: FloatArray) -> Tuple[FloatArray, FloatArray]:
    """Rotations (6, 3, 3) and origins (6, 3) of the arm's frame and arm_link_1 to arm_link_5, in the arm's frame.

    In the candle every link's axes are the arm's frame's: the URDF's chain in closed form (a test compares).

    Args:
        q: mechanical angles (5,), rad.
    """
    q1, q2, q3, q4, q5 = (float(v) for v in q)
    c1, s1, c5, s5 = math.cos(q1), math.sin(q1), math.cos(q5), math.sin(q5)
    rotations, origins = np.zeros((6, 3, 3)), np.zeros((6, 3))
    rotations[0] = np.eye(3)
    rotations[1] = (c1, -s1, 0.0), (s1, c1, 0.0), (0.0, 0.0, 1.0)
    out, up = SHOULDER_AHEAD_M, SHOULDER_HEIGHT_M
    origins[1, 2] = SHOULDER_HEIGHT_M - LINK_2_OVER_LINK_1_M
    angle = 0.0
    for link, turn, length in ((2, q2, UPPER_ARM_M), (3, q3, FOREARM_M), (4, q4, LINK_5_OVER_LINK_4_M)):
        angle += turn
        c, s = math.cos(angle), math.sin(angle)
        rotations[link] = (c1 * c, -s1, c1 * s), (s1 * c, c1, s1 * s), (-s, 0.0, c)
        origins[link] = c1 * out, s1 * out, up
        out, up = out + length * s, up + length * c
    out, up = out + WRIST_ASIDE_M * c, up - WRIST_ASIDE_M * s
    rotations[5] = rotations[4] @ np.array(((c5, s5, 0.0), (-s5, c5, 0.0), (0.0, 0.0, 1.0)))
    origins[5] = c1 * out, s1 * out, up
    return rotations, origins
