"""Cells nobody thought of: fleet, goals, obstacles and troubles at random, the same for the same kind and seed.

Everything starts clear of everything else: robots stand three cells apart from what is on the floor and two inside the
volume, debris lies where nothing else does. Whether each goal can be reached is not promised: ``unreachable_goals`` of
``yarm.sim.checks.cell_check`` says it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Callable, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from yarm.geometry import BoolArray, GridSpec, Pose2
from yarm.geometry.kinds import ObjectKind
from yarm.robots.ankurbot import ARM_REACH_M, BODY_RADIUS_M, EE_HEIGHT_M
from yarm.robots.hc10 import NAME
from yarm.sim.scenes.events import Event, Trigger
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import HALF_CELL_M, ArmSpec, RobotSpec, ThingSpec
from yarm.sim.scenes.variation import BORDER_CELLS, fixture_columns, start_cells, wider

STREAM = 5
"""Keeps these random numbers apart from others of the same seed."""
ATTEMPTS = 200
"""Cells that are drawn until one has room for all that was drawn for it."""
TRIES = 300
MOST_ROBOTS, MOST_DEBRIS, MOST_OBSTACLES, MOST_TARGETS = 5, 8, 4, 2
FALL_S = 20.0
"""Debris falls within so long of the mission's start, s."""
APART_M = 0.30
CLOSE_M = (0.17, 0.21)
"""How far apart two debris are that are close together, metres; a piece is 0.15 m long."""
SLIP_M = (0.03, 0.12)
SLIP_BELOW_M = 0.9
"""Debris slips when an end effector comes nearer than this, metres."""
BOX_M = (0.15, 0.5)
BOX_HEIGHT_M = (0.2, 1.1)
WALL_M = (0.5, 0.5, 1.2)
"""A box that a target is inside of, which nobody can reach."""
PERSON = "person"
"""Name of whoever walks across a cell and stops for nothing."""
PERSON_M = (0.4, 0.4, 1.2)
PERSON_MPS = (0.5, 1.0)
DROP_M = 0.005
"""Debris falls from so high, metres."""
HALF_DEBRIS_M = 0.02
PART_TOP_M, TABLE_TOP_M = 0.73, 0.70
TUCKED_SHARE = 0.25
EDGE_X_M, EDGE_Y_M = (0.30, 0.37), (0.44, 0.51)
"""The strips of the table's top along its far side and its ends, metres, distance from its middle."""
PART_X_M, PART_Y_M = (-0.42, -0.08), (-0.27, 0.27)

Point = Tuple[float, float]
Interval = Tuple[float, float]


class NoRoomError(ValueError):
    """No place is found for something in this attempt."""


@dataclass
class Draft:
    """A cell while it is drawn.

    Attributes:
        rng: random numbers.
        robots: placed so far.
        things: that are there from the start.
        events: in order.
        fixed: columns (gx, gy) with fixtures and obstacles in them.
        taken: those, and the columns of robots and of what lies on the floor.
        goals: where goals are, metres, world.
    """

    rng: np.random.Generator
    robots: List[RobotSpec]
    things: List[ThingSpec]
    events: List[Event]
    fixed: BoolArray
    taken: BoolArray
    goals: Dict[str, Point]

    def within(self, low_high: Interval) -> float:
        """A number at random."""
        return float(self.rng.uniform(*low_high))

    def count(self, least: int, most: int) -> int:
        """A whole number at random, both ends included."""
        return int(self.rng.integers(least, most + 1))

    def angle(self) -> float:
        """A heading at random, rad."""
        return self.within((-math.pi, math.pi))

    def first(self, drawn: Callable[[], Optional[Point]], what: str) -> Point:
        """The first of many draws that is some.

        Raises:
            NoRoomError: none is.
        """
        for _ in range(TRIES):
            found = drawn()
            if found is not None:
                return found
        raise NoRoomError(what)

    def apart(self, place: Point, least_m: float = APART_M) -> bool:
        """Whether a place is so far from every goal."""
        return all(math.dist(place, other) >= least_m for other in self.goals.values())


SPEC = GridSpec()


def random_cell(kind: str, seed: int) -> Scene:
    """A cell with 1 to 5 robots, up to 8 debris, 4 obstacles and 2 targets, and the trouble of its kind.

    Args:
        kind: one of KINDS.
        seed: equal kinds and seeds give equal cells.

    Raises:
        ValueError: no such kind.
    """
    if kind not in KINDS:
        raise ValueError(f"kind {kind!r}: expected one of {', '.join(KINDS)}")
    for attempt in range(ATTEMPTS):
        try:
            return _drawn(kind, seed, np.random.default_rng([seed, STREAM, KINDS.index(kind), attempt]))
        except NoRoomError:
            continue
    raise ValueError(f"random_cell({kind!r}, {seed}): no cell with room for everything in {ATTEMPTS} attempts")


