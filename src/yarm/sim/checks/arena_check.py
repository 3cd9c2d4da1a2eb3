"""What of an arena can be reached and mapped, and whether it keeps the rules of an arena."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import List, Optional, Tuple

import numpy as np
from scipy.ndimage import binary_dilation, distance_transform_edt, label

from yarm.geometry import BoolArray, FloatArray, IntArray
from yarm.robots.turtlebot import CAMERA_Z_M, RADIUS_M, SCAN_RANGE_MIN_M, SCAN_VALID_M
from yarm.sim.checks.finding import Finding
from yarm.sim.kinematic.flat_boxes import FlatBoxes
from yarm.sim.scenes.arena import Arena, BlockKind

DISC_M = 0.18
"""Radius of the disc that must fit: the robot with a little room."""
EDGE_M = 0.05
"""Edge of the cells that count, as in the robot's map."""
MARGIN_M = 0.5
"""Cells reach so far outside the arena."""
LOOK_CELLS = 3
"""Views are taken from every n-th reachable cell along both axes."""
RAYS = 720
FACE_DEEP_M = 0.005
"""A face's cell is the one so far behind where a ray meets it: a face may lie between two cells."""
START_GAP_M = 0.15
"""A start in contact with something is joined to free cells within this."""
MOST_LOST_M2 = 0.5
PASSAGE_M = 0.70
PASSAGE_SLACK_M = 0.02
"""Cells are discs' centres: a passage counts as wide enough when it is at most this much too narrow."""
LOW_FROM_M, LOW_TO_M = 0.05, 0.20
MOST_LOW = 6


@dataclass(frozen=True, eq=False)
class ArenaCells:
    """An arena in cells of EDGE_M; arrays are (rows, columns), row 0 at the least y.

    Attributes:
        origin: x, y of the outer corner of cell (0, 0), metres.
        gap_m: distance of each cell's centre to the nearest thing of any height; negative inside.
        tall_gap_m: the same to what the scan sees.
        reachable: places of the disc's centre, connected to the start.
        inside: cells within the outer walls.
    """

    origin: Tuple[float, float]
    gap_m: FloatArray
    tall_gap_m: FloatArray
    reachable: BoolArray
    inside: BoolArray

    def centres(self) -> FloatArray:
        """(rows * columns, 2) centres of the cells, metres, row by row."""
        rows, columns = self.gap_m.shape
        return _centres(self.origin, (rows, columns))


@dataclass(frozen=True, eq=False)
class Mappable:
    """What can be mapped: what is seen within 5 m from where the disc can be.

    Attributes:
        cells: of the arena.
        free: (rows, columns) wholly free cells that are seen.
        faces: (rows, columns) cells of walls and blocks' faces that are seen; no cell is in both.
    """

    cells: ArenaCells
    free: BoolArray
    faces: BoolArray

    @property
    def area_m2(self) -> float:
        """Of all mappable cells."""
        return float(self.free.sum() + self.faces.sum()) * EDGE_M**2


def arena_cells(arena: Arena) -> ArenaCells:
    """An arena in cells, and which of them the disc reaches."""
    first = [math.floor((value - MARGIN_M) / EDGE_M + 1e-9) for value in arena.lower]
    last = [math.ceil((value + MARGIN_M) / EDGE_M - 1e-9) for value in arena.upper]
    shape = (last[1] - first[1], last[0] - first[0])
    origin = (first[0] * EDGE_M, first[1] * EDGE_M)
    boxes = FlatBoxes(arena.blocks)
    centres = _centres(origin, shape)
    gaps = boxes.signed(centres)
    tall = boxes.heights >= CAMERA_Z_M
    gap, tall_gap = gaps.min(axis=1, initial=math.inf), gaps[:, tall].min(axis=1, initial=math.inf)
    inside = np.all((centres > np.array(arena.lower)) & (centres < np.array(arena.upper)), axis=1)
    clear = ((gap >= DISC_M) & inside).reshape(shape)
    reachable = _joined(clear, centres, (arena.start.x, arena.start.y))
    return ArenaCells(origin, gap.reshape(shape), tall_gap.reshape(shape), reachable, inside.reshape(shape))


