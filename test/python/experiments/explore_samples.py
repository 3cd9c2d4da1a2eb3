"""A small room, and records of made-up runs in it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Optional

import numpy as np

from yarm.experiments.explore.judge import Judge
from yarm.experiments.explore.record import ExploreRecord, PathRow
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.sim.scenes.arena import Arena, Block

WALLS = (
    Block("south", "wall", Pose2(0.0, -1.025), (4.1, 0.05, 0.6)),
    Block("north", "wall", Pose2(0.0, 1.025), (4.1, 0.05, 0.6)),
    Block("west", "wall", Pose2(-2.025, 0.0), (0.05, 2.1, 0.6)),
    Block("east", "wall", Pose2(2.025, 0.0), (0.05, 2.1, 0.6)),
)
BLOCK = Block("block_1", "block", Pose2(1.0, 0.5), (0.4, 0.3, 0.6))
BRICK = Block("low_1", "low", Pose2(1.0, -0.5), (0.1, 0.4, 0.1))
ROOM = Arena("room", "custom", 0, (-2.0, -1.0), (2.0, 1.0), (*WALLS, BLOCK, BRICK), Pose2(-1.0, 0.0))


def perfect_map(judge: Judge, shift: Pose2 = Pose2(0.0, 0.0)) -> GridMap:  # noqa: B008
    """The map that knows everything mappable, and the low obstacle; its frame may lie elsewhere."""
    truth = judge.truth
    cells = np.full(truth.free.shape, -1, dtype=np.int8)
    cells[truth.free] = 0
    cells[truth.faces] = 100
    outline = judge.obstacles[1].outline
    index = np.floor((outline - np.array(truth.cells.origin)) / 0.05).astype(int)
    cells[index[:, 1], index[:, 0]] = 100
    return GridMap(cells, 0.05, shift.inverse().compose(Pose2(*truth.cells.origin)))


def path_row(t_s: float, x: float, speed: float, y: float = 0.0, yaw: float = 0.0) -> PathRow:
    return PathRow(t_s, x, y, yaw, x, y, yaw, speed, 0.0, speed)


def record_of(grid_map: Optional[GridMap] = None, **changes: Any) -> ExploreRecord:
    record = ExploreRecord(
        arena="room",
        controller="made_up",
        seed=3,
        mode="kinematic",
        time_limit_s=900.0,
        max_speed=0.3,
        near_speed=0.15,
        near_distance=0.7,
        end_s=900.0,
        done=False,
        reason="",
        path=(),
        coverage=(),
        touches=(),
        events=(),
        map=grid_map,
    )
    return replace(record, **changes)
