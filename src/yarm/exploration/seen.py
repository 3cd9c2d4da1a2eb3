"""What the sensors have swept, kept in the map frame, whatever happens to the map itself."""

from __future__ import annotations

import math
from typing import Tuple

import numpy as np

from yarm.exploration.squares import Squares
from yarm.geometry import BoolArray, FloatArray, Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots import turtlebot

EDGE_M = 0.05
"""Of the squares: small enough that one under the robot's edge hides no brick beside it."""
NOTHING: FloatArray = np.zeros((0, 2))
THING_M = 0.15
"""Width of a known thing: a cell of the map and one on each side, as only the edges towards the camera are known."""
QUARTERS_RAD: FloatArray = 0.5 * math.pi * np.arange(4)
"""Along the axes of the map frame: where a view that has one in it reaches farthest."""
PASSED_OVER_M = 0.15
"""A scan that goes on for more than this behind a thing has passed over it."""


class SweptGround:
    """When each square of the ground was last in view; -inf where it never was.

    Args:
        near_m: nearer ground is not seen.
        far_m: farther ground is not judged.
    """

    def __init__(self, near_m: float, far_m: float) -> None:
        self._near_m, self._far_m = near_m, far_m
        self._squares = Squares(EDGE_M)
        self._when: FloatArray = np.full((self._squares.count, self._squares.count), -np.inf)

    def see(self, base: Pose2, scan: Scan, now_s: float, things: FloatArray = NOTHING) -> None:
        """A scan from a pose of the base in the map has swept what lies before its hits.

        Args:
            base: in the map.
            scan: what was measured.
            now_s: time.
            things: (n, 2) places of known things in the base frame, metres; those that the scan passes over hide what
                lies behind them, which is then not swept.
        """
        sensor = base.compose(scan.sensor)
        low, high = self._bounds(sensor.yaw_rad, abs(scan.angle_min_rad))
        rows = self._squares.span(sensor.y + low[1], sensor.y + high[1])
        columns = self._squares.span(sensor.x + low[0], sensor.x + high[0])
        away_y = self._squares.centres(rows.start, rows.stop)[:, None] - sensor.y
        away_x = self._squares.centres(columns.start, columns.stop)[None, :] - sensor.x
        c, s = math.cos(sensor.yaw_rad), math.sin(sensor.yaw_rad)
        ahead, aside = c * away_x + s * away_y, c * away_y - s * away_x
        in_view = (ahead > 0.0) & (np.abs(aside) <= ahead * abs(math.tan(scan.angle_min_rad)))
        row, column = np.nonzero(in_view)
        ahead, aside = ahead[in_view], aside[in_view]
        distance = np.hypot(ahead, aside)
        beam = np.rint((np.arctan2(aside, ahead) - scan.angle_min_rad) / scan.angle_increment_rad).astype(np.int64)
        ranges = _open_ranges(scan, things)[np.minimum(np.maximum(beam, 0), len(scan.ranges) - 1)]
        swept = (distance < ranges) & (distance >= self._near_m) & (distance <= self._far_m)
        self._when[row[swept] + rows.start, column[swept] + columns.start] = now_s

    def stand(self, base: Pose2, now_s: float) -> None:
        """The robot stands here: the ground under it is known."""
        rows = self._squares.span(base.y - turtlebot.RADIUS_M, base.y + turtlebot.RADIUS_M)
        columns = self._squares.span(base.x - turtlebot.RADIUS_M, base.x + turtlebot.RADIUS_M)
        away_y = self._squares.centres(rows.start, rows.stop)[:, None] - base.y
        away_x = self._squares.centres(columns.start, columns.stop)[None, :] - base.x
        self._when[rows, columns][np.hypot(away_y, away_x) <= turtlebot.RADIUS_M] = now_s

    def _bounds(self, yaw_rad: float, half_rad: float) -> Tuple[FloatArray, FloatArray]:
        """(2,) least and (2,) greatest x and y, metres from the sensor, of a view this wide about a heading."""
        turns = QUARTERS_RAD[np.abs(np.remainder(QUARTERS_RAD - yaw_rad + math.pi, 2.0 * math.pi) - math.pi) < half_rad]
        angles = np.concatenate([[yaw_rad - half_rad, yaw_rad + half_rad], turns])
        rim = self._far_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return np.minimum(rim.min(axis=0), 0.0), np.maximum(rim.max(axis=0), 0.0)

    def since(self, points: FloatArray, since_s: float) -> BoolArray:
        """(n,) which of points (n, 2) of the map frame have been in view at this time or later."""
        seen: BoolArray = self._when.take(self._squares.of_points(points)) >= since_s
        return seen

    def over(self, grid_map: GridMap, since_s: float) -> BoolArray:
        """(rows, columns) which cells of a map have been in view at this time or later."""
        seen: BoolArray = self._when.take(self._squares.of_map(grid_map)) >= since_s
        return seen


def _open_ranges(scan: Scan, things: FloatArray) -> FloatArray:
    """(beams,) how far each beam looks at open floor, metres: to its hit, or to the nearest thing it passes over."""
    hits: FloatArray = np.where(scan.valid(), scan.ranges, 0.0).astype(float)
    if len(things) == 0:
        return hits
    ranges = hits.copy()
    away = scan.sensor.inverse().moved(things)
    distance, bearing = np.hypot(away[:, 0], away[:, 1]), np.arctan2(away[:, 1], away[:, 0])
    half = np.arctan2(0.5 * THING_M, np.maximum(distance, THING_M))
    first = np.rint((bearing - half - scan.angle_min_rad) / scan.angle_increment_rad).astype(np.int64)
    last = np.rint((bearing + half - scan.angle_min_rad) / scan.angle_increment_rad).astype(np.int64)
    ahead = np.flatnonzero((last >= 0) & (first < len(ranges)))
    for i in ahead[np.argsort(-distance[ahead])]:  # the nearest is the last to say
        beams = slice(max(first[i], 0), max(last[i] + 1, 0))
        ranges[beams][hits[beams] > distance[i] + PASSED_OVER_M] = distance[i]
    return ranges