def _centres(origin: Tuple[float, float], shape: Tuple[int, int]) -> FloatArray:
    rows, columns = shape
    x = origin[0] + (np.arange(columns) + 0.5) * EDGE_M
    y = origin[1] + (np.arange(rows) + 0.5) * EDGE_M
    centres: FloatArray = np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=1)
    return centres


def mappable(arena: Arena, cells: Optional[ArenaCells] = None) -> Mappable:
    """What can be mapped; about a second."""
    cells = arena_cells(arena) if cells is None else cells
    boxes = FlatBoxes(arena.blocks)
    tall = boxes.subset(np.flatnonzero(boxes.heights >= CAMERA_Z_M))
    half_diagonal = EDGE_M / math.sqrt(2.0)
    view = _View(cells, tall, cells.gap_m > half_diagonal)
    rows, columns = np.nonzero(cells.reachable)
    chosen = (rows % LOOK_CELLS == 0) & (columns % LOOK_CELLS == 0)
    centres = cells.centres().reshape(*cells.gap_m.shape, 2)
    for row, column in zip(rows[chosen], columns[chosen]):
        view.look(float(centres[row, column, 0]), float(centres[row, column, 1]))
    return Mappable(cells, view.free(), view.faces & ~view.free())


class _View:
    """Gathers what is seen from many places."""

    def __init__(self, cells: ArenaCells, tall: FlatBoxes, candidates: BoolArray) -> None:
        self._cells = cells
        self._tall = tall
        self._candidates: IntArray = np.flatnonzero(candidates)
        self._unseen = self._candidates
        self._centres = cells.centres()
        self._bearings: FloatArray = np.linspace(-math.pi, math.pi, RAYS, endpoint=False)
        self.faces: BoolArray = np.zeros(candidates.shape, dtype=bool)

    def free(self) -> BoolArray:
        """Candidates that have been seen."""
        seen: BoolArray = np.zeros(self.faces.size, dtype=bool)
        seen[self._candidates] = True
        seen[self._unseen] = False
        return seen.reshape(self.faces.shape)

    def look(self, x: float, y: float) -> None:
        """All around from a place."""
        ranges = self._tall.cast(x, y, self._bearings).ranges
        met = (ranges >= SCAN_RANGE_MIN_M) & (ranges <= SCAN_VALID_M)
        deep, bearings = ranges[met] + FACE_DEEP_M, self._bearings[met]
        ends = np.stack([y + deep * np.sin(bearings), x + deep * np.cos(bearings)])
        row, column = np.floor((ends - np.array(self._cells.origin[::-1])[:, None]) / EDGE_M).astype(np.int64)
        inside = (row >= 0) & (column >= 0) & (row < self.faces.shape[0]) & (column < self.faces.shape[1])
        self.faces[row[inside], column[inside]] = True
        away = self._centres[self._unseen] - (x, y)
        distance = np.hypot(away[:, 0], away[:, 1])
        ray = (np.arctan2(away[:, 1], away[:, 0]) + math.pi) * (RAYS / (2.0 * math.pi))
        left = np.floor(ray).astype(np.int64) % RAYS
        reach = np.minimum(np.minimum(ranges[left], ranges[(left + 1) % RAYS]), SCAN_VALID_M)
        self._unseen = self._unseen[distance >= reach]


def _joined(clear: BoolArray, centres: FloatArray, start: Tuple[float, float]) -> BoolArray:
    """Clear cells connected to the one nearest to the start; none when that is too far."""
    distance = np.hypot(centres[:, 0] - start[0], centres[:, 1] - start[1])
    distance[~clear.ravel()] = math.inf
    nearest = int(np.argmin(distance))
    if not distance[nearest] <= START_GAP_M:
        return np.zeros_like(clear)
    parts, _ = label(clear)
    joined: BoolArray = parts == parts.ravel()[nearest]
    return joined


