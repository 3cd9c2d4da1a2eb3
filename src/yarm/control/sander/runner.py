"""Carries out one script at a time: computations, motions, waits."""

from __future__ import annotations

from typing import Any, Callable, Optional, Tuple

from yarm.control.sander.follower import MotionFollower
from yarm.control.sander.steps import Compute, Follow, Job, Script, Step, Wait
from yarm.geometry.grid import FloatArray

MOST_STEPS = 100
"""A script that takes more steps in one reading goes round in a circle."""


class ScriptRunner:
    """The script under way, and the step it is at."""

    def __init__(self, follower: MotionFollower, run_job: Callable[[Callable[[], Any]], Job]) -> None:
        """Nothing to do.

        Args:
            follower: of the arm's motions.
            run_job: starts a computation.
        """
        self._follower = follower
        self._run_job = run_job
        self._script: Optional[Script] = None
        self._step: Optional[Step] = None
        self._job: Optional[Job] = None

    @property
    def idle(self) -> bool:
        """Whether there is no script."""
        return self._script is None

    @property
    def moving(self) -> bool:
        """Whether a motion is being followed or computed."""
        return self._follower.active or self._job is not None

    def begin(self, script: Script) -> None:
        """Take up a script in place of the one under way; what still moves comes to rest first."""
        self.drop()
        self._script = script

    def drop(self) -> None:
        """Forget the script; a motion goes on to its end."""
        self._script, self._step, self._job = None, None, None

    def advance(self, q: FloatArray, now_s: float, hold: bool = False) -> None:
        """Go on as far as it gets at one reading of the joints.

        Args:
            q: measured joints (6,), rad.
            now_s: time of the reading.
            hold: only watch what moves; the script does not go on.

        Raises:
            ArmError: a computation found nothing, or the arm does not follow; the script is still there.
            RuntimeError: the script never waits.
        """
        for _ in range(MOST_STEPS):
            if self._follower.active and not self._watch(q, now_s):
                return
            if self._script is None or hold:
                return
            result = self._result()
            if result is None:
                return
            try:
                step = next(self._script) if self._step is None else self._script.send(result[0])
            except StopIteration:
                self.drop()
            else:
                self._take(step, now_s)
        raise RuntimeError("a sander script goes round without ever waiting")

    def _watch(self, q: FloatArray, now_s: float) -> bool:
        """Note where the tip is, brake when told to; true when the arm is at rest."""
        step = self._step
        if isinstance(step, Follow):
            if step.note is not None:
                step.note(self._follower.arc_m(q, now_s))
            if not self._follower.braking and step.until():
                self._follower.brake(q, now_s)
                return False
        return self._follower.arrived(q, now_s)

    def _result(self) -> Optional[Tuple[Any]]:
        """Result of the step under way; None while it is not done."""
        if self._job is not None:
            if not self._job.done():
                return None
            job, self._job = self._job, None
            return (job.result(),)
        if isinstance(self._step, Wait) and not self._step.until():
            return None
        return (not self._follower.braking,)

    def _take(self, step: Step, now_s: float) -> None:
        self._step = step
        if isinstance(step, Compute):
            self._job = self._run_job(step.function)
        elif isinstance(step, Follow):
            self._follower.send(step.motion, now_s)
