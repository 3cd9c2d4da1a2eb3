"""The fleet: views with the others standing somewhere, ways alone, targets, costs."""

from __future__ import annotations

import math

import pytest

from python.planning.fleet_samples import FLEETS, OPEN, SPEC, blocks, fleet_of, goals
from python.planning.samples import walls
from yarm.planning.fleet.fleet import Move, Progress, free_path


def test_the_others_are_in_the_way_where_they_stand_by_then() -> None:
    fleet = FLEETS["swap"]
    path = ((2, 12, 0), (26, 12, 0))
    assert not free_path(fleet.view(0, fleet.starts), path)
    assert free_path(fleet.view(0, fleet.starts, [1]), path)
    assert free_path(fleet.view(0, ((2, 12, 0), (26, 2, 0))), path)
    assert fleet.view(0, fleet.starts) is fleet.view(0, fleet.starts), "made once"


def test_the_way_alone_knows_walls_but_no_robots() -> None:
    assert FLEETS["swap"].alone(0) == ((2, 12, 0), (26, 12, 0))
    closed = fleet_of(blocks((2, 12)), goals((26, 12)), walls(SPEC, [(14, 16, 0, 24)]))
    assert closed.alone(0) is None
    assert fleet_of(blocks((2, 12), (9, 9)), goals((26, 12)), OPEN).alone(1) is None, "it has no target"


def test_a_robot_without_a_target_is_satisfied_anywhere() -> None:
    fleet = fleet_of(blocks((2, 12), (26, 12)), goals((26, 20), (2, 12)))
    assert fleet.satisfied(0, (26, 20, 3)) and not fleet.satisfied(0, (26, 19, 0))
    fleet.restrict([1])
    assert fleet.satisfied(0, (5, 5, 0)) and not fleet.satisfied(1, (5, 5, 0))


def test_costs_are_ways_and_turns() -> None:
    fleet = FLEETS["crossing"]
    moves = [Move(0, (2, 12, 0), (5, 16, 0)), Move(1, (14, 2, 0), (14, 2, 1))]
    quarter = abs(fleet.spaces[1].headings[1]) / math.radians(10.0)
    assert fleet.cost(moves) == 5.0 + quarter and quarter == 9.0


def test_what_a_path_sweeps_is_everything_on_it() -> None:
    fleet = FLEETS["crossing"]
    layout = fleet.spaces[0].layout
    swept = layout.cells_of_set(fleet.swept(0, ((2, 12, 0), (5, 12, 0), (5, 14, 0))))
    columns = {(x, y) for x, y, _ in swept.tolist()}
    assert columns == {(x, y) for x in range(2, 7) for y in (12, 13)} | {(x, y) for x in (5, 6) for y in range(12, 16)}
    assert {z for _, _, z in swept.tolist()} == {0, 1}


def test_progress_is_copied_not_shared() -> None:
    state = Progress(((1, 1, 0), (9, 9, 0)))
    trial = state.copy()
    trial.go(0, ((1, 1, 0), (2, 1, 0), (2, 4, 1)))
    assert trial.poses == ((2, 4, 1), (9, 9, 0)) and len(trial.moves) == 2
    assert state.poses == ((1, 1, 0), (9, 9, 0)) and state.moves == []


def test_what_was_searched_is_kept_until_it_takes_too_much_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = fleet_of(blocks((2, 12), (26, 12)), goals((26, 20), (2, 12)))
    view = fleet.view(0, fleet.starts)
    first = fleet.flooding(view, (2, 12, 0))
    first.reached()
    assert fleet.flooding(view, (3, 12, 0)) is not first
    assert fleet.flooding(view, (2, 12, 0)) is first
    monkeypatch.setattr("yarm.planning.fleet.fleet.FLOODINGS_BYTES", first.size_bytes - 1)
    second = fleet.flooding(view, (4, 12, 0))
    assert fleet.flooding(view, (4, 12, 0)) is second
    assert fleet.flooding(view, (2, 12, 0)) is not first, "the oldest makes room"
