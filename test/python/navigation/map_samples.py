"""Maps for the tests of navigation, drawn with letters."""

from __future__ import annotations

import numpy as np

from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap

VALUES = {".": 0, "#": 100, "?": -1}


def drawn(picture: str, scale: int = 4) -> GridMap:
    """A map of 5 cm cells from a picture: '.' free, '#' occupied, '?' unknown; top line at the greatest y.

    Each letter becomes scale x scale cells.
    """
    lines = [line.strip() for line in picture.strip().splitlines()][::-1]
    cells = np.array([[VALUES[letter] for letter in line] for line in lines], np.int8)
    return GridMap(np.kron(cells, np.ones((scale, scale), np.int8)), 0.05, Pose2(0.0, 0.0))


def cluttered(seed: int, yaw_rad: float = 0.0) -> GridMap:
    """A walled room of 7 x 7 m with 25 blocks anywhere."""
    rng = np.random.default_rng(seed)
    cells = np.zeros((140, 140), np.int8)
    for _ in range(25):
        row, column = rng.integers(5, 130, 2)
        cells[row : row + rng.integers(2, 25), column : column + rng.integers(1, 20)] = 100
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    return GridMap(cells, 0.05, Pose2(-3.5, -3.5, yaw_rad))
