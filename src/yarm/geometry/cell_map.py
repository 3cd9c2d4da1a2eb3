"""The live occupancy grid as the core sees it: a MapMetaData message without ROS."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Mapping, Optional, Tuple

import numpy as np
import numpy.typing as npt

from yarm.geometry.grid import GridSpec, IntArray

STRAY = "debris_auto_"
"""What the names of pieces of debris that nobody registered begin with, on the map."""


@dataclass(frozen=True)
class SeenPiece:
    """What the cameras see of a piece of debris, from its points alone.

    Attributes:
        points: seen of it.
        top_m: over its middle, at the height of its top, metres, world.
        axis_rad: direction of its longer side, rad, world; half a turn means the same.
        length_m: extent along that side, metres.
        width_m: extent across it, metres.
        cameras: the cameras that see points of it, numbered from 1.
    """

    points: int
    top_m: Tuple[float, float, float]
    axis_rad: float
    length_m: float
    width_m: float
    cameras: Tuple[int, ...] = ()


@dataclass(frozen=True)
class CarriedPiece:
    """How a piece of debris hangs on a robot's hand.

    Attributes:
        robot: that carries it.
        position_m: of the piece's seed in the frame of the robot's end effector, metres.
        quaternion: its orientation there, x, y, z, w.
    """

    robot: str
    position_m: Tuple[float, float, float]
    quaternion: Tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class MappedObject:
    """One object of the live grid.

    Attributes:
        name: unique name; "unknown_<n>" for a thing nobody registered, "debris_auto_<n>" for debris nobody did.
        kind: "Mobile", "Manipulator", "Debris", "Target" or "Obstacle".
        uid: number, unique for the life of the perception process.
        position_m: seed (a robot's end effector), metres, world.
        quaternion: seed orientation x, y, z, w.
        cells: (n, 3) its cells; none for a target and for what is carried: a robot's load is among the robot's cells.
        piece: what is seen of it, of debris; None for anything else, and for debris that is not seen. On a hand only
            what nobody registered has one.
        carried: how it hangs on a robot's hand, of debris; None for what does not.
    """

    name: str
    kind: str
    uid: int
    position_m: Tuple[float, float, float]
    quaternion: Tuple[float, float, float, float]
    cells: IntArray
    piece: Optional[SeenPiece] = None
    carried: Optional[CarriedPiece] = None

    @property
    def size_m(self) -> Optional[Tuple[float, float, float]]:
        """Length, width and height, metres, of a piece that nobody registered, as it is seen: its seed is its middle.

        None for anything else.
        """
        if self.piece is None or not self.name.startswith(STRAY):
            return None
        return self.piece.length_m, self.piece.width_m, 2.0 * (self.piece.top_m[2] - self.position_m[2])


class CellState(IntEnum):
    """What is known of a cell. Values as in MapMetaData.visibility."""

    NEVER_SEEN = 0
    HIDDEN = 1
    FREE = 2
    """A camera sees through it."""
    OCCUPIED = 3
    """A camera sees something in it."""


OTHER_HIDERS = 1 << 30
"""Bit of ``Visibility.hidden_by`` for the objects from the 31st on."""
NO_HIDER = 1 << 31
"""Bit for a camera that would see the cell, but has no view or no reading, or whose hider is not on the map."""


@dataclass(frozen=True, eq=False)
class Visibility:
    """What the cameras see of the cells.

    Attributes:
        states: (gx, gy, gz) int8, see ``CellState``.
        hidden_by: (n,) uint32, for each cell that is hidden or never seen, in the grid's order: bit k stands for the
            map's k-th object, which may hide it; see OTHER_HIDERS and NO_HIDER. 0: no camera would see it, were nothing
            in the cell.
        age_s: (gx, gy, gz) since a camera last saw each cell, s, +inf for never; None when this map does not tell.
    """

    states: npt.NDArray[np.int8]
    hidden_by: npt.NDArray[np.uint32]
    age_s: Optional[npt.NDArray[np.float32]] = None

    @property
    def unseen(self) -> npt.NDArray[np.bool_]:
        """(gx, gy, gz) cells that no camera sees now."""
        unseen: npt.NDArray[np.bool_] = self.states < CellState.FREE
        return unseen


@dataclass(frozen=True, eq=False)
class CellMap:
    """Occupancy at one capture time.

    Attributes:
        stamp_s: capture time, s.
        spec: the grid.
        grid: (gx, gy, gz) int8: 0 nobody, 1 one object, 2 more than one.
        objects: by name, in the order of the message.
        visibility: what the cameras see of the cells; None when perception does not judge it.
    """

    stamp_s: float
    spec: GridSpec
    grid: npt.NDArray[np.int8]
    objects: Mapping[str, MappedObject] = field(default_factory=dict)
    visibility: Optional[Visibility] = None
