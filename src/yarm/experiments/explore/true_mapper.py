"""Draws scans into a map from the true pose: what a SLAM without error would publish, by the rules of src/slam."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter

from yarm.geometry import BoolArray, FloatArray, IntArray, Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.grid_map import UNKNOWN, GridMap
from yarm.robots.turtlebot import SCAN_BIAS_PER_M

MarkArray = npt.NDArray[np.float32]


@dataclass(frozen=True)
class MapRules:
    """How scans become cells; names and numbers of slam::MapParams and slam::ScanParams.

    Attributes:
        resolution_m: edge of a cell.
        max_range_m: longer ranges clear this far and mark nothing.
        range_weight_m: a mark counts 1 / (1 + (sigma / range_weight)^2).
        occupied_hits: weight of hits above which a cell may be occupied.
        occupied_share: share of hits among all marks above which it is.
        blur_share: a cell with less than this share of a neighbour's hits is blur of that neighbour's wall.
        sigma_base_m: standard deviation of a range is base + slope r^2.
        sigma_slope: 1/m.
        bias_slope: 1/m; ranges are lengthened by this times r^2, the nearest of noisy rows reads short.
    """

    resolution_m: float = 0.05
    max_range_m: float = 5.0
    range_weight_m: float = 0.012
    occupied_hits: float = 1.0
    occupied_share: float = 0.25
    blur_share: float = 0.1
    sigma_base_m: float = 0.006
    sigma_slope: float = 0.0012
    bias_slope: float = SCAN_BIAS_PER_M


class TrueMapper:
    """Hits and misses of cells, and the map they make. The map frame is the world's."""

    def __init__(
        self,
        lower: Tuple[float, float],
        upper: Tuple[float, float],
        margin_m: float = 0.5,
        rules: MapRules = MapRules(),
    ) -> None:
        """An unknown map.

        Args:
            lower: least x, y that can be seen, metres.
            upper: greatest x, y.
            margin_m: the map reaches so much farther on every side.
            rules: how scans become cells.
        """
        edge = rules.resolution_m
        first = [int(np.floor((value - margin_m) / edge)) for value in lower]
        last = [int(np.ceil((value + margin_m) / edge)) for value in upper]
        self._rules = rules
        self._columns, self._rows = last[0] - first[0], last[1] - first[1]
        self._origin = Pose2(first[0] * edge, first[1] * edge)
        self._hits: MarkArray = np.zeros(self._rows * self._columns, dtype=np.float32)
        self._misses: MarkArray = np.zeros(self._rows * self._columns, dtype=np.float32)
        self.scans = 0

    def add(self, scan: Scan, base: Pose2) -> None:
        """Draw a scan taken from a pose of the base; each cell counts once, as hit rather than as miss."""
        sensor = base.compose(scan.sensor)
        valid = scan.valid()
        read = np.where(valid, scan.ranges, 0.0).astype(float)
        ranges = read + self._rules.bias_slope * read**2
        hits, weights = self._hit_cells(ranges, scan.angles() + sensor.yaw_rad, sensor)
        kept = self._hits[hits]
        self._hits[hits] = kept + weights
        misses, weights = self._missed_cells(ranges, scan, sensor, hits)
        self._misses[misses] += weights
        self.scans += 1

    def _weight(self, ranges: FloatArray) -> MarkArray:
        sigma = (self._rules.sigma_base_m + self._rules.sigma_slope * ranges**2) / self._rules.range_weight_m
        weight: MarkArray = (1.0 / (1.0 + sigma**2)).astype(np.float32)
        return weight

    def _hit_cells(self, ranges: FloatArray, bearings: FloatArray, sensor: Pose2) -> Tuple[IntArray, MarkArray]:
        hit = (ranges > 0.0) & (ranges <= self._rules.max_range_m)
        edge = self._rules.resolution_m
        column = np.floor((sensor.x + ranges[hit] * np.cos(bearings[hit]) - self._origin.x) / edge).astype(np.int64)
        row = np.floor((sensor.y + ranges[hit] * np.sin(bearings[hit]) - self._origin.y) / edge).astype(np.int64)
        inside = (column >= 0) & (row >= 0) & (column < self._columns) & (row < self._rows)
        return row[inside] * self._columns + column[inside], self._weight(ranges[hit][inside])

    def _missed_cells(
        self, ranges: FloatArray, scan: Scan, sensor: Pose2, hits: IntArray
    ) -> Tuple[IntArray, MarkArray]:
        """Cells whose centre a beam has passed, looked up from the cells: the fan's box is gone through once."""
        edge = self._rules.resolution_m
        reach = np.minimum(ranges, self._rules.max_range_m)
        rows, columns = self._window(reach, scan, sensor)
        dx = self._origin.x + (np.arange(columns.start, columns.stop) + 0.5) * edge - sensor.x
        dy = (self._origin.y + (np.arange(rows.start, rows.stop) + 0.5) * edge - sensor.y)[:, None]
        c, s = np.cos(sensor.yaw_rad), np.sin(sensor.yaw_rad)
        ahead, aside = c * dx + s * dy, c * dy - s * dx
        in_fan = self._in_fan(ahead, aside, scan)
        row, column = np.nonzero(in_fan)
        ahead, aside = ahead[in_fan], aside[in_fan]
        beam = np.rint((np.arctan2(aside, ahead) - scan.angle_min_rad) / scan.angle_increment_rad).astype(np.int64)
        beam = np.minimum(np.maximum(beam, 0), len(reach) - 1)
        passed = ahead**2 + aside**2 < reach[beam] ** 2
        cells = (row[passed] + rows.start) * self._columns + column[passed] + columns.start
        weights = self._weight(reach)[beam[passed]]
        was_hit: BoolArray = np.zeros(len(self._hits), dtype=bool)
        was_hit[hits] = True
        keep = ~was_hit[cells]
        return cells[keep], weights[keep]

    def _in_fan(self, ahead: FloatArray, aside: FloatArray, scan: Scan) -> BoolArray:
        """Which places, in the sensor's frame, lie between the outermost beams (a fan of less than half a turn)."""
        low, high = scan.angle_min_rad, scan.angle_min_rad + scan.angle_increment_rad * (len(scan.ranges) - 1)
        inside: BoolArray = (aside * np.cos(low) >= ahead * np.sin(low)) & (
            aside * np.cos(high) <= ahead * np.sin(high)
        )
        return inside & (ahead > 0.0)

    def _window(self, reach: FloatArray, scan: Scan, sensor: Pose2) -> Tuple[slice, slice]:
        """Rows and columns of the box around the sensor and the ends of its beams."""
        bearings = scan.angles() + sensor.yaw_rad
        x, y = sensor.x + reach * np.cos(bearings), sensor.y + reach * np.sin(bearings)
        edge = self._rules.resolution_m

        def span(values: FloatArray, at: float, origin: float, count: int) -> slice:
            low, high = min(float(values.min()), at), max(float(values.max()), at)
            first = min(max(int((low - origin) / edge), 0), count)
            return slice(first, min(max(int((high - origin) / edge) + 1, first), count))

        return span(y, sensor.y, self._origin.y, self._rows), span(x, sensor.x, self._origin.x, self._columns)

    def map(self) -> GridMap:
        """The map as it stands."""
        shape = (self._rows, self._columns)
        hits, misses = self._hits.reshape(shape), self._misses.reshape(shape)
        marks = hits + misses
        wall = (hits > self._rules.occupied_hits) & (hits > self._rules.occupied_share * marks)
        wall &= hits >= self._rules.blur_share * maximum_filter(hits, size=3, mode="constant")
        cells = np.full(shape, UNKNOWN, dtype=np.int8)
        cells[(misses > hits) & ~wall] = 0
        cells[wall] = 100
        return GridMap(cells, self._rules.resolution_m, self._origin)
