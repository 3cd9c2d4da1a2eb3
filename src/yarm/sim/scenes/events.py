"""Scripted events of a scene: when something happens and what; each fires once."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Callable, FrozenSet, List, Mapping, Optional, Tuple

from yarm.sim.scenes.specs import ThingSpec
from yarm.yaml_fields import Faults, Fields

COMMANDER_STATES = ("IDLE", "STARTED", "CALIBRATION", "MENU", "BOUNDED", "BOUNDLESS", "CLEANUP")
PUSH_SPEED_MPS = 0.2


class When(str, Enum):
    """Keys of a scene file that say when an event fires."""

    TIME = "time"
    STATE = "state"
    RASTER = "raster"
    ROBOT = "robot"
    HOLDING = "holding"


class Do(str, Enum):
    """Keys of a scene file that say what happens then."""

    SPAWN = "spawn"
    DELETE = "delete"
    PUSH = "push"
    MOVE = "move"
    CAMERA = "camera"
    VACUUM = "vacuum"


@dataclass(frozen=True)
class Trigger:
    """When an event fires; exactly one of the five is used.

    Attributes:
        time_s: at this simulated time.
        state: when the Commander enters this state.
        raster: when this share of a manipulator's raster is done, 0 to 1.
        arm: which manipulator's; empty for any.
        robots: when the end effector of one of these robots comes nearer than ``below_m`` to ``near``, horizontally.
        near: name of the object it comes near to.
        below_m: that distance, metres.
        holding: when something hangs on the hand of this robot.
        after_s: delay from then on, s.
    """

    time_s: Optional[float] = None
    state: str = ""
    raster: Optional[float] = None
    arm: str = ""
    robots: Tuple[str, ...] = ()
    near: str = ""
    below_m: float = 0.0
    holding: str = ""
    after_s: float = 0.0


@dataclass(frozen=True)
class Event:
    """One thing that happens; exactly one of spawn, delete, push, move, camera, vacuum is used.

    Attributes:
        name: for messages.
        when: its trigger.
        spawn: object to put into the cell.
        delete: name of an object to take away.
        push: name of a debris to push along (``dx_m``, ``dy_m``) at PUSH_SPEED_MPS.
        move: name of an obstacle nobody registered, or of a bin, that goes along (``dx_m``, ``dy_m``), whatever is in
            its way.
        dx_m: along world x, metres.
        dy_m: along world y, metres.
        speed_mps: of a move, m/s.
        camera: number of the overhead camera to switch, 1 to 4; 0 for none.
        vacuum: name of a robot whose hand's vacuum fails, or works again.
        enabled: of a camera or a vacuum: on or off.
    """

    name: str
    when: Trigger
    spawn: Optional[ThingSpec] = None
    delete: str = ""
    push: str = ""
    move: str = ""
    dx_m: float = 0.0
    dy_m: float = 0.0
    speed_mps: float = 1.0
    camera: int = 0
    vacuum: str = ""
    enabled: bool = True

    def names(self) -> Tuple[str, ...]:
        """Names of the objects it speaks of, which must exist."""
        when = (self.when.arm, *self.when.robots, self.when.near, self.when.holding)
        named = (*when, self.delete, self.push, self.move, self.vacuum)
        return tuple(name for name in named if name)


@dataclass(frozen=True)
class Situation:
    """What the triggers look at.

    Attributes:
        time_s: simulated time.
        commander_state: name of the Commander's state; empty while unknown.
        raster: share of its raster that each manipulator has done; none while unknown.
        positions: x, y of each object's seed, metres, world.
        holding: robots on whose hands something hangs.
    """

    time_s: float
    commander_state: str = ""
    raster: Mapping[str, float] = field(default_factory=dict)
    positions: Mapping[str, Tuple[float, float]] = field(default_factory=dict)
    holding: FrozenSet[str] = frozenset()


class Script:
    """The events not fired yet; a plain function of the situations it is shown."""

    def __init__(self, events: Tuple[Event, ...]) -> None:
        """Take over a scene's events."""
        self._due: List[Tuple[float, Event]] = []
        self._waiting: List[Event] = list(events)

    def fired(self, now: Situation) -> Tuple[Event, ...]:
        """Events that happen now, in order of the scene."""
        for event in list(self._waiting):
            if _holds(event.when, now):
                self._waiting.remove(event)
                self._due.append((now.time_s + event.when.after_s, event))
        ready = tuple(event for due_s, event in self._due if due_s <= now.time_s)
        self._due = [(due_s, event) for due_s, event in self._due if due_s > now.time_s]
        return ready

    def again(self, event: Event, time_s: float) -> None:
        """Let an event that could not happen fire once more, at a simulated time."""
        self._due.append((time_s, event))


