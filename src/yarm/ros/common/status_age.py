"""How old a status of the Commander may be for whoever reads it: it is latched, so a dead Commander's stays."""

from __future__ import annotations

from yarm.msg import CommanderStatus
from yarm.ros.common import names

STALE_S = 3.0
"""The Commander speaks once a second of simulated time at least; an older status is no news of it, s."""
LOST_S = 10.0
"""After so long without a word, s, it is not waited for any longer."""
SAME_ENTRY_S = 1e-3
"""Rounding of the moment at which a state was entered, s."""


def silence(status: CommanderStatus, now_s: float, limit_s: float) -> str:
    """Who is silent and for how long, when a status is older than a limit, s, at a simulated time; else empty."""
    age_s = now_s - status.header.stamp.to_sec()
    if age_s <= limit_s:
        return ""
    return (
        f"nothing heard from {names.COMMANDER_NODE} for {age_s:.1f} s: "
        f"what {names.COMMANDER_STATUS} shows is that old; is it running?"
    )


def entered_since(status: CommanderStatus, before: CommanderStatus) -> bool:
    """Whether a state has been entered after an earlier status: what came meanwhile may have been sent before it."""

    def entered_s(said: CommanderStatus) -> float:
        return float(said.header.stamp.to_sec() - said.elapsed_s)

    return bool(status.state != before.state or entered_s(status) > entered_s(before) + SAME_ENTRY_S)
