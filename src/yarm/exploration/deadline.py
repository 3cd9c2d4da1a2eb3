"""The end of the time: speeds that fade so that the robot rests in time, and the gate that every command passes.

The gate stands after the controller, in a process of its own. It lets commands through only while the explorer says,
again and again, that the robot may move (its lease). An explorer that dies, hangs or puts off its own deadline moves
nothing. Others who decide where a robot drives, such as the inspector, can hold it in the same way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Optional

from yarm.exploration.model import LOOP_S, Command
from yarm.safety.heartbeat import AHEAD_S

SETTLE_S = 0.5
"""Zeros are sent from this long before the deadline: the base needs a moment to come to rest, s."""
BRAKE_MPS2 = 0.5
BRAKE_RADPS2 = 3.0
LEASE_AGE_S = 0.3
"""A lease counts for so long after its stamp, s."""
COMMAND_AGE_S = 0.3
"""A command counts for so long after it came, s."""
SLACK_S = 0.05
"""The gate brakes this much later than the explorer itself does, so that it changes nothing while all is well, s."""


def faded(command: Command, now_s: float, deadline_s: float) -> Command:
    """A command, held for one pass of the loop, as slow as it must be to rest ``SETTLE_S`` before a deadline.

    Args:
        command: what is wanted.
        now_s: the present.
        deadline_s: when the robot has to rest, on the same clock; infinite for never.
    """
    left_s = max(0.0, deadline_s - SETTLE_S - now_s - LOOP_S)
    return Command(
        _clipped(command.v_mps, BRAKE_MPS2 * left_s),
        _clipped(command.w_radps, BRAKE_RADPS2 * left_s),
    )


@dataclass(frozen=True)
class Lease:
    """What the explorer grants, ten times a second.

    Attributes:
        stamp_s: when.
        started_s: when the run began; another value is another run.
        deadline_s: when the robot has to rest.
        moving: the run goes on; false: the robot is to stand.
    """

    stamp_s: float
    started_s: float
    deadline_s: float
    moving: bool


@dataclass(frozen=True)
class Passed:
    """What the gate lets through.

    Attributes:
        command: to the base.
        reason: why it is less than what was wanted, and what to do; empty while nothing is held back.
    """

    command: Command
    reason: str = ""


class Gate:
    """Every command to the base goes through here; pure, on simulated seconds."""

    def __init__(self, who: str = "explorer") -> None:
        """Closed until it is heard that the robot may move, from somebody of this name."""
        self._who = who
        self._stopped = ""
        self.reset()

    def reset(self) -> None:
        """Simulated time went backwards: closed until the explorer is heard again."""
        self._lease: Optional[Lease] = None
        self._command = Command()
        self._command_s = -math.inf
        self._over = False

    def stop(self, reason: str) -> None:
        """A person wants the robot to stand, whoever grants what, over a reset too; an empty reason releases it."""
        self._stopped = reason

    def hear(self, lease: Lease, now_s: float) -> bool:
        """Take in a lease; the newest counts, and within a run the deadline can only come nearer.

        Returns:
            false when its numbers mean nothing or its stamp lies in the future, and it was not taken.
        """
        if not (lease.stamp_s <= now_s + AHEAD_S and math.isfinite(lease.started_s) and lease.deadline_s < math.inf):
            return False
        before = self._lease
        if before is not None and lease.stamp_s < before.stamp_s:
            return True
        deadline_s = lease.deadline_s
        if before is not None and before.started_s == lease.started_s:
            deadline_s = min(deadline_s, before.deadline_s)
        self._lease = Lease(lease.stamp_s, lease.started_s, deadline_s, lease.moving)
        return True

    def want(self, command: Command, now_s: float) -> None:
        """Take in a command on its way to the base."""
        finite = math.isfinite(command.v_mps) and math.isfinite(command.w_radps)
        self._command = command if finite else Command()
        self._command_s = now_s

    def step(self, now_s: float) -> Passed:
        """What the base is told now. Once a deadline has passed it is told to stand until :meth:`reset`."""
        objection = self._objection(now_s)
        if self._stopped:
            objection = f"stands: {self._stopped}"
        if objection:
            return Passed(Command(), objection)
        assert self._lease is not None
        slowed = faded(self._command, now_s - SLACK_S, self._lease.deadline_s)
        return Passed(slowed, "" if slowed == self._command else "brakes: the time is nearly over")

    def _objection(self, now_s: float) -> str:
        lease = self._lease
        if lease is not None and now_s >= lease.deadline_s - SETTLE_S:
            self._over = True
        if self._over:
            return "stands: the time is over; another run needs the nodes started again"
        if lease is None:
            return f"stands: nothing heard from the {self._who} yet; start it"
        if now_s - lease.stamp_s > LEASE_AGE_S:
            age_s = now_s - lease.stamp_s
            return (
                f"stands: nothing heard from the {self._who} for {age_s:.1f} s, at most {LEASE_AGE_S:g} s; "
                "look whether it still runs"
            )
        if not lease.moving:
            return "stands: the explorer is not exploring"
        if now_s - self._command_s > COMMAND_AGE_S:
            return f"stands: no command for more than {COMMAND_AGE_S:g} s"
        return ""


def _clipped(value: float, most: float) -> float:
    return min(most, max(-most, value))
