"""What a page is sent of a room: its map, and marks on it; metres, in the map's frame."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Dict, List, Sequence, Tuple

import numpy as np
import numpy.typing as npt

from yarm.console.wire import encode
from yarm.geometry import FloatArray

UNSEEN = 255
"""What a page gets for a cell that nobody has seen; else the probability that it is occupied, 0 to 100."""
Colour = Tuple[float, float, float, float]
"""Red, green, blue and how opaque, 0 to 1."""


@dataclass(frozen=True, eq=False)
class RoomMap:
    """An occupancy grid on the floor.

    Attributes:
        cells: (height, width) probabilities in percent, -1 for unseen; row 0 at the origin.
        resolution_m: edge of a cell, metres.
        origin: x and y of the corner of cell (0, 0), metres, and its turn, rad.
    """

    cells: npt.NDArray[np.int8]
    resolution_m: float
    origin: Tuple[float, float, float]

    def message(self, version: int) -> bytes:
        """As a page gets it; array ``cells``, row by row."""
        height, width = self.cells.shape
        header = {
            "kind": "map",
            "version": version,
            "width": width,
            "height": height,
            "resolution": self.resolution_m,
            "origin": list(self.origin),
            "seen": self.seen(),
        }
        cells = np.where(self.cells < 0, UNSEEN, np.clip(self.cells, 0, 100)).astype(np.uint8)
        return encode(header, {"cells": cells.reshape(-1)})

    def seen(self) -> List[float]:
        """Corners of what has been seen, in the map's own directions: x0, y0, x1, y1; empty for nothing."""
        rows, columns = np.nonzero(self.cells >= 0)
        if not len(rows):
            return []
        low = np.array([columns.min(), rows.min()]) * self.resolution_m
        high = np.array([columns.max() + 1, rows.max() + 1]) * self.resolution_m
        x, y, _ = self.origin
        return [float(value) for value in (x + low[0], y + low[1], x + high[0], y + high[1])]


@dataclass
class Marks:
    """Solids, lines and words on a map, in the order they are drawn."""

    solids: List[Dict[str, Any]] = field(default_factory=list)
    poses: List[FloatArray] = field(default_factory=list)
    sizes: List[Tuple[float, float, float]] = field(default_factory=list)
    lines: List[Dict[str, Any]] = field(default_factory=list)
    points: List[FloatArray] = field(default_factory=list)
    texts: List[Dict[str, Any]] = field(default_factory=list)

    def solid(self, shape: str, pose: FloatArray, size: Tuple[float, float, float], colour: Colour) -> None:
        """A box, cylinder or sphere: its pose, (4, 4), and full size along its axes."""
        self.solids.append({"shape": shape, "colour": list(colour)})
        self.poses.append(pose)
        self.sizes.append(size)

    def line(self, points: FloatArray, colour: Colour) -> None:
        """A line through points, (n, 3)."""
        self.lines.append({"count": len(points), "colour": list(colour)})
        self.points.append(points)

    def text(self, words: str, at: Sequence[float]) -> None:
        """Words over a place."""
        self.texts.append({"text": words, "at": [round(float(value), 3) for value in at]})

    def message(self, version: int) -> bytes:
        """As a page gets them; arrays ``pose`` (n, 16), ``size`` (n, 3), ``points`` (n, 3) of the lines in order."""
        header = {
            "kind": "marks",
            "version": version,
            "solids": self.solids,
            "lines": self.lines,
            "texts": self.texts,
        }
        arrays = {
            "pose": np.array(self.poses, np.float32).reshape(-1, 16),
            "size": np.array(self.sizes, np.float32).reshape(-1, 3),
            "points": np.concatenate(self.points or [np.empty((0, 3))]).astype(np.float32),
        }
        return encode(header, arrays)
