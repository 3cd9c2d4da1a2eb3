"""Recognition as the report's program was printed, faults included: rows of 25 numbers, votes for nothing.

Kept to be compared with; its faults are listed in docs/inspection.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Sequence

import numpy as np

from yarm.geometry import FloatArray
from yarm.tags.features import DETECTOR
from yarm.tags.motifs import GreyImage
from yarm.tags.report import FOUND, LEAST_AREA_PX2, LEAST_SIGHTINGS, MOST_MINOR_VOTES, UNSET, ReportRecogniser, Sighting

FIELDS = 25
LEAST_GOOD_PRINTED = 33
"""Sightings with as many good matches or fewer are rejected."""
TANGLED = -7.0
TAG_FROM_0, STATUS, GOOD, TAG_FROM_1, AREA, SHARE, CORNERS = 0, 1, 2, 3, 4, 5, 6
FLAGS, TANGLE, ANGLES, CORNER, PREDICTED = 14, 15, 16, 20, 21
"""Where each indicator stands in a row; the corners and angles take 8 and 4 places."""
CONNECTOR = "CONNECTOR"
Row = FloatArray
"""(25,) numbers, ``UNSET`` where nothing was written."""


@dataclass(frozen=True)
class PrintedVerdict:
    """What the printed vote comes to.

    Attributes:
        tag: number of the tag counted from 0; -1 for blank; None when the box gets no line.
        votes: rows that were kept for each tag from 0.
        unmatched: rows kept of a box without a line.
    """

    tag: Optional[int]
    votes: Mapping[int, int]
    unmatched: int = 0


def row_of(sighting: Sighting) -> Row:
    """The 25 numbers that the program keeps of a sighting."""
    row = np.full(FIELDS, UNSET)
    row[TAG_FROM_0], row[TAG_FROM_1] = sighting.tag - 1, sighting.tag
    row[STATUS], row[GOOD] = sighting.status, sighting.good
    if sighting.status != FOUND or sighting.corners is None:
        return row
    row[STATUS] = UNSET
    corners = sighting.corners
    row[AREA], row[SHARE] = sighting.area_px2, sighting.share
    row[CORNERS : CORNERS + 8] = corners.reshape(-1)
    row[FLAGS] = corner_flags(corners)
    row[TANGLE] = TANGLED if sighting.tangled else UNSET
    row[ANGLES : ANGLES + 4] = sighting.angles
    row[CORNER] = 100 + int(np.argmin(corners.sum(1)))
    row[PREDICTED] = sighting.predicted_deg
    return row


def corner_flags(corners: FloatArray) -> int:
    """Bits: 1 top runs leftward, 2 left side runs upward, 4 right side runs upward, 8 bottom runs leftward."""
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = corners
    return int(x0 >= x1) + 2 * int(y0 >= y3) + 4 * int(y1 >= y2) + 8 * int(x3 >= x2)


def is_kept(row: Row) -> bool:
    """Whether a row counts as a vote. The answer for an image that did not come is never set, and so counts as yes."""
    if row[STATUS] == UNSET:
        return bool(row[AREA] > LEAST_AREA_PX2 and row[TANGLE] != TANGLED and row[GOOD] > LEAST_GOOD_PRINTED)
    return bool(row[STATUS] == -70.0)


def printed_rejection(sighting: Sighting) -> str:
    """Why a sighting is no vote; empty when it is one."""
    row = row_of(sighting)
    if is_kept(row):
        return ""
    few = row[STATUS] == UNSET and row[GOOD] <= LEAST_GOOD_PRINTED
    return f"{LEAST_GOOD_PRINTED} good matches or fewer" if few else sighting.rejection


def map_text(images: Sequence[Sequence[Row]]) -> str:
    """``MapText.txt``: a line of 25 numbers for each row of an image that counts, and CONNECTOR after each image.

    Args:
        images: the rows of each image that count, by whichever rule the round votes.
    """
    return "".join(laser_text(rows) + f"{CONNECTOR}\n" for rows in images)


def laser_text(rows: Sequence[Row]) -> str:
    """``LaserText.txt``: a line of 25 numbers for each row that counts, of the boxes without a verdict."""
    return "".join(f"{_line(row)}\n" for row in rows)


def _line(row: Row) -> str:
    return " ".join(f"{number:.6g}" for number in row)


class PrintedRecogniser:
    """The printed program: grey, no crop."""

    def __init__(self, tags: Mapping[int, GreyImage], detector: str = DETECTOR) -> None:
        """Find the tags' features.

        Raises:
            DetectorError: the installed OpenCV does not have this detector.
        """
        self._recogniser = ReportRecogniser(tags, detector, crop=False)

    def look(self, image: Optional[GreyImage], box: int = 0, predicted_deg: float = 90.0) -> List[Row]:
        """A row for each tag in an image; None for an image that did not come."""
        return [row_of(sighting) for sighting in self._recogniser.look(image, box, predicted_deg)]

    @staticmethod
    def verdict(rows: Sequence[Row]) -> PrintedVerdict:
        """The verdict on a box from all rows of all its images."""
        return printed_verdict(rows)


def printed_verdict(rows: Sequence[Row]) -> PrintedVerdict:
    """The printed vote on a box from all rows of all its images."""
    kept = [row for row in rows if is_kept(row)]
    votes: Dict[int, int] = {}
    for row in kept:
        votes[int(row[TAG_FROM_0])] = votes.get(int(row[TAG_FROM_0]), 0) + 1
    if len(kept) < LEAST_SIGHTINGS:
        return PrintedVerdict(-1, votes)
    strong = [tag for tag, count in votes.items() if count > MOST_MINOR_VOTES]
    if len(strong) == 1:
        return PrintedVerdict(strong[0], votes)
    return PrintedVerdict(None, votes, len(kept))
