"""Clouds of the simulated overhead cameras for the tests of their poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Tuple

import numpy as np
from scipy.spatial.transform import Rotation

from yarm.geometry import FloatArray
from yarm.geometry.solids import Solid
from yarm.sim.engine.world import SimWorld
from yarm.sim.scenes.scene import load_scene
from yarm.sim.sensors.cameras import Eyes

CAMERAS = (1, 2, 3, 4)


@dataclass(frozen=True, eq=False)
class Cell:
    """A simulated cell at rest, its known solids and its cameras."""

    eyes: Eyes
    bodies: dict
    transforms: dict
    static: Tuple[Solid, ...]
    moving: Tuple[Solid, ...]

    def cloud(self, camera: int, frame: int) -> FloatArray:
        """Points (n, 3) of a camera, optical frame; NaN where nothing is in range."""
        cloud = self.eyes.overhead_cloud(camera, self.transforms, frame)
        return np.stack([cloud["x"], cloud["y"], cloud["z"]], axis=-1).reshape(-1, 3).astype(float)

    def true_pose(self, camera: int) -> FloatArray:
        """T_world_optical."""
        return self.eyes.overhead_poses[camera - 1]


def cell(scene: str, seed: int = 1) -> Cell:
    """A shipped scene at its start, with noise."""
    world = SimWorld(load_scene(scene))
    world.run(0.1)
    eyes, poses = Eyes(seed, noise=True), dict(world.transforms())
    eyes.look_at(world.bodies, poses)
    static, moving = [], []
    for body in world.bodies.values():
        for item in body.solids:
            solid = Solid(item.solid.shape, item.solid.size, poses[item.frame] @ item.T_frame_solid)
            (moving if body.dynamic else static).append(solid)
    world.close()
    return Cell(eyes, dict(world.bodies), poses, tuple(static), tuple(moving))


def off_by(pose: FloatArray, rng: np.random.Generator, shift_m: float, turn_deg: float) -> FloatArray:
    """A pose shifted and turned by so much in a random direction and about a random axis."""
    direction, axis = rng.normal(size=3), rng.normal(size=3)
    moved = pose.copy()
    turn = Rotation.from_rotvec(math.radians(turn_deg) * axis / np.linalg.norm(axis))
    moved[:3, :3] = pose[:3, :3] @ turn.as_matrix()
    moved[:3, 3] += shift_m * direction / np.linalg.norm(direction)
    return moved


def apart(one: FloatArray, other: FloatArray) -> Tuple[float, float]:
    """How far two poses are apart, metres and degrees."""
    difference = np.linalg.inv(one) @ other
    turn = Rotation.from_matrix(difference[:3, :3]).as_rotvec()
    return float(np.linalg.norm(difference[:3, 3])), math.degrees(float(np.linalg.norm(turn)))
