"""The ankurbot's hand in PyBullet: a lift that goes down from the arm's tip, and a suction cup at its end."""

from __future__ import annotations

import math
from typing import List, Tuple

import numpy as np
import pybullet

from yarm.geometry.urdf import UrdfModel
from yarm.robots.ankurbot import LIFT_JOINT
from yarm.sim.robots.errors import CommandError
from yarm.sim.robots.suction import HOLDING_N, SuctionCup

LIFT_SPEED_MPS = 0.15
"""Speed at which the set-point of the lift goes to where it is commanded."""
PRESSING_FORCE_N = 20.0
"""Greatest force of the lift; with the hand's weight less than the 30 N that a piece must never feel."""


LIFT_SHARES = {"hand": 1.0, "stage": 0.5}
"""How far links of the telescope go down, as shares of the lift's way."""


class SuctionHand(SuctionCup):
    """Lift and cup of one robot. ``update`` once a tick."""

    def __init__(self, client: int, uid: int, names: List[str], model: UrdfModel, holding_n: float = HOLDING_N) -> None:
        """Draw the hand up.

        Args:
            client: PyBullet's number of the world.
            uid: of the robot.
            names: its link names by PyBullet's index.
            model: its description.
            holding_n: force with which the cup holds.
        """
        self._hand, self._stage = (names.index(link) for link in LIFT_SHARES)
        super().__init__(client, uid, self._hand, np.eye(4), holding_n)
        self.stroke_m = model.joints[LIFT_JOINT].upper
        self._wanted_m = self._set_m = 0.0
        self._motors()

    @property
    def lift_m(self) -> float:
        """How far down the cup really is, metres."""
        return self._lift()[0]

    @property
    def lift_speed_mps(self) -> float:
        """How fast the cup goes down, m/s."""
        return self._lift()[1]

    def lift_to(self, down_m: float) -> None:
        """Command the lift, metres down from drawn up.

        Raises:
            CommandError: not finite, or beyond the stroke.
        """
        if not math.isfinite(down_m) or not 0.0 <= down_m <= self.stroke_m:
            raise CommandError(f"lift {down_m} m must be within 0 to {self.stroke_m:g} m")
        self._wanted_m = down_m

    def update(self, dt_s: float) -> None:
        """Move the set-point on; take, hold or lose."""
        if self._set_m != self._wanted_m:
            step = LIFT_SPEED_MPS * dt_s
            self._set_m += min(max(self._wanted_m - self._set_m, -step), step)
            self._motors()
        self.update_cup()

    def _lift(self) -> Tuple[float, float]:
        position, speed, *_ = pybullet.getJointState(self._uid, self._hand, physicsClientId=self._client)
        return float(position), float(speed)

    def _motors(self) -> None:
        for link, share in zip((self._hand, self._stage), LIFT_SHARES.values()):
            pybullet.setJointMotorControl2(
                self._uid,
                link,
                pybullet.POSITION_CONTROL,
                targetPosition=share * self._set_m,
                force=PRESSING_FORCE_N,
                physicsClientId=self._client,
            )
