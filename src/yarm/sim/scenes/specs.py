"""What stands in a scene: mobile robots, manipulators, and things that come and go."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.geometry import GridSpec
from yarm.robots.hc10 import AT_ORIGIN, Station

HALF_CELL_M = GridSpec().upper[0]
"""The mapped volume is x, y in [-HALF_CELL_M, HALF_CELL_M), metres."""


WITH_HAND = "ankurbot_hand"
"""The type of robot that carries a hand."""
ROBOT_TYPES = ("ankurbot", WITH_HAND)
DRAWN, NOT_DRAWN = "drawn", "none"
"""What a scene says of a robot's shapes: whether perception is told them."""


@dataclass(frozen=True)
class RobotSpec:
    """A mobile robot at its start.

    Attributes:
        name: unique name.
        type: one of ROBOT_TYPES.
        x: body centre on the floor, metres, world.
        y: likewise.
        heading_rad: of its arm.
        drawn: perception is told its shapes; else it has to learn them in calibration.
    """

    name: str
    type: str
    x: float
    y: float
    heading_rad: float
    drawn: bool = True

    @property
    def has_hand(self) -> bool:
        """Whether its type has a hand, whatever the others of the cell have."""
        return self.type == WITH_HAND


@dataclass(frozen=True)
class ArmSpec:
    """A manipulator; where it is bolted in its station and folded is in config/cell/hc10.yaml.

    Attributes:
        name: unique name.
        type: one of ARM_TYPES.
        tucked: it stays folded and takes no orders: to everybody it is an Obstacle.
        station: where its stand, table and part are, and how it is folded.
    """

    name: str
    type: str
    tucked: bool = False
    station: Station = AT_ORIGIN


@dataclass(frozen=True)
class FixtureSpec:
    """A stand or a table with its part, or a bin.

    Attributes:
        name: unique name.
        type: one of STATION_FIXTURES, or "bin".
        station: whose it is; for a bin where it stands itself.
    """

    name: str
    type: str
    station: Station = AT_ORIGIN


@dataclass(frozen=True)
class ThingSpec:
    """Debris, a target or an obstacle.

    Attributes:
        name: unique name.
        kind: "Debris", "Target" or "Obstacle".
        x: centre, metres, world.
        y: centre, metres, world.
        z: centre, metres, world.
        yaw_rad: heading, rad.
        size: obstacles that are boxes: along x, y, z, metres; else empty.
        registered: debris and obstacles: whether anybody is told of it, or it can only be seen.
        model: file of the description (URDF or xacro) it is drawn from; empty for the package's debris or a box.
    """

    name: str
    kind: str
    x: float
    y: float
    z: float
    yaw_rad: float = 0.0
    size: Tuple[float, ...] = ()
    registered: bool = True
    model: str = ""
