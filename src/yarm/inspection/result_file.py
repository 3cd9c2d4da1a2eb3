"""The result of a round as a text file, a line a box in visiting order."""

from __future__ import annotations

from typing import Iterable, List, Sequence

from yarm.inspection.model import BLANK, OURS, PRINTED, Verdict

HEADER = "Tag is 0 means blank"
PUBLISHED_WORD, OUR_WORD = "boxNumnber", "boxNumber"
"""The publication's spelling, and ours."""


def lines_of(controller: str, verdicts: Sequence[Verdict]) -> List[str]:
    """The whole file as this controller writes it."""
    if controller == PRINTED:
        return [*printed_lines(verdicts), *unmatched_lines(verdicts)]
    return [*result_lines(verdicts, OUR_WORD if controller == OURS else PUBLISHED_WORD), *unmatched_lines(verdicts)]


def result_lines(verdicts: Sequence[Verdict], word: str = OUR_WORD) -> List[str]:
    """Header and one line for each box that has a tag or is blank; six digits, as they were published."""
    return [HEADER, *(_line(verdict, word) for verdict in verdicts if verdict.reading.tag >= BLANK)]


def printed_lines(verdicts: Sequence[Verdict]) -> List[str]:
    """The same lines as the printed program writes them: without header, pose and mark of a duplicate."""
    return [f"{PUBLISHED_WORD}: {v.box} tag is {_tag(v)}" for v in verdicts if v.reading.tag >= BLANK]


def unmatched_lines(verdicts: Iterable[Verdict]) -> List[str]:
    """One line for each box without a verdict."""
    return [f"unmatched: {verdict.box}" for verdict in verdicts if verdict.reading.tag < BLANK]


def _tag(verdict: Verdict) -> str:
    return "blank" if verdict.reading.tag == BLANK else str(verdict.reading.tag)


def _line(verdict: Verdict, word: str) -> str:
    pose = verdict.pose
    mark = " (duplicate)" if verdict.duplicate else ""
    where = f"x: {pose.x:.6g}, y: {pose.y:.6g}, phi: {pose.yaw_rad:.6g}"
    return f"{word}: {verdict.box} tag is {_tag(verdict)} {where}{mark}"
