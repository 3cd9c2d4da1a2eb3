"""Tours of simulated rooms for tests of the map maker, written by ``slam_world_log``; planar poses; scores of maps."""

from __future__ import annotations

import math
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import List, Tuple

import numpy as np

Pose = Tuple[float, float, float]
"""x, y (m), yaw (rad)."""
ANGLE_MIN, ANGLE_MAX = -0.52157, 0.52428
"""Bearings of the first and the last beam, rad."""


def compose(a: Pose, b: Pose) -> Pose:
    """T_1_3 from T_1_2 and T_2_3."""
    c, s = math.cos(a[2]), math.sin(a[2])
    yaw = math.remainder(a[2] + b[2], 2.0 * math.pi)
    return a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], yaw


def inverse(a: Pose) -> Pose:
    """T_2_1 from T_1_2."""
    c, s = math.cos(a[2]), math.sin(a[2])
    return -c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]


@dataclass(frozen=True)
class Moment:
    """One scan of a tour with its odometry and the truth."""

    stamp_ns: int
    odometry: Pose
    truth: Pose
    ranges: np.ndarray


@dataclass(frozen=True)
class Tour:
    """A tour: what was seen (n, 2), the room's surfaces (m, 4) as x, y, x, y, and the scans."""

    seen: np.ndarray
    surfaces: np.ndarray
    moments: List[Moment]


def record(program: Path, room: int, scans: int, file: Path, boxes: bool = False) -> Tour:
    """Have a tour of a room, or of one with ten boxes, written and read it."""
    command = [str(program), str(room), str(scans), str(file), *(["boxes"] if boxes else [])]
    subprocess.run(command, check=True, timeout=120.0)
    seen, surfaces, *lines = file.read_text().splitlines()
    moments = []
    for line in lines:
        stamp, *rest = line.split()
        values = [float(value) for value in rest]
        odometry, truth = tuple(values[:3]), tuple(values[3:6])
        moments.append(Moment(int(stamp), odometry, truth, np.array(values[6:], np.float32)))
    return Tour(np.array(seen.split(), float).reshape(-1, 2), np.array(surfaces.split(), float).reshape(-1, 4), moments)


def clearance(points: np.ndarray, surfaces: np.ndarray) -> np.ndarray:
    """Distance of each point (n, 2) to the nearest surface (m, 4), m."""
    a, b = surfaces[:, :2], surfaces[:, 2:]
    along = b - a
    share = np.einsum("nmk,mk->nm", points[:, None] - a, along) / np.sum(along**2, axis=1)
    nearest = a + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)


def occupied(grid: np.ndarray, resolution: float, origin: Tuple[float, float], T_room_map: Pose) -> np.ndarray:
    """Centres of the occupied cells of a grid (rows, columns) in the room's frame, (n, 2), m."""
    rows, columns = np.nonzero(grid > 50)
    x = origin[0] + (columns + 0.5) * resolution
    y = origin[1] + (rows + 0.5) * resolution
    c, s = math.cos(T_room_map[2]), math.sin(T_room_map[2])
    return np.stack([T_room_map[0] + c * x - s * y, T_room_map[1] + s * x + c * y], axis=1)


def share_near(points: np.ndarray, cells: np.ndarray, reach: float) -> float:
    """Share of points that have a cell within reach."""
    distances = np.linalg.norm(points[:, None] - cells, axis=2)
    return float(np.mean(distances.min(axis=1) <= reach))
