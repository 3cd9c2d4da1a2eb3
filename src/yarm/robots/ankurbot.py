"""The mobile robot: its measures, as in urdf/cell/ankurbot.urdf.xacro (a test compares), and its cells from its solids.

The cells are for scenes and kinematic worlds, where no camera sees it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import List, Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import BoolArray, FloatArray, GridSpec, Mask, transform_matrix, wrap_angle

TOUCH_M = 1e-9
"""A solid that enters a cell by less, metres, only touches it."""


@dataclass(frozen=True)
class Disc:
    """An upright cylinder in the robot's frame (origin at the end effector, x along the arm), metres."""

    x: float
    y: float
    radius: float
    z: Tuple[float, float]


@dataclass(frozen=True)
class Beam:
    """An upright box in the robot's frame (origin at the end effector, x along the arm), metres."""

    x: Tuple[float, float]
    y: Tuple[float, float]
    z: Tuple[float, float]


ARM_REACH_M = 1.30
"""End effector ahead of the body's centre, metres."""
EE_HEIGHT_M = 0.89
"""End effector over the floor, metres."""
LIFT_JOINT = "lift_joint"
"""The lift of a hand in the robot's description and joint states, metres down."""
HAND_LIFTS_KG = 1.8
"""The heaviest piece that a hand's lift raises (20 N, the cup too), kg; a heavier one holds it down."""
HAND_STROKE_M = 0.20
"""How far a hand's lift goes down from drawn up, metres."""
HAND_EE_HEIGHT_M = 0.97
"""End effector of a robot with a hand over the floor, metres."""
LIFT_LINKS: Mapping[str, float] = {"hand": -0.075, "stage": 0.0}
"""Links of a hand that its lift moves: how far over the end effector each is when drawn up, metres."""
BODY_RADIUS_M = 0.35
WHEEL_RADIUS_M = 0.05
HALF_WHEEL_BASE_M = 0.15
CASTERS = ("fl", "fr", "rl", "rr")
CASTER_XY_M: Tuple[Tuple[float, float], ...] = (
    (HALF_WHEEL_BASE_M, HALF_WHEEL_BASE_M),
    (HALF_WHEEL_BASE_M, -HALF_WHEEL_BASE_M),
    (-HALF_WHEEL_BASE_M, HALF_WHEEL_BASE_M),
    (-HALF_WHEEL_BASE_M, -HALF_WHEEL_BASE_M),
)
"""Where each caster is, in the order of CASTERS, metres, body frame: x along the arm, y left."""
ANKURBOT_DISCS: Tuple[Disc, ...] = (
    Disc(-ARM_REACH_M, 0.0, BODY_RADIUS_M, (0.10, 0.55)),
    *(Disc(-ARM_REACH_M + x, y, WHEEL_RADIUS_M, (0.0, 2.0 * WHEEL_RADIUS_M)) for x, y in sorted(CASTER_XY_M)),
    Disc(0.0, 0.0, 0.04, (0.85, 0.93)),
)
"""Body, wheels and end effector of the mobile robot."""
ANKURBOT_BEAMS: Tuple[Beam, ...] = (
    Beam((-ARM_REACH_M - 0.05, -ARM_REACH_M + 0.05), (-0.05, 0.05), (0.55, 0.97)),
    Beam((-ARM_REACH_M, 0.0), (-0.04, 0.04), (0.85, 0.93)),
)
"""Mast and arm of the mobile robot."""
_RAISED_M = HAND_EE_HEIGHT_M - EE_HEIGHT_M
_FACE_M = HAND_EE_HEIGHT_M + LIFT_LINKS["hand"]
HAND_DISCS: Tuple[Disc, ...] = (
    *(
        replace(disc, z=(disc.z[0] + _RAISED_M, disc.z[1] + _RAISED_M)) if disc.x == 0.0 else disc
        for disc in ANKURBOT_DISCS
    ),
    Disc(0.0, 0.0, 0.05, (_FACE_M, _FACE_M + 0.03)),
    Disc(0.0, 0.0, 0.018, (_FACE_M + 0.03, HAND_EE_HEIGHT_M + 0.07)),
)
"""Body, wheels, end effector, cup and telescope of the mobile robot with a hand that is drawn up."""
HAND_BEAMS: Tuple[Beam, ...] = (
    replace(ANKURBOT_BEAMS[0], z=(ANKURBOT_BEAMS[0].z[0], ANKURBOT_BEAMS[0].z[1] + _RAISED_M)),
    replace(ANKURBOT_BEAMS[1], z=(ANKURBOT_BEAMS[1].z[0] + _RAISED_M, ANKURBOT_BEAMS[1].z[1] + _RAISED_M)),
    Beam((-0.03, 0.03), (-0.03, 0.03), (HAND_EE_HEIGHT_M - 0.04, HAND_EE_HEIGHT_M + 0.04)),
)
"""Its mast, its arm and the slide at the arm's tip."""


