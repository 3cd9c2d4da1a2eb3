"""Ways of one robot: short, checked, and found whenever there is one."""

from __future__ import annotations

import math
from typing import Optional, Tuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from python.planning.samples import arm, block, request, robot, walls
from yarm.geometry import GridSpec, Mask
from yarm.planning.cspace.robot_space import ShapeCache, View
from yarm.planning.fleet.problem import PlanningProblem, turns_of
from yarm.planning.roadmap.particles import cell_order
from yarm.planning.roadmap.roadmap import Roadmap, even_roadmap
from yarm.planning.roadmap.search import (
    Flooding,
    Path,
    Target,
    _Search,
    find_path,
    flood,
    merged,
    path_cost,
    reachable,
    search,
)

SPEC = GridSpec((30, 24, 4), (0.0, 0.0, 0.0), (3.0, 2.4, 0.4))
ROADMAP = Roadmap.of(cell_order((30, 24))[:60].astype(np.int64))


def view_of(mask: Mask, occupied: np.ndarray, column: Tuple[int, int], turns: Tuple[float, ...] = (0.0,)) -> View:
    ask = request(SPEC, occupied, [robot("r", column, mask)])
    problem = PlanningProblem.of(ask, turns_of(turns), ShapeCache())
    assert problem is not None
    return View(problem.spaces[0], ())


def assert_checked(view: View, path: Optional[Path], start: Tuple[int, int, int], goal: Tuple[int, int]) -> None:
    assert path is not None
    assert path[0] == start
    assert path[-1][:2] == goal
    assert all(view.move(a, b) for a, b in zip(path, path[1:]))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10**6))
def test_a_way_is_found_exactly_when_one_exists_through_cells(seed: int) -> None:
    rng = np.random.default_rng(seed)
    occupied = np.zeros(SPEC.shape, bool)
    occupied[rng.random(SPEC.shape[:2]) < 0.035] = True
    occupied[1, 1] = False
    view = view_of(block(1, 1), occupied, (1, 1))
    free = ~view.space.layout.image_of_set(view.blocked(0))
    labels, _ = ndimage.label(free)
    goal = tuple(int(v) for v in rng.integers(0, SPEC.shape[:2]))
    exists = bool(free[goal]) and labels[goal] == labels[1, 1]
    path = find_path(view, ROADMAP, (1, 1, 0), Target(goal))
    if exists:
        assert_checked(view, path, (1, 1, 0), goal)
    else:
        assert path is None


def test_the_way_around_a_wall_is_as_short_as_the_taut_string() -> None:
    view = view_of(block(1, 1), walls(SPEC, [(14, 16, 0, 18)]), (4, 4))
    path = find_path(view, ROADMAP, (4, 4, 0), Target((26, 4)))
    assert_checked(view, path, (4, 4, 0), (26, 4))
    taut = math.dist((4, 4), (13, 19)) + 3 + math.dist((16, 19), (26, 4))
    assert path is not None
    assert path_cost(view, path) <= 1.03 * taut


def test_a_gap_no_particle_lies_in_is_found_by_adding_particles() -> None:
    gap = next(y for y in range(3, 20) if not any(12 <= x <= 18 and p == y for x, p in ROADMAP.columns))
    view = view_of(block(1, 1), walls(SPEC, [(14, 17, 0, gap - 1), (14, 17, gap + 2, 24)]), (4, 4))
    assert search(view, ROADMAP, (4, 4, 0), Target((26, 20))) is None
    assert_checked(view, find_path(view, ROADMAP, (4, 4, 0), Target((26, 20))), (4, 4, 0), (26, 20))


def test_a_robot_turns_where_it_must_and_only_then() -> None:
    turns = (0.0, 90.0, -90.0)
    view = view_of(arm(5), np.zeros(SPEC.shape, bool), (10, 12), turns)
    straight = find_path(view, ROADMAP, (10, 12, 0), Target((25, 20)))
    assert straight == ((10, 12, 0), (25, 20, 0))
    corner = find_path(view, ROADMAP, (10, 12, 0), Target((1, 12)))
    assert_checked(view, corner, (10, 12, 0), (1, 12))
    assert corner is not None
    assert corner[-1][2] != 0


def test_a_wanted_heading_is_reached() -> None:
    view = view_of(arm(5), np.zeros(SPEC.shape, bool), (15, 12), (0.0, 90.0, -90.0))
    path = find_path(view, ROADMAP, (15, 12, 0), Target((15, 12), 3))
    assert path is not None
    assert path[-1] == (15, 12, 3)
    assert all(view.move(a, b) for a, b in zip(path, path[1:]))


def test_flood_and_wander_reach_the_same_cells() -> None:
    view = view_of(block(2, 2), walls(SPEC, [(14, 16, 0, 20)]), (4, 4))
    reached = reachable(view, (4, 4, 0))
    image = view.space.layout.image_of_set(reached[0])
    for column in ((26, 4), (4, 20), (12, 21)):
        bit = 1 << view.space.layout.bit(*column)
        way = flood(view, (4, 4, 0), lambda h, bit=bit: bit)
        assert (way is not None) == image[column]
        if way is not None:
            assert all(abs(a[0] - b[0]) + abs(a[1] - b[1]) == 1 for a, b in zip(way, way[1:]))
        pose = (0, bit.bit_length() - 1) if image[column] else None
        chosen = Flooding(view, (4, 4, 0)).wander(lambda _, pose=pose: pose)
        assert (chosen is None) == (way is None)


