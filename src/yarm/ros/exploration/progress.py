"""The lines that a person sees of an exploration, one a second."""

from __future__ import annotations

import math
import textwrap
from typing import List

from yarm.msg import ExplorerStatus

REASON_SHOWN = 100
"""Characters of a reason; all of it is told at the end."""


def progress_line(status: ExplorerStatus, rate: float, share: float, bumps: int) -> str:
    """Of a run that is judged by the truth.

    Args:
        status: of the explorer.
        rate: simulated seconds a second.
        share: of what can be mapped; NaN before the first map.
        bumps: contacts by the truth.
    """
    mapped = f"{100.0 * share:5.1f} % mapped" if math.isfinite(share) else "    - % mapped"
    return " | ".join([f"{status.elapsed:6.1f} s", f"x{rate:.2f}", mapped, *_state(status, bumps)])


def status_line(status: ExplorerStatus) -> str:
    """Of a run of which only the explorer's own word is known."""
    return " | ".join([f"{status.elapsed:6.1f} s", f"{status.known_m2:5.1f} m2 known", *_state(status, status.bumps)])


def _state(status: ExplorerStatus, bumps: int) -> List[str]:
    reason = [textwrap.shorten(status.reason, REASON_SHOWN, placeholder=" ...")] if status.reason else []
    return [f"{status.left:5.0f} s left", f"{status.state}: {status.behaviour}", f"bumps: {bumps}", *reason]
