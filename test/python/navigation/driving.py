"""A driver in a kinematic room, for the tests of driving to goals."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Callable, List, Optional, Sequence

import numpy as np

from support.rooms import room
from yarm.geometry import FloatArray, Pose2
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import UNKNOWN, GridMap
from yarm.navigation.move_base import MoveBase, Observation, Status, Step
from yarm.navigation.move_base_params import MoveBaseParams
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.kinematic.world import KinematicWorld
from yarm.sim.scenes.arena import Arena, Block

CELL_M = 0.05


def outline(block: Block) -> FloatArray:
    """(4, 2) corners of a block, counter-clockwise."""
    return FlatBoxes([block]).corners()[0]


def map_of(arena: Arena, known: Optional[Sequence[Block]] = None) -> GridMap:
    """What is known of a room: its walls, and those blocks in it that are known; all unless given."""
    side = round((arena.upper[0] - arena.lower[0]) / CELL_M) + 4
    cells = np.zeros((side, side), np.int8)
    cells[:1], cells[-1:], cells[:, :1], cells[:, -1:] = (UNKNOWN,) * 4
    empty = GridMap(cells, CELL_M, Pose2(arena.lower[0] - 2 * CELL_M, arena.lower[1] - 2 * CELL_M))
    blocks = [b for b in arena.blocks if b.kind == "wall" or known is None or b in known]
    return with_bodies(empty, [outline(b) for b in blocks])


class Drive:
    """One robot, one room, one :class:`MoveBase`; the localisation is exact unless it swings.

    Attributes:
        swing_m: the believed place lies so far to the south-east of the true one when the robot looks north-east, and
            to the north-west when it looks south-west; half way in between it is exact.
    """

    def __init__(
        self, *blocks: Block, known: Optional[Sequence[Block]] = None, swing_m: float = 0.0, **params: Any
    ) -> None:
        """Standing at the origin of a room of 4 x 4 m."""
        self.swing_m = swing_m
        self.params = MoveBaseParams(**params)
        self.base = MoveBase(self.params)
        self.arena = room(*blocks)
        self.world = KinematicWorld(self.arena, 3)
        self.map: Optional[GridMap] = map_of(self.arena, known)
        self.map_count = 1
        self.scans, self.placed = True, True
        self.steps: List[Step] = []
        self.events: List[str] = []
        self.now_s = 0.0
        self._scan = self.world.scan()

    @property
    def here(self) -> Pose2:
        return self.world.truth

    @property
    def believed(self) -> Pose2:
        """Where the localisation says the robot is, map frame."""
        here = self.here
        off_m = self.swing_m * math.cos(here.yaw_rad - math.pi / 4) / math.sqrt(2.0)
        return Pose2(here.x + off_m, here.y - off_m, here.yaw_rad)

    def observe(self) -> Observation:
        if self.scans:
            self._scan = replace(self.world.scan(), stamp_s=self.now_s)
        pose = self.believed if self.placed else None
        bumps = self.world.take_bumps()
        odometry = self.world.odometry().pose
        return Observation(self.now_s, pose, "test", self._scan, pose, self.map, self.map_count, None, bumps, odometry)

    def step(self) -> Step:
        """One step and the time that its command stands."""
        step = self.base.step(self.observe())
        self.steps.append(step)
        self.events += step.events
        drive = step.drive
        self.world.step(
            0.0 if drive is None else drive.v_mps, 0.0 if drive is None else drive.w_radps, self.params.period_s
        )
        self.now_s += self.params.period_s
        return step

    def go(self, x: float, y: float, yaw_rad: float = 0.0) -> None:
        self.base.go(Pose2(x, y, yaw_rad), self.now_s)

    def run(self, limit_s: float = 120.0, until: Optional[Callable[[Step], bool]] = None) -> Step:
        """Steps until the goal is over, or something else holds."""
        end_s = self.now_s + limit_s
        while self.now_s < end_s:
            step = self.step()
            if step.status in (Status.SUCCEEDED, Status.ABORTED) or (until is not None and until(step)):
                return step
        raise AssertionError(f"not over after {limit_s} s; {self.here}, events {self.events}")

    def put(self, *blocks: Block) -> None:
        """Other blocks stand in the room from now on; nobody told the robot."""
        world = KinematicWorld(replace(room(*blocks), start=self.here), 4)
        self.world = world
