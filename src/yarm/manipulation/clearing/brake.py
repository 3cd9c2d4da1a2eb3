"""A person's stop of a robot that is on its way: its time runs slower and slower, and stands; after it it runs again.

Arm and base stay on their way, and go on from where they stood.
"""

from __future__ import annotations

BRAKE_S = 0.25
"""From full speed to rest, s."""


class Brake:
    """How fast a robot's time runs: 1 as always, 0 it stands."""

    def __init__(self) -> None:
        """It runs."""
        self.rate = 1.0

    def step(self, stopped: bool, dt_s: float) -> float:
        """The rate for the next so many seconds, while somebody has stopped it or nobody has."""
        change = dt_s / BRAKE_S
        self.rate = max(0.0, self.rate - change) if stopped else min(1.0, self.rate + change)
        return self.rate
