"""What the scan cannot see, kept beside the map: low obstacles and places where the robot bumped into something."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Set, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Scan
from yarm.navigation.costs import Room
from yarm.navigation.grid_map import GridMap
from yarm.robots import turtlebot

Key = Tuple[int, int]
BEARINGS = {
    turtlebot.Bumper.LEFT: math.radians(60.0),
    turtlebot.Bumper.CENTER: 0.0,
    turtlebot.Bumper.RIGHT: math.radians(-60.0),
}
"""Middle of each sector of the bumper."""
SECTOR_RAD = math.radians(60.0)


@dataclass(frozen=True)
class OverlaySettings:
    """How places are kept.

    Attributes:
        cell_m: places are kept on squares of this side, anchored at the origin of the map frame.
        sure_near_m: from this distance on a camera view can show that a place is free ...
        sure_far_m: ... and up to this.
        half_view_rad: half of the angle within which it can.
        misses: so many more views must show a place free than showed it taken before it is given up.
        contact_m: beyond the robot's rim, where what it bumped into is marked.
        known_m: a bump this near to something that the map has already adds nothing.
    """

    cell_m: float = 0.05
    sure_near_m: float = 1.05
    sure_far_m: float = 2.0
    half_view_rad: float = math.radians(26.0)
    misses: int = 8
    contact_m: float = 0.03
    known_m: float = 0.06


@dataclass
class _Place:
    seen: int = 0
    free: int = 0
    bumped: bool = False


class Overlay:
    """Places in the map frame; they are laid over any map of that frame, whatever its size, origin or resolution."""

    def __init__(self, settings: Optional[OverlaySettings] = None) -> None:
        """Nothing yet."""
        self._settings = settings or OverlaySettings()
        self._places: Dict[Key, _Place] = {}
        self.count = 0
        """How often the set of places has changed."""
        self._in_order: Tuple[int, List[Key], FloatArray] = (0, [], np.zeros((0, 2)))

    def points(self) -> FloatArray:
        """(n, 2) centres of the places, map frame, metres."""
        return self._sorted()[1]

    def see(self, pose: Pose2, points: FloatArray, scan: Optional[Scan] = None) -> None:
        """Take in one view of the depth camera.

        Args:
            pose: of the base in the map when the view was taken.
            points: (n, 2) low obstacles in the base frame, metres.
            scan: of the same moment; without it nothing is ever given up.
        """
        hit = {self._key(*point) for point in pose.moved(points)}
        for key in hit:
            if key not in self._places:
                self._places[key] = _Place()
                self.count += 1
            self._places[key].seen += 1
        if scan is not None and self._places:
            self._give_up(pose, points, hit, scan)

    def bump(self, pose: Pose2, bumper: turtlebot.Bumper, grid_map: Optional[GridMap] = None) -> FloatArray:
        """Mark what a sector of the bumper touched, unless the map shows it already.

        Returns:
            (n, 2) the marked places, map frame, metres; (0, 2) when the map explains the bump.
        """
        radius = turtlebot.RADIUS_M + self._settings.contact_m
        bearings = BEARINGS[bumper] + np.linspace(-0.5, 0.5, 7) * SECTOR_RAD
        arc = pose.moved(radius * np.stack([np.cos(bearings), np.sin(bearings)], axis=1))
        if grid_map is not None:
            gap = Room(grid_map, 2.0 * self._settings.known_m).distances(arc)
            if np.any(gap < self._settings.known_m):
                return np.zeros((0, 2))
        marked = arc[1:-1]
        for point in marked:
            self._places.setdefault(self._key(*point), _Place()).bumped = True
        self.count += 1
        return marked

    def over(self, grid_map: GridMap) -> GridMap:
        """The map with every place occupied in it; the map itself when there are none."""
        points = self._spread(grid_map.resolution_m)
        cells = grid_map.cells_of(points)
        inside = np.all((cells >= 0) & (cells < np.array(grid_map.cells.shape)), axis=1)
        if not inside.any():
            return grid_map
        merged = grid_map.cells.copy()
        merged[cells[inside, 0], cells[inside, 1]] = 100
        return GridMap(merged, grid_map.resolution_m, grid_map.origin)

    def _spread(self, resolution_m: float) -> FloatArray:
        """Points of the places, close enough together that none of the cells of a finer map is left out."""
        count = max(1, math.ceil(self._settings.cell_m / resolution_m - 1e-6))
        offsets = ((np.arange(count) + 0.5) / count - 0.5) * self._settings.cell_m
        grid = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        spread: FloatArray = (self.points()[:, None, :] + grid[None, :, :]).reshape(-1, 2)
        return spread

    def _sorted(self) -> Tuple[List[Key], FloatArray]:
        """The places in order, and their centres (n, 2); kept until the set of places changes."""
        if self._in_order[0] != self.count:
            keys = sorted(self._places)
            centres = (np.array(keys, dtype=float).reshape(-1, 2) + 0.5) * self._settings.cell_m
            self._in_order = (self.count, keys, centres)
        return self._in_order[1], self._in_order[2]

    def _key(self, x: float, y: float) -> Key:
        return math.floor(x / self._settings.cell_m), math.floor(y / self._settings.cell_m)

    def _give_up(self, pose: Pose2, points: FloatArray, hit: Set[Key], scan: Scan) -> None:
        keys, places = self._sorted()
        camera = pose.compose(scan.sensor)
        seen_free = self._seen_free(camera, places, _bearing_range(points, scan.sensor), scan)
        gone: List[Key] = []
        for index in seen_free:
            key = keys[index]
            place = self._places[key]
            beside = any((key[0] + i, key[1] + j) in hit for i in (-1, 0, 1) for j in (-1, 0, 1))
            if not beside and not place.bumped:
                place.free += 1
                if place.free >= place.seen + self._settings.misses:
                    gone.append(key)
        for key in gone:
            del self._places[key]
            self.count += 1

    def _seen_free(self, camera: Pose2, places: FloatArray, taken: FloatArray, scan: Scan) -> List[int]:
        """Which of places (n, 2) lie in open view: no wall and no low obstacle (bearing, range) before or at them."""
        s = self._settings
        local = camera.inverse().moved(places)
        distance, bearing = np.hypot(local[:, 0], local[:, 1]), np.arctan2(local[:, 1], local[:, 0])
        free = (distance > s.sure_near_m) & (distance < s.sure_far_m) & (np.abs(bearing) < s.half_view_rad)
        candidates = np.flatnonzero(free)
        if len(candidates) == 0:
            return []
        angles, valid, found = scan.angles(), scan.valid(), []
        for i in candidates:
            width = s.cell_m / distance[i]
            beams = (np.abs(angles - bearing[i]) < width) & valid
            through = beams.any() and bool(np.all(scan.ranges[beams] > distance[i] + 2.0 * s.cell_m))
            shadow = (np.abs(taken[:, 0] - bearing[i]) < 2.0 * width) & (taken[:, 1] < distance[i] + s.cell_m)
            if through and not shadow.any():
                found.append(int(i))
        return found


def _bearing_range(points: FloatArray, sensor: Pose2) -> FloatArray:
    local = sensor.inverse().moved(points)
    both: FloatArray = np.stack([np.arctan2(local[:, 1], local[:, 0]), np.hypot(local[:, 0], local[:, 1])], axis=1)
    return both
