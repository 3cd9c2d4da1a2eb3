"""A cleaning round keeps clear of everything, covers what can be reached and says what cannot."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from yarm.experiments.coursework.sweep_picture import draw_sweep
from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid, surface_points
from yarm.manipulation.coverage.floor import Floor
from yarm.manipulation.coverage.sweep import RobotSpace, SweepError, SweepPlan, corners, named_cells, plan_sweep

UPRIGHT = (0.0, 0.0, 0.0, 1.0)
BODY = Solid(Shape.CYLINDER, (0.3, 0.4), transform_matrix((0.0, 0.0, 0.3), UPRIGHT))
ARM = Solid(Shape.BOX, (1.2, 0.08, 0.08), transform_matrix((0.6, 0.0, 0.9), UPRIGHT))
ROBOT = (BODY, ARM)
TABLE = Solid(Shape.BOX, (0.8, 0.8, 0.7), transform_matrix((0.0, 0.0, 0.35), UPRIGHT))
MAST = Solid(Shape.CYLINDER, (0.05, 2.0), transform_matrix((0.9, -0.9, 1.0), UPRIGHT))
START = Pose2(-1.5, -1.5, 0.0)


def driven(plan: SweepPlan, start: Pose2) -> FloatArray:
    """Where the body goes when it drives straight from stop to stop, every 2 cm."""
    points = [np.array((start.x, start.y)), *(np.array((stop.x, stop.y)) for stop in plan.stops)]
    pieces = [
        a + np.linspace(0.0, 1.0, max(int(np.linalg.norm(b - a) / 0.02), 2))[:, None] * (b - a)
        for a, b in zip(points[:-1], points[1:])
    ]
    return np.concatenate(pieces)


def test_every_pose_on_the_way_keeps_the_robots_surface_off_the_things() -> None:
    plan = plan_sweep(RobotSpace(ROBOT, (TABLE, MAST)), START, 1.8, 0.4)
    surface = surface_points(ROBOT, 0.03)
    for x, y in driven(plan, START)[::3].tolist():
        place = transform_matrix((x, y, 0.0), quaternion_from_rpy(0.0, 0.0, plan.heading_rad))
        at = surface @ place[:3, :3].T + place[:3, 3]
        over = np.abs(at - (0.0, 0.0, 0.35)) - (0.4, 0.4, 0.35)
        assert np.linalg.norm(np.maximum(over, 0.0), axis=1).min() > 0.03
        assert (np.hypot(at[:, 0] - 0.9, at[:, 1] + 0.9) - 0.05).min() > 0.03


def test_the_way_goes_over_every_cell_that_is_to_be() -> None:
    plan = plan_sweep(RobotSpace(ROBOT, (TABLE, MAST)), START, 1.8, 0.4)
    over = plan.gone_over(driven(plan, START))
    wanted = np.zeros_like(over)
    wanted[tuple(plan.coverage.cells.T)] = True
    assert np.array_equal(over, wanted)
    assert 30 < wanted.sum() < wanted.size
    half_way = plan.gone_over(driven(plan, START)[:200])
    assert 0 < half_way.sum() < wanted.sum()
    assert not plan.gone_over(np.zeros((0, 2))).any()


def test_the_arm_passes_over_a_low_table_and_not_through_a_high_one() -> None:
    low = plan_sweep(RobotSpace(ROBOT, (TABLE,)), START, 1.8, 0.4, 0.0)
    high = Solid(Shape.BOX, (0.8, 0.8, 1.2), transform_matrix((0.0, 0.0, 0.6), UPRIGHT))
    walled = plan_sweep(RobotSpace(ROBOT, (high,)), START, 1.8, 0.4, 0.0)
    assert walled.floor.free.sum() < low.floor.free.sum()
    assert not np.any(walled.floor.free & ~low.floor.free)
    left_of_it = walled.floor.cell(np.array((-1.2, 0.1)))
    assert low.floor.free[left_of_it]
    assert not walled.floor.free[left_of_it]


def test_the_heading_that_covers_most_is_taken() -> None:
    space = RobotSpace(ROBOT, (Solid(Shape.BOX, (0.2, 3.6, 1.2), transform_matrix((1.9, 0.0, 0.6), UPRIGHT)),))
    best = plan_sweep(space, START, 1.8, 0.4)
    ahead = plan_sweep(space, START, 1.8, 0.4, 0.0)
    assert len(ahead.coverage.cells) < len(best.coverage.cells)
    assert math.cos(best.heading_rad) < 0.5


def test_a_start_too_near_and_a_floor_out_of_reach_are_refused() -> None:
    space = RobotSpace(ROBOT, (TABLE,))
    with pytest.raises(SweepError, match=r"at \(0\.00, 0\.60\) something is too near"):
        plan_sweep(space, Pose2(0.0, 0.6, 0.0), 1.8, 0.4)
    wall = [
        Solid(Shape.BOX, size, transform_matrix(xyz, UPRIGHT))
        for size, xyz in (
            ((0.1, 4.0, 1.2), (2.0, 0.0, 0.6)),
            ((0.1, 4.0, 1.2), (-2.0, 0.0, 0.6)),
            ((4.0, 0.1, 1.2), (0.0, 2.0, 0.6)),
            ((4.0, 0.1, 1.2), (0.0, -2.0, 0.6)),
        )
    ]
    with pytest.raises(SweepError, match="no cell of the floor can be gone to with a heading of 90 deg"):
        plan_sweep(RobotSpace(ROBOT, wall), Pose2(-4.0, 0.0, math.pi / 2), 1.8, 0.4, math.pi / 2)


def test_only_turns_and_ends_are_stops() -> None:
    cells = np.array([(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2)])
    assert corners(cells).tolist() == [[0, 0], [2, 0], [2, 2], [1, 2]]
    assert corners(cells[:1]).tolist() == [[0, 0]]
    assert corners(np.array([(0, 0), (1, 0), (0, 0)])).tolist() == [[0, 0], [1, 0], [0, 0]]


def test_the_picture_is_drawn(tmp_path: Path) -> None:
    plan = plan_sweep(RobotSpace(ROBOT, (TABLE, MAST)), START, 1.8, 0.4)
    path = draw_sweep(plan, driven(plan, START), (TABLE, MAST), tmp_path / "made" / "sweep.png")
    assert path.read_bytes()[:4] == b"\x89PNG"


def test_cells_are_named_by_their_centres_and_many_are_cut_short() -> None:
    floor = Floor(np.full(2, -1.0), 0.5, np.ones((4, 4), dtype=bool))
    assert named_cells(floor, np.zeros((0, 2), dtype=int)) == "none"
    assert named_cells(floor, np.array([(0, 0), (3, 2)])) == "(-0.75, -0.75), (0.75, 0.25)"
    assert named_cells(floor, np.argwhere(floor.free)).endswith("(0.25, 0.75), 4 more")
