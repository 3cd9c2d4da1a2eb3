"""The line that a person sees of a round, one a second."""

from __future__ import annotations

from typing import Sequence

from yarm.inspection.model import Verdict, reading_words
from yarm.inspection.session import SessionStep


def progress_line(step: SessionStep, verdicts: Sequence[Verdict], boxes: int, *measured: str) -> str:
    """Time, stage, verdicts so far, time left and time home.

    Args:
        step: of the session.
        verdicts: so far.
        boxes: how many there are.
        measured: more, after the time.
    """
    read = " ".join(f"{v.box}:{reading_words(v.reading.tag)}" for v in verdicts)
    parts = [
        f"{step.elapsed_s:6.1f} s",
        *measured,
        f"{step.stage}{f' box {step.box}' if step.box else ''}",
        f"{len(verdicts)} of {boxes} boxes{': ' if read else ''}{read}",
        f"{step.left_s:.0f} s left",
        f"{step.time_home_s:.0f} s home",
        *([step.reason] if step.reason else []),
    ]
    return " | ".join(parts)