def _drawn(kind: str, seed: int, rng: np.random.Generator) -> Scene:
    arm = ArmSpec(NAME, "hc10", tucked=bool(rng.uniform() < TUCKED_SHARE))
    empty = Scene(f"random_{kind}", seed, f"a random cell: {kind}", arms=(arm,))
    fixed = np.array(fixture_columns(empty.placed_fixtures, SPEC))
    draft = Draft(rng, [], [], [], fixed, fixed.copy(), {})
    troubles = _troubles(kind, draft)
    for i in range(draft.count(0, MOST_OBSTACLES)):
        _place_obstacle(draft, f"obstacle_{i + 1}", registered=True)
    least = 2 if "crowded" in troubles else 1
    for i in range(draft.count(least, MOST_ROBOTS)):
        _place_robot(draft, f"ankurbot_{i + 1}")
    targets = draft.count(0, MOST_TARGETS)
    for i in range(targets):
        _place_target(draft, f"target_{i + 1}")
    for i in range(draft.count(0 if targets else 1, MOST_DEBRIS)):
        _place_debris(draft, f"debris_{i + 1}")
    for trouble in troubles:
        TROUBLES[trouble](draft)
    return replace(empty, robots=tuple(draft.robots), things=tuple(draft.things), events=tuple(draft.events))


def _troubles(kind: str, draft: Draft) -> Sequence[str]:
    if kind == "plain":
        return ()
    if kind != "mixed":
        return (kind,)
    names = sorted(TROUBLES)
    chosen = draft.rng.choice(len(names), size=draft.count(2, 3), replace=False)
    return [names[i] for i in sorted(chosen)]


def _later(draft: Draft) -> Trigger:
    return Trigger(state="BOUNDLESS", after_s=draft.within((0.0, FALL_S)))


def _box_columns(place: Point, size: Sequence[float], yaw_rad: float) -> BoolArray:
    """Columns (gx, gy) that the rectangle along the axes around a box covers."""
    c, s = abs(math.cos(yaw_rad)), abs(math.sin(yaw_rad))
    half = (0.5 * (c * size[0] + s * size[1]), 0.5 * (s * size[0] + c * size[1]))
    return _rectangle((place[0] - half[0], place[0] + half[0]), (place[1] - half[1], place[1] + half[1]))


def _rectangle(x: Interval, y: Interval) -> BoolArray:
    columns = np.zeros(SPEC.shape[:2], dtype=bool)
    low, high = SPEC.column_of((x[0], y[0])), SPEC.column_of((x[1], y[1]))
    columns[max(0, low[0]) : max(0, high[0] + 1), max(0, low[1]) : max(0, high[1] + 1)] = True
    return columns


def _anywhere(draft: Draft, border_m: float) -> Point:
    edge = HALF_CELL_M - border_m
    return draft.within((-edge, edge)), draft.within((-edge, edge))


def _place_obstacle(draft: Draft, name: str, registered: bool) -> None:
    """A box three cells clear of everything on the floor."""
    size = (draft.within(BOX_M), draft.within(BOX_M), draft.within(BOX_HEIGHT_M))
    yaw_rad = draft.angle()
    kept_clear = wider(draft.taken)

    def spot() -> Optional[Point]:
        place = _anywhere(draft, 0.4)
        clear = not (kept_clear & _box_columns(place, size, yaw_rad)).any()
        return place if clear and draft.apart(place, 0.5) else None

    x, y = draft.first(spot, name)
    _add_box(draft, ThingSpec(name, ObjectKind.OBSTACLE, x, y, 0.5 * size[2], yaw_rad, size, registered))


def _add_box(draft: Draft, box: ThingSpec) -> None:
    columns = _box_columns((box.x, box.y), box.size, box.yaw_rad)
    draft.things.append(box)
    draft.fixed |= columns
    draft.taken |= columns


def _place_robot(draft: Draft, name: str) -> None:
    kept_clear = wider(draft.taken)
    robot = RobotSpec(name, "ankurbot", 0.0, 0.0, 0.0)

    def spot() -> Optional[Point]:
        nonlocal robot
        place = _anywhere(draft, BODY_RADIUS_M + 0.1)
        robot = replace(robot, x=place[0], y=place[1], heading_rad=draft.angle())
        return place if _stands_clear(robot, kept_clear) else None

    draft.first(spot, name)
    draft.robots.append(robot)
    draft.taken[tuple(start_cells(robot, SPEC)[:, :2].T)] = True


