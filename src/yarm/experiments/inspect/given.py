"""What a round is given of a layout: maps of the empty room, where the boxes stand, where about it starts; as files."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from yarm.experiments.inspect.eyes import boxes_of
from yarm.geometry import Pose2
from yarm.navigation.bodies import with_bodies
from yarm.navigation.grid_map import UNKNOWN, GridMap
from yarm.navigation.map_file import write_map
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import BlockKind
from yarm.sim.scenes.layout import Layout

CELL_M = 0.05
FINE_CELL_M = 0.025
"""Cells of the map that localisation is given: a face in a map stands up to half a cell beside its place."""
MARGIN_CELLS = 4.5
"""A map reaches so far beyond the room: the walls' faces lie on middles of cells, not on the border between two."""
BY_HAND = Pose2(0.10, -0.10, 0.10)
"""A pose that is given by hand is so far off."""


@dataclass(frozen=True)
class Given:
    """Files of a layout: descriptions of the maps, the boxes, and the start as a hand gives it to ``amcl``."""

    map: Path
    fine_map: Path
    boxes: Path
    start: Path


def room_map(layout: Layout, cell_m: float = CELL_M) -> GridMap:
    """The room without boxes: walls occupied, free inside, not known outside; its frame is the world's."""
    lower, upper = np.array(layout.arena.lower), np.array(layout.arena.upper)
    columns, rows = (math.ceil(float(v) / cell_m - 1e-6 + 2 * MARGIN_CELLS) for v in upper - lower)
    corner = lower - MARGIN_CELLS * cell_m
    cells = np.full((rows, columns), UNKNOWN, np.int8)
    grid = GridMap(cells, cell_m, Pose2(float(corner[0]), float(corner[1])))
    every = np.indices(cells.shape).reshape(2, -1).T
    middles = grid.centres_of(every)
    inside = every[np.all((middles > lower) & (middles < upper), axis=1)]
    cells[inside[:, 0], inside[:, 1]] = 0
    walls = [block for block in layout.arena.blocks if block.kind != BlockKind.BOX]
    return with_bodies(grid, list(FlatBoxes(walls).corners()))


def write_given(layout: Layout, folder: Path) -> Given:
    """Write the files into a folder, which is made when missing.

    Raises:
        MapFileError: the map cannot be written.
        OSError: the folder or the boxes cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    lines = ["# Boxes in the map: centre on the floor, where the tag looks; width, depth, height.", "boxes:"]
    for box in boxes_of(layout):
        place = f"x: {box.pose.x!r}, y: {box.pose.y!r}, phi: {box.pose.yaw_rad!r}"
        size = [box.size.width, box.size.depth, box.size.height]
        lines.append(f"  - {{number: {box.number}, {place}, size: {size}}}")
    boxes = folder / "boxes.yaml"
    boxes.write_text("\n".join(lines) + "\n")
    start = folder / "start.yaml"
    rough = layout.arena.start.compose(BY_HAND)
    values = {"given": "true", "x": repr(rough.x), "y": repr(rough.y), "a": repr(rough.yaw_rad)}
    lines = [
        "# About where the robot starts, as a hand gives it.",
        *(f"initial_pose_{k}: {v}" for k, v in values.items()),
    ]
    start.write_text("\n".join(lines) + "\n")
    coarse, fine = (
        write_map(room_map(layout, cell_m), folder / name)
        for cell_m, name in ((CELL_M, "map"), (FINE_CELL_M, "fine_map"))
    )
    return Given(coarse.description, fine.description, boxes, start)
