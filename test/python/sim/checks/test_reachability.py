"""Where a robot can go: free configurations and what is reached from one, against slow counting."""

from __future__ import annotations

import math
from collections import deque
from itertools import product
from typing import Set, Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray, GridSpec, quaternion_from_rpy, transform_matrix
from yarm.geometry.urdf import LinkSolid
from yarm.sim.checks.reachability import (
    HEADINGS,
    SAMPLE_M,
    ConfigurationSpace,
    RobotShape,
    compatible,
    configurations_at,
    heading_angles,
    nearest_heading,
    pairs,
    solid_points,
)
from yarm.sim.engine.bodies import FramedSolid

SPEC = GridSpec((12, 12, 3), (0.0, 0.0, 0.0), (1.2, 1.2, 0.3))
BAR = np.array([[-0.1 * k, 0.0, 0.15] for k in range(4)])
"""Points of a robot that reaches three cells behind its end effector, in the middle layer."""
Configuration = Tuple[int, int, int]


def wall(x: int, gap: Set[int]) -> FloatArray:
    """Points in the middle of the cells of a wall across the grid, with a gap; all layers."""
    rows = [y for y in range(12) if y not in gap]
    return np.array([[0.1 * x + 0.05, 0.1 * y + 0.05, 0.1 * z + 0.05] for y in rows for z in range(3)])


def free_by_counting(shape: RobotShape, obstacles: FloatArray, heading: int, x: int, y: int) -> bool:
    """Every cell inside, and none with an obstacle among its 26 neighbours."""
    taken = {tuple(cell) for cell in np.floor(obstacles / 0.1 + 1e-9).astype(int).tolist()}
    for dx, dy, z in shape.cells[heading].tolist():
        if not (0 <= x + dx < 12 and 0 <= y + dy < 12):
            return False
        if any((x + dx + i, y + dy + j, z + k) in taken for i, j, k in product((-1, 0, 1), repeat=3)):
            return False
    return True


@pytest.fixture(name="space", scope="module")
def space_fixture() -> ConfigurationSpace:
    """A bar in two halves of a grid, joined by a gap of five cells."""
    return ConfigurationSpace(RobotShape.from_points(BAR, SPEC), wall(6, {4, 5, 6, 7, 8}), SPEC)


def test_free_is_what_counting_says(space: ConfigurationSpace) -> None:
    for heading in range(0, HEADINGS, 5):
        for x in range(12):
            for y in range(12):
                counted = free_by_counting(space.shape, wall(6, {4, 5, 6, 7, 8}), heading, x, y)
                assert space.free[heading][x, y] == counted, (heading, x, y)


def reached_by_flooding(space: ConfigurationSpace, start: Configuration) -> Set[Configuration]:
    """Configurations that steps to neighbouring columns and headings lead to."""
    seen, ring = {start}, deque([start])
    while ring:
        heading, x, y = ring.popleft()
        steps = [(heading, x + dx, y + dy) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
        for new in [*steps, ((heading + 1) % HEADINGS, x, y), ((heading - 1) % HEADINGS, x, y)]:
            if new not in seen and 0 <= new[1] < 12 and 0 <= new[2] < 12 and space.free[new[0]][new[1], new[2]]:
                seen.add(new)
                ring.append(new)
    return seen


@pytest.mark.parametrize("start", [(0, 4, 6), (18, 8, 6), (35, 4, 1)])
def test_reachable_is_what_flooding_finds(space: ConfigurationSpace, start: Configuration) -> None:
    assert space.free[start[0]][start[1], start[2]]
    reached = space.reachable((start[1], start[2]), start[0])
    assert {tuple(c) for c in np.argwhere(reached).tolist()} == reached_by_flooding(space, start)


def test_a_closed_wall_parts_the_grid_and_a_gap_joins_it(space: ConfigurationSpace) -> None:
    closed = ConfigurationSpace(space.shape, wall(6, set()), SPEC)
    assert not closed.reachable((4, 6), 0)[:, 8:].any()
    assert space.reachable((4, 6), 0)[:, 8:].any()


def test_a_start_that_is_not_free_leads_nowhere(space: ConfigurationSpace) -> None:
    assert not space.reachable((6, 1), 0).any()
    assert not space.reachable((-1, 20), 0).any()


def test_configurations_of_a_column_are_its_headings(space: ConfigurationSpace) -> None:
    reached = space.reachable((4, 6), 0)
    found = configurations_at(reached, (4, 6))
    assert [heading for heading, _ in found] == np.nonzero(reached[:, 4, 6])[0].tolist()
    assert {column for _, column in found} == {(4, 6)}


def test_two_robots_are_compatible_with_a_cell_between_them() -> None:
    shape = RobotShape.from_points(BAR, SPEC)
    ahead = nearest_heading(0.0)
    here = [(ahead, (5, 5))]
    assert not compatible(shape, SPEC, here, [(ahead, (5, 6))])
    assert compatible(shape, SPEC, here, [(ahead, (5, 7))])
    assert compatible(shape, SPEC, here, [(ahead, (5, 6)), (ahead, (5, 7))])
    assert not compatible(shape, SPEC, here, [])


@pytest.mark.parametrize(("yaw_deg", "index"), [(0, 0), (4, 0), (6, 1), (-10, 35), (180, 18), (356, 0), (-3, 0)])
def test_the_nearest_heading(yaw_deg: float, index: int) -> None:
    assert nearest_heading(math.radians(yaw_deg)) == index
    assert len(heading_angles()) == HEADINGS


def test_a_turned_robot_has_its_cells_turned() -> None:
    shape = RobotShape.from_points(BAR, SPEC)
    assert {tuple(c) for c in shape.cells[0].tolist()} == {(-k, 0, 1) for k in range(4)}
    assert {tuple(c) for c in shape.cells[9].tolist()} == {(0, -k, 1) for k in range(4)}


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