def _stands_clear(robot: RobotSpec, kept_clear: BoolArray) -> bool:
    """Whether a robot is inside the volume and off these columns (gx, gy); its end and middle are looked at first."""
    body = Pose2(robot.x, robot.y, robot.heading_rad)
    for ahead_m in (ARM_REACH_M, 0.0, 0.5 * ARM_REACH_M):
        point = body.compose(Pose2(ahead_m, 0.0))
        if max(abs(point.x), abs(point.y)) > HALF_CELL_M - 0.2 or kept_clear[SPEC.column_of((point.x, point.y))]:
            return False
    columns = start_cells(robot, SPEC)[:, :2]
    inside = np.all(columns >= BORDER_CELLS) and np.all(columns < np.subtract(kept_clear.shape, BORDER_CELLS))
    return bool(inside) and not kept_clear[tuple(columns.T)].any()


def _place_target(draft: Draft, name: str) -> None:
    kept_clear = wider(draft.fixed)

    def spot() -> Optional[Point]:
        place = _anywhere(draft, 0.4)
        return place if draft.apart(place) and not kept_clear[SPEC.column_of(place)] else None

    _add_target(draft, name, draft.first(spot, name))


def _add_target(draft: Draft, name: str, place: Point) -> None:
    draft.goals[name] = place
    draft.things.append(ThingSpec(name, ObjectKind.TARGET, place[0], place[1], EE_HEIGHT_M))


def _on_part(draft: Draft) -> Tuple[Point, float]:
    return (draft.within(PART_X_M), draft.within(PART_Y_M)), PART_TOP_M


def _on_edge(draft: Draft) -> Tuple[Point, float]:
    """Near the table's far side or one of its ends, beside the part."""
    if draft.rng.uniform() < 0.5:
        return (draft.within(EDGE_X_M), draft.within((-EDGE_Y_M[1], EDGE_Y_M[1]))), TABLE_TOP_M
    side = 1.0 if draft.rng.uniform() < 0.5 else -1.0
    return (draft.within((-EDGE_X_M[1], EDGE_X_M[1])), side * draft.within(EDGE_Y_M)), TABLE_TOP_M


def _on_floor(draft: Draft) -> Tuple[Point, float]:
    return _anywhere(draft, 0.4), 0.0


def _place_debris(draft: Draft, name: str) -> None:
    """On the part, the table's edge or the floor; there from the start or falling."""
    where = (_on_part, _on_edge, _on_floor)[draft.count(0, 2)]
    top = 0.0
    kept_clear = wider(draft.taken)

    def spot() -> Optional[Point]:
        nonlocal top
        place, top = where(draft)
        lies = where is not _on_floor or not kept_clear[SPEC.column_of(place)]
        return place if lies and draft.apart(place) else None

    _drop(draft, name, draft.first(spot, name), top)


def _drop(draft: Draft, name: str, place: Point, top: float) -> None:
    z = top + HALF_DEBRIS_M + DROP_M
    piece = ThingSpec(name, ObjectKind.DEBRIS, place[0], place[1], z, draft.angle())
    draft.goals[name] = place
    if top == 0.0:
        draft.taken |= _box_columns(place, (0.15, 0.15), 0.0)
    if draft.rng.uniform() < 0.5:
        draft.things.append(piece)
    else:
        draft.events.append(Event(f"{name} falls", _later(draft), spawn=piece))


def _pieces(draft: Draft) -> Mapping[str, ThingSpec]:
    spawned = [event.spawn for event in draft.events if event.spawn is not None]
    return {t.name: t for t in (*draft.things, *spawned) if t.kind == ObjectKind.DEBRIS}


def _slips(draft: Draft) -> None:
    """A piece on the part slips along it when somebody comes near."""
    name = f"debris_{len(_pieces(draft)) + 1}"
    ends: List[Point] = []

    def spot() -> Optional[Point]:
        place, _ = _on_part(draft)
        length, angle = draft.within(SLIP_M), draft.angle()
        end = (place[0] + length * math.cos(angle), place[1] + length * math.sin(angle))
        on = PART_X_M[0] <= end[0] <= PART_X_M[1] and PART_Y_M[0] <= end[1] <= PART_Y_M[1]
        ends[:] = [end]
        return place if on and draft.apart(place) and draft.apart(end) else None

    place = draft.first(spot, name)
    _drop(draft, name, place, PART_TOP_M)
    robots = tuple(robot.name for robot in draft.robots)
    near = Trigger(robots=robots, near=name, below_m=SLIP_BELOW_M)
    dx_m, dy_m = ends[0][0] - place[0], ends[0][1] - place[1]
    draft.events.append(Event(f"{name} slips", near, push=name, dx_m=dx_m, dy_m=dy_m))


