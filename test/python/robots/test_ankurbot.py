"""The robot's cells against its own solids, sampled densely."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np
import pytest

from yarm.geometry import FloatArray, GridError, GridSpec
from yarm.geometry.solids import surface_points
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.ankurbot import ANKURBOT_BEAMS, ANKURBOT_DISCS, Beam, Disc, ankurbot_mask, solids_mask

SPEC = GridSpec()
STEP_M = 0.012
Cell = Tuple[int, ...]


def inside(points: FloatArray) -> FloatArray:
    """Which points (n, 3), the robot's frame, lie in one of its solids."""
    x, y, z = points.T
    found = np.zeros(len(points), dtype=bool)
    for disc in ANKURBOT_DISCS:
        found |= (np.hypot(x - disc.x, y - disc.y) < disc.radius) & (disc.z[0] < z) & (z < disc.z[1])
    for beam in ANKURBOT_BEAMS:
        found |= (
            (beam.x[0] < x) & (x < beam.x[1]) & (beam.y[0] < y) & (y < beam.y[1]) & (beam.z[0] < z) & (z < beam.z[1])
        )
    return found


def samples(yaw_rad: float, offset: Tuple[float, float]) -> FloatArray:
    """Points (n, 3) all over the robot, metres, from the lower corner of its end effector's column on the floor."""
    axes = [np.arange(-1.7, 0.1, STEP_M), np.arange(-0.4, 0.4, STEP_M), np.arange(0.005, 1.0, STEP_M)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = points[inside(points)]
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    x = offset[0] + c * points[:, 0] - s * points[:, 1]
    y = offset[1] + s * points[:, 0] + c * points[:, 1]
    corner = [-SPEC.resolution[0] / 2, -SPEC.resolution[1] / 2, SPEC.lower[2]]
    return np.column_stack([x, y, points[:, 2]]) - corner


def gap_m(cell: Cell, points: FloatArray) -> float:
    """Distance of the nearest of the points to a cell, metres."""
    lower = np.asarray(cell) * SPEC.resolution
    return float(
        np.linalg.norm(np.maximum(np.maximum(lower - points, points - lower - SPEC.resolution), 0), axis=1).min()
    )


@pytest.mark.parametrize(("yaw_rad", "offset"), [(0.0, (0.0, 0.0)), (0.4, (0.03, -0.04)), (-2.0, (0.0, 0.0))])
def test_the_cells_are_those_that_the_solids_enter(yaw_rad: float, offset: Tuple[float, float]) -> None:
    mask = {tuple(cell) for cell in ankurbot_mask(SPEC, yaw_rad, offset).cells.tolist()}
    points = samples(yaw_rad, offset)
    cells = np.unique(np.floor(points / SPEC.resolution).astype(int), axis=0)
    sampled = {tuple(cell) for cell in cells[cells[:, 2] >= 0].tolist()}
    assert sampled <= mask
    assert len(sampled) > 0.9 * len(mask)
    assert (
        max([gap_m(cell, points) for cell in mask - sampled], default=0.0) < STEP_M
    )  # entered by less than the samples' distance


def test_along_x_it_is_17_by_7_by_15_cells() -> None:
    cells = ankurbot_mask(SPEC, 0.0).cells
    assert tuple(cells.max(axis=0) - cells.min(axis=0) + 1) == (17, 7, 15)
    assert cells[:, 0].max() == 0 and cells[:, 2].min() == 0


def test_a_quarter_turn_turns_the_cells() -> None:
    ahead, left = ankurbot_mask(SPEC, 0.0).cells, ankurbot_mask(SPEC, math.pi / 2).cells
    assert {(-y, x, z) for x, y, z in ahead.tolist()} == {tuple(cell) for cell in left.tolist()}


def test_touching_a_cell_is_not_entering_it() -> None:
    size = float(SPEC.resolution[0])
    flush = Beam((-0.5 * size, 0.5 * size), (-0.5 * size, 0.5 * size), (0.2, 0.3))
    cells = solids_mask(SPEC, (), (flush,), 0.0).cells
    assert {(x, y) for x, y, _ in cells.tolist()} == {(0, 0)}
    over = Beam((-0.5 * size, 0.5 * size + 1e-6), (-0.5 * size, 0.5 * size), (0.2, 0.3))
    assert {(x, y) for x, y, _ in solids_mask(SPEC, (), (over,), 0.0).cells.tolist()} == {(0, 0), (1, 0)}


def test_a_robot_above_the_grid_has_no_cells_and_is_refused() -> None:
    with pytest.raises(GridError):
        solids_mask(SPEC, (Disc(0.0, 0.0, 0.1, (5.0, 6.0)),), (), 0.0)


def test_discs_and_beams_hold_the_drawn_robot_but_for_its_casters() -> None:
    """The description in urdf/ is the source; only what turns under the body may stick out of the upright shapes."""
    model = parse_urdf(expand_xacro(resource("urdf", "cell", "ankurbot.urdf.xacro")))
    T_base_ee = model.rigid_group("ee")[1]
    for solid in model.solids:
        link, T_group_link = model.rigid_group(solid.link)
        if link != "base_link":
            continue
        points = surface_points([solid.seen_from(T_group_link)], 0.02)
        own = (points - T_base_ee[:3, 3]) + [0.0, 0.0, T_base_ee[2, 3]]
        shrunk = own.mean(axis=0) + 0.99 * (own - own.mean(axis=0))
        assert inside(shrunk).all(), solid.link
