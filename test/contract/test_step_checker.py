"""The independent checker: what it must refuse, what it must allow, and that brute force agrees."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from yarm.geometry import GridSpec, Mask
from yarm.planning.model.types import FleetPlan, PlanRequest, PlanStatus, Robot, RobotPlan, Waypoint, without_robots
from yarm.planning.verification.bruteforce import touches
from yarm.planning.verification.checker import check_step, chessboard_clearance, robotless_map, sweep_of
from yarm.robots.ankurbot import ankurbot_mask

POINT = [(0, 0, 0)]
BAR = [(0, 0, 0), (-1, 0, 0), (-2, 0, 0), (-3, 0, 0)]
QUARTER = math.pi / 2.0


def test_free_motion_is_safe(request_of, plan_of):
    request = request_of((12, 12, 2), {"a": ((2, 2), POINT)})
    assert check_step(request, plan_of(a=((9, 7), 0.0))).safe


def test_overlap_on_the_way_is_refused_and_named(request_of, plan_of):
    request = request_of((12, 12, 2), {"a": ((2, 2), POINT)}, boxes={"crate": [(5, 2, 0)]})
    verdict = check_step(request, plan_of(a=((9, 2), 0.0)))
    assert not verdict.safe and "a" in verdict.reason and "crate" in verdict.reason
    assert (5, 2, 0) in {tuple(int(v) for v in cell) for cell in verdict.cells}


@pytest.mark.parametrize("offset,safe", [((1, 0), False), ((1, 1), False), ((0, 2), True), ((2, 2), True)])
def test_margin_is_all_26_neighbours(request_of, plan_of, offset, safe):
    box = (6 + offset[0], 5 + offset[1], 0)
    request = request_of((12, 12, 3), {"a": ((2, 5), POINT)}, boxes={"crate": [box]})
    assert check_step(request, plan_of(a=((6, 5), 0.0))).safe is safe


@pytest.mark.parametrize("z,safe", [(0, False), (1, False), (2, True)])
def test_margin_counts_in_height(request_of, plan_of, z, safe):
    request = request_of((12, 12, 3), {"a": ((2, 5), POINT)}, boxes={"crate": [(6, 5, z)]})
    assert check_step(request, plan_of(a=((9, 5), 0.0))).safe is safe


def test_diagonal_move_takes_both_cells_beside_it(request_of, plan_of):
    request = request_of((8, 8, 1), {"a": ((2, 2), POINT)}, boxes={"crate": [(1, 4, 0)]})
    assert not check_step(request, plan_of(a=((3, 3), 0.0))).safe, "(2, 3) is swept and beside (1, 4)"
    far = request_of((8, 8, 1), {"a": ((2, 2), POINT)}, boxes={"crate": [(0, 4, 0)]})
    assert check_step(far, plan_of(a=((3, 3), 0.0))).safe


def test_turn_sweeps_between_free_ends(request_of, plan_of):
    """Start and end of the turn are clear of the crate, the way between is not."""
    boxes = {"crate": [(7, 7, 0)]}
    request = request_of((20, 20, 1), {"a": ((10, 10), BAR)}, boxes=boxes)
    sweep = sweep_of(request, request.robots[0], Waypoint((10, 10), QUARTER))
    assert {tuple(c) for c in sweep.end} == {(10, 10, 0), (10, 9, 0), (10, 8, 0), (10, 7, 0)}
    assert (8, 8, 0) in {tuple(c) for c in sweep.cells}
    assert not check_step(request, plan_of(a=((10, 10), QUARTER))).safe
    assert check_step(request, plan_of(a=((10, 10), -QUARTER))).safe


def test_half_turn_is_swept_both_ways_round(request_of):
    request = request_of((20, 20, 1), {"a": ((10, 10), BAR)})
    cells = {tuple(c) for c in sweep_of(request, request.robots[0], Waypoint((10, 10), math.pi)).cells}
    assert (10, 7, 0) in cells and (10, 13, 0) in cells


def test_robots_that_cross_are_refused_even_when_their_ends_are_free(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((2, 6), POINT), "b": ((6, 2), POINT)})
    verdict = check_step(request, plan_of(a=((10, 6), 0.0), b=((6, 10), 0.0)))
    assert not verdict.safe and "a and b" in verdict.reason
    assert check_step(request, plan_of(a=((10, 6), 0.0))).safe


def test_staying_robot_is_an_obstacle_with_its_margin(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((2, 6), POINT), "b": ((6, 7), POINT)})
    assert not check_step(request, plan_of(a=((10, 6), 0.0), b=None)).safe
    assert check_step(request, plan_of(a=((2, 3), 0.0))).safe


def test_swap_is_refused(request_of, plan_of):
    request = request_of((12, 4, 1), {"a": ((2, 2), POINT), "b": ((8, 2), POINT)})
    assert not check_step(request, plan_of(a=((8, 2), 0.0), b=((2, 2), 0.0))).safe


def test_robot_beside_an_obstacle_may_stay_or_leave_but_not_overlap(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((5, 5), POINT)}, boxes={"crate": [(6, 5, 0)]})
    assert check_step(request, plan_of(a=None)).safe
    assert check_step(request, plan_of(a=((2, 5), 0.0))).safe
    assert not check_step(request, plan_of(a=((7, 5), 0.0))).safe


def test_robot_beside_an_obstacle_gets_no_exemption_for_others(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((5, 5), POINT)}, boxes={"crate": [(6, 5, 0)], "wall": [(2, 4, 0)]})
    assert not check_step(request, plan_of(a=((3, 5), 0.0))).safe


def test_robots_side_by_side_may_part(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((5, 5), POINT), "b": ((6, 5), POINT)})
    assert check_step(request, plan_of(a=((2, 5), 0.0))).safe
    assert check_step(request, plan_of(a=((2, 5), 0.0), b=((9, 5), 0.0))).safe
    assert not check_step(request, plan_of(a=((9, 5), 0.0))).safe


def test_border_of_the_volume(request_of, plan_of):
    request = request_of((10, 10, 1), {"a": ((5, 5), BAR)})
    assert check_step(request, plan_of(a=((3, 5), 0.0))).safe, "the border has no margin"
    assert not check_step(request, plan_of(a=((2, 5), 0.0))).safe


def test_cells_outside_the_grid_count_as_beside_an_obstacle_too(request_of, plan_of):
    """The cell at (-1, 5) is beside the crate already, so it may come in past it; nobody may come in upon it."""
    two = [(0, 0, 0), (-3, 0, 0)]
    request = request_of((12, 12, 2), {"a": ((2, 5), two)}, boxes={"crate": [(0, 4, 0)]})
    assert check_step(request, plan_of(a=((4, 5), 0.0))).safe
    assert not check_step(request, plan_of(a=((4, 4), 0.0))).safe, "touches it"
    further = request_of((12, 12, 2), {"a": ((2, 6), two)}, boxes={"crate": [(0, 4, 0)]})
    assert not check_step(further, plan_of(a=((4, 5), 0.0))).safe, "beside it only on the way"


def test_robot_partly_outside_may_only_move_inward(request_of, plan_of):
    request = request_of((10, 10, 1), {"a": ((2, 5), BAR)})
    assert check_step(request, plan_of(a=((5, 5), 0.0))).safe
    assert not check_step(request, plan_of(a=((1, 5), 0.0))).safe


def test_forbidden_columns(request_of, plan_of):
    forbidden = np.zeros((10, 10), dtype=bool)
    forbidden[6:, :] = True
    request = request_of((10, 10, 1), {"a": ((2, 5), POINT)}, forbidden=forbidden)
    assert not check_step(request, plan_of(a=((7, 5), 0.0))).safe
    assert check_step(request, plan_of(a=((5, 5), 0.0))).safe
    inside = request_of((10, 10, 1), {"a": ((7, 5), POINT)}, forbidden=forbidden)
    assert check_step(inside, plan_of(a=((3, 5), 0.0))).safe
    assert not check_step(inside, plan_of(a=((8, 5), 0.0))).safe


def test_goal_debris_is_no_obstacle_once_assigned(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((2, 5), POINT)}, goals={"a": (6, 5)}, boxes={"debris": [(6, 5, 0)]})
    assert not check_step(request, plan_of(a=((6, 5), 0.0))).safe
    goal = replace(request.goals["goal_a"], cells=np.array([[6, 5, 0]]))
    assert check_step(replace(request, goals={"goal_a": goal}), plan_of(a=((6, 5), 0.0))).safe


def test_motion_from_off_the_centre_must_not_overlap(request_of, plan_of):
    """From the column's centre the slide clears the wall; from half a cell aside it does not."""
    wall = [(x, 4, 0) for x in range(12)]
    request = request_of((12, 12, 1), {"a": ((5, 5), POINT)}, boxes={"wall": wall})
    assert check_step(request, plan_of(a=((5, 7), 0.0))).safe
    bar = request_of((12, 12, 1), {"a": ((5, 5), [(0, 0, 0), (-1, 0, 0)])}, boxes={"wall": wall})
    shifted = replace(bar.robots[0], position_m=(0.55, 0.59))
    assert not check_step(replace(bar, robots=(shifted,)), plan_of(a=((5, 7), QUARTER))).safe


