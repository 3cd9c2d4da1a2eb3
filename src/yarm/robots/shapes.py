"""A mobile robot's known solids, and the cells they fill at a heading: its mask.

The mask comes from the drawing of the robot, not from what the cameras saw of it: noise at its edge would make it
collide with the part it passes over.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Dict, List, Sequence, Tuple

import numpy as np

from yarm.geometry import GridSpec, Mask, transform_points
from yarm.geometry.solids import Shape, Solid
from yarm.robots.ankurbot import Beam, Disc, solids_mask

YAW_STEP_RAD = math.radians(0.1)
"""Headings closer than this share a mask."""
STEPS_A_QUARTER = 900
TAKEN_OFF_M = 0.02
"""A hand takes a piece at most so far from its middle, metres."""


@dataclass(frozen=True)
class PieceShape:
    """A piece of debris however it lies: radius about its middle seen from above, and height, metres."""

    radius_m: float
    height_m: float


@dataclass(frozen=True, eq=False)
class RobotShape:
    """All solids of a mobile robot, rigid with its end effector.

    Attributes:
        discs: upright cylinders; x, y from the end effector (x along the arm), z above the floor.
        beams: upright boxes, likewise.
    """

    discs: Tuple[Disc, ...]
    beams: Tuple[Beam, ...]
    _loaded: Dict[PieceShape, RobotShape] = field(default_factory=dict, repr=False)
    _masks: Dict[Tuple[GridSpec, int], Mask] = field(default_factory=dict, repr=False)

    def mask(self, spec: GridSpec, yaw_rad: float) -> Mask:
        """Cells the robot fills with its end effector over the centre of a column, heading as given."""
        key = (spec, round(yaw_rad / YAW_STEP_RAD))
        if key not in self._masks:
            self._masks[key] = self._made(*key)
        return Mask(self._masks[key].cells, yaw_rad)

    def _made(self, spec: GridSpec, steps: int) -> Mask:
        """The mask so many steps of yaw from x: where columns are squares, one in the first quarter turned."""
        quarters, first = divmod(steps, STEPS_A_QUARTER)
        if quarters % 4 == 0 or spec.resolution[0] != spec.resolution[1]:
            return solids_mask(spec, self.discs, self.beams, steps * YAW_STEP_RAD)
        return self.mask(spec, first * YAW_STEP_RAD).turned_by_quarters(quarters)

    @property
    def lowest_at_tip_m(self) -> float:
        """Height of the lowest of it under its end effector, metres: of a hand drawn up, the cup's face."""
        discs = [disc.z[0] for disc in self.discs if math.hypot(disc.x, disc.y) < disc.radius]
        beams = [b.z[0] for b in self.beams if b.x[0] < 0.0 < b.x[1] and b.y[0] < 0.0 < b.y[1]]
        return min([*discs, *beams], default=math.inf)

    def with_load(self, piece: PieceShape) -> RobotShape:
        """The same with a piece hanging under its end effector."""
        if piece not in self._loaded:
            top = self.lowest_at_tip_m
            load = Disc(0.0, 0.0, piece.radius_m + TAKEN_OFF_M, (top - piece.height_m, top))
            self._loaded[piece] = RobotShape((*self.discs, load), self.beams)
        return self._loaded[piece]


def piece_shape(solids: Sequence[Solid]) -> PieceShape:
    """The shape of a piece of debris from its solids, with their poses in its frame (origin in its middle, z up)."""
    corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    points = np.concatenate([transform_points(solid.pose, corners * solid.half_extent) for solid in solids])
    return PieceShape(float(np.hypot(points[:, 0], points[:, 1]).max()), float(np.ptp(points[:, 2])))


def robot_shape(solids: Sequence[Solid], height_m: float) -> RobotShape:
    """The shape of a robot from its solids.

    Args:
        solids: with their poses in the end effector's frame (x along the arm, z up).
        height_m: height of the end effector above the floor, metres.
    """
    discs: List[Disc] = []
    beams: List[Beam] = []
    for solid in solids:
        half = solid.half_extent
        corners = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]) * half
        points = transform_points(solid.pose, corners)
        low, high = points.min(axis=0), points.max(axis=0)
        z = (float(low[2]) + height_m, float(high[2]) + height_m)
        if solid.shape == Shape.SPHERE or (solid.shape == Shape.CYLINDER and abs(solid.pose[2, 2]) > 1.0 - 1e-6):
            x, y = (float(v) for v in solid.pose[:2, 3])
            discs.append(Disc(x, y, float(half[0]), z))
        else:
            beams.append(Beam((float(low[0]), float(high[0])), (float(low[1]), float(high[1])), z))
    return RobotShape(tuple(discs), tuple(beams))
