"""The HC10 in its cell: where it is bolted, how it is folded, and its station, which a scene may put elsewhere."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Tuple

import numpy as np
import yaml

from yarm.geometry import FloatArray, GridSpec, quaternion_from_rpy, transform_matrix, transform_points
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource

NAME = "hc10_barc"
"""Name of the first HC10; every other one's begins with it: ``hc10_barc_2``."""
N_JOINTS = 6
STATION_FIXTURES = ("table", "stand")
"""What belongs to a station: types of fixtures, in urdf/cell/cell.urdf.xacro."""

EDGE_CELLS = 1e-6
"""An area that enters a cell by less, in cells, only touches it."""
Area = Tuple[int, int, int, int, int, int]
"""Cells x from, to, y from, to, z from, to, inclusive."""
PRIVATE_AREA: Area = (11, 29, 17, 32, 0, 10)
"""Where a manipulator works whose station is at the world's origin: cells of the usual grid."""


@dataclass(frozen=True)
class ArmMount:
    """The shipped mounting.

    Attributes:
        base_xyz: where the arm is bolted, metres, frame of its station; it is not turned there.
        storage: storage pose, (6,) rad.
    """

    base_xyz: Tuple[float, float, float]
    storage: Tuple[float, ...]


@lru_cache(maxsize=1)
def arm_mount() -> ArmMount:
    """Read config/cell/hc10.yaml."""
    raw = yaml.safe_load(resource("config", "cell", "hc10.yaml").read_text(encoding="utf-8"))
    x, y, z = raw["base_xyz"]
    return ArmMount((float(x), float(y), float(z)), tuple(float(angle) for angle in raw["storage"]))


@dataclass(frozen=True)
class Box:
    """A solid box: name, size and centre, metres, frame of the station."""

    name: str
    size: Tuple[float, float, float]
    centre: Tuple[float, float, float]


@lru_cache(maxsize=1)
def station_boxes() -> Tuple[Box, ...]:
    """Stand, table and part, from urdf/cell/cell.urdf.xacro."""
    boxes = []
    for fixture in ("stand", "table"):
        model = parse_urdf(expand_xacro(resource("urdf", "cell", "cell.urdf.xacro"), part=fixture))
        for solid in model.solids:
            x, y, z = (model.rigid_group(solid.link)[1] @ solid.pose)[:3, 3].tolist()
            length, width, height = solid.size
            boxes.append(Box(solid.link, (length, width, height), (x, y, z)))
    return tuple(boxes)


@dataclass(frozen=True)
class Station:
    """A manipulator's place in the cell: stand, table and part, which keep their places to each other.

    Its frame is the world's when it is neither moved nor turned: on the floor below the middle of the table.

    Attributes:
        x: its origin, metres, world.
        y: likewise.
        yaw_rad: how far it is turned about z, rad.
        storage: storage pose of its arm, (6,) rad; empty for the shipped one.
    """

    x: float = 0.0
    y: float = 0.0
    yaw_rad: float = 0.0
    storage: Tuple[float, ...] = ()

    @property
    def pose(self) -> FloatArray:
        """T_world_station (4, 4)."""
        return transform_matrix((self.x, self.y, 0.0), quaternion_from_rpy(0.0, 0.0, self.yaw_rad))

    @property
    def folded(self) -> Tuple[float, ...]:
        """Storage pose of its arm, (6,) rad."""
        return self.storage or arm_mount().storage

    @property
    def base_xyz(self) -> Tuple[float, float, float]:
        """Where its arm is bolted, metres, world; the arm's base is turned by ``yaw_rad`` there."""
        x, y, z = transform_points(self.pose, np.array([arm_mount().base_xyz]))[0].tolist()
        return x, y, z

    def moved_area(self, spec: GridSpec, area: Area) -> Area:
        """The cells that an area of the station that is not moved comes to lie in, cut off at the grid's border.

        Args:
            spec: the grid.
            area: its cells with the station at the world's origin.
        """
        size, lower = spec.resolution[:2], np.asarray(spec.lower[:2])
        corners = np.array([(x, y, 0.0) for x in (area[0], area[1] + 1) for y in (area[2], area[3] + 1)])
        corners[:, :2] = lower + corners[:, :2] * size
        edges = (transform_points(self.pose, corners)[:, :2] - lower) / size
        low = np.floor(edges.min(axis=0) + EDGE_CELLS).astype(int)
        high = np.ceil(edges.max(axis=0) - EDGE_CELLS).astype(int) - 1
        last = np.asarray(spec.shape[:2]) - 1
        (x0, y0), (x1, y1) = np.clip(low, 0, last).tolist(), np.clip(high, 0, last).tolist()
        return x0, x1, y0, y1, area[4], area[5]


def area_text(area: Area) -> str:
    """An area as in a calibration answer: ``11,29,17,32,0,10``."""
    return ",".join(str(cell) for cell in area)


def parse_area(text: str) -> Area:
    """An area from its text.

    Raises:
        ValueError: not six whole numbers, or a last cell before the first one of its axis.
    """
    try:
        x0, x1, y0, y1, z0, z1 = (int(part) for part in text.split(","))
    except ValueError as error:
        raise ValueError(f"area {text!r} must be six whole numbers: x from, to, y from, to, z from, to") from error
    if x1 < x0 or y1 < y0 or z1 < z0:
        raise ValueError(f"area {text!r} must not end before it begins on any axis")
    return x0, x1, y0, y1, z0, z1


AT_ORIGIN = Station()
"""The shipped station, neither moved nor turned."""


def station_faults(station: Station) -> str:
    """What is wrong with a station's numbers; empty when nothing is."""
    numbers = (station.x, station.y, station.yaw_rad, *station.storage)
    if not all(math.isfinite(value) for value in numbers):
        return f"x, y, yaw_rad and storage must be finite numbers, not {numbers}"
    if station.storage and len(station.storage) != N_JOINTS:
        return f"storage must be empty or {N_JOINTS} angles, rad; it has {len(station.storage)}"
    return ""