def test_plan_for_an_unknown_robot_and_headings_that_are_not_finite(request_of, plan_of):
    request = request_of((12, 12, 1), {"a": ((2, 5), POINT)})
    assert not check_step(request, plan_of(ghost=((3, 5), 0.0))).safe
    assert not check_step(request, plan_of(a=((3, 5), float("nan")))).safe


def test_clearance_counts_free_cells(request_of):
    request = request_of((12, 12, 1), {"a": ((2, 5), POINT), "b": ((2, 10), POINT)}, boxes={"crate": [(7, 8, 0)]})
    sweeps = [sweep_of(request, request.robots[0], Waypoint((9, 5), 0.0)), sweep_of(request, request.robots[1], None)]
    assert chessboard_clearance(robotless_map(request), sweeps) == 2


def test_ankurbot_turn_covers_the_robot_at_every_angle():
    spec = GridSpec()
    robot = Robot("a", (30, 25), 0.0, ankurbot_mask(spec, 0.0))
    request = PlanRequest(spec, np.zeros(spec.shape, dtype=bool), (robot,), {}, {})
    swept = {tuple(c) for c in sweep_of(request, robot, Waypoint((30, 25), QUARTER)).cells}
    for angle in np.linspace(0.0, QUARTER, 46):
        assert {tuple(c) for c in ankurbot_mask(spec, float(angle)).at((30, 25))} <= swept


