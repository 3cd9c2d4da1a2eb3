"""Ways by several waypoints: every leg is swept, and the short cut that a base makes at a corner it drives round."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from python.planning.samples import SMALL, block, request, robot, walls
from yarm.geometry import GridSpec
from yarm.planning.model.types import Robot, Waypoint
from yarm.planning.verification.checker import _known_motion, check_release, sweep_along, sweep_of
from yarm.robots.ankurbot import ankurbot_mask

CORNER, END = Waypoint((12, 3), 0.0), Waypoint((12, 9), 0.0)
FREE = walls(SMALL, [])


def cells(sweep):
    return {tuple(cell) for cell in sweep.cells.tolist()}


def test_a_way_is_its_legs_with_turns_where_they_are() -> None:
    asked = request(SMALL, FREE, [robot("a", (5, 3), block(3, 1))])
    first = sweep_of(asked, asked.robots[0], CORNER)
    along = sweep_along(asked, asked.robots[0], [CORNER, END])
    onward = sweep_of(asked, robot("a", CORNER.column, block(3, 1)), END)
    inside = cells(along) - (cells(first) | cells(onward))
    assert cells(along) >= cells(first) | cells(onward)
    assert {(x < 14 and y > 3) for x, y, _ in inside} == {True}
    assert np.array_equal(along.end, onward.end)
    turned = sweep_along(asked, asked.robots[0], [CORNER, Waypoint(END.column, math.pi / 2)])
    assert len(cells(turned) - cells(along)) > 0, "it turns at the corner"
    assert cells(turned) > cells(first)


def test_what_lies_inside_a_corner_is_touched_by_the_short_cut_and_kept_clear_of() -> None:
    fleet = [robot("a", (5, 3), block(1, 1))]
    asked = request(SMALL, FREE, fleet)
    legs = cells(sweep_of(asked, fleet[0], CORNER)) | cells(sweep_of(asked, robot("a", (12, 3), block(1, 1)), END))
    inside = cells(sweep_along(asked, fleet[0], [CORNER, END])) - legs
    assert {(x, y) for x, y, _ in inside} >= {(11, 4)}
    assert all(x < 12 and y > 3 for x, y, _ in inside)
    beside = request(SMALL, walls(SMALL, [(9, 10, 6, 7)]), fleet)
    assert check_release(beside, {"a": (CORNER,)}, {}).safe
    assert "within one cell" in check_release(beside, {"a": (CORNER, END)}, {}).reason


def test_every_leg_is_held_against_the_map_and_against_moves_under_way() -> None:
    fleet = [robot("a", (5, 3), block(1, 1)), robot("b", (2, 9), block(1, 1))]
    asked = request(SMALL, walls(SMALL, [(10, 15, 7, 8)]), fleet)
    assert check_release(asked, {"a": (CORNER,)}, {}).safe
    assert "a would" in check_release(asked, {"a": (CORNER, END)}, {}).reason
    free = request(SMALL, FREE, fleet)
    assert check_release(free, {"a": (CORNER, END)}, {}).safe
    across = Waypoint((14, 9), 0.0)
    assert "a and b would" in check_release(free, {"b": (across,)}, {"a": (CORNER, END)}).reason
    assert check_release(free, {"b": (across,)}, {"a": (CORNER,)}).safe
    assert "nan" in check_release(free, {"a": (CORNER, Waypoint(END.column, math.nan))}, {}).reason


def test_a_turn_between_two_known_masks_is_what_both_of_them_may_sweep() -> None:
    """Every mask on the way is in it, nothing that the mask before does not sweep, and it ends with the last."""
    cell = GridSpec()
    before = Robot("a", (25, 25), 0.0, ankurbot_mask(cell, 0.0))
    known = replace(before, mask_at=partial(ankurbot_mask, cell))
    asked = request(cell, np.zeros(cell.shape, bool), [before])
    end = Waypoint((25, 25), math.radians(-45.0))
    turned, drawn = sweep_of(asked, before, end), sweep_of(asked, known, end)
    assert cells(drawn) < cells(turned)
    assert np.array_equal(drawn.end, ankurbot_mask(cell, end.yaw_rad).at(end.column))
    for yaw in np.linspace(0.0, end.yaw_rad, 10):
        assert {tuple(c) for c in ankurbot_mask(cell, yaw).at((25, 25)).tolist()} <= cells(drawn)
    real = sweep_of(asked, replace(known, position_m=(0.08, 0.03)), end)
    assert len(real.real) != len(real.cells)


def test_a_motion_that_is_remembered_is_that_which_is_reckoned_anew() -> None:
    rng, around = np.random.default_rng(8), request(SMALL, walls(SMALL, []), [])
    fleet = [robot("a", (8, 8), block(3, 1)), robot("a", (8, 8), block(1, 3)), robot("a", (9, 8), block(3, 1))]
    places = [Waypoint((int(x), int(y)), yaw) for x, y in rng.integers(4, 12, (4, 2)) for yaw in (0.0, math.pi / 2)]
    asked = [(one, place) for one in fleet for place in places]
    remembered = [sweep_of(around, one, place) for one, place in asked * 2][len(asked) :]
    for (one, place), before in zip(asked, remembered):
        _known_motion.cache_clear()
        anew = sweep_of(around, one, place)
        for kind in ("start", "cells", "real", "end"):
            assert np.array_equal(getattr(before, kind), getattr(anew, kind)), (
                f"seed 8, {one.column} to {place}: {kind}"
            )
        assert not before.cells.flags.writeable
    assert len({sweep.cells.tobytes() for sweep in remembered}) > len(asked) // 2
