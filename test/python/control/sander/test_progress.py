"""What is left of a raster, what of it may be done now, and in which order."""

from __future__ import annotations

from typing import Any, List, Tuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from python.control.arm_samples import PART_LOWER, PART_TOP_M, PART_UPPER, TOOL_RADIUS_M, planner, scan
from python.control.sander.test_machine import Cell
from yarm.control.sander.progress import ARC_TOLERANCE_M, KeepOff, RasterProgress, joined, without
from yarm.control.sander.raster import coverage
from yarm.control.sander.states import Button, SanderState

PLAN = planner(0.04).raster(scan())
DISTANCE_M = 0.2
CORNER = np.array([[PART_LOWER[0], PART_LOWER[1]]])


def keep_off(points: Any, distance_m: float = DISTANCE_M) -> KeepOff:
    return KeepOff(np.asarray(points, dtype=float).reshape(-1, 2), distance_m)


def to_the_end(progress: RasterProgress) -> List[Tuple[float, float]]:
    """Every piece in the order in which they come, each done as a whole."""
    found = []
    while (piece := progress.next_piece()) is not None:
        progress.go_to(piece)
        progress.note(piece[1])
        found.append(piece)
    return found


def test_without_anything_to_keep_off_it_is_one_piece() -> None:
    progress = RasterProgress()
    progress.begin(PLAN)
    assert to_the_end(progress) == [(0.0, PLAN.raster.length_m)]
    assert progress.finished and progress.share == pytest.approx(1.0)


def test_what_is_near_is_left_out_and_done_later() -> None:
    progress = RasterProgress()
    progress.begin(PLAN)
    progress.keep_off(keep_off(CORNER))
    first = to_the_end(progress)
    assert not progress.finished and 0.4 < progress.share < 0.95
    for a, b in first:
        for arc in np.arange(a, b, 0.01):
            point = PLAN.point_at(arc)[0]
            assert np.linalg.norm(point[:2] - CORNER[0]) > DISTANCE_M - 1e-6
    progress.keep_off(None)
    rest = to_the_end(progress)
    assert progress.finished and progress.share == pytest.approx(1.0)
    assert joined([*first, *rest]) == (pytest.approx((0.0, PLAN.raster.length_m)),)


def test_it_goes_on_from_where_it_is_then_to_what_follows_then_round() -> None:
    progress = RasterProgress()
    progress.begin(PLAN, [(1.0, 1.5)], 1.5)
    assert progress.next_piece() == (1.5, PLAN.raster.length_m)
    progress.note(2.0)
    progress.begin(PLAN, [(1.0, PLAN.raster.length_m)], 2.0)
    assert progress.next_piece() == (0.0, 1.0)


def test_everywhere_too_near_there_is_no_piece() -> None:
    progress = RasterProgress()
    progress.begin(PLAN)
    progress.keep_off(keep_off(CORNER, 5.0))
    assert progress.next_piece() is None and not progress.finished
    assert not progress.may_go_to(0.1)
    progress.keep_off(keep_off([]))
    assert progress.next_piece() == (0.0, PLAN.raster.length_m) and progress.may_go_to(0.1)


ENDS = st.floats(0.0, 10.0)
PIECES = st.lists(st.tuples(ENDS, ENDS).map(lambda ends: (min(ends), max(ends))), max_size=8)


@given(PIECES, st.floats(-1.0, 11.0))
def test_pieces_joined_hold_what_they_held(pieces: List[Tuple[float, float]], at: float) -> None:
    found = joined(pieces)
    assert all(a[1] < b[0] for a, b in zip(found, found[1:]))
    assert any(a <= at <= b for a, b in found) or not any(a <= at <= b for a, b in pieces)


@given(PIECES, PIECES)
def test_nothing_is_lost_and_nothing_is_left_in_others(pieces: Any, others: Any) -> None:
    apart = joined(others)
    for piece in joined(pieces):
        left = without(piece, apart, 0.0)
        inside = sum(max(min(b, piece[1]) - max(a, piece[0]), 0.0) for a, b in apart)
        assert sum(b - a for a, b in left) == pytest.approx(piece[1] - piece[0] - inside, abs=1e-9)
        assert all(b <= c + 1e-12 or a >= d - 1e-12 for a, b in left for c, d in apart)


