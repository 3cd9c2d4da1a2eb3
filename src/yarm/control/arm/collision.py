"""What the HC10 must not touch: stand, table with workpiece, and itself (PyBullet, without graphics or stepping)."""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

import pybullet

from yarm.control.arm.model import ArmDescription
from yarm.geometry.grid import FloatArray
from yarm.robots.hc10 import Box, station_boxes

SANDER_LINKS = ("sander",)
LINKS_ON_STAND = ("base_link", "base", "link_1_s")


@dataclass(frozen=True)
class Clearance:
    """Least distance found, metres (capped at what was asked for), and between whom."""

    distance_m: float
    between: str


class ArmCollision:
    """Distances between the arm, itself and the cell. Not thread-safe; ``close`` frees the physics client."""

    def __init__(self, arm: ArmDescription, boxes: Optional[Sequence[Box]] = None) -> None:
        """Load the arm and the boxes.

        Args:
            arm: the description.
            boxes: of the cell; None for those of its station.
        """
        self._client = pybullet.connect(pybullet.DIRECT)
        with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
            file.write(arm.urdf)
            file.flush()
            self._arm = pybullet.loadURDF(
                str(Path(file.name)), arm.base_xyz.tolist(), useFixedBase=True, physicsClientId=self._client
            )
        self._links, self._joints = self._index(arm)
        self._boxes = {box.name: self._add(box) for box in (station_boxes() if boxes is None else boxes)}
        self._pairs = self._own_pairs(arm)

    def clearance(self, q: FloatArray, within_m: float, sanding: bool = False) -> Clearance:
        """Least distance at a configuration.

        Args:
            q: joints (6,), rad.
            within_m: distances above this are not looked for.
            sanding: the tool may touch the part.
        """
        self._set(q)
        least = Clearance(within_m, "")
        for name, box in self._boxes.items():
            for point in pybullet.getClosestPoints(self._arm, box, within_m, physicsClientId=self._client):
                link = self._links[point[3]]
                allowed = (name == "stand" and link in LINKS_ON_STAND) or (
                    sanding and name == "part" and link in SANDER_LINKS
                )
                if point[8] < least.distance_m and not allowed:
                    least = Clearance(point[8], f"{link} and {name}")
        for a, b in self._pairs:
            for point in pybullet.getClosestPoints(self._arm, self._arm, within_m, a, b, physicsClientId=self._client):
                if point[8] < least.distance_m:
                    least = Clearance(point[8], f"{self._links[a]} and {self._links[b]}")
        return least

    def free(self, q: FloatArray, margin_m: float, sanding: bool = False) -> bool:
        """Whether everything is further away than a margin."""
        return self.clearance(q, margin_m, sanding).distance_m >= margin_m

    def close(self) -> None:
        """Free the physics client; the object is useless afterwards."""
        pybullet.disconnect(self._client)

    def _set(self, q: FloatArray) -> None:
        for joint, value in zip(self._joints, q):
            pybullet.resetJointState(self._arm, joint, float(value), physicsClientId=self._client)

    def _index(self, arm: ArmDescription) -> Tuple[Dict[int, str], List[int]]:
        links = {-1: arm.model.links[0]}
        joints = {}
        for index in range(pybullet.getNumJoints(self._arm, physicsClientId=self._client)):
            info = pybullet.getJointInfo(self._arm, index, physicsClientId=self._client)
            links[index] = info[12].decode()
            joints[info[1].decode()] = index
        return links, [joints[joint.name] for joint in arm.model.moving_joints]

    def _add(self, box: Box) -> int:
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[0.5 * s for s in box.size], physicsClientId=self._client
        )
        return int(
            pybullet.createMultiBody(
                baseCollisionShapeIndex=shape, basePosition=box.centre, physicsClientId=self._client
            )
        )

    def _own_pairs(self, arm: ArmDescription) -> List[Tuple[int, int]]:
        """Pairs of links with solids that are neither one rigid body nor neighbours."""
        order = [arm.model.links[0], *(joint.child for joint in arm.model.moving_joints)]
        solid = {s.link for s in arm.model.solids}
        place = {
            index: order.index(arm.model.rigid_group(name)[0]) for index, name in self._links.items() if name in solid
        }
        return [(a, b) for a, b in combinations(sorted(place), 2) if abs(place[a] - place[b]) > 1]
