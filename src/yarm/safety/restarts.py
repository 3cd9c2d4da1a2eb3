"""When a program that has died is started again: soon, later each time, and not for ever."""

from __future__ import annotations

import signal
from dataclasses import dataclass, field
from typing import List

FIRST_DELAY_S, LONGEST_DELAY_S = 0.1, 1.6
"""Pause before the first start again, which doubles with each further one up to the other, s."""
SETTLED_S = 30.0
"""Who has lived so long, s, begins with the first pause again."""
LIMIT, WITHIN_S = 8, 60.0
"""So many deaths within so long, s, and it is given up."""
STARTED_S = 5.0
"""Who ends by itself with an exit code before it has ever lived so long refuses to run, s; that it will do again."""


def words(code: int) -> str:
    """How a process ended, from its code as of ``subprocess``: negative numbers are signals."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return f"killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"killed by signal {-code}"


@dataclass(frozen=True)
class Verdict:
    """What to do after a death.

    Attributes:
        again: whether it is started again.
        delay_s: after which pause.
        reason: why not, for people; empty when it is.
    """

    again: bool
    delay_s: float = 0.0
    reason: str = ""


@dataclass
class Restarts:
    """Knows when one program has died. Wall time throughout, s.

    Attributes:
        count: times it was started again.
        last: how it ended last; empty before.
        verdict: its exit code is its verdict: only who was killed is started again.
    """

    verdict: bool = False
    count: int = 0
    last: str = ""
    _deaths_s: List[float] = field(default_factory=list)
    _in_a_row: int = 0
    _has_run: bool = False

    def died(self, code: int, started_s: float, now_s: float, hung: str = "") -> Verdict:
        """It has ended.

        Args:
            code: exit code; the negative number of the signal that killed it.
            started_s: when it was started.
            now_s: the present.
            hung: how it hung when it was killed for that.
        """
        lived_s = now_s - started_s
        self.last = hung or words(code)
        self._has_run |= lived_s >= STARTED_S
        if code == 0:
            return Verdict(False, reason="it ended by itself")
        if code > 0 and self.verdict:
            return Verdict(False, reason=f"{self.last} is its verdict")
        if code > 0 and not self._has_run:
            return Verdict(False, reason=f"{self.last} {lived_s:.1f} s after its start: it refuses to run")
        self._deaths_s = [at_s for at_s in self._deaths_s if now_s - at_s < WITHIN_S] + [now_s]
        if len(self._deaths_s) >= LIMIT:
            return Verdict(False, reason=f"it died {LIMIT} times within {WITHIN_S:g} s, the last time {self.last}")
        self._in_a_row = 1 if lived_s >= SETTLED_S else self._in_a_row + 1
        self.count += 1
        return Verdict(True, min(FIRST_DELAY_S * 2.0 ** (self._in_a_row - 1), LONGEST_DELAY_S))
