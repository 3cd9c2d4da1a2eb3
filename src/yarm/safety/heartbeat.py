"""A dead-man's switch: something may move only while everybody who watches over it is heard from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, Mapping

AHEAD_S = 0.5
"""A heartbeat stamped later than this after the present is refused: it would keep the switch closed for ever, s."""


@dataclass(frozen=True)
class _Pulse:
    stamp_s: float
    refusal: str


class DeadMansSwitch:
    """Knows when each watcher was last heard from. Not thread-safe; simulated seconds throughout."""

    def __init__(self, ages_s: Mapping[str, float]) -> None:
        """Nobody heard yet.

        Args:
            ages_s: greatest age of the newest heartbeat of each watcher, by the name of its node, s; empty: nobody
                watches, and whatever moves may move.
        """
        self._ages_s = dict(ages_s)
        self._pulses: Dict[str, _Pulse] = {}
        self._stopped = ""

    def stop(self, reason: str) -> None:
        """A person has stopped everything, for a reason, or with an empty one has released it again."""
        self._stopped = reason

    def hear(self, watcher: str, stamp_s: float, now_s: float, refusal: str = "") -> bool:
        """Take in a heartbeat; the newest counts.

        Args:
            watcher: name of its node.
            stamp_s: of what it has looked at.
            now_s: the present.
            refusal: why it forbids motion; empty when it does not.

        Returns:
            false when the stamp lies in the future and the heartbeat was not taken.
        """
        if not stamp_s <= now_s + AHEAD_S:
            return False
        known = self._pulses.get(watcher)
        if known is None or stamp_s >= known.stamp_s:
            self._pulses[watcher] = _Pulse(stamp_s, refusal)
        return True

    def objection(self, now_s: float) -> str:
        """Why nothing may move now, whom that depends on and what to do; empty when it may."""
        if self._stopped:
            return f"stands: {self._stopped}"
        for watcher, limit_s in self._ages_s.items():
            pulse = self._pulses.get(watcher)
            if pulse is None:
                return f"stands: nothing heard from {watcher} yet; {_remedy(watcher)}"
            if pulse.refusal:
                return f"stands: {watcher} forbids motion: {pulse.refusal}"
            if now_s - pulse.stamp_s > limit_s:
                return f"stands: nothing heard from {watcher} for more than {limit_s:g} s; {_remedy(watcher)}"
        return ""

    def reset(self) -> None:
        """Forget every heartbeat (time went backwards); a stop stays."""
        self._pulses.clear()


def _remedy(watcher: str) -> str:
    return f"start {watcher}, or set guarded to false to move without anybody watching"
