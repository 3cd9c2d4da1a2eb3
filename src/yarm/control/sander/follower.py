"""One motion at a time: sent, watched by the measured joints, braked on its own path."""

from __future__ import annotations

from typing import List, Optional

import numpy as np

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import REST_TOLERANCE_RAD, ArmMotion
from yarm.geometry.grid import FloatArray

FOLLOW_GRACE_S = 3.0
HALT_S = 0.1
EARLY_S, LATE_S = 0.5, 0.05
"""An arm that lags, or leads, by more than this is looked for no further along its motion."""


class MotionFollower:
    """Knows which motion the arm follows, and where on it the arm is."""

    def __init__(self, stop_s: float) -> None:
        """Nothing moves.

        Args:
            stop_s: a motion that is braked comes to rest in this time.
        """
        self._stop_s = stop_s
        self._motion: Optional[ArmMotion] = None
        self._start_s = 0.0
        self._out: List[ArmMotion] = []
        self.braking = False

    @property
    def active(self) -> bool:
        """Whether the arm is on its way."""
        return self._motion is not None

    def take(self) -> List[ArmMotion]:
        """The motions to send since the last call, in order; each replaces the one before."""
        out, self._out = self._out, []
        return out

    def send(self, motion: ArmMotion, now_s: float) -> None:
        """Begin a motion; one of no length is not sent, only watched for being there."""
        self._motion, self._start_s, self.braking = motion, now_s, False
        if motion.duration_s > 0.0:
            self._out.append(motion)

    def brake(self, q: FloatArray, now_s: float) -> None:
        """Bring the motion under way to rest on its own path; once is enough."""
        if self._motion is None or self.braking:
            return
        self.send(self._motion.braked(self._phase(self._motion, q, now_s), self._stop_s), now_s)
        self.braking = True

    def halt(self, q: FloatArray, now_s: float) -> None:
        """Stand still where the arm is measured, whatever it was following."""
        self.send(ArmMotion(np.array([0.0, HALT_S]), np.array([q, q]), np.zeros(2)), now_s)
        self.braking = True

    def arc_m(self, q: FloatArray, now_s: float) -> float:
        """Way along the path of the motion under way at which the tip is, metres.

        Raises:
            ArmError: nothing is under way.
        """
        if self._motion is None:
            raise ArmError("no motion is under way that the tip could be on")
        return self._motion.arc_at(self._phase(self._motion, q, now_s))

    def arrived(self, q: FloatArray, now_s: float) -> bool:
        """Whether the arm rests where the motion ends; it is over then.

        Raises:
            ArmError: it should be there for FOLLOW_GRACE_S and is not; the motion is given up.
        """
        if self._motion is None:
            return True
        late_s = now_s - self._start_s - self._motion.duration_s
        errors = np.abs(q - self._motion.positions[-1])
        away = float(np.max(errors))
        if late_s >= 0.0 and away <= REST_TOLERANCE_RAD:
            self._motion = None
            return True
        if late_s > FOLLOW_GRACE_S:
            self._motion = None
            raise ArmError(
                f"the arm does not follow: joint {int(np.argmax(errors)) + 1} is {away:.3f} rad away "
                f"{FOLLOW_GRACE_S:g} s after the motion's end, allowed {REST_TOLERANCE_RAD:g}; does something block it?"
            )
        return False

    def _phase(self, motion: ArmMotion, q: FloatArray, now_s: float) -> float:
        elapsed_s = now_s - self._start_s
        return motion.nearest_time(q, elapsed_s - EARLY_S, elapsed_s + LATE_S)