def drawn_up(robot: str, frame: str) -> Optional[FloatArray]:
    """Where a frame of a robot's hand is in its end effector's, (4, 4), metres, drawn up; None for any other frame.

    A robot drives with its hand drawn up: that is its shape for whoever plans and watches its ways.
    """
    link = frame.lstrip("/")[len(robot) + 1 :] if frame.lstrip("/").startswith(f"{robot}/") else ""
    height_m = LIFT_LINKS.get(link)
    return None if height_m is None else transform_matrix((0.0, 0.0, height_m), (0.0, 0.0, 0.0, 1.0))


@lru_cache(maxsize=256)
def ankurbot_mask(spec: GridSpec, yaw_rad: float, offset: Tuple[float, float] = (0.0, 0.0)) -> Mask:
    """Cells of the mobile robot: every cell that one of its solids enters.

    Args:
        spec: the grid; cells above or below it are left out, cells beside it are kept.
        yaw_rad: heading of the arm, rad, world.
        offset: end effector's position from the centre of its column, metres, world.

    Returns:
        Mask relative to the end effector's column: 17 x 7 x 15 cells with the arm along x on the usual grid.
    """
    return solids_mask(spec, ANKURBOT_DISCS, ANKURBOT_BEAMS, yaw_rad, offset)


def solids_mask(
    spec: GridSpec,
    discs: Tuple[Disc, ...],
    beams: Tuple[Beam, ...],
    yaw_rad: float,
    offset: Tuple[float, float] = (0.0, 0.0),
) -> Mask:
    """Cells that any of the solids enters; arguments as for ``ankurbot_mask``.

    Raises:
        GridError: no solid reaches into the grid's heights.
    """
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    reach = max(
        [math.hypot(d.x, d.y) + d.radius for d in discs]
        + [math.hypot(max(map(abs, b.x)), max(map(abs, b.y))) for b in beams]
    )
    size = spec.resolution[:2]
    span = np.ceil(reach / size + 1.0).astype(np.int64)
    columns = np.argwhere(np.ones(2 * span + 1, dtype=bool)) - span
    centres = columns * size - np.asarray(offset)
    parts: List[FloatArray] = []
    for disc in discs:
        middle = np.array([c * disc.x - s * disc.y, s * disc.x + c * disc.y])
        parts.append(_raised(spec, columns, _near_disc(centres - middle, size, disc.radius), disc.z))
    for beam in beams:
        mid_x, mid_y = sum(beam.x) / 2.0, sum(beam.y) / 2.0
        middle = np.array([c * mid_x - s * mid_y, s * mid_x + c * mid_y])
        half = np.array([beam.x[1] - beam.x[0], beam.y[1] - beam.y[0]]) / 2.0
        parts.append(_raised(spec, columns, _near_beam(centres - middle, size, half, yaw_rad), beam.z))
    return Mask.from_cells(np.concatenate(parts), (0, 0), wrap_angle(yaw_rad))


def _near_disc(apart: FloatArray, size: FloatArray, radius: float) -> BoolArray:
    gap = np.maximum(np.abs(apart) - size / 2.0, 0.0)
    inside: BoolArray = np.hypot(gap[:, 0], gap[:, 1]) < radius - TOUCH_M
    return inside


def _near_beam(apart: FloatArray, size: FloatArray, half: FloatArray, yaw_rad: float) -> BoolArray:
    """Separating axes of an upright cell and a turned rectangle (Gottschalk, Lin, Manocha, SIGGRAPH 1996)."""
    along = np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
    across = np.array([-along[1], along[0]])
    inside: BoolArray = np.ones(len(apart), dtype=bool)
    for axis in (np.array([1.0, 0.0]), np.array([0.0, 1.0]), along, across):
        own = half[0] * abs(axis @ along) + half[1] * abs(axis @ across)
        inside &= np.abs(apart @ axis) < own + (size / 2.0) @ np.abs(axis) - TOUCH_M
    return inside


def _raised(spec: GridSpec, columns: FloatArray, inside: BoolArray, z: Tuple[float, float]) -> FloatArray:
    """Cells (n, 3) of the marked columns at the heights z, metres, within the grid's heights."""
    floor, height = spec.lower[2], float(spec.resolution[2])
    low = max(0, math.floor((z[0] - floor) / height + TOUCH_M))
    high = min(spec.shape[2], math.ceil((z[1] - floor) / height - TOUCH_M))
    heights = np.arange(low, max(low, high))
    marked = columns[inside]
    return np.column_stack([np.repeat(marked, len(heights), axis=0), np.tile(heights, len(marked))])
