"""What a robot can see of the tags in a layout: for each the place that it can get to and that shows most."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Set, Tuple

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, FloatArray, Pose2, wrap_angle
from yarm.robots import turtlebot
from yarm.sim.checks.finding import Finding
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Block, BlockKind
from yarm.sim.scenes.layout import Layout

DISC_M = 0.20
"""The robot's disc as its navigation sees it."""
LEAST_SHARE = 0.70
CELL_M = 0.05
DISTANCES_M = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
ANGLES_DEG = (0, 15, -15, 30, -30, 45, -45, 60, -60)
ACROSS, DOWN = 11, 8
"""Points of a face that are looked at, along its width and its height."""


@dataclass(frozen=True)
class Sight:
    """The best look at a tag.

    Attributes:
        box: its number, from 1.
        share: of the face that is seen, 0 to 1.
        pose: from where; None when no place shows anything.
    """

    box: int
    share: float
    pose: Optional[Pose2]


def sights(layout: Layout) -> Tuple[Sight, ...]:
    """The best look at each tag from where the disc can get to from the start."""
    places = _Places(layout)
    return tuple(_best(layout, number, places) for number in range(1, len(layout.boxes) + 1))


def check_layout(layout: Layout) -> Tuple[Finding, ...]:
    """For each tag whether enough of it is seen from somewhere that the robot can get to."""
    found = []
    for sight in sights(layout):
        where = "from nowhere that the robot gets to"
        if sight.pose is not None:
            at = sight.pose
            where = f"from ({at.x:.2f}, {at.y:.2f}), {math.degrees(at.yaw_rad):.0f} deg"
        text = f"box {sight.box}: {100 * sight.share:.0f} % of its face is seen {where}"
        least = f" (at least {100 * LEAST_SHARE:.0f} %, by a disc of {DISC_M} m)"
        found.append(Finding(sight.share >= LEAST_SHARE, text + least))
    return tuple(found)


def visible_share(layout: Layout, number: int, pose: Pose2) -> float:
    """Share of a box's face that the camera of a robot at this pose sees, 0 to 1.

    A point of the face is seen when it is in the picture above the robot's own plate, the face looks towards the
    camera, and no other box is in the way (all stand higher than the camera's line to any face).
    """
    box = layout.boxes[number - 1]
    camera = pose.compose(turtlebot.RGB_MOUNT)
    points, heights = _face_points(box)
    away = np.hypot(points[:, 0] - camera.x, points[:, 1] - camera.y)
    bearings = np.arctan2(points[:, 1] - camera.y, points[:, 0] - camera.x)
    aside = np.array([wrap_angle(float(bearing) - camera.yaw_rad) for bearing in bearings])
    ahead = away * np.cos(aside)
    optical = np.stack([-away * np.sin(aside), turtlebot.CAMERA_Z_M - heights, ahead], axis=1)
    columns, rows = turtlebot.RGB_CAMERA.project(optical).T
    with np.errstate(invalid="ignore"):
        in_picture = (columns >= 0.0) & (columns < turtlebot.RGB_CAMERA.width)
        in_picture &= (rows >= 0.0) & (rows < turtlebot.HIDDEN_ROWS_FROM)
    outwards = math.cos(box.pose.yaw_rad), math.sin(box.pose.yaw_rad)
    faces = (camera.x - points[:, 0]) * outwards[0] + (camera.y - points[:, 1]) * outwards[1] > 0.0
    others = [block for block in layout.arena.blocks if block is not box and block.kind != BlockKind.LOW]
    enter, _, _ = FlatBoxes(others).spans(camera.x, camera.y, bearings)
    open_way = np.all(enter >= away - 1e-6, axis=0)
    return float(np.mean(in_picture & faces & open_way))


def _face_points(box: Block) -> Tuple[FloatArray, FloatArray]:
    """(n, 2) points of the tag on the floor plane and (n,) their heights, metres."""
    across = (np.arange(ACROSS) + 0.5) / ACROSS - 0.5
    heights = (np.arange(DOWN) + 0.5) / DOWN * box.size[2]
    local = np.stack([np.full(ACROSS, 0.5 * box.size[0]), across * box.size[1]], axis=1)
    places = np.array([(p.x, p.y) for p in (box.pose.compose(Pose2(float(x), float(y))) for x, y in local)])
    return np.repeat(places, DOWN, axis=0), np.tile(heights, ACROSS)


class _Places:
    """Where the disc can get to from the start."""

    def __init__(self, layout: Layout) -> None:
        arena = layout.arena
        self._boxes = FlatBoxes(arena.blocks)
        self._lower = arena.lower
        counts = [math.ceil((high - low) / CELL_M) for low, high in zip(arena.lower, arena.upper)]
        x = arena.lower[0] + (np.arange(counts[0]) + 0.5) * CELL_M
        y = arena.lower[1] + (np.arange(counts[1]) + 0.5) * CELL_M
        centres = np.stack([np.tile(x, counts[1]), np.repeat(y, counts[0])], axis=1)
        clear: BoolArray = (self._boxes.signed(centres).min(axis=1) >= DISC_M).reshape(counts[1], counts[0])
        labels, _ = ndimage.label(clear)
        self._labels = labels
        self._own = self._near(layout.start.x, layout.start.y)

    def reached(self, pose: Pose2) -> bool:
        """Whether the disc fits there and gets there."""
        inside = self._boxes.distances(pose.x, pose.y).min() >= DISC_M
        return bool(inside) and bool(self._own & self._near(pose.x, pose.y))

    def _near(self, x: float, y: float) -> Set[int]:
        """Labels of the free ground within a cell of a point."""
        column, row = int((x - self._lower[0]) / CELL_M), int((y - self._lower[1]) / CELL_M)
        window = self._labels[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        return {int(label) for label in window.ravel() if label}


def _best(layout: Layout, number: int, places: _Places) -> Sight:
    box = layout.boxes[number - 1]
    best = Sight(number, 0.0, None)
    for pose in _candidates(box):
        if places.reached(pose):
            share = visible_share(layout, number, pose)
            best = Sight(number, share, pose) if share > best.share else best
    return best


def _candidates(box: Block) -> List[Pose2]:
    """Poses around a face that look at its middle."""
    middle = box.pose.compose(Pose2(0.5 * box.size[0], 0.0))
    poses = []
    for distance in DISTANCES_M:
        for angle in ANGLES_DEG:
            bearing = box.pose.yaw_rad + math.radians(angle)
            x, y = middle.x + distance * math.cos(bearing), middle.y + distance * math.sin(bearing)
            poses.append(Pose2(x, y, wrap_angle(bearing + math.pi)))
    return poses
