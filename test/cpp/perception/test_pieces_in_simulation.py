"""Where the C++ perception sees pieces of debris, against where they are, Kinect noise on."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Iterator, List, Tuple

import numpy as np
import pytest

from support.simulated_cell import SimulatedCell
from yarm.geometry import SeenPiece
from yarm.sim.scenes.specs import ThingSpec

CALIBRATION_SETS, SETS, ROUNDS = 5, 4, 6
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
        abs(float(off @ pose[:2, 0])),
        abs(float(off @ pose[:2, 1])),
        piece.top_m[2] - float(pose[2, 3]) - HALF_HEIGHT_M,
        abs(turned),
    )


@pytest.fixture(name="cell", scope="module")
def cell_fixture() -> Iterator[SimulatedCell]:
    """The scene `single`: a robot, the table, no HC10."""
    cell = SimulatedCell("single")
    cell.world.run(0.5)
    for _ in range(CALIBRATION_SETS):
        cell.next_set(calibrating=True)
    yield cell
    cell.close()


def looked_at(cell: SimulatedCell, rng: np.random.Generator) -> Tuple[List[Error], int]:
    """Errors of the views of four pieces in some sets, and how many views there should have been."""
    names = [f"debris_{number}" for number in range(len(SURFACES))]
    for name, (height, x, y) in zip(names, SURFACES):
        place = (float(rng.uniform(*x)), float(rng.uniform(*y)), height + HALF_HEIGHT_M + 0.003)
        cell.world.spawn(ThingSpec(name, "Debris", *place, float(rng.uniform(-math.pi, math.pi))))
    cell.tell()
    cell.world.run(0.5)
    errors = []
    for _ in range(SETS):
        pieces = cell.next_set(calibrating=False).pieces
        assert set(pieces) <= set(names)
        truth = cell.world.transforms()
        errors += [error_of(piece, truth[name]) for name, piece in pieces.items()]
    for name in names:
        cell.world.delete(name)
    cell.tell()
    return errors, SETS * len(names)


def test_pieces_are_seen_where_they_are(cell: SimulatedCell) -> None:
    """The cameras' pixels are 3 cm apart there: that is what is left of it."""
    rng, errors, wanted = np.random.default_rng(3), [], 0
    for _ in range(ROUNDS):
        found, views = looked_at(cell, rng)
        errors += found
        wanted += views
    assert len(errors) >= 0.95 * wanted, "a piece in fifty has too few points"
    assert np.median([error.along_m for error in errors]) < 0.010
    assert np.median([error.across_m for error in errors]) < 0.008
    assert max(math.hypot(error.along_m, error.across_m) for error in errors) < 0.05
    assert abs(np.median([error.top_m for error in errors])) < 0.005
    assert max(abs(error.top_m) for error in errors) < 0.03
    assert np.median([error.axis_rad for error in errors]) < math.radians(10.0)


def test_only_debris_is_a_piece(cell: SimulatedCell) -> None:
    assert cell.next_set(calibrating=False).pieces == {}
