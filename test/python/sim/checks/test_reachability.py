"""Where a robot can go: free configurations and what is reached from one, against slow counting."""

from __future__ import annotations

import math
from collections import deque
from functools import partial
from itertools import product
from typing import Dict, List, Sequence, Set, Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray, GridSpec, quaternion_from_rpy, transform_matrix
from yarm.geometry.urdf import LinkSolid
from yarm.robots.ankurbot import Beam
from yarm.robots.shapes import RobotShape
from yarm.robots.turns import FINER_TURNS_DEG, QUARTER_TURNS_DEG
from yarm.sim.checks.reachability import SAMPLE_M, ConfigurationSpace, pairs, solid_points
from yarm.sim.scenes.bodies import FramedSolid

SPEC = GridSpec((12, 12, 3), (0.0, 0.0, 0.0), (1.2, 1.2, 0.3))
BAR = partial(RobotShape((), (Beam((-0.34, 0.04), (-0.04, 0.04), (0.11, 0.19)),)).mask, SPEC)
"""A robot that reaches three cells behind its end effector, in the middle layer."""
GAP = {4, 5, 6, 7, 8}
Place = Tuple[int, int, int]
"""Steps of five degrees from the first heading, and a column."""


def wall(x: int, gap: Set[int]) -> FloatArray:
    """Points in the middle of the cells of a wall across the grid, with a gap; all layers."""
    rows = [y for y in range(12) if y not in gap]
    return np.array([[0.1 * x + 0.05, 0.1 * y + 0.05, 0.1 * z + 0.05] for y in rows for z in range(3)])


def free_by_counting(obstacles: FloatArray, yaw_rad: float, x: int, y: int) -> bool:
    """Every cell inside, and none with an obstacle among its 26 neighbours."""
    taken = {tuple(cell) for cell in np.floor(obstacles / 0.1 + 1e-9).astype(int).tolist()}
    for dx, dy, z in BAR(yaw_rad).cells.tolist():
        if not (0 <= x + dx < 12 and 0 <= y + dy < 12):
            return False
        if any((x + dx + i, y + dy + j, z + k) in taken for i, j, k in product((-1, 0, 1), repeat=3)):
            return False
    return True


@pytest.fixture(name="space", scope="module")
def space_fixture() -> ConfigurationSpace:
    """A bar in two halves of a grid, joined by a gap of five cells."""
    return ConfigurationSpace(BAR, wall(6, GAP), SPEC)


def test_free_is_what_counting_says(space: ConfigurationSpace) -> None:
    for yaw_deg in range(0, 360, 50):
        for x, y in product(range(12), repeat=2):
            yaw_rad = math.radians(yaw_deg)
            assert space.free_at(yaw_rad)[x, y] == free_by_counting(wall(6, GAP), yaw_rad, x, y), (yaw_deg, x, y)


def reached_by_flooding(space: ConfigurationSpace, start: Place, turns_deg: Sequence[float]) -> Set[Place]:
    """Places that steps to neighbouring columns and turns lead to; a turn is looked at every five degrees."""

    def free(steps: int, x: int, y: int) -> bool:
        inside = 0 <= x < 12 and 0 <= y < 12
        return inside and bool(space.free_at(math.radians(5.0 * steps))[x, y])

    seen, ring = {start}, deque([start])
    while ring:
        steps, x, y = ring.popleft()
        news: List[Place] = [(steps, x + 1, y), (steps, x - 1, y), (steps, x, y + 1), (steps, x, y - 1)]
        for turn in (round(angle / 5.0) for angle in turns_deg):
            sign = 1 if turn > 0 else -1
            if all(free(steps + sign * k, x, y) for k in range(abs(turn) + 1)):
                news.append(((steps + turn) % 72, x, y))
        for new in news:
            if new not in seen and free(*new):
                seen.add(new)
                ring.append(new)
    return seen


@pytest.mark.parametrize("turns_deg", [QUARTER_TURNS_DEG, (*QUARTER_TURNS_DEG, *FINER_TURNS_DEG), (0.0, 10.0, -10.0)])
@pytest.mark.parametrize("start", [(0, 4, 6), (36, 8, 6), (70, 4, 1), (3, 4, 6)])
def test_reachable_is_what_flooding_finds(space: ConfigurationSpace, start: Place, turns_deg: Sequence[float]) -> None:
    steps, x, y = start
    assert space.free_at(math.radians(5.0 * steps))[x, y]
    reached = space.reachable((x, y), math.radians(5.0 * steps), turns_deg)
    found = {
        (round(math.degrees(heading) / 5.0) % 72, int(x), int(y))
        for heading, columns in zip(reached.headings_rad, reached.columns)
        for x, y in np.argwhere(columns)
    }
    assert found == reached_by_flooding(space, start, turns_deg)


