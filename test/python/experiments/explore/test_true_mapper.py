"""Maps from the true pose: walls where they are, free before them, nothing where nothing was seen."""

from __future__ import annotations

import math

import numpy as np

from yarm.experiments.explore.true_mapper import TrueMapper
from yarm.geometry import Pose2
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena, Block

WALL = Block("wall", "wall", Pose2(2.025, 0.0), (0.05, 4.0, 0.6))
ARENA = Arena("t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (WALL,), Pose2(0.0, 0.0))


def test_a_wall_is_drawn_where_it_stands() -> None:
    world = KinematicWorld(ARENA, 3)
    mapper = TrueMapper(ARENA.lower, ARENA.upper)
    for _ in range(20):
        mapper.add(world.scan(), world.truth)
    grid = mapper.map()
    rows, columns = np.nonzero(grid.occupied)
    centres = grid.centres_of(np.stack([rows, columns], axis=1))
    assert np.all(np.abs(centres[:, 0] - 2.0) < 0.06) and len(centres) > 30
    assert grid.free[grid.cell_of(1.0, 0.0)] and grid.unknown[grid.cell_of(2.3, 0.0)], "before it and behind it"
    assert grid.unknown[grid.cell_of(1.0, 1.2)], "outside the fan"
    assert grid.unknown[grid.cell_of(-1.0, 0.0)], "behind the robot"
    assert mapper.scans == 20


def test_beams_without_a_range_draw_nothing() -> None:
    empty = Arena("t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (), Pose2(0.0, 0.0))
    mapper = TrueMapper(empty.lower, empty.upper)
    mapper.add(KinematicWorld(empty, 0).scan(), empty.start)
    assert mapper.map().known_m2 == 0.0


def test_what_is_drawn_turns_with_the_robot() -> None:
    behind = Pose2(0.0, 0.0, math.pi)
    arena = Arena(
        "t", "custom", 0, (-3.0, -3.0), (3.0, 3.0), (Block("w", "wall", Pose2(-2.0, 0), (0.1, 3, 1)),), behind
    )
    mapper = TrueMapper(arena.lower, arena.upper)
    world = KinematicWorld(arena, 0)
    for _ in range(5):
        mapper.add(world.scan(), world.truth)
    grid = mapper.map()
    assert grid.free[grid.cell_of(-1.0, 0.0)] and grid.unknown[grid.cell_of(1.0, 0.0)]
