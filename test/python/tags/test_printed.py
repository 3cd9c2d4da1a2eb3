"""The printed program's rows and votes, and its faults."""

from __future__ import annotations

from typing import Any, List

import numpy as np
import pytest

from python.tags.tag_views import TAGS, view
from yarm.sim.sensors.rgb_camera import Imaging
from yarm.tags.printed import (
    AREA,
    CORNER,
    FIELDS,
    FLAGS,
    GOOD,
    PREDICTED,
    STATUS,
    TAG_FROM_0,
    TAG_FROM_1,
    TANGLE,
    PrintedRecogniser,
    corner_flags,
    is_kept,
    laser_text,
    map_text,
    row_of,
)
from yarm.tags.report import FEW, FOUND, UNSET, Sighting

SOME = {n: TAGS[n] for n in (2, 8, 12)}
CORNERS = np.array([[100.0, 100.0], [300.0, 100.0], [300.0, 260.0], [100.0, 260.0]])


@pytest.fixture(scope="module")
def recogniser() -> PrintedRecogniser:
    return PrintedRecogniser(SOME)


def row(tag: int = 8, good: int = 80, area: float = 32000.0, tangled: bool = False) -> np.ndarray:
    return row_of(Sighting(tag, 1, FOUND, area, 0.05, CORNERS, tangled, 400, good, (90.0,) * 4, 90.0, 0.0, 120.0))


def test_a_row_has_25_numbers_in_the_printed_places() -> None:
    found = row(8)
    assert found.shape == (FIELDS,)
    assert [found[i] for i in (TAG_FROM_0, TAG_FROM_1, GOOD, AREA, CORNER, PREDICTED, FLAGS)] == [
        7,
        8,
        80,
        32000.0,
        100,
        120.0,
        0,
    ]
    assert found[TANGLE] == UNSET
    assert row(8, tangled=True)[TANGLE] == -7.0
    few = row_of(Sighting(8, 1, FEW, good=2))
    assert few[STATUS] == -60.0
    assert few[AREA] == UNSET


def test_the_flags_of_corners_out_of_order() -> None:
    assert corner_flags(CORNERS) == 0
    assert corner_flags(CORNERS[[1, 0, 3, 2]]) == 1 + 8
    assert corner_flags(CORNERS[[3, 2, 1, 0]]) == 2 + 4


@pytest.mark.parametrize(("changes", "kept"), [({}, True), ({"good": 33}, False), ({"area": 3000.0}, False)])
def test_what_is_kept(changes: Any, kept: bool) -> None:
    assert is_kept(row(**changes)) is kept
    assert not is_kept(row(tangled=True))


def test_the_files_hold_a_line_a_row() -> None:
    lines = map_text([[row(8)], [], [row(2), row(12)]]).splitlines()
    assert [line == "CONNECTOR" for line in lines] == [False, True, True, False, False, True]
    numbers = [float(word) for word in lines[0].split()]
    assert numbers == pytest.approx(row(8).tolist(), rel=1e-5)
    assert [line.split()[TAG_FROM_1] for line in laser_text([row(8), row(2)]).splitlines()] == ["8", "2"]


def test_votes(recogniser: PrintedRecogniser) -> None:
    rows: List[np.ndarray] = [row(8)] * 12
    assert recogniser.verdict(rows).tag == 7, "counted from 0"
    assert recogniser.verdict(rows[:9]).tag == -1
    several = recogniser.verdict(rows + [row(2)] * 9)
    assert (several.tag, several.unmatched) == (None, 21), "no line for this box"


class TestKnownFaults:
    """What the printed program gets wrong beside the report's own faults."""

    def test_a_frame_that_did_not_come_is_a_vote_for_every_tag(self, recogniser: PrintedRecogniser) -> None:
        verdict = recogniser.verdict([row for _ in range(21) for row in recogniser.look(None)])
        assert dict(verdict.votes) == {1: 21, 7: 21, 11: 21}
        mixed = [r for _ in range(8) for r in recogniser.look(None)] + [row(8)] * 13
        assert recogniser.verdict(mixed).tag is None

    def test_the_tag_is_counted_from_nought(self, recogniser: PrintedRecogniser) -> None:
        frame, _ = view(TAGS[8])
        verdict = recogniser.verdict([row for _ in range(12) for row in recogniser.look(frame.grey)])
        assert verdict.tag == 7

    def test_a_dark_room_is_blank(self, recogniser: PrintedRecogniser) -> None:
        frame, _ = view(TAGS[8], imaging=Imaging(gain=0.01))
        assert recogniser.verdict([row for _ in range(21) for row in recogniser.look(frame.grey)]).tag == -1
