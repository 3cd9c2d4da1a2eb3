"""Seeded scenes in which one robot has no way to its goal, though it would have one if nothing stood about.

For whoever says what would change that (``yarm.planning.why``). Boxes stand at random and may overlap; that there is no
way is found by the complete search of ``yarm.planning.scenes.oracle``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np

from yarm.geometry import BoolArray, GridSpec
from yarm.planning.model.types import Goal, GoalKind
from yarm.planning.scenes.oracle import Node, Shape, Space
from yarm.planning.scenes.scene import Box, PlanScene, SceneRobot, Stand

TRIES = 500
BOXES = (4, 14)
"""Least and most boxes of a scene."""
LONGEST_SHARE = 0.6
"""Longest side of a box, of the grid's."""


@dataclass(frozen=True, eq=False)
class InfeasibleMaker:
    """Makes scenes of one robot in one grid.

    Attributes:
        spec: the grid.
        robot: the robot; only where it starts differs.
    """

    spec: GridSpec
    robot: SceneRobot

    def make(self, seed: int) -> PlanScene:
        """The scene of a seed.

        Raises:
            RuntimeError: none found (a grid in which the robot can hardly move).
        """
        shape = Shape(self.robot, self.spec)
        empty = Space(shape, np.zeros(self.spec.shape, dtype=np.bool_))
        for attempt in range(TRIES):
            rng = np.random.default_rng([seed, attempt])
            boxes = tuple(_box(rng, self.spec) for _ in range(int(rng.integers(*BOXES))))
            occupied = PlanScene(self.spec, boxes, (), {}).occupied()
            space = Space(shape, occupied)
            starts = np.argwhere(space.free[0])
            if not len(starts):
                continue
            start = tuple(int(v) for v in starts[int(rng.integers(len(starts)))])
            goals = np.argwhere(_cut_off(space, empty, Node(0, *start)))
            if len(goals):
                column = tuple(int(v) for v in goals[int(rng.integers(len(goals)))])
                robot = SceneRobot(
                    self.robot.name, Stand((start[0], start[1]), self.robot.start.yaw_rad), self.robot.cells
                )
                goal = Goal("goal", GoalKind.TARGET, (column[0], column[1]))
                return PlanScene(self.spec, boxes, (robot,), {"goal": goal}, {robot.name: "goal"}, f"infeasible_{seed}")
        raise RuntimeError(f"no infeasible scene found for seed {seed} in {TRIES} tries")


def _cut_off(space: Space, empty: Space, start: Node) -> BoolArray:
    """(gx, gy) columns that are out of reach, and would not be if nothing stood about."""
    cut: BoolArray = np.isinf(space.lengths(start)) & np.isfinite(empty.lengths(start))
    return cut


def _box(rng: np.random.Generator, spec: GridSpec) -> Box:
    """A wall or a block on the floor."""
    gx, gy, gz = spec.shape
    thin = int(rng.integers(1, 4))
    long = int(rng.integers(3, max(4, int(LONGEST_SHARE * max(gx, gy)))))
    width, depth = (long, thin) if rng.random() < 0.5 else (thin, long)
    x, y = int(rng.integers(0, max(1, gx - width))), int(rng.integers(0, max(1, gy - depth)))
    return (x, min(gx, x + width), y, min(gy, y + depth), 0, int(rng.integers(gz // 2, gz + 1)))


def moved_boxes(boxes: Tuple[Box, ...], index: int, dx: int, dy: int) -> Tuple[Box, ...]:
    """The boxes with one of them moved by columns."""
    x0, x1, y0, y1, z0, z1 = boxes[index]
    return (*boxes[:index], (x0 + dx, x1 + dx, y0 + dy, y1 + dy, z0, z1), *boxes[index + 1 :])
