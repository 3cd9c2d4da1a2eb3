"""What robots answer to a CALIBRATION goal: ``SPACE=XY/AREA=17,7,15`` or ``SPACE=SWITCH/AREA=11,29,17,32,0,10``."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Dict, Tuple

import numpy as np

from yarm.control.actions import SearchSpace
from yarm.geometry import BoolArray, GridSpec

LENGTHS: Dict[SearchSpace, int] = {SearchSpace.XY: 3, SearchSpace.SWITCH: 6}
"""Numbers that follow AREA for each search space."""

_PATTERN = re.compile(r"^SPACE=(?P<space>[A-Z]+)/AREA=(?P<area>-?\d+(,-?\d+)*)$")


class AnswerError(ValueError):
    """A robot's answer cannot be understood; the message quotes it."""


@dataclass(frozen=True)
class Answer:
    """What a robot can do.

    Attributes:
        space: in what it is moved.
        area: XY: its extent in cells, x, y, z, the arm along x. SWITCH: its private area, the cells x, y and z from
            first to last, both inclusive.
    """

    space: SearchSpace
    area: Tuple[int, ...]

    def private_columns(self, spec: GridSpec) -> BoolArray:
        """Columns (gx, gy) of the private area; none for a robot that has no such area."""
        columns = np.zeros(spec.shape[:2], dtype=bool)
        if self.space is SearchSpace.SWITCH:
            x0, x1, y0, y1 = self.area[:4]
            columns[max(x0, 0) : x1 + 1, max(y0, 0) : y1 + 1] = True
        return columns


def parse_answer(text: str) -> Answer:
    """An answer from its text.

    Raises:
        AnswerError: the text is not in the form above.
    """
    match = _PATTERN.match(text.strip())
    if match is None or match["space"] not in tuple(SearchSpace):
        raise AnswerError(
            f"calibration answer {text!r} must be SPACE=XY/AREA=x,y,z or SPACE=SWITCH/AREA=x0,x1,y0,y1,z0,z1"
        )
    space = SearchSpace(match["space"])
    area = tuple(int(part) for part in match["area"].split(","))
    if len(area) != LENGTHS[space]:
        raise AnswerError(f"calibration answer {text!r} must have {LENGTHS[space]} numbers after AREA, not {len(area)}")
    return Answer(space, area)
