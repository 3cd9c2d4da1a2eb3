"""Other layouts of a scene: where robots start, where debris falls and slips to, and where targets are, from a seed.

Places are drawn within the scene's ranges, and drawn again until every robot stands well inside the mapped volume,
clear of the fixtures and of the others, and goals are apart from each other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple, TypeVar

import numpy as np
from scipy import ndimage

from yarm.geometry import BoolArray, GridSpec, IntArray, Pose2
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.geometry.urdf import expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots.ankurbot import ARM_REACH_M, BODY_RADIUS_M, ankurbot_mask
from yarm.sim.scenes.events import Event
from yarm.sim.scenes.specs import HALF_CELL_M, FixtureSpec, RobotSpec, ThingSpec
from yarm.yaml_fields import Fields, SceneError

STREAM = 3
"""Keeps these random numbers apart from others of the same seed."""
CLEAR_CELLS = 3
"""A robot starts this far from fixtures and other robots, cells."""
BORDER_CELLS = 2
"""And this far from the border of the volume, cells."""
TRIES = 1000
INSIDE = np.array(
    [
        *((x, 0.0) for x in np.arange(0.0, ARM_REACH_M, 0.05)),
        *((0.94 * BODY_RADIUS_M * math.cos(a), 0.94 * BODY_RADIUS_M * math.sin(a)) for a in np.arange(0.0, 6.2, 0.3)),
    ]
)
"""Points (n, 2) within a robot's solids, metres, its base's frame: where these have no room, it has none."""
Found = TypeVar("Found")
Point = Tuple[float, float]
Robots = Tuple[RobotSpec, ...]
Things = Tuple[ThingSpec, ...]
Events = Tuple[Event, ...]


@dataclass(frozen=True)
class Area:
    """A rectangle along the axes: lower and upper end of x and of y, metres, world."""

    x: Tuple[float, float]
    y: Tuple[float, float]

    def holds(self, place: Point) -> bool:
        """Whether a place is in it."""
        return self.x[0] <= place[0] <= self.x[1] and self.y[0] <= place[1] <= self.y[1]


@dataclass(frozen=True)
class Vary:
    """How far the layout of another seed may differ from the scene file's.

    Attributes:
        start_m: robots start within this of their place, metres.
        start_rad: and within this of their heading, rad.
        places: by name of a debris or target, where it may be, and slip to; others stay where the file has them.
        apart_m: least distance between two goals, metres.
        slip_m: least and greatest length of a push, metres, in any direction; () as in the file.
    """

    start_m: float = 0.0
    start_rad: float = 0.0
    places: Mapping[str, Area] = field(default_factory=dict)
    apart_m: float = 0.0
    slip_m: Tuple[float, ...] = ()


def read_vary(fields: Fields) -> Vary:
    """The ``vary`` mapping of a scene file; faults go to its list."""
    places = {}
    for entry in fields.entries("places"):
        places[entry.text("name")] = Area(_range(entry, "x", HALF_CELL_M), _range(entry, "y", HALF_CELL_M))
        entry.finish()
    vary = Vary(
        fields.number("start_m", 0.0, 1.0, "m", 0.0),
        math.radians(fields.number("turn_deg", 0.0, 180.0, "deg", 0.0)),
        places,
        fields.number("apart_m", 0.0, 2.0, "m", 0.0),
        _range(fields, "slip_m", 1.0) if fields.has("slip_m") else (),
    )
    fields.finish()
    return vary


def _range(fields: Fields, name: str, most: float) -> Tuple[float, float]:
    low, high = fields.numbers(name, 2, -most, most)
    if low > high:
        fields.faults.add(fields.path(name), [low, high], "the lesser number first")
    return low, high


def vary_layout(
    vary: Vary, seed: int, fixtures: Sequence[FixtureSpec], robots: Robots, things: Things, events: Events
) -> Tuple[Robots, Things, Events]:
    """The layout of a seed: the same for the same seed, names, order and triggers as in the scene file.

    Raises:
        SceneError: no place is found for something; the scene's ranges leave none.
    """
    rng = np.random.default_rng([seed, STREAM])
    starts = _starts(vary, rng, fixtures, robots)
    places: Dict[str, Point] = {}
    spawned = [event.spawn for event in events if event.spawn is not None]
    moved = {thing.name: _placed(vary, rng, thing, places) for thing in (*things, *spawned)}
    slipped = tuple(_slipped(vary, rng, event, places) for event in events)
    return (
        starts,
        tuple(moved[thing.name] for thing in things),
        tuple(event if event.spawn is None else replace(event, spawn=moved[event.spawn.name]) for event in slipped),
    )


def _starts(vary: Vary, rng: np.random.Generator, fixtures: Sequence[FixtureSpec], robots: Robots) -> Robots:
    spec = GridSpec()
    kept_clear = wider(fixture_columns(tuple(fixtures), spec))
    placed: List[RobotSpec] = []
    for robot in robots:
        placed.append(_first(partial(_start, vary, rng, robot, kept_clear, spec), f"a start for {robot.name}"))
        own = np.zeros(spec.shape[:2], dtype=bool)
        own[tuple(start_cells(placed[-1], spec)[:, :2].T)] = True
        kept_clear = kept_clear | wider(own)
    return tuple(placed)


def _start(
    vary: Vary, rng: np.random.Generator, robot: RobotSpec, kept_clear: BoolArray, spec: GridSpec
) -> Optional[RobotSpec]:
    """A start within the ranges; None when it is outside the volume or near something."""
    length, angle = vary.start_m * math.sqrt(rng.uniform()), rng.uniform(-math.pi, math.pi)
    turn = rng.uniform(-vary.start_rad, vary.start_rad)
    x, y = robot.x + length * math.cos(angle), robot.y + length * math.sin(angle)
    spot = replace(robot, x=x, y=y, heading_rad=robot.heading_rad + turn)
    c, s = math.cos(spot.heading_rad), math.sin(spot.heading_rad)
    some = np.floor((INSIDE @ np.array([[c, s], [-s, c]]) + (x, y) - spec.lower[:2]) / spec.resolution[:2])
    if not _free(some.astype(np.int64), kept_clear):
        return None
    return spot if _free(start_cells(spot, spec)[:, :2], kept_clear) else None


def _free(columns: IntArray, kept_clear: BoolArray) -> bool:
    """Whether columns (n, 2) are well inside the volume and clear."""
    inside = np.all(columns >= BORDER_CELLS) and np.all(columns < np.subtract(kept_clear.shape, BORDER_CELLS))
    return bool(inside) and not kept_clear[tuple(columns.T)].any()


def _placed(vary: Vary, rng: np.random.Generator, thing: ThingSpec, places: Dict[str, Point]) -> ThingSpec:
    """The thing where this seed puts it; where goals are is noted in ``places``."""
    area = vary.places.get(thing.name)
    spot = thing
    if area is not None:
        x, y = _first(partial(_place, rng, area, places, vary.apart_m), f"a place for {thing.name}")
        yaw_rad = float(rng.uniform(-math.pi, math.pi)) if thing.kind == ObjectKind.DEBRIS else thing.yaw_rad
        spot = replace(thing, x=x, y=y, yaw_rad=yaw_rad)
    if thing.kind in GOAL_KINDS:
        places[thing.name] = (spot.x, spot.y)
    return spot


def _place(rng: np.random.Generator, area: Area, others: Mapping[str, Point], apart_m: float) -> Optional[Point]:
    place = (float(rng.uniform(*area.x)), float(rng.uniform(*area.y)))
    return place if _apart(place, others, apart_m) else None


def _slipped(vary: Vary, rng: np.random.Generator, event: Event, places: Dict[str, Point]) -> Event:
    """A push in this seed's direction that ends where the debris may be; ``places`` has where each goal is by then."""
    area = vary.places.get(event.push)
    if area is None or not vary.slip_m:
        return event
    end = _first(partial(_slip, vary, rng, area, event.push, places), f"a push for {event.push}")
    begin, places[event.push] = places[event.push], end
    return replace(event, dx_m=end[0] - begin[0], dy_m=end[1] - begin[1])