@pytest.fixture(scope="module", name="told")
def fixture_told() -> Cell:
    """Something falls into a corner while it sands there; it goes on elsewhere, and comes back when that is gone."""
    cell = Cell()
    cell.sanding(0.02)
    cell.keep_off = keep_off(CORNER, 0.35)
    cell.marks = [len(cell.log)]
    assert cell.run(200.0, until=lambda: "too near" in cell.machine.report.reason), cell.machine.report
    assert cell.run(10.0, until=lambda: cell.machine.report.lifted and not cell.machine.report.moving)
    cell.marks.append(len(cell.log))
    cell.share = cell.machine.report.progress
    cell.keep_off = keep_off([])
    assert cell.run(200.0, until=lambda: cell.machine.report.progress >= 1.0), cell.machine.report
    return cell


def tips(cell: Cell) -> np.ndarray:
    return np.array(
        [planner().kinematics.tip(q)[:3, 3] for _, q, state in cell.log if state is SanderState.SCAN_TO_PATH]
    )


def test_told_what_is_near_it_sands_elsewhere(told: Cell) -> None:
    assert 0.3 < told.share < 0.9
    after = np.array([planner().kinematics.tip(q)[:3, 3] for _, q, _ in told.log[told.marks[0] + 60 : told.marks[1]]])
    low = after[after[:, 2] < PART_TOP_M + 0.05]
    assert len(low) > 100
    assert np.linalg.norm(low[:, :2] - CORNER, axis=1).min() > 0.3


def test_in_the_end_all_of_the_part_is_covered(told: Cell) -> None:
    assert told.machine.report.reason == ""
    assert coverage(tips(told), PART_LOWER, PART_UPPER, PART_TOP_M, TOOL_RADIUS_M) >= 0.95


def test_it_keeps_the_speed_and_stays_off_the_part_on_its_ways(told: Cell) -> None:
    q = np.array([entry[1] for entry in told.log])
    assert planner().arm.limits.contain(q)
    for _, joints, state in told.log[::40]:
        assert planner().collision.free(joints, 0.005, sanding=state is SanderState.SCAN_TO_PATH)
    assert tips(told)[:, 2].min() > PART_TOP_M - 0.003


def test_paused_where_nothing_may_be_done_it_hovers_over_what_may() -> None:
    cell = Cell()
    cell.sanding(0.02)
    stopped = cell.tip()
    cell.keep_off = keep_off(CORNER, 0.35)
    cell.run(0.1, switches=[False])
    assert cell.run(15.0, until=lambda: cell.machine.report.lifted and not cell.machine.report.moving)
    cell.run(4.0)
    assert cell.tip()[2] >= 1.15 and np.linalg.norm(cell.tip()[:2] - CORNER[0]) > 0.34
    assert np.linalg.norm(cell.tip()[:2] - stopped[:2]) > 0.1
    progress = cell.machine.report.progress
    assert cell.run(10.0, switches=[True], until=lambda: cell.machine.report.progress > progress + 0.02)
    assert cell.machine.memory.done[0][0] == 0.0 and len(cell.machine.memory.done) == 2
    assert cell.machine.memory.done[0][1] < cell.machine.memory.done[1][0] - ARC_TOLERANCE_M


def test_everywhere_too_near_it_says_so_until_it_does_something_else() -> None:
    cell = Cell()
    cell.sanding(0.02)
    cell.keep_off = keep_off(CORNER, 5.0)
    assert cell.run(10.0, until=lambda: cell.machine.report.lifted and not cell.machine.report.moving)
    assert "too near to debris or a robot" in cell.machine.report.reason
    cell.to(SanderState.STORAGE, Button.STORE)
    assert cell.machine.report.reason == ""
