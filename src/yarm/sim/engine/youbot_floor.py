"""A floor with debris, a bin and obstacles on it, and a youBot: a PyBullet world of its own."""

from __future__ import annotations

import math
from typing import Dict, List, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, transform_matrix
from yarm.robots.youbot import NAME
from yarm.sim.engine.bodies import load_box, load_floor, load_urdf, open_engine
from yarm.sim.robots.youbot import Youbot
from yarm.sim.scenes.bodies import description
from yarm.sim.scenes.youbot_floor import FloorScene

STEPS_PER_SECOND = 240
AT_REST_MPS = 0.01
DROP_M = 0.002
"""Debris begins so far over the floor."""


class YoubotFloor:
    """The world. Close it, or use it as a context manager."""

    def __init__(self, scene: FloorScene, joints: FloatArray, seed: int = 0) -> None:
        """Put everything there.

        Args:
            scene: who stands where.
            joints: of the arm at the start, mechanical angles (5,), rad.
            seed: of the slip.
        """
        self.scene = scene
        self.client = open_engine(STEPS_PER_SECOND)
        self._names: Dict[int, str] = {load_floor(self.client): "floor"}
        for name, box in scene.boxes():
            yaw = math.atan2(box.pose[1, 0], box.pose[0, 0])
            self._names[load_box(self.client, box.size, box.pose[:3, 3].tolist(), yaw)] = name
        self._pieces: Dict[str, int] = {}
        text, _ = description("debris.urdf.xacro")
        for piece in scene.debris:
            height = 0.5 * piece.height_m + DROP_M
            uid = load_urdf(self.client, text, (piece.x, piece.y, height), piece.yaw_rad, fixed=False)
            pybullet.changeDynamics(uid, -1, mass=piece.mass_kg, frictionAnchor=1, physicsClientId=self.client)
            self._pieces[piece.name], self._names[uid] = uid, piece.name
        self.robot = Youbot(self.client, scene.start, joints, np.random.default_rng(seed))
        self._steps = 0
        self.touched: Dict[Tuple[str, str], float] = {}

    def __enter__(self) -> YoubotFloor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the engine."""
        pybullet.disconnect(physicsClientId=self.client)

    @property
    def time_s(self) -> float:
        """Simulated time, s."""
        return self._steps / STEPS_PER_SECOND

    def step(self) -> None:
        """One physics step; what touches the robot is noted with its greatest force, N."""
        self.robot.update()
        pybullet.stepSimulation(physicsClientId=self.client)
        self._steps += 1
        for link, body, force in self.robot.touching():
            key = (link, self._names.get(body, NAME))
            self.touched[key] = max(self.touched.get(key, 0.0), force)

    def piece(self, name: str) -> FloatArray:
        """T_world_piece (4, 4) of a piece's middle."""
        at = self.piece_pose(name)
        return np.asarray(transform_matrix(at[:3], at[3:]))

    def piece_pose(self, name: str) -> Tuple[float, ...]:
        """The same as x, y, z, metres, and a quaternion x, y, z, w."""
        at = pybullet.getBasePositionAndOrientation(self._pieces[name], physicsClientId=self.client)
        # The engine speaks of the centre of mass, which lies under the middle.
        info = pybullet.getDynamicsInfo(self._pieces[name], -1, physicsClientId=self.client)
        middle = pybullet.multiplyTransforms(*at, *pybullet.invertTransform(info[3], info[4]))
        return (*middle[0], *middle[1])

    def held(self) -> str:
        """Name of the piece that hangs on the cup; empty without one."""
        uid = self.robot.cup.held_uid
        return "" if uid is None else self._names[uid]

    def in_bin(self, name: str) -> bool:
        """Whether a piece lies in the bin: its middle inside, at rest, nothing holding it."""
        inside = np.linalg.inv(self.scene.bin.pose) @ self.piece(name)[:, 3]
        width, depth, height = self.scene.bin.size
        speed = pybullet.getBaseVelocity(self._pieces[name], physicsClientId=self.client)[0]
        return bool(
            abs(inside[0]) < 0.5 * width
            and abs(inside[1]) < 0.5 * depth
            and 0.0 < inside[2] < height
            and np.linalg.norm(speed) < AT_REST_MPS
            and self.held() != name
        )

    def wrong_touches(self) -> List[str]:
        """Touches that must not be: all but wheels on the floor, and the cup on debris; its own links never."""
        pieces = {piece.name for piece in self.scene.debris}
        return [
            f"{link} and {other}, {force:.0f} N"
            for (link, other), force in self.touched.items()
            if not (link.startswith("wheel_") and other == "floor") and not (link == "suction_cup" and other in pieces)
        ]