def _holds(when: Trigger, now: Situation) -> bool:
    if when.time_s is not None:
        return now.time_s >= when.time_s
    if when.state:
        return now.commander_state == when.state
    if when.raster is not None:
        done = [share for arm, share in now.raster.items() if when.arm in ("", arm)]
        return max(done, default=0.0) >= when.raster
    if when.holding:
        return when.holding in now.holding
    to = now.positions.get(when.near)
    places = [now.positions[robot] for robot in when.robots if robot in now.positions]
    return to is not None and any((x - to[0]) ** 2 + (y - to[1]) ** 2 < when.below_m**2 for x, y in places)


def read_events(top: Fields, faults: Faults, spawn_reader: Callable[[Fields], ThingSpec]) -> Tuple[Event, ...]:
    """The ``events`` list of a scene file; ``spawn_reader`` reads an object to spawn."""
    return tuple(_event(fields, i, faults, spawn_reader) for i, fields in enumerate(top.entries("events")))


def _event(fields: Fields, i: int, faults: Faults, spawn_reader: Callable[[Fields], ThingSpec]) -> Event:
    name = fields.text("name", f"event {i + 1}")
    when = _trigger(fields.section("when"))
    action = fields.section("do")
    fields.finish()
    kinds = [kind for kind in Do if action.has(kind.value)]
    if len(kinds) != 1:
        faults.add(action.key, sorted(map(str, action.raw)), f"exactly one of {', '.join(Do)}")
        return Event(name, when)
    event = _action(name, when, kinds[0], action, spawn_reader)
    action.finish()
    return event


def _action(name: str, when: Trigger, kind: Do, action: Fields, spawn_reader: Callable[[Fields], ThingSpec]) -> Event:
    if kind is Do.SPAWN:
        return Event(name, when, spawn=spawn_reader(action.section("spawn")))
    if kind is Do.DELETE:
        return Event(name, when, delete=action.text("delete"))
    if kind is Do.CAMERA:
        return Event(name, when, camera=action.whole("camera", 1, 4, 1), enabled=action.flag("enabled"))
    if kind is Do.VACUUM:
        return Event(name, when, vacuum=action.text("vacuum"), enabled=action.flag("enabled"))
    if kind is Do.MOVE:
        return Event(
            name,
            when,
            move=action.text("move"),
            dx_m=action.number("dx", -10.0, 10.0, "m", 0.0),
            dy_m=action.number("dy", -10.0, 10.0, "m", 0.0),
            speed_mps=action.number("speed", 0.01, 5.0, "m/s", 1.0),
        )
    return Event(
        name,
        when,
        push=action.text("push"),
        dx_m=action.number("dx", -1.0, 1.0, "m", 0.0),
        dy_m=action.number("dy", -1.0, 1.0, "m", 0.0),
    )


def _trigger(fields: Fields) -> Trigger:
    kinds = [kind for kind in When if fields.has(kind.value)]
    after_s = fields.number("after", 0.0, 3600.0, "s", 0.0)
    trigger = Trigger(after_s=after_s)
    if len(kinds) != 1:
        fields.faults.add(fields.key, sorted(map(str, fields.raw)), f"exactly one of {', '.join(When)}")
        return trigger
    if kinds[0] is When.TIME:
        trigger = Trigger(time_s=fields.number("time", 0.0, 86400.0, "s"), after_s=after_s)
    elif kinds[0] is When.STATE:
        trigger = Trigger(state=fields.text("state", choices=COMMANDER_STATES), after_s=after_s)
    elif kinds[0] is When.RASTER:
        arm = fields.text("manipulator") if fields.has("manipulator") else ""
        trigger = Trigger(raster=fields.number("raster", 0.0, 1.0, ""), arm=arm, after_s=after_s)
    elif kinds[0] is When.HOLDING:
        trigger = Trigger(holding=fields.text("holding"), after_s=after_s)
    else:
        trigger = Trigger(
            robots=tuple(fields.text("robot").split()),
            near=fields.text("near"),
            below_m=fields.number("below", 0.01, 10.0, "m"),
            after_s=after_s,
        )
    fields.finish()
    return trigger
