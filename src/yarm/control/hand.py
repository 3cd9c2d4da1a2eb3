"""Work of a suction hand at a mobile robot's tip: pick a piece up, let it go; one call of ``step`` per new reading.

The robot stands still meanwhile, over the piece or the bin; ``before_driving`` draws up a hand that was left down, as
when a drop was cancelled, before the base may drive. It owns no clock and no threads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Optional

from yarm.control.actions import MobileAction
from yarm.control.base.controller import Outcome
from yarm.params import param
from yarm.robots.ankurbot import HAND_LIFTS_KG, HAND_STROKE_M

REACHED_M = 0.003
"""A lift within this of where it was sent is there, metres."""
CARRYING_M = 0.005
"""Carrying height: the base drives while the lift is not farther down than this, metres."""
STALLED_MPS = 0.005
"""A lift slower than this on its way has met something, m/s."""
UP_STALLS = 2.0
"""On its way up it may stand so many times as long: it was pressing, and first comes back to where it stands."""


@dataclass(frozen=True)
class HandParams:
    """How a hand picks and lets go."""

    hand_tolerance_m: float = param(0.01, "m", "the tip is brought this near to a piece or a bin's middle", 0.005, 0.05)
    hand_drop_m: float = param(0.18, "m", "how far down a piece is let go, from drawn up", 0.0, HAND_STROKE_M)
    hand_stall_s: float = param(0.5, "s", "a hand that has stood for so long on its way has met something", 0.1, 5.0)
    hand_limit_s: float = param(15.0, "s", "longest time for one pick or drop", 1.0, 120.0)


class HandStage(Enum):
    """What the hand is doing."""

    IDLE = "idle"
    DOWN = "down"
    LETTING_GO = "letting go"
    UP = "up"


@dataclass(frozen=True)
class HandReading:
    """State of a hand: metres down from drawn up, m/s down, and whether something hangs on its cup."""

    lift_m: float
    speed_mps: float
    grasping: bool


@dataclass(frozen=True)
class HandCommand:
    """What to send to the hand.

    Attributes:
        lift_m: where the lift goes, metres down; None to leave it.
        suction: on or off; None to leave it.
        outcome: how the work stands.
        reason: sentence on the outcome; empty while active.
    """

    lift_m: Optional[float] = None
    suction: Optional[bool] = None
    outcome: Outcome = Outcome.ACTIVE
    reason: str = ""


@dataclass
class _Work:
    """One pick or drop: what, since when, why it has failed, how far down it got, since when the lift stands."""

    action: MobileAction
    since_s: float
    failure: str = ""
    lowest_m: float = 0.0
    standing_since_s: float = field(default=0.0)


@dataclass
class _Raising:
    """A hand drawn up before the base drives: since when, and since when it stands."""

    since_s: float
    standing_since_s: float


class HandWork:
    """Picks or drops with one hand, one thing at a time."""

    def __init__(self, params: HandParams) -> None:
        """At rest, drawn up."""
        self._params = params
        self._work: Optional[_Work] = None
        self._raising: Optional[_Raising] = None
        self.stage = HandStage.IDLE

    @property
    def active(self) -> bool:
        """Whether the hand is at work."""
        return self._work is not None

    def start(self, action: MobileAction, reading: HandReading, now_s: float) -> HandCommand:
        """Begin a PICK or a DROP.

        Args:
            action: which.
            reading: of the hand now.
            now_s: time, s.
        """
        picks = action is MobileAction.PICK
        if picks is reading.grasping:
            why = "something hangs on the cup already" if picks else "nothing hangs on the cup"
            return self._end(Outcome.ABORTED, why)
        self._work = _Work(action, now_s, standing_since_s=now_s)
        self.stage = HandStage.DOWN
        return HandCommand(self._depth_m, True if picks else None)

    def stop(self) -> HandCommand:
        """Give the work up: the hand is drawn up, with what it holds."""
        self._work, self._raising, self.stage = None, None, HandStage.IDLE
        return HandCommand(lift_m=0.0)

    def before_driving(self, reading: HandReading, now_s: float) -> Optional[HandCommand]:
        """What must be done before the base drives on; None when it may, the hand being at its carrying height.

        A hand that does not come up ends the goal; a piece that holds it down is let go, so that the next goal can be.

        Args:
            reading: of the hand now.
            now_s: time, s.
        """
        if reading.lift_m <= CARRYING_M:
            self._raising = None
            return None
        if self._raising is None:
            self._raising = _Raising(now_s, now_s)
        raising, params = self._raising, self._params
        if abs(reading.speed_mps) > STALLED_MPS:
            raising.standing_since_s = now_s
        where = f"the base does not drive with its hand {reading.lift_m:.3f} m down, {CARRYING_M:g} m allowed"
        if reading.grasping and now_s - raising.standing_since_s > UP_STALLS * params.hand_stall_s:
            self._raising = None
            return HandCommand(0.0, False, Outcome.ABORTED, f"{where}: {_too_heavy(reading)}")
        if now_s - raising.since_s > params.hand_limit_s:
            self._raising = None
            return HandCommand(0.0, None, Outcome.ABORTED, f"{where}: not drawn up within {params.hand_limit_s:g} s")
        return HandCommand(lift_m=0.0)

    def step(self, reading: HandReading, now_s: float) -> HandCommand:
        """Command that answers one reading at a time, s.

        Raises:
            RuntimeError: no work was started.
        """
        work = self._work
        if work is None:
            raise RuntimeError("no pick or drop was started")
        work.lowest_m = max(work.lowest_m, reading.lift_m)
        if abs(reading.speed_mps) > STALLED_MPS:
            work.standing_since_s = now_s
        if now_s - work.since_s > self._params.hand_limit_s:
            text = f"not done within {self._params.hand_limit_s:g} s: {self.stage.value}, {reading.lift_m:.3f} m down"
            return self._end(Outcome.ABORTED, text)
        steps = {HandStage.DOWN: self._down, HandStage.LETTING_GO: self._letting_go, HandStage.UP: self._up}
        return steps[self.stage](work, reading, now_s)

    @property
    def _depth_m(self) -> float:
        assert self._work is not None
        return HAND_STROKE_M if self._work.action is MobileAction.PICK else self._params.hand_drop_m

    def _down(self, work: _Work, reading: HandReading, now_s: float) -> HandCommand:
        there = reading.lift_m >= self._depth_m - REACHED_M
        stalled = now_s - work.standing_since_s > self._params.hand_stall_s
        if work.action is MobileAction.PICK:
            return self._reaching(work, reading, now_s, there, stalled)
        return self._dropping(work, reading, there, stalled)

    def _reaching(self, work: _Work, reading: HandReading, now_s: float, there: bool, stalled: bool) -> HandCommand:
        if reading.grasping:
            work.standing_since_s = now_s
            return self._draw_up()
        if there:
            return self._draw_up(f"nothing met down to {reading.lift_m:.3f} m, where the lift ends")
        return self._draw_up(f"what was met {reading.lift_m:.3f} m down is not held") if stalled else HandCommand()

    def _dropping(self, work: _Work, reading: HandReading, there: bool, stalled: bool) -> HandCommand:
        if not reading.grasping:
            return self._draw_up(f"the piece was lost {reading.lift_m:.3f} m down")
        if there:
            self.stage = HandStage.LETTING_GO
            return HandCommand(suction=False)
        if stalled:
            self.stage, work.failure = HandStage.UP, f"met something {reading.lift_m:.3f} m down; is the bin full?"
            return HandCommand(lift_m=0.0)
        return HandCommand()

    def _letting_go(self, work: _Work, reading: HandReading, now_s: float) -> HandCommand:
        del work, now_s
        return HandCommand() if reading.grasping else self._draw_up()

    def _up(self, work: _Work, reading: HandReading, now_s: float) -> HandCommand:
        picked = work.action is MobileAction.PICK and not work.failure
        if picked and not reading.grasping:
            return self._draw_up(f"the piece was lost on the way up, {reading.lift_m:.3f} m down")
        if picked and now_s - work.standing_since_s > UP_STALLS * self._params.hand_stall_s:
            return self._draw_up(_too_heavy(reading))
        if reading.lift_m > REACHED_M:
            return HandCommand()
        if work.failure:
            return self._end(Outcome.ABORTED, work.failure)
        done = "picked up" if picked else "let go"
        return self._end(Outcome.SUCCEEDED, f"{done} {work.lowest_m:.3f} m down")

    def _draw_up(self, failure: str = "") -> HandCommand:
        """Up again; a failure ends suction too."""
        assert self._work is not None
        self.stage, self._work.failure = HandStage.UP, self._work.failure or failure
        return HandCommand(lift_m=0.0, suction=False if failure else None)

    def _end(self, outcome: Outcome, reason: str) -> HandCommand:
        self._work, self.stage = None, HandStage.IDLE
        return HandCommand(lift_m=0.0, outcome=outcome, reason=reason)


def _too_heavy(reading: HandReading) -> str:
    return (
        f"what hangs on the cup holds it {reading.lift_m:.3f} m down and is let go: "
        f"the lift raises {HAND_LIFTS_KG:g} kg at most"
    )
