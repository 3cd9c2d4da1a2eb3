"""States and buttons of the HC10 sander, shared by the sander and by whoever presses its buttons."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Optional


class SanderState(IntEnum):
    """States as published (Int8)."""

    STORAGE = 0
    SCANNING = 1
    MOVE_TO_PART = 2
    TELEOPERATION = 3
    SCAN_TO_PATH = 4
    MOVE_TO_STORAGE = 5

    @property
    def words(self) -> str:
        """Name for people."""
        return self.name.lower().replace("_", " ")

    @staticmethod
    def of(number: int) -> Optional[SanderState]:
        """The state of a number as published; None for a number that means none."""
        return SanderState(number) if number in SanderState._value2member_map_ else None


class Button(IntEnum):
    """Index of each joystick button."""

    HOLD = 0
    STORE = 1
    ADVANCE = 2
    START = 3


@dataclass(frozen=True)
class SanderReport:
    """What the sander says of itself (the fields of SanderStatus.msg)."""

    state: SanderState
    enabled: bool = False
    moving: bool = False
    lifted: bool = False
    progress: float = 0.0
    reason: str = ""
    presses: int = 0
    switches: int = 0
