"""Configuration space against cell-by-cell checks, and turns against the independent checker."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from typing import List, Set, Tuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from python.planning.samples import SMALL, arm, block, request, robot
from yarm.geometry import GridSpec, Mask, wrap_angle
from yarm.planning.cspace.cell_sets import CellSet, Layout, bits_of, difference, dilated, intersection, union
from yarm.planning.cspace.footprint import Shape, Smears, border_for, columns_of
from yarm.planning.cspace.robot_space import RobotSpace, ShapeCache, View, headings_from, with_margin
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.model.types import Waypoint
from yarm.planning.verification.checker import sweep_of
from yarm.robots.ankurbot import ankurbot_mask

CELL = GridSpec()
QUARTERS = turns_of((0.0, 90.0, -90.0))
Cell = Tuple[int, int, int]
CELLS = st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3), st.integers(0, 3)), min_size=1, max_size=8)


def cells_of(array: np.ndarray) -> Set[Tuple[int, ...]]:
    return set(map(tuple, array.tolist()))


def space_of(mask: Mask, occupied: np.ndarray, column: Tuple[int, int], yaw: float = 0.0) -> RobotSpace:
    problem = PlanningProblem.of(request(SMALL, occupied, [robot("r", column, mask, yaw)]), QUARTERS, ShapeCache())
    assert problem is not None
    return problem.spaces[0]


@settings(max_examples=60, deadline=None)
@given(CELLS, arrays(np.bool_, SMALL.shape, elements=st.booleans(), fill=st.just(False)))
def test_blocked_columns_are_those_where_a_cell_is_taken(cells: list, occupied: np.ndarray) -> None:
    mask = Mask(np.unique(np.array(cells), axis=0))
    layout = Layout(SMALL.shape, border_for([mask]))
    image = layout.image_of_set(Shape.of_mask(mask, layout).blocked_by(layout.set_of_grid(occupied)))
    for x in range(SMALL.shape[0]):
        for y in range(SMALL.shape[1]):
            at = mask.at((x, y))
            inside = at[SMALL.contains(at)]
            assert image[x, y] == occupied[tuple(inside.T)].any()


@settings(max_examples=60, deadline=None)
@given(st.lists(CELLS, min_size=2, max_size=3), arrays(np.bool_, SMALL.shape, elements=st.booleans()))
def test_shapes_held_against_the_same_smears_are_blocked_as_alone(robots: list, occupied: np.ndarray) -> None:
    masks = [Mask(np.unique(np.array(cells), axis=0)) for cells in robots]
    layout = Layout(SMALL.shape, border_for(masks))
    cells = layout.set_of_grid(occupied)
    smears = Smears(cells)
    for mask in masks:
        shape = Shape.of_mask(mask, layout)
        assert shape.blocked_among(smears) == shape.blocked_by(cells)


@settings(max_examples=60, deadline=None)
@given(CELLS, st.tuples(st.integers(4, 11), st.integers(4, 7)), st.tuples(st.integers(4, 11), st.integers(4, 7)))
def test_a_line_is_free_exactly_when_its_sweep_is(cells: list, a: Tuple[int, int], b: Tuple[int, int]) -> None:
    mask = Mask(np.unique(np.array(cells), axis=0))
    rng = np.random.default_rng(len(cells) + 100 * a[0] + b[1])
    occupied = rng.random(SMALL.shape) < 0.02
    space = space_of(mask, occupied, a)
    swept = space.layout.cells_of_set(space.swept((*a, 0), (*b, 0)))
    inflated = with_margin(
        space.layout.set_of_grid(occupied), space.layout.set_of_cells(mask.at(a)), space.layout.stride
    )
    touches = bool(cells_of(swept) & cells_of(space.layout.cells_of_set(inflated)))
    assert View(space, ()).line(*a, *b, 0) == (not touches)


@settings(max_examples=60, deadline=None)
@given(
    CELLS,
    st.integers(-3, 3),
    st.sampled_from([0.0, math.pi / 4, 0.3]),
    st.sampled_from([0.0, math.pi / 4, math.pi / 2, 1.0, 2 * math.pi]),
)
def test_a_turn_from_a_right_angle_on_is_that_of_the_mask_turned_there(
    cells: list, quarters: int, first: float, angle: float
) -> None:
    here = np.unique(np.array(cells), axis=0)
    there = here.copy()
    for _ in range(quarters % 4):
        there[:, :2] = np.stack([-there[:, 1], there[:, 0]], axis=-1)
    layout = Layout(SMALL.shape, border_for([Mask(here)]))
    given_turned = Shape.of_mask(Mask(there), layout).turned(first, angle, SMALL.resolution)
    turned = Shape.of_mask(Mask(here), layout).turned(quarters * math.pi / 2 + first, angle, SMALL.resolution)
    assert turned.cell_set == given_turned.cell_set
    columns = np.array(columns_of(turned.column_set, layout))
    x0, x1, y0, y1 = turned.bounds
    assert ((x0, y0), (x1, y1)) == (tuple(columns.min(axis=0)), tuple(columns.max(axis=0)))


@pytest.mark.parametrize("angle", [90.0, -90.0, 37.0])
@pytest.mark.parametrize("mask", [arm(6), block(2, 1)], ids=["arm", "block"])
def test_a_move_sweeps_what_the_independent_checker_says(mask: Mask, angle: float) -> None:
    one = robot("r", (8, 6), mask)
    ask = request(SMALL, np.zeros(SMALL.shape, bool), [one])
    problem = PlanningProblem.of(ask, turns_of((0.0, angle)), ShapeCache())
    assert problem is not None
    space = problem.spaces[0]
    h = min(range(len(space.headings)), key=lambda i: abs(math.remainder(space.headings[i] - math.radians(angle), 7)))
    mine = cells_of(space.layout.cells_of_set(space.swept((8, 6, 0), (10, 7, h))))
    ask = request(SMALL, np.zeros(SMALL.shape, bool), [one])
    swept = sweep_of(ask, one, Waypoint((10, 7), space.headings[h])).cells
    theirs = cells_of(swept[SMALL.contains(swept)])
    assert theirs <= mine
    if abs(angle) == 90.0:
        assert len(mine - theirs) <= 0.03 * len(theirs)
    inflated = dilated(space.layout.set_of_cells(swept), space.layout.stride)
    assert mine <= cells_of(space.layout.cells_of_set(inflated))


def test_all_quarter_turns_come_from_one_sweep() -> None:
    cache = ShapeCache()
    one = robot("r", (8, 6), arm(5), 30.0)
    problem = PlanningProblem.of(request(SMALL, np.zeros(SMALL.shape, bool), [one]), QUARTERS, cache)
    assert problem is not None
    space = problem.spaces[0]
    assert len(space.headings) == 4
    direct = space.shape0.turned(-math.pi / 2, math.pi / 2, SMALL.resolution)
    k = next(k for k in range(4) if abs(math.remainder(space.headings[k] - one.yaw_rad + math.pi / 2, 7)) < 1e-6)
    assert space.turn_shape(0, k).cell_set == direct.cell_set


@given(CELLS, CELLS, CELLS)
def test_shapes_have_cells_in_common_and_together(one: List[Cell], other: List[Cell], third: List[Cell]) -> None:
    layout = Layout(SMALL.shape, 6)
    a, b, c = (Shape.of_mask(Mask(np.array(cells)), layout) for cells in (one, other, third))
    both, all_three = a.common(b), a.together(b, c)
    assert both.cell_set == intersection(a.cell_set, b.cell_set)
    assert all_three.cell_set == union(union(a.cell_set, b.cell_set), c.cell_set)
    for made in (both, all_three):
        columns = [column for _, group in made.groups for column in columns_of(group, layout)]
        assert len(columns) == len(set(columns))


def size(cell_set: CellSet) -> int:
    """Number of cells."""
    return sum(len(bits_of(layer)) for layer in cell_set)


def test_with_masks_at_every_heading_shapes_are_these_and_turns_cover_all_between() -> None:
    one = robot("r", (25, 25), ankurbot_mask(CELL, 0.3))
    one = replace(one, yaw_rad=0.3, mask_at=partial(ankurbot_mask, CELL))
    turns = turns_of((0.0, 90.0, -90.0, 45.0, -45.0))
    problem = PlanningProblem.of(request(CELL, np.zeros(CELL.shape, bool), [one]), turns, ShapeCache())
    assert problem is not None
    space = problem.spaces[0]
    assert len(space.headings) == 8
    for h, yaw in enumerate(space.headings):
        assert space.shape(h).cell_set == Shape.of_mask(ankurbot_mask(CELL, yaw), space.layout).cell_set
        k = min(range(8), key=lambda k: abs(wrap_angle(space.headings[k] - yaw - math.pi / 4)))
        turn = space.turn_shape(h, k)
        assert turn.cell_set == space.turn_shape(k, h).cell_set
        onward = space.shape(h).turned(0.0, math.pi / 4, CELL.resolution)
        back = space.shape(k).turned(-math.pi / 4, math.pi / 4, CELL.resolution)
        both = intersection(onward.cell_set, back.cell_set)
        assert turn.cell_set == union(union(both, space.shape(h).cell_set), space.shape(k).cell_set)
        assert size(turn.cell_set) < 0.95 * size(onward.cell_set)
        for part in np.linspace(0.0, math.pi / 4, 9):
            between = Shape.of_mask(ankurbot_mask(CELL, yaw + part), space.layout)
            assert difference(between.cell_set, turn.cell_set) == (0,) * CELL.shape[2]


def test_the_border_has_no_margin_and_a_robot_outside_may_only_come_in() -> None:
    space = space_of(block(3, 2), np.zeros(SMALL.shape, bool), (14, 5))
    view = View(space, ())
    assert view.stands((13, 10, 0))
    assert view.stands((14, 5, 0))
    assert not view.stands((15, 5, 0))
    assert not view.stands((13, 11, 0))
    inside = space_of(block(3, 2), np.zeros(SMALL.shape, bool), (10, 5))
    assert not View(inside, ()).stands((14, 5, 0))


def test_what_is_beside_the_robot_already_keeps_no_margin_but_stays_an_obstacle() -> None:
    occupied = np.zeros(SMALL.shape, bool)
    occupied[7, :, :] = True
    view = View(space_of(block(1, 1), occupied, (6, 5)), ())
    assert view.stands((6, 5, 0))
    assert view.line(6, 5, 2, 5, 0)
    assert not view.stands((7, 5, 0))
    assert not view.stands((6, 8, 0))
    assert not view.line(6, 5, 6, 8, 0)


def test_another_robot_keeps_its_margin_wherever_it_stands() -> None:
    robots = [robot("a", (2, 2), block(2, 2)), robot("b", (10, 6), arm(4))]
    problem = PlanningProblem.of(request(SMALL, np.zeros(SMALL.shape, bool), robots), QUARTERS, ShapeCache())
    assert problem is not None
    a, b = problem.spaces
    for pose in ((9, 5, 0), (6, 3, 1), (12, 8, 2)):
        view = View(a, [(b, pose)])
        stride = a.layout.stride
        inflated = dilated(b.shape(pose[2]).at(pose[:2]), stride)
        for x in range(15):
            for y in range(11):
                free = not any(p & q for p, q in zip(a.shape0.at((x, y)), inflated))
                assert view.stands((x, y, 0)) == free


def test_headings_close_under_the_turns_and_the_wanted_one_comes_last() -> None:
    assert len(headings_from(0.1, QUARTERS, None)) == 4
    assert len(headings_from(0.1, turns_of((0.0,)), None)) == 1
    headings = headings_from(0.1, QUARTERS, 1.0)
    assert headings[0] == pytest.approx(0.1)
    assert headings[-1] == pytest.approx(1.0)
    assert len(headings_from(0.0, turns_of((7.0,)), None)) <= 36


@given(st.floats(-math.pi, math.pi))
def test_eighth_turns_lead_to_the_same_eight_headings_in_the_same_order_from_everywhere(yaw_rad: float) -> None:
    headings = headings_from(yaw_rad, turns_of((0.0, 90.0, -90.0, 45.0, -45.0)), None)
    wanted = [0, 90, -90, 45, -45, 180, 135, -135]
    assert [abs(wrap_angle(a - yaw_rad - math.radians(b))) < 1e-9 for a, b in zip(headings, wanted)] == [True] * 8


def test_between_the_headings_it_keeps_to_a_robot_may_turn_to_the_next_of_them_and_not_back() -> None:
    astray = replace(robot("r", (7, 5), block(1, 1), 37.0), home_yaw_rad=math.pi)
    problem = PlanningProblem.of(request(SMALL, np.zeros(SMALL.shape, bool), [astray]), QUARTERS, ShapeCache())
    assert problem is not None
    space = problem.spaces[0]
    degrees = [round(math.degrees(heading)) % 360 for heading in space.headings]
    assert (degrees[:4], sorted(degrees[4:])) == ([37, 127, 307, 217], [0, 90, 180, 270])
    turns = {(degrees[h], degrees[k]) for h in range(8) for k in range(8) if space.turn_angle(h, k) is not None}
    assert {k for h, k in turns if h == 37} == {127, 307, 0, 90}
    assert {k for h, k in turns if h == 90} == {0, 180}
    at_home = replace(astray, yaw_rad=math.radians(90.3))
    assert headings_from(at_home.yaw_rad, QUARTERS, None, math.pi) == headings_from(at_home.yaw_rad, QUARTERS, None)


def test_forbidden_columns_may_not_be_entered_but_may_be_left() -> None:
    forbidden = np.zeros(SMALL.shape[:2], bool)
    forbidden[6:] = True
    robots = [robot("r", (6, 5), block(1, 1))]
    problem = PlanningProblem.of(
        request(SMALL, np.zeros(SMALL.shape, bool), robots, forbidden=forbidden), QUARTERS, ShapeCache()
    )
    assert problem is not None
    view = View(problem.spaces[0], ())
    assert view.line(6, 5, 2, 5, 0)
    assert not view.stands((7, 5, 0))
