"""What a check says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """One check.

    Attributes:
        holds: whether it does.
        text: a sentence.
        goal: name of the goal that it is about, alone; empty for any other check.
    """

    holds: bool
    text: str
    goal: str = ""