def narrow_passages(cells: ArenaCells) -> List[Tuple[float, float]]:
    """Places, metres, of passages that the disc of DISC_M takes and one of half PASSAGE_M does not.

    What is reachable but no part of the wider disc's body is a remnant: a corner, which borders what the wider disc
    covers along one stretch, or a passage, which borders it along two or more (or joins nothing wide at all).
    """
    wide_m = 0.5 * PASSAGE_M - PASSAGE_SLACK_M
    wide = cells.reachable & (cells.gap_m >= wide_m)
    to_wide = distance_transform_edt(~wide, sampling=EDGE_M) if wide.any() else np.full(wide.shape, math.inf)
    covered = to_wide <= wide_m - DISC_M + 0.5 * EDGE_M
    remnants, count = label(cells.reachable & ~covered, structure=np.ones((3, 3)))
    centres = cells.centres().reshape(*wide.shape, 2)
    found = []
    for number in range(1, count + 1):
        remnant = remnants == number
        border = binary_dilation(remnant, structure=np.ones((3, 3))) & covered & cells.reachable
        _, stretches = label(border, structure=np.ones((3, 3)))
        if stretches > 1:
            found.append((float(centres[remnant][:, 0].mean()), float(centres[remnant][:, 1].mean())))
    return found


def is_sound(cells: ArenaCells) -> bool:
    """Whether the disc reaches all that it has room for, within MOST_LOST_M2, by passages wide enough."""
    room = cells.inside & (cells.gap_m >= DISC_M)
    lost = float((room & ~cells.reachable).sum()) * EDGE_M**2
    return lost <= MOST_LOST_M2 and not narrow_passages(cells)


def check_arena(arena: Arena) -> List[Finding]:
    """Every check of an arena."""
    cells = arena_cells(arena)
    boxes = FlatBoxes(arena.blocks)
    gap = float(boxes.distances(arena.start.x, arena.start.y).min(initial=math.inf))
    found = [_start(gap)]
    if not cells.reachable.any():
        return [*found, Finding(False, f"enclosed: a disc of {DISC_M} m cannot leave the start")]
    seen = mappable(arena, cells)
    reached = float(cells.reachable.sum()) * EDGE_M**2
    found.append(Finding(True, f"a disc of {DISC_M} m reaches {reached:.1f} m2; {seen.area_m2:.1f} m2 can be mapped"))
    never = float((cells.inside & (cells.gap_m > EDGE_M) & ~seen.free).sum()) * EDGE_M**2
    text = f"{never:.2f} m2 of the floor can never be seen (at most {MOST_LOST_M2} m2)"
    found.append(Finding(never <= MOST_LOST_M2, text))
    for x, y in narrow_passages(cells):
        found.append(Finding(False, f"a passage at ({x:.2f}, {y:.2f}) is narrower than {PASSAGE_M} m"))
    return found + _low(arena)


def _start(gap: float) -> Finding:
    if gap < RADIUS_M:
        return Finding(False, f"the robot starts inside something: {gap:.4f} m to it, its radius is {RADIUS_M} m")
    contact = "in contact" if gap < RADIUS_M + 0.001 else f"{gap - RADIUS_M:.2f} m from the nearest thing"
    return Finding(True, f"starts {contact}")


def _low(arena: Arena) -> List[Finding]:
    low = [block for block in arena.blocks if block.kind == BlockKind.LOW]
    found = [Finding(len(low) <= MOST_LOW, f"{len(low)} low obstacles (at most {MOST_LOW})")]
    for block in low:
        if not LOW_FROM_M <= block.size[2] <= LOW_TO_M:
            found.append(
                Finding(False, f"{block.name} is {block.size[2]:.2f} m tall, not {LOW_FROM_M} to {LOW_TO_M} m")
            )
    return found
