"""Numbers of the report's method: each one decides something, and what it decides changes with it."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.report_rig import Rig, scan
from yarm.exploration import report
from yarm.exploration.params import ExploreParams
from yarm.exploration.report.behaviours import to_the_middle
from yarm.exploration.report.controller import ReportController
from yarm.exploration.report.follow import CellFollower
from yarm.exploration.report.frontiers import cropped, frontiers, padded, with_probabilities
from yarm.exploration.report.params import ReportParams
from yarm.exploration.report.view import room_of
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import Bumper


def rig(**numbers: Any) -> Rig:
    return Rig(ReportController(ExploreParams(controller="report"), 1, ReportParams(**numbers)))


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(ReportParams)])
def test_every_number_is_looked_at(name: str) -> None:
    folder = Path(str(report.__file__)).parent
    text = "".join(path.read_text() for path in folder.glob("*.py") if path.name != "params.py")
    assert f"params.{name}" in text or f"DEFAULTS.{name}" in text


def test_what_counts_as_ahead_and_as_a_side() -> None:
    assert room_of(scan(1.0), params=ReportParams(ahead=0.05)).centre == 1.0
    assert room_of(scan(1.0, left=2.0, right=2.0), params=ReportParams(ahead=0.3)).centre == 1.0
    beside = scan(2.0, left=1.0, right=1.0)
    assert room_of(beside).centre == 2.0 and room_of(beside, params=ReportParams(ahead=0.3)).centre == 1.0
    edge = scan(2.0)
    edge.ranges[-10] = 0.6
    assert room_of(edge).left == 2.0
    assert room_of(edge, params=ReportParams(skipped_beams=0)).left == pytest.approx(0.6)
    assert room_of(scan(math.nan, math.nan, 1.5), params=ReportParams(nothing=9.0)).left == 9.0


def test_what_is_too_far_and_what_too_near() -> None:
    assert rig().step(scan(4.5)).command.v_mps == 0.2
    assert rig(valid_range=4.0).step(scan(4.5)).command.v_mps == 0.0
    assert rig(valid_least=2.2).step(scan(2.0)).command.v_mps == 0.0
    assert room_of(scan(0.5), params=ReportParams(valid_least=0.45)).centre == 0.5


def test_how_fast_it_turns_away_from_a_bump() -> None:
    assert rig().step(scan(2.0), (Bumper.LEFT, True)).command.w_radps == pytest.approx(-math.pi / 6)
    assert rig(bump_turn=0.1).step(scan(2.0), (Bumper.LEFT, True)).command.w_radps == pytest.approx(-0.1)


def test_how_strong_a_turn_to_the_middle_may_be() -> None:
    assert to_the_middle(3.0, 1.0, ReportParams()) == 0.0
    assert to_the_middle(3.0, 1.0, ReportParams(middle_share=2.0)) == pytest.approx(0.6)


def test_how_near_to_where_it_came_from_a_selection_may_end() -> None:
    def ends_at_165_degrees(**numbers: float) -> bool:
        here = rig(**numbers)
        here.step(scan(0.48))
        here.run(math.radians(165.0) / 0.4, scan(0.48))
        return here.step(scan(3.0)).behaviour == "forward"

    assert not ends_at_165_degrees() and ends_at_165_degrees(selection_back=0.1)


def test_how_a_full_turn_begins_and_ends() -> None:
    def turn(**numbers: Any) -> Rig:
        here = rig(turn_period=5.0, off=("frontier", "stuck"), **numbers)
        here.run(33.0, scan(2.0))
        return here

    def backing(here: Rig) -> int:
        steps = [step for step in here.steps if step.behaviour == "full_turn"]
        return sum(step.command.v_mps < 0.0 for step in steps[:60])

    assert backing(turn()) - backing(turn(turn_backing=4)) == 6

    def length(here: Rig) -> int:
        names = [step.behaviour for step in here.steps]
        return names.index("pause") - names.index("full_turn")

    assert length(turn()) > length(turn(turn_rest=1.0)) + 20


def test_what_is_kept_around_the_map_and_what_is_a_speck() -> None:
    cells = np.full((30, 30), -1, np.int8)
    cells[10:20, 10:20] = 0
    cells[12, 12:15] = 100
    whole = GridMap(cells, 0.05, Pose2(0.0, 0.0))
    small = cropped(whole, 1)
    assert small is not None and small.cells.shape == (12, 12)
    assert not (padded(whole, 5) == 100).any() and (padded(whole, 5, speck=2) == 100).any()
    row = np.zeros((30, 30), np.int8)
    row[12, 5:21:5] = 100
    spread = GridMap(row, 0.05, Pose2(0.0, 0.0))
    assert not (padded(spread, 5) == 100).any() and (padded(spread, 5, window=21) == 100).any()


def test_how_frontier_cells_are_merged_weighed_and_drawn() -> None:
    cells = np.zeros((12, 9), np.int8)
    cells[:, 6:] = -1
    cells[4, 3] = 100
    found = frontiers(cells, (6, 0), ReportParams())
    assert len(frontiers(cells, (6, 0), ReportParams(merging=3))) > len(found)
    plain = frontiers(cells, (6, 0), ReportParams(unknown=1.0))
    assert [2.0 * f.unknown for f in plain] == [f.unknown for f in found]
    double = frontiers(cells, (6, 0), ReportParams(obstacle=200.0))
    assert sum(f.obstacles for f in double) == 2.0 * sum(f.obstacles for f in found) > 0.0
    even = [f.probability for f in with_probabilities(found, 1e4)]
    assert max(even) / min(even) < 1.01 < max(f.probability for f in with_probabilities(found)) * len(found)


def test_how_fast_it_turns_to_the_path_and_when_it_looks_for_a_frontier_again() -> None:
    points = np.stack([np.zeros(30), 0.05 * np.arange(30)], axis=1)
    for rate in (0.1, 0.3):
        first = CellFollower(points, 0.05, ReportParams(follow_turn=rate)).step(Pose2(0.0, 0.0, 0.5 * math.pi - 0.5))
        assert first is not None and first.w_radps == pytest.approx(0.5 * rate) and first.v_mps == 0.0

    def driven_before_frontier(retry: float) -> int:
        here = rig(growth_window=5.0, retry=retry, off=("full_turn", "stuck"))
        here.held = True
        cells = np.zeros((40, 40), np.int8)
        here.map = GridMap(cells, 0.05, Pose2(-1.0, -1.0))
        here.run(10.5, scan(2.0))
        cells = cells.copy()
        cells[:, 30:] = -1
        here.map = GridMap(cells, 0.05, Pose2(-1.0, -1.0))
        here.run(10.0, scan(2.0))
        return [step.behaviour for step in here.steps].index("frontier")

    assert driven_before_frontier(4.0) - driven_before_frontier(1.0) >= 20


@pytest.mark.parametrize("numbers", [{"follow_to_go": 12}, {"follow_short": 40}])
def test_which_cell_is_driven_to(numbers: Any) -> None:
    """A path that bends after six cells: who looks farther along it turns earlier."""
    along = 0.05 * np.arange(30)
    points = np.stack([np.minimum(along, 0.3), np.maximum(along - 0.3, 0.0)], axis=1)
    near, far = (CellFollower(points, 0.05, ReportParams(**which)) for which in ({}, numbers))
    first, other = near.step(Pose2(0.0, 0.0)), far.step(Pose2(0.0, 0.0))
    assert first is not None and other is not None
    assert first.v_mps > 0.0 and other.v_mps == 0.0 and other.w_radps > 0.0
