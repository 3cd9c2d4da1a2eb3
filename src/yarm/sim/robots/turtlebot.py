"""The TurtleBot in PyBullet: two motors, a bumper that feels, a watchdog."""

from __future__ import annotations

import math
from typing import FrozenSet, Set, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, Pose2, transform_matrix, wrap_angle
from yarm.robots import turtlebot
from yarm.robots.turtlebot import Bumper
from yarm.sim.engine.bodies import com_offset, link_names, load_urdf
from yarm.sim.robots.bumper import Point, pressed_sectors
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.wheels import Wheels
from yarm.sim.scenes.bodies import description

BODY = -1
"""PyBullet's number of base_link, the root."""
LET_GO_M = 0.001
"""A sector that is pressed stays so until what pressed it is farther away than this."""


class TurtleBot:
    """A Kobuki base with its plates. Moves only through its two wheels."""

    def __init__(self, client: int, start: Pose2) -> None:
        """Put the robot on the floor with its base at a pose, world."""
        text, _ = description("turtlebot.urdf.xacro", "body", "exploration")
        self._client = client
        position = (start.x, start.y, turtlebot.BASE_LINK_Z_M)
        self.uid = load_urdf(client, text, position, start.yaw_rad, fixed=False, round_sides=True)
        self._T_com_root = np.linalg.inv(com_offset(client, self.uid))
        self.links = link_names(client, self.uid)
        joints = [self.links.index(link) for link in ("left_wheel", "right_wheel")]
        self._wheels = Wheels(client, self.uid, joints, turtlebot.WHEEL_RADIUS_M, turtlebot.WHEEL_TORQUE_NM)
        self._wanted_mps: FloatArray = np.zeros(2)
        self._told_s = -math.inf
        self._touched: Set[Point] = set()
        self._near: Set[Point] = set()
        self._pressed: FrozenSet[Bumper] = frozenset()

    def drive(self, v_mps: float, w_radps: float, now_s: float) -> bool:
        """Command speed ahead and turning, + = left, at a time, s; true when one had to be clamped to its limit.

        Raises:
            CommandError: not finite.
        """
        if not (math.isfinite(v_mps) and math.isfinite(w_radps)):
            raise CommandError(f"speed {v_mps} m/s and turning {w_radps} rad/s must be finite numbers")
        v = min(max(v_mps, -turtlebot.SPEED_LIMIT_MPS), turtlebot.SPEED_LIMIT_MPS)
        w = min(max(w_radps, -turtlebot.TURN_LIMIT_RADPS), turtlebot.TURN_LIMIT_RADPS)
        self._wanted_mps = v + 0.5 * turtlebot.WHEEL_BASE_M * w * np.array([-1.0, 1.0])
        self._told_s = now_s
        return (v, w) != (v_mps, w_radps)

    def update(self, now_s: float, dt_s: float, acceleration: float) -> None:
        """Once a tick: ramp the wheels, by ``acceleration`` m/s^2 at most; stop when nothing was said for too long."""
        if now_s - self._told_s > turtlebot.COMMAND_TIMEOUT_S:
            self._wanted_mps = np.zeros(2)
        if np.any(self._wanted_mps) or np.any(self._wheels.speeds_mps):
            self._wheels.ramp_to(self._wanted_mps, acceleration * dt_s)

    def rolled_m(self) -> FloatArray:
        """(2,) what the left and the right wheel have rolled since the start, by their encoders, metres."""
        ticks = np.round(self._wheels.angles() / turtlebot.WHEEL_TICK_RAD)
        rolled: FloatArray = ticks * (turtlebot.WHEEL_TICK_RAD * turtlebot.WHEEL_RADIUS_M)
        return rolled

    def wheel_readings(self) -> Tuple[FloatArray, FloatArray]:
        """Angles (2,), rad, wrapped, and speeds (2,) of the rims that the motors are set to, m/s."""
        return np.array([wrap_angle(float(angle)) for angle in self._wheels.angles()]), self._wheels.speeds_mps

    def feel(self) -> None:
        """Once a physics step: note what touches the body."""
        for point in pybullet.getContactPoints(bodyA=self.uid, linkIndexA=BODY, physicsClientId=self._client):
            if point[8] <= LET_GO_M:
                (self._touched if point[8] <= 0.0 else self._near).add(point[5])

    def pressed(self) -> FrozenSet[Bumper]:
        """Sectors of the bumper that were touched since the last call, or not yet let go."""
        pose = self.pose()
        kept = self._pressed & pressed_sectors(pose, self._near)
        self._pressed = kept | pressed_sectors(pose, self._touched)
        self._touched, self._near = set(), set()
        return self._pressed

    def base(self) -> FloatArray:
        """T_world_base (4, 4) of base_link."""
        position, quaternion = pybullet.getBasePositionAndOrientation(self.uid, physicsClientId=self._client)
        T_world_base: FloatArray = transform_matrix(position, quaternion) @ self._T_com_root
        return T_world_base

    def pose(self) -> Pose2:
        """Of base_footprint, world: under base_link, on the floor."""
        T_world_base = self.base()
        heading = math.atan2(T_world_base[1, 0], T_world_base[0, 0])
        return Pose2(float(T_world_base[0, 3]), float(T_world_base[1, 3]), heading)

    def speed(self) -> Tuple[float, float]:
        """True speed ahead, m/s, + = forward, and turning, rad/s."""
        (vx, vy, _), (_, _, w) = pybullet.getBaseVelocity(self.uid, physicsClientId=self._client)
        pose = self.pose()
        # The engine speaks of the centre of mass, a little behind the axle: turning moves it aside, not ahead.
        return vx * math.cos(pose.yaw_rad) + vy * math.sin(pose.yaw_rad), float(w)