def _close(draft: Draft) -> None:
    """Two pieces close together on the part."""
    number = len(_pieces(draft))
    second: List[Point] = []

    def spot() -> Optional[Point]:
        place, _ = _on_part(draft)
        length, angle = draft.within(CLOSE_M), draft.angle()
        beside = (place[0] + length * math.cos(angle), place[1] + length * math.sin(angle))
        on = PART_X_M[0] <= beside[0] <= PART_X_M[1] and PART_Y_M[0] <= beside[1] <= PART_Y_M[1]
        second[:] = [beside]
        return place if on and draft.apart(place) and draft.apart(beside) else None

    place = draft.first(spot, f"debris_{number + 1}")
    _drop(draft, f"debris_{number + 1}", place, PART_TOP_M)
    _drop(draft, f"debris_{number + 2}", second[0], PART_TOP_M)


def _unregistered(draft: Draft) -> None:
    """One or two boxes that nobody is told of."""
    for i in range(draft.count(1, 2)):
        _place_obstacle(draft, f"box_{i + 1}", registered=False)


def _camera(draft: Draft) -> None:
    """A camera fails for a while."""
    number, begin_s = draft.count(1, 4), draft.within((0.0, FALL_S))
    again = Trigger(state="BOUNDLESS", after_s=begin_s + draft.within((3.0, 20.0)))
    fails = Trigger(state="BOUNDLESS", after_s=begin_s)
    draft.events.append(Event(f"camera {number} fails", fails, camera=number, enabled=False))
    draft.events.append(Event(f"camera {number} is back", again, camera=number, enabled=True))


def _unreachable(draft: Draft) -> None:
    """A target inside a box."""
    kept_clear = wider(draft.taken)

    def spot() -> Optional[Point]:
        place = _anywhere(draft, 0.5)
        return place if not (kept_clear & _box_columns(place, WALL_M, 0.0)).any() and draft.apart(place, 0.6) else None

    x, y = draft.first(spot, "the box around a target")
    _add_box(draft, ThingSpec("wall", ObjectKind.OBSTACLE, x, y, 0.5 * WALL_M[2], 0.0, WALL_M))
    _add_target(draft, "target_inside", (x, y))


def _crowded(draft: Draft) -> None:
    """A target where a robot stands, so that it has to give way, for two robots."""
    for i in range(2):
        robot = draft.robots[i]
        place = (robot.x, robot.y)
        if wider(draft.fixed)[SPEC.column_of(place)] or not draft.apart(place):
            raise NoRoomError(f"a target where {robot.name} stands")
        _add_target(draft, f"target_under_{i + 1}", place)


def _walker(draft: Draft) -> None:
    """A person walks across, 1.5 to 3 m along an axis, clear of what stood there at the start, and is gone."""
    kept_clear = wider(draft.taken)
    way: List[Point] = []

    def spot() -> Optional[Point]:
        place, length = _anywhere(draft, 0.3), draft.within((1.5, 3.0)) * (1 - 2 * draft.count(0, 1))
        along_x = draft.count(0, 1) == 1
        end = (place[0] + length, place[1]) if along_x else (place[0], place[1] + length)
        way[:] = [(end[0] - place[0], end[1] - place[1])]
        middle = (0.5 * (place[0] + end[0]), 0.5 * (place[1] + end[1]))
        size = (PERSON_M[0] + abs(way[0][0]), PERSON_M[1] + abs(way[0][1]))
        inside = max(abs(end[0]), abs(end[1])) <= HALF_CELL_M - 0.3
        return place if inside and not (kept_clear & _box_columns(middle, size, 0.0)).any() else None

    x, y = draft.first(spot, "a person's way")
    speed_mps, begin = draft.within(PERSON_MPS), _later(draft)
    gone = replace(begin, after_s=begin.after_s + 1.0 + math.hypot(*way[0]) / speed_mps)
    z = 0.5 * PERSON_M[2] + 0.03
    person = ThingSpec(PERSON, ObjectKind.OBSTACLE, x, y, z, 0.0, PERSON_M, registered=False)
    walks = replace(begin, after_s=begin.after_s + 0.5)
    draft.events.append(Event("a person comes", begin, spawn=person))
    draft.events.append(
        Event("the person walks", walks, move=PERSON, dx_m=way[0][0], dy_m=way[0][1], speed_mps=speed_mps)
    )
    draft.events.append(Event("the person is gone", gone, delete=PERSON))


TROUBLES: Mapping[str, Callable[[Draft], None]] = {
    "slips": _slips,
    "close": _close,
    "unregistered": _unregistered,
    "camera": _camera,
    "unreachable": _unreachable,
    "crowded": _crowded,
    "walker": _walker,
}
"""What makes a cell hard, by name; a mixed one has two or three of them."""
KINDS = ("plain", *TROUBLES, "mixed")
