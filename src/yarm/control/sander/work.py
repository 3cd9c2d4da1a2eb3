"""The script under way: begun, dropped, interrupted and begun again, tried again after something blocked the arm."""

from __future__ import annotations

from typing import List

from yarm.control.arm.errors import ArmError
from yarm.control.arm.motion import ArmMotion
from yarm.control.sander.follower import MotionFollower
from yarm.control.sander.runner import ScriptRunner
from yarm.control.sander.scripts import SanderScripts, Situation
from yarm.control.sander.states import SanderState
from yarm.control.sander.steps import Script
from yarm.geometry.grid import FloatArray


class SanderWork:
    """One script at a time, and what is left to do of one that was stopped.

    Joints ``q`` (6,) are the measured ones, rad; ``now_s`` is the time of their reading.

    Attributes:
        reason: why the arm stands, for people; empty when there is nothing to say.
    """

    def __init__(
        self, situation: Situation, scripts: SanderScripts, follower: MotionFollower, runner: ScriptRunner
    ) -> None:
        """Nothing to do.

        Args:
            situation: how the sander stands.
            scripts: what is begun again after a stop.
            follower: of the arm's motions.
            runner: carries scripts out.
        """
        self._now = situation
        self._scripts = scripts
        self._follower = follower
        self._runner = runner
        self._storing = False
        self._interrupted = False
        self._blocked = False
        self.reason = ""

    @property
    def idle(self) -> bool:
        """Whether there is no script."""
        return self._runner.idle

    @property
    def moving(self) -> bool:
        """Whether a motion is being followed or computed."""
        return self._runner.moving

    @property
    def at_rest(self) -> bool:
        """Whether there is no script, and the last motion has come to its end."""
        return self._runner.idle and not self._follower.active

    @property
    def storing(self) -> bool:
        """Whether what is under way, or was interrupted, leads to storage."""
        return self._storing

    @property
    def blocked(self) -> bool:
        """Whether something was in the way of the raster, so that it goes on with the next ON."""
        return self._blocked

    @property
    def active(self) -> bool:
        """Whether there is a script, or one that was interrupted."""
        return self._interrupted or not self._runner.idle

    def take_up(self, active: bool, storing: bool, blocked: bool) -> None:
        """Be as another one was when it died; what was under way then is begun again by ``go_on``."""
        self._interrupted, self._storing, self._blocked = active, storing, blocked

    def halt(self, q: FloatArray, now_s: float) -> None:
        """Stand still wherever the arm is: it may have left its motion. What was under way is begun by ``go_on``."""
        self._interrupted = self.active
        self._runner.drop()
        self._now.scanning = False
        self._follower.halt(q, now_s)

    def take(self) -> List[ArmMotion]:
        """The motions to send since the last call, in order."""
        return self._follower.take()

    def begin(self, script: Script, q: FloatArray, now_s: float, storing: bool = False) -> None:
        """Take up a script in place of the one under way; ``storing`` when it leads to storage."""
        self.drop(q, now_s)
        self._storing = storing
        self.reason = ""
        self._runner.begin(script)

    def drop(self, q: FloatArray, now_s: float) -> None:
        """Brake what moves, forget the script and that one was blocked."""
        self._follower.brake(q, now_s)
        self._runner.drop()
        self._storing = self._interrupted = self._blocked = False
        self._now.scanning = self._now.lifted = False
        self._now.waits_for = ""

    def interrupt(self, q: FloatArray, now_s: float) -> None:
        """Brake what moves; its script is begun again by ``go_on``."""
        if self._follower.active and not self._follower.braking:
            self._follower.brake(q, now_s)
            self._interrupted = not self._runner.idle

    def go_on(self, q: FloatArray, now_s: float) -> None:
        """Begin again what was interrupted, from wherever the arm rests; nothing when nothing was."""
        if self._interrupted:
            self.begin(self._scripts.again(self._storing), q, now_s, self._storing)

    def retry(self, q: FloatArray, now_s: float) -> None:
        """Go on with the raster on which something blocked the arm; nothing when nothing did."""
        if self._blocked:
            self.begin(self._scripts.resume(), q, now_s)

    def advance(self, q: FloatArray, now_s: float, hold: bool) -> None:
        """Go on as far as one reading of the joints allows; ``hold`` only watches what moves."""
        try:
            self._runner.advance(q, now_s, hold)
        except ArmError as error:
            self.drop(q, now_s)
            self.reason = f"stays where it is: {error}"
            self._blocked = self._now.state is SanderState.SCAN_TO_PATH and self._now.progress.plan is not None