def test_ankurbot_mask_has_the_extent_of_the_robot():
    cells = ankurbot_mask(GridSpec(), 0.0).cells
    assert (np.ptp(cells, axis=0) + 1).tolist() == [17, 7, 15]
    assert cells.min(axis=0).tolist() == [-16, -3, 0] and cells.max(axis=0).tolist() == [0, 3, 14]


cell = st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(0, 1))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    mask=st.lists(cell, min_size=1, max_size=6),
    boxes=st.lists(st.tuples(st.integers(0, 13), st.integers(0, 13), st.integers(0, 1)), max_size=4),
    start=st.tuples(st.integers(4, 9), st.integers(4, 9)),
    end=st.tuples(st.integers(0, 13), st.integers(0, 13)),
    turn_deg=st.sampled_from([0.0, 0.0, 90.0, -90.0, 30.0, 180.0]),
)
def test_brute_force_finds_nothing_in_a_step_called_safe(mask, boxes, start, end, turn_deg):
    spec = GridSpec((14, 14, 2), (0.0, 0.0, 0.0), (1.4, 1.4, 0.2))
    robot = Robot("a", start, 0.3, Mask.from_cells(np.array(mask), (0, 0), 0.3))
    occupied = np.zeros(spec.shape, dtype=bool)
    for box in boxes:
        occupied[box] = True
    request = PlanRequest(spec, without_robots(spec, occupied, (robot,)), (robot,), {}, {})
    step = Waypoint(end, 0.3 + math.radians(turn_deg))
    plan = FleetPlan(PlanStatus.SOLVED, "", {"a": RobotPlan("a", "", PlanStatus.SOLVED, step=step)})
    verdict = check_step(request, plan)
    found = touches(request, plan)
    if verdict.safe:
        assert not found
    elif found:
        assert verdict.reason
