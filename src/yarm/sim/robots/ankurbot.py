"""The mobile robot in PyBullet: its motors, its frames."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, List, Tuple

import numpy as np
import pybullet

from yarm.geometry import FloatArray, transform_matrix, wrap_angle
from yarm.robots.ankurbot import CASTERS, LIFT_JOINT, LIFT_LINKS, WHEEL_RADIUS_M
from yarm.sim.engine.bodies import com_offset, link_names, load_urdf
from yarm.sim.robots.drive import wheel_speeds
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.hand import LIFT_SHARES, SuctionHand
from yarm.sim.robots.wheels import Wheels
from yarm.sim.scenes.bodies import ankurbot_description, mobile_body
from yarm.sim.scenes.specs import RobotSpec

CASTER_TORQUE_NM = 50.0
CASTER_SPEED_RPS = 12.0
WHEEL_TORQUE_NM = 20.0


@dataclass(frozen=True)
class CasterReading:
    """One caster's controller: commanded and measured angle, rad, speed, rad/s, and motor torque, N m."""

    set_point: float
    angle: float
    speed: float
    torque: float


class Ankurbot:
    """Four steered, driven casters under a body with a fixed arm. Moves only through its wheels."""

    def __init__(self, client: int, spec: RobotSpec, hands: bool = False) -> None:
        """Put the robot on the floor.

        Args:
            client: PyBullet's number of the world.
            spec: which, where, with its arm in which direction.
            hands: it carries a hand, drawn up, whatever its type.
        """
        hand = hands or spec.has_hand
        text, model = ankurbot_description(hand)
        self._client = client
        self.uid = load_urdf(client, text, (spec.x, spec.y, 0.0), spec.heading_rad, fixed=False)
        self._T_com_root = np.linalg.inv(com_offset(client, self.uid))
        names = link_names(client, self.uid)
        self._casters = [names.index(f"{caster}_caster") for caster in CASTERS]
        self._wheel_joints = [names.index(f"{caster}_wheel") for caster in CASTERS]
        self._T_base_ee = model.rigid_group("ee")[1]
        self.reach_m = float(self._T_base_ee[0, 3])
        self.body = replace(mobile_body(spec, hands), uids=(self.uid,))
        self._set_points = np.zeros(4)
        self._drive = (0.0, 0.0)
        self.hand = SuctionHand(client, self.uid, names, model) if hand else None
        for caster in range(4):
            self._steer_motor(caster)
        self._wheels = Wheels(client, self.uid, self._wheel_joints, WHEEL_RADIUS_M, WHEEL_TORQUE_NM)

    def steer(self, caster: str, angle_rad: float) -> bool:
        """Command one caster's angle, clamped to [-pi, pi]; true when it had to be clamped.

        Raises:
            CommandError: not finite.
        """
        if not math.isfinite(angle_rad):
            raise CommandError(f"caster {caster}: angle {angle_rad} must be a finite number of rad")
        index = CASTERS.index(caster)
        clamped = min(max(angle_rad, -math.pi), math.pi)
        if clamped != self._set_points[index]:
            self._set_points[index] = clamped
            self._steer_motor(index)
        return abs(clamped - angle_rad) > 1e-6

    def drive(self, speed_mps: float, yaw_rate_rps: float, limit_mps: float) -> bool:
        """Command drive speed and yaw rate; wheel speeds are limited, m/s; true when the drive speed was clamped.

        Raises:
            CommandError: not finite.
        """
        if not (math.isfinite(speed_mps) and math.isfinite(yaw_rate_rps)):
            raise CommandError(f"drive speed {speed_mps} m/s and yaw rate {yaw_rate_rps} rad/s must be finite numbers")
        clamped = min(max(speed_mps, -limit_mps), limit_mps)
        self._drive = (clamped, yaw_rate_rps)
        return clamped != speed_mps

    def update(self, dt_s: float, acceleration: float, limit_mps: float) -> bool:
        """Once a tick: wheel speeds from the command and the measured casters, ramped by ``acceleration`` m/s^2.

        Returns:
            false when a yaw rate is commanded while the wheels are parallel, so that it means nothing.
        """
        if self.hand is not None:
            self.hand.update(dt_s)
        if self._drive == (0.0, 0.0) and not np.any(self._wheels.speeds_mps):
            return True
        result = wheel_speeds(self.caster_angles(), *self._drive)
        wanted = result.speeds_mps
        fastest = float(np.max(np.abs(wanted)))
        if fastest > limit_mps:
            wanted = wanted * (limit_mps / fastest)
        self._wheels.ramp_to(wanted, acceleration * dt_s)
        return result.has_centre

    def caster_angles(self) -> FloatArray:
        """Measured caster angles (4,), rad."""
        states = pybullet.getJointStates(self.uid, self._casters, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def caster_readings(self) -> List[CasterReading]:
        """State of each caster's controller, in the order of CASTERS."""
        states = pybullet.getJointStates(self.uid, self._casters, physicsClientId=self._client)
        return [CasterReading(float(goal), s[0], s[1], s[3]) for goal, s in zip(self._set_points, states)]

    def joint_readings(self) -> Tuple[List[str], List[float], List[float]]:
        """Names, positions (rad, wheels wrapped), speeds (rad/s) of casters, wheels and a hand's lift (m, m/s)."""
        states = pybullet.getJointStates(self.uid, self._casters + self._wheel_joints, physicsClientId=self._client)
        names = [f"{c}_caster_joint" for c in CASTERS] + [f"{c}_wheel_joint" for c in CASTERS]
        positions, speeds = [wrap_angle(state[0]) for state in states], [state[1] for state in states]
        if self.hand is None:
            return names, positions, speeds
        return [*names, LIFT_JOINT], [*positions, self.hand.lift_m], [*speeds, self.hand.lift_speed_mps]

    def transforms(self) -> Dict[str, FloatArray]:
        """T_world_frame (4, 4) of its frames."""
        position, quaternion = pybullet.getBasePositionAndOrientation(self.uid, physicsClientId=self._client)
        T_world_base = transform_matrix(position, quaternion) @ self._T_com_root
        name, T_world_ee = self.body.name, T_world_base @ self._T_base_ee
        frames = {f"{name}/base_link": T_world_base, f"{name}/ee": T_world_ee}
        if self.hand is not None:
            down_m = self.hand.lift_m
            for link, height_m in LIFT_LINKS.items():
                frames[f"{name}/{link}"] = T_world_link = T_world_ee.copy()
                T_world_link[:3, 3] += (height_m - LIFT_SHARES[link] * down_m) * T_world_ee[:3, 2]
        return frames

    def _steer_motor(self, index: int) -> None:
        pybullet.setJointMotorControl2(
            self.uid,
            self._casters[index],
            pybullet.POSITION_CONTROL,
            targetPosition=float(self._set_points[index]),
            force=CASTER_TORQUE_NM,
            maxVelocity=CASTER_SPEED_RPS,
            physicsClientId=self._client,
        )
