"""What has become of a goal that was given to the navigation, by its action's status and result messages; pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import AbstractSet, Optional, Tuple

from yarm.inspection.model import Outcome

SUCCEEDED = 3
"""Of actionlib_msgs/GoalStatus."""
ENDINGS = {2: "taken back", 4: "given up", 5: "refused", 8: "taken back", 9: "lost"}
"""Other statuses of goals that have ended, in words."""
RESULT_DELAY_S = 0.2
"""A result counts from so long after its stamp, so that in lock-step it counts at the same pass in every run."""
SILENT_S = 5.0
"""An action server that has said nothing for so long is gone."""


@dataclass(frozen=True)
class _Result:
    status: int
    text: str
    stamp_s: float


class GoalWatch:
    """Follows one goal after the other. Times are the clock's, s."""

    def __init__(self) -> None:
        """Nothing was sent and nothing heard."""
        self._name = ""
        self._result: Optional[_Result] = None
        self._known_s = -math.inf
        self._alive_s = -math.inf

    def sent(self, name: str, now_s: float) -> None:
        """A goal of a new name was sent; the one before counts no more."""
        self._name, self._result, self._known_s = name, None, now_s

    def heard_status(self, names: AbstractSet[str], now_s: float) -> None:
        """The server lives, and knows these goals."""
        self._alive_s = max(self._alive_s, now_s)
        if self._name in names:
            self._known_s = max(self._known_s, now_s)

    def heard_result(self, name: str, status: int, text: str, stamp_s: float) -> None:
        """A goal has ended; one of another name is nobody's."""
        if name == self._name and self._result is None:
            self._result = _Result(status, text, stamp_s)

    def outcome(self, now_s: float) -> Tuple[Outcome, str]:
        """How the goal stands, and why it failed."""
        result = self._result
        if result is not None:
            if now_s < result.stamp_s + RESULT_DELAY_S - 1e-6:
                return Outcome.BUSY, ""
            if result.status == SUCCEEDED:
                return Outcome.DONE, ""
            word = ENDINGS.get(result.status, f"ended with status {result.status}")
            return Outcome.FAILED, f"the goal was {word}: {result.text}" if result.text else f"the goal was {word}"
        if now_s - self._known_s > SILENT_S and now_s - self._alive_s <= SILENT_S:
            return Outcome.FAILED, f"the navigation has not known the goal for {now_s - self._known_s:.1f} s"
        return Outcome.BUSY, ""

    def gone(self, now_s: float) -> str:
        """What is wrong with the server; empty when it lives."""
        if self._alive_s == -math.inf:
            return "nothing heard of it yet"
        age_s = now_s - self._alive_s
        return f"silent for {age_s:.1f} s" if age_s > SILENT_S else ""