def test_a_robot_drives_only_at_the_headings_that_its_turns_lead_to() -> None:
    """Two robots in a lane that leads askew: through it leads the heading of one of them, and turns of the other."""
    rows = [(x, y) for x, y in product(range(12), repeat=2) if abs(x - y) in (5, 6)]
    lane = np.array([[0.1 * x + 0.05, 0.1 * y + 0.05, 0.15] for x, y in rows])
    space = ConfigurationSpace(BAR, lane, SPEC)
    reaches: Dict[Tuple[int, int], bool] = {}
    for yaw_deg, turn_deg in product((0, 45), (90, 45)):
        reached = space.reachable((3, 3), math.radians(yaw_deg), (0.0, float(turn_deg), float(-turn_deg)))
        reaches[yaw_deg, turn_deg] = bool(reached.columns[:, 10, 10].any())
        assert len(reached.headings_rad) == 360 // turn_deg
    assert reaches == {(0, 90): False, (0, 45): True, (45, 90): True, (45, 45): True}


def test_a_closed_wall_parts_the_grid_and_a_gap_joins_it(space: ConfigurationSpace) -> None:
    closed = ConfigurationSpace(BAR, wall(6, set()), SPEC)
    assert not closed.reachable((4, 6), 0.0, QUARTER_TURNS_DEG).columns[:, 8:].any()
    assert space.reachable((4, 6), 0.0, QUARTER_TURNS_DEG).columns[:, 8:].any()


def test_a_start_that_is_not_free_leads_nowhere(space: ConfigurationSpace) -> None:
    assert not space.reachable((6, 1), 0.0, QUARTER_TURNS_DEG).columns.any()
    assert not space.reachable((-1, 20), 0.0, QUARTER_TURNS_DEG).columns.any()


def test_configurations_of_a_column_are_its_headings(space: ConfigurationSpace) -> None:
    reached = space.reachable((4, 6), 0.0, (0.0, 10.0, -10.0))
    found = reached.at((4, 6))
    assert len(found) == reached.columns[:, 4, 6].sum() > 2
    assert {column for _, column in found} == {(4, 6)}
    assert all(free_by_counting(wall(6, GAP), yaw_rad, 4, 6) for yaw_rad, _ in found)


def test_two_robots_are_compatible_with_a_cell_between_them(space: ConfigurationSpace) -> None:
    here = [(0.0, (5, 5))]
    assert not space.compatible(here, [(0.0, (5, 6))])
    assert space.compatible(here, [(0.0, (5, 7))])
    assert space.compatible(here, [(0.0, (5, 6)), (0.0, (5, 7))])
    assert not space.compatible(here, [])


@pytest.mark.parametrize(("shape", "size"), [("box", (0.3, 0.2, 0.1)), ("cylinder", (0.1, 0.3)), ("sphere", (0.12,))])
def test_points_fill_a_solid_densely(shape: str, size: Tuple[float, ...]) -> None:
    pose = transform_matrix((1.0, 2.0, 0.5), quaternion_from_rpy(0.3, 0.2, 0.1))
    solid = LinkSolid(shape, size, np.eye(4), "a")
    points = solid_points([(FramedSolid("a", solid, np.eye(4)), pose)])
    own = (points - pose[:3, 3]) @ pose[:3, :3]
    assert np.all(np.abs(own) <= solid.half_extent + 1e-9)
    inner = np.random.default_rng(3).uniform(-0.55, 0.55, (200, 3)) * solid.half_extent
    gaps = np.linalg.norm(own[None] - inner[:, None], axis=2).min(axis=1)
    assert gaps.max() <= SAMPLE_M * math.sqrt(3.0) / 2.0 + 1e-9
    assert solid_points([]).shape == (0, 3)


def test_pairs_are_every_two() -> None:
    assert list(pairs(["a", "b", "c"])) == [("a", "b"), ("a", "c"), ("b", "c")]
