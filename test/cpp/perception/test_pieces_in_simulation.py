"""Where the C++ perception sees pieces of debris, against where they are, Kinect noise on."""

from __future__ import annotations

import math
from typing import Iterator

import numpy as np
import pytest

from support.piece_errors import calibrated_cell, looked_at
from support.simulated_cell import SimulatedCell

SETS, ROUNDS = 4, 6


@pytest.fixture(name="cell", scope="module")
def cell_fixture() -> Iterator[SimulatedCell]:
    """The scene `single`: a robot, the table, no HC10."""
    cell = calibrated_cell()
    yield cell
    cell.close()


def test_pieces_are_seen_where_they_are(cell: SimulatedCell) -> None:
    """The cameras' pixels are 3 cm apart there: that is what is left of it."""
    rng = np.random.default_rng(3)
    pieces = [views for _ in range(ROUNDS) for views in looked_at(cell, rng, SETS)]
    errors = [error for views in pieces for error in views]
    assert len(errors) >= 0.95 * SETS * len(pieces), "a piece in fifty has too few points"
    assert np.median([abs(error.along_m) for error in errors]) < 0.010
    assert np.median([abs(error.across_m) for error in errors]) < 0.008
    assert max(math.hypot(error.along_m, error.across_m) for error in errors) < 0.05
    assert abs(np.median([error.top_m for error in errors])) < 0.005
    assert max(abs(error.top_m) for error in errors) < 0.03
    assert np.median([abs(error.axis_rad) for error in errors]) < math.radians(10.0)


def test_only_debris_is_a_piece(cell: SimulatedCell) -> None:
    assert cell.next_set(calibrating=False).pieces == {}