@pytest.mark.parametrize("seed", range(4))
def test_a_flooding_that_is_asked_again_says_what_a_new_one_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    view = view_of(arm(5), walls(SPEC, [(14, 16, 0, 20)]), (4, 12), (0.0, 45.0, -45.0, 90.0, -90.0))
    start, kept = (4, 12, 0), Flooding(view, (4, 12, 0))
    layout, found = view.space.layout, 0
    for column in rng.integers((0, 0), (30, 24), (30, 2)).tolist():
        bit, heading = 1 << layout.bit(*column), int(rng.integers(3))
        way = kept.way(lambda h, bit=bit, heading=heading: bit if h == heading else 0)
        assert way == flood(view, start, lambda h, bit=bit, heading=heading: bit if h == heading else 0), f"seed {seed}"
        found += way is not None
    assert 3 < found < 30
    assert kept.reached() == reachable(view, start)
    assert kept.size_bytes > 1000


def test_a_goal_that_only_another_heading_fits_is_reached_with_few_expansions(monkeypatch: pytest.MonkeyPatch) -> None:
    """The turn that the goal needs counts from the start on, so the search does not flood the present heading first."""
    turns = (0.0, 90.0, -90.0)
    view = view_of(arm(5), walls(SPEC, [(20, 22, 8, 17)]), (10, 12), turns)
    assert not view.stands((24, 12, 0))
    expanded = []
    expand = _Search._expand

    def counted(self: _Search, state: Tuple[int, int], cost: float) -> None:
        expanded.append(state)
        expand(self, state, cost)

    monkeypatch.setattr(_Search, "_expand", counted)
    path = search(view, ROADMAP, (10, 12, 0), Target((24, 12)))
    assert_checked(view, path, (10, 12, 0), (24, 12))
    assert path is not None
    cost = path_cost(view, path)
    monkeypatch.setattr(_Search, "_least_turn", lambda self, h: 0.0)
    with_turns, expanded[:] = len(expanded), []
    blind = search(view, ROADMAP, (10, 12, 0), Target((24, 12)))
    assert blind is not None
    assert cost <= path_cost(view, blind) + 1e-9
    assert with_turns < len(expanded)


def test_moves_are_merged_into_turn_then_translation() -> None:
    assert merged([(1, 1, 0), (1, 1, 0), (1, 1, 2), (5, 1, 2)]) == ((1, 1, 0), (5, 1, 2))
    assert merged([(1, 1, 0), (4, 1, 0), (4, 1, 1)]) == ((1, 1, 0), (4, 1, 0), (4, 1, 1))


@pytest.mark.parametrize("count", [1, 2, 5])
def test_few_particles_are_enough(count: int) -> None:
    roadmap = Roadmap.of(cell_order((30, 24))[:count].astype(np.int64))
    view = view_of(block(1, 1), walls(SPEC, [(14, 16, 0, 20)]), (4, 4))
    assert_checked(view, find_path(view, roadmap, (4, 4, 0), Target((26, 4))), (4, 4, 0), (26, 4))


@pytest.mark.parametrize(("ceiling", "added"), [(None, True), (20, True), (12, False)])
def test_no_search_uses_more_particles_than_the_ceiling_and_none_fails_for_it(
    ceiling: Optional[int], added: bool
) -> None:
    gap = next(y for y in range(3, 20) if not any(12 <= x <= 18 and p == y for x, p in ROADMAP.columns))
    view = view_of(block(1, 1), walls(SPEC, [(14, 17, 0, gap - 1), (14, 17, gap + 2, 24)]), (4, 4))
    roadmap = even_roadmap((30, 24), 12, 0, 1.0, ceiling)
    assert find_path(view, roadmap, (4, 4, 0), Target((10, 4))) is not None
    assert roadmap.used == 0, "a straight way needs none"
    assert_checked(view, find_path(view, roadmap, (4, 4, 0), Target((26, 20))), (4, 4, 0), (26, 20))
    assert (roadmap.used > 12) is added
    assert roadmap.used <= (ceiling or math.inf)


def test_added_particles_extend_the_graph_and_leave_the_triangulation_alone() -> None:
    order = cell_order((30, 24)).astype(np.int64)
    base = Roadmap.of(order[:40], order[40:60])
    larger = base.denser(lambda columns: columns[:, 0] < 15)
    assert np.array_equal(larger.particles, base.particles), "nothing is added before a search asks"
    assert set(larger.nearest((7, 12), 60)) == {i for i in range(60) if i < 40 or order[i, 0] < 15}
    assert len(larger.particles) > 40
    assert np.array_equal(larger.edges[: len(base.edges)], base.edges)
    used = larger.nearest((0, 0), 60)
    neighbours = {i: larger.neighbours(i) for i in used}
    assert all(neighbours.values())
    assert all(i in neighbours[j] for i in used for j in neighbours[i])
    edges = {tuple(sorted((i, j))) for i in used for j in neighbours[i]}
    shown = {tuple(sorted(map(order.tolist().index, larger.particles[edge].tolist()))) for edge in larger.edges}
    assert shown == edges
