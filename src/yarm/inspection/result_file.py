"""The result of a round as a text file, a line a box in visiting order."""

from __future__ import annotations

from typing import Iterable, List, Sequence

from yarm.inspection.model import BLANK, Verdict

HEADER = "Tag is 0 means blank"
PUBLISHED_WORD, OUR_WORD = "boxNumnber", "boxNumber"
"""The publication's spelling, and ours."""


def result_lines(verdicts: Sequence[Verdict], word: str = OUR_WORD) -> List[str]:
    """Header and one line for each box that has a tag or is blank; six digits, as they were published."""
    return [HEADER, *(_line(verdict, word) for verdict in verdicts if verdict.reading.tag >= BLANK)]


def unmatched_lines(verdicts: Iterable[Verdict]) -> List[str]:
    """One line for each box without a verdict."""
    return [f"unmatched: {verdict.box}" for verdict in verdicts if verdict.reading.tag < BLANK]


def _line(verdict: Verdict, word: str) -> str:
    tag = "blank" if verdict.reading.tag == BLANK else str(verdict.reading.tag)
    pose = verdict.pose
    mark = " (duplicate)" if verdict.duplicate else ""
    return f"{word}: {verdict.box} tag is {tag} x: {pose.x:.6g}, y: {pose.y:.6g}, phi: {pose.yaw_rad:.6g}{mark}"
