"""Errors of where perception sees pieces of debris, at random places of a simulated cell, Kinect noise on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List

import numpy as np

from support.simulated_cell import SimulatedCell
from yarm.geometry import SeenPiece
from yarm.sim.scenes.specs import ThingSpec

CALIBRATION_SETS = 5
HALF_HEIGHT_M = 0.02
SURFACES = [
    (0.73, (-0.42, -0.08), (-0.27, -0.08)),
    (0.73, (-0.42, -0.08), (0.08, 0.27)),
    (0.70, (0.10, 0.35), (-0.50, -0.15)),
    (0.70, (0.10, 0.35), (0.15, 0.50)),
]
"""Height, and range of x and y, of each place for a piece, metres: two on the part, two on the table, all apart."""


@dataclass(frozen=True)
class Error:
    """What is wrong with one view: metres along and across the piece, metres of its top, rad of its axis."""

    along_m: float
    across_m: float
    top_m: float
    axis_rad: float


def error_of(piece: SeenPiece, pose: np.ndarray) -> Error:
    """A view against the truth (4, 4)."""
    off = np.array(piece.top_m[:2]) - pose[:2, 3]
    turned = math.remainder(piece.axis_rad - math.atan2(pose[1, 0], pose[0, 0]), math.pi)
    return Error(
        float(off @ pose[:2, 0]),
        float(off @ pose[:2, 1]),
        piece.top_m[2] - float(pose[2, 3]) - HALF_HEIGHT_M,
        turned,
    )


def calibrated_cell() -> SimulatedCell:
    """The scene `single`, a robot and the table, calibrated; to be closed."""
    cell = SimulatedCell("single")
    cell.world.run(0.5)
    for _ in range(CALIBRATION_SETS):
        cell.next_set(calibrating=True)
    return cell


def looked_at(cell: SimulatedCell, rng: np.random.Generator, sets: int) -> List[List[Error]]:
    """Four pieces come, are looked at and go again: errors of the views of each."""
    names = [f"debris_{number}" for number in range(len(SURFACES))]
    for name, (height, x, y) in zip(names, SURFACES):
        place = (float(rng.uniform(*x)), float(rng.uniform(*y)), height + HALF_HEIGHT_M + 0.003)
        cell.world.spawn(ThingSpec(name, "Debris", *place, float(rng.uniform(-math.pi, math.pi))))
    cell.tell()
    cell.world.run(0.5)
    errors: List[List[Error]] = [[] for _ in names]
    for _ in range(sets):
        pieces = cell.next_set(calibrating=False).pieces
        assert set(pieces) <= set(names)
        truth = cell.world.transforms()
        for name, piece in pieces.items():
            errors[names.index(name)].append(error_of(piece, truth[name]))
    for name in names:
        cell.world.delete(name)
    cell.tell()
    return errors
