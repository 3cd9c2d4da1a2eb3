"""The manipulator of the kinematic world: plays its real raster, pauses, lifts off and goes on where it stopped."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Tuple

import numpy as np

from yarm.experiments.study.clearance import SAMPLE_M
from yarm.geometry import FloatArray
from yarm.geometry.solids import surface_points
from yarm.geometry.urdf import Joint, UrdfModel

STOP_S = 0.3
"""Time from OFF to standing still, s."""
LIFT_S = 1.5
"""Time from the surface to the hover or back, s."""
PERIOD_S = 0.05
"""Time between two rows of a track, s."""


@dataclass(frozen=True, eq=False)
class ArmTrack:
    """A raster in time.

    Attributes:
        period_s: time between two rows, s.
        work: (n, 6) joints along the raster, rad.
        hover: (n, 6) joints lifted off along the tool's normal at the same place, rad.
    """

    period_s: float
    work: FloatArray
    hover: FloatArray

    @property
    def length_s(self) -> float:
        """Time from the first row to the last, s."""
        return self.period_s * (len(self.work) - 1)


class ArmModel:
    """Where the links are at given joints, and points all over them."""

    def __init__(self, model: UrdfModel, T_world_base: FloatArray, tip_link: str, spacing_m: float = SAMPLE_M) -> None:
        """An arm.

        Args:
            model: its description.
            T_world_base: (4, 4) pose of its root link.
            tip_link: link whose origin is the tool's tip.
            spacing_m: of the points on its links, metres.
        """
        self._T_world_base = T_world_base
        self._tip = tip_link
        self._root = model.links[0]
        self._chain = _from_root(model)
        self._index = {joint.name: i for i, joint in enumerate(model.moving_joints)}
        self._points: Dict[str, FloatArray] = {}
        for link in model.links:
            own = [solid for solid in model.solids if solid.link == link]
            if own:
                self._points[link] = surface_points(own, spacing_m)

    def links(self, q: FloatArray) -> Dict[str, FloatArray]:
        """Pose (4, 4), world, of each link at joints (6,), rad."""
        poses = {self._root: self._T_world_base}
        for joint in self._chain:
            pose = poses[joint.parent] @ joint.T_parent_child
            if joint.name in self._index:
                pose[:3, :3] = pose[:3, :3] @ _rotation(joint.axis, float(q[self._index[joint.name]]))
            poses[joint.child] = pose
        return poses

    def points(self, q: FloatArray) -> FloatArray:
        """Points (n, 3) on all links, metres, world."""
        poses = self.links(q)
        return np.concatenate([own @ poses[link][:3, :3].T + poses[link][:3, 3] for link, own in self._points.items()])

    def tip(self, q: FloatArray) -> Tuple[float, float, float]:
        """The tool's tip, metres, world."""
        x, y, z = self.links(q)[self._tip][:3, 3]
        return float(x), float(y), float(z)


def _from_root(model: UrdfModel) -> List[Joint]:
    """Joints in an order in which every parent's pose is known before its child's."""
    known, ordered, left = {model.links[0]}, [], list(model.joints.values())
    while left:
        joint = next(j for j in left if j.parent in known)
        left.remove(joint)
        known.add(joint.child)
        ordered.append(joint)
    return ordered


def _rotation(axis: Tuple[float, float, float], angle_rad: float) -> FloatArray:
    """Turn (3, 3) about an axis of length 1 (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turn: FloatArray = np.eye(3) + math.sin(angle_rad) * cross + (1.0 - math.cos(angle_rad)) * (cross @ cross)
    return turn


class ArmPlayer:
    """An arm at work on a track; over and over, from its end back to its start by way of the hover."""

    def __init__(self, model: ArmModel, track: ArmTrack, phase_s: float = 0.0) -> None:
        """At work.

        Args:
            model: the arm.
            track: what it does.
            phase_s: where in the track it begins, s.
        """
        self._model = model
        self._track = track
        self._at_s = phase_s % track.length_s
        self._lift = 0.0
        self._off_s = 0.0

    def step(self, dt_s: float, enabled: bool) -> None:
        """Go on by dt; sand when enabled, else stop, lift off and wait."""
        self._off_s = 0.0 if enabled else self._off_s + dt_s
        if enabled and self._lift > 0.0:
            self._lift = max(0.0, self._lift - dt_s / LIFT_S)
        elif self._off_s > STOP_S:
            self._lift = min(1.0, self._lift + dt_s / LIFT_S)
        else:
            self._at_s = (self._at_s + dt_s) % self._track.length_s

    def joints(self) -> FloatArray:
        """Joints (6,) now, rad."""
        row = min(int(self._at_s / self._track.period_s), len(self._track.work) - 1)
        q: FloatArray = (1.0 - self._lift) * self._track.work[row] + self._lift * self._track.hover[row]
        return q

    def points(self) -> FloatArray:
        """Points (n, 3) on its links, metres, world."""
        return self._model.points(self.joints())

    def tip(self) -> Tuple[float, float, float]:
        """Its tool's tip, metres, world."""
        return self._model.tip(self.joints())
