"""Why a robot was given a goal, and no other, in words."""

from __future__ import annotations

import math
from typing import Sequence


def chosen(robots: Sequence[str], lengths: Sequence[float], which: int) -> str:
    """Why one of the robots was given a goal, by the ways (cells) of all of them to it."""
    others = [(robot, length) for k, (robot, length) in enumerate(zip(robots, lengths)) if k != which]
    ways = [f"{robot} {f'{length:.1f}' if math.isfinite(length) else 'none'}" for robot, length in others]
    text = f"{lengths[which]:.1f} cells of way"
    if not ways:
        return f"{text}; nobody else is free"
    nearer = any(length < lengths[which] for _, length in others)
    sums = "; the sum over all goals is least so" if nearer else ""
    return f"{text}; {', '.join(ways)}{sums}"
