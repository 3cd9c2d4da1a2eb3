"""Driven wheels in PyBullet: speeds that are ramped, motors that hold at rest."""

from __future__ import annotations

from typing import Sequence

import numpy as np
import pybullet

from yarm.geometry import FloatArray


class Wheels:
    """The driven wheels of one robot.

    Attributes:
        speeds_mps: (n,) speed of each wheel's rim that its motor is set to, m/s.
    """

    def __init__(self, client: int, uid: int, joints: Sequence[int], radius_m: float, torque_nm: float) -> None:
        """Hold the wheels still.

        Args:
            client: PyBullet's number of the world.
            uid: PyBullet's number of the robot.
            joints: PyBullet's number of each wheel's joint.
            radius_m: of a wheel.
            torque_nm: greatest torque of a motor.
        """
        self._client, self._uid, self._joints = client, uid, list(joints)
        self._radius_m = radius_m
        self._forces = [torque_nm] * len(self._joints)
        self.speeds_mps: FloatArray = np.zeros(len(self._joints))
        self._drive()

    def ramp_to(self, wanted_mps: FloatArray, step_mps: float) -> None:
        """Move the speeds (n,) towards wanted ones, the largest change by ``step_mps``, the others in proportion."""
        change = wanted_mps - self.speeds_mps
        largest = float(np.max(np.abs(change)))
        self.speeds_mps = wanted_mps.copy() if largest <= step_mps else self.speeds_mps + change * (step_mps / largest)
        self._drive()

    def angles(self) -> FloatArray:
        """(n,) angle that each wheel has turned by, rad."""
        states = pybullet.getJointStates(self._uid, self._joints, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def _drive(self) -> None:
        if not np.any(self.speeds_mps):
            self._brake()
            return
        pybullet.setJointMotorControlArray(
            self._uid,
            self._joints,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=(self.speeds_mps / self._radius_m).tolist(),
            forces=self._forces,
            physicsClientId=self._client,
        )

    def _brake(self) -> None:
        """Hold the wheels at their angles: a motor that only holds speed 0 creeps by some mm a minute."""
        pybullet.setJointMotorControlArray(
            self._uid,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=self.angles().tolist(),
            forces=self._forces,
            physicsClientId=self._client,
        )
