"""Cartesian velocity of the tip from joystick axes, within the joints' limits and clear of everything."""

from __future__ import annotations

from typing import List, Optional, Tuple

import numpy as np

from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.params import SanderParams
from yarm.control.sander.planner import SanderPlanner
from yarm.geometry.grid import FloatArray

STALE_S = 0.5
AHEAD_S = 0.1
DAMPING = 0.02
DEAD_ZONE = 0.02


class Teleoperation:
    """Integrates axes into short motions."""

    def __init__(self, planner: SanderPlanner, params: SanderParams) -> None:
        """At rest.

        Args:
            planner: kinematics and collision model.
            params: speeds of fully pushed axes.
        """
        self._planner = planner
        self._params = params
        self._q: FloatArray = planner.arm.storage
        self._velocity = np.zeros(6)
        self._heard_s = -np.inf
        self._last_s = 0.0
        self.reason = ""

    def start(self, q: FloatArray) -> None:
        """Begin at measured joints (6,), rad."""
        self._q = q.copy()
        self._velocity = np.zeros(6)
        self._heard_s = -np.inf
        self.reason = ""

    def step(
        self, q: FloatArray, axes: Optional[Tuple[float, float, float, float]], stamp_s: float
    ) -> Optional[ArmMotion]:
        """A short motion to send, or None.

        Args:
            q: measured joints (6,), rad.
            axes: x, y, z, turn about world z, -1 to 1; None when nothing new has come.
            stamp_s: time of the reading.
        """
        dt_s = min(max(stamp_s - self._last_s, 0.0), 0.1)
        self._last_s = stamp_s
        was_moving = bool(np.any(self._velocity))
        if axes is not None:
            self._velocity, self._heard_s = self._wanted(axes), stamp_s
        elif stamp_s - self._heard_s > STALE_S:
            self._velocity = np.zeros(6)
        if not np.any(self._velocity):
            if was_moving:
                return _motion(self._q, self._q)
            self._q = q.copy()
            return None
        return self._moved(dt_s)

    def halt(self, q: FloatArray) -> List[ArmMotion]:
        """Stand still at once: the motion to send when it moves, else none; the axes must be pushed again."""
        if not np.any(self._velocity):
            return []
        self.start(q)
        return [_motion(q, q)]

    def _wanted(self, axes: Tuple[float, float, float, float]) -> FloatArray:
        pushed = np.clip(np.nan_to_num(np.array(axes)), -1.0, 1.0)
        pushed[np.abs(pushed) < DEAD_ZONE] = 0.0
        linear, turn = self._params.teleoperation_mps, self._params.teleoperation_radps
        return np.concatenate([pushed[:3] * linear, [0.0, 0.0, pushed[3] * turn]])

    def _moved(self, dt_s: float) -> Optional[ArmMotion]:
        jacobian = self._planner.kinematics.jacobian(self._q)
        speeds = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + DAMPING**2 * np.eye(6), self._velocity)
        limits = self._planner.arm.limits
        speeds = speeds / max(1.0, float(np.max(np.abs(speeds) / (0.5 * limits.speed))))
        here, ahead = self._q + speeds * dt_s, self._q + speeds * (dt_s + AHEAD_S)
        if not limits.contain(ahead):
            return self._refused("a joint's limit is reached")
        clearance = self._planner.collision.clearance(ahead, self._params.margin_m)
        if clearance.distance_m < self._params.margin_m:
            return self._refused(f"{clearance.between} would be {clearance.distance_m:.3f} m apart")
        self.reason = ""
        self._q = here
        return _motion(here, ahead)

    def _refused(self, reason: str) -> ArmMotion:
        self.reason = f"teleoperation stopped: {reason}"
        self._velocity = np.zeros(6)
        return _motion(self._q, self._q)


def _motion(here: FloatArray, ahead: FloatArray) -> ArmMotion:
    return ArmMotion(np.array([0.0, AHEAD_S]), np.array([here, ahead]), np.zeros(2))