def _slip(vary: Vary, rng: np.random.Generator, area: Area, name: str, places: Mapping[str, Point]) -> Optional[Point]:
    length, angle = rng.uniform(vary.slip_m[0], vary.slip_m[1]), rng.uniform(-math.pi, math.pi)
    end = (places[name][0] + length * math.cos(angle), places[name][1] + length * math.sin(angle))
    others = {other: place for other, place in places.items() if other != name}
    return end if area.holds(end) and _apart(end, others, vary.apart_m) else None


def _first(drawn: Callable[[], Optional[Found]], what: str) -> Found:
    for _ in range(TRIES):
        found = drawn()
        if found is not None:
            return found
    raise SceneError(f"vary: {what} is not found in {TRIES} draws: the ranges leave no room")


def _apart(place: Point, others: Mapping[str, Point], least_m: float) -> bool:
    return all(math.dist(place, other) >= least_m for other in others.values())


def start_cells(robot: RobotSpec, spec: GridSpec) -> IntArray:
    """Cells (n, 3) of a robot at its start, also those outside the grid."""
    ee = Pose2(robot.x, robot.y, robot.heading_rad).compose(Pose2(ARM_REACH_M, 0.0))
    column = spec.column_of((ee.x, ee.y))
    centre = spec.column_centre(column)
    return ankurbot_mask(spec, ee.yaw_rad, (ee.x - centre[0], ee.y - centre[1])).at(column)


@lru_cache(maxsize=8)
def fixture_columns(fixtures: Tuple[FixtureSpec, ...], spec: GridSpec) -> BoolArray:
    """Columns (gx, gy) that fixtures stand in; turned ones by the rectangle along the axes that holds them."""
    columns = np.zeros(spec.shape[:2], dtype=bool)
    for fixture in fixtures:
        model = parse_urdf(expand_xacro(resource("urdf", "cell", "cell.urdf.xacro"), part=fixture.type))
        for solid in model.solids:
            pose = fixture.station.pose @ model.rigid_group(solid.link)[1] @ solid.pose
            reach = (np.abs(pose[:3, :3]) @ solid.half_extent)[:2]
            low = spec.column_of(pose[:2, 3] - reach + 1e-6)
            high = spec.column_of(pose[:2, 3] + reach - 1e-6)
            columns[low[0] : high[0] + 1, low[1] : high[1] + 1] = True
    return columns


def wider(columns: BoolArray) -> BoolArray:
    """Columns (gx, gy) and those within CLEAR_CELLS of them, diagonally too."""
    grown: BoolArray = ndimage.binary_dilation(columns, np.ones((3, 3), dtype=bool), iterations=CLEAR_CELLS)
    return grown
