"""The bin that debris goes into: its measures, as in urdf/cell/cell.urdf.xacro (a test compares)."""

from __future__ import annotations

from yarm.geometry import FloatArray

NAME = "bin"
"""Type of the fixture; names of bins begin with it, by which everybody knows them."""
WIDTH_M = 0.40
"""Outer width of its square, metres."""
WALL_M = 0.02
"""Thickness of walls and floor, metres."""
RIM_M = 0.60
"""Height of its rim over the floor, metres."""


def is_bin(name: str) -> bool:
    """Whether an object is a bin, by its name."""
    return name.startswith(NAME)


def inside(point: FloatArray) -> bool:
    """Whether a point (3,), metres, is in a bin; frame: the middle of its floor area, z up from the cell's floor."""
    half = 0.5 * WIDTH_M - WALL_M
    return bool(abs(point[0]) < half and abs(point[1]) < half and 0.0 < point[2] < RIM_M)
