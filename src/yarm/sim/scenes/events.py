"""Scripted events of a scene: when something happens and what; each fires once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Callable, List, Mapping, Optional, Tuple

from yarm.sim.yaml_fields import Faults, Fields

if TYPE_CHECKING:
    from yarm.sim.scene import ThingSpec

COMMANDER_STATES = ("IDLE", "STARTED", "CALIBRATION", "MENU", "BOUNDED", "BOUNDLESS", "CLEANUP")
PUSH_SPEED_MPS = 0.2


@dataclass(frozen=True)
class Trigger:
    """When an event fires; exactly one of the four is used.

    Attributes:
        time_s: at this simulated time.
        state: when the Commander enters this state.
        raster: when this share of a manipulator's raster is done, 0 to 1.
        robot: when this robot's end effector comes nearer than ``below_m`` to ``near``, horizontally.
        near: name of the object it comes near to.
        below_m: that distance, metres.
        after_s: delay from then on, s.
    """

    time_s: Optional[float] = None
    state: str = ""
    raster: Optional[float] = None
    robot: str = ""
    near: str = ""
    below_m: float = 0.0
    after_s: float = 0.0


@dataclass(frozen=True)
class Event:
    """One thing that happens; exactly one of spawn, delete, push, camera is used.

    Attributes:
        name: for messages.
        when: its trigger.
        spawn: object to put into the cell.
        delete: name of an object to take away.
        push: name of a debris to push along (``dx_m``, ``dy_m``) at PUSH_SPEED_MPS.
        dx_m: along world x, metres.
        dy_m: along world y, metres.
        camera: number of the overhead camera to switch, 1 to 4; 0 for none.
        camera_on: switch it on or off.
    """

    name: str
    when: Trigger
    spawn: Optional[ThingSpec] = None
    delete: str = ""
    push: str = ""
    dx_m: float = 0.0
    dy_m: float = 0.0
    camera: int = 0
    camera_on: bool = True

    def names(self) -> Tuple[str, ...]:
        """Names of the objects it speaks of, which must exist."""
        return tuple(name for name in (self.when.robot, self.when.near, self.delete, self.push) if name)


@dataclass(frozen=True)
class Situation:
    """What the triggers look at.

    Attributes:
        time_s: simulated time.
        commander_state: name of the Commander's state; empty while unknown.
        raster: share of the raster done; 0 while unknown.
        positions: x, y of each object's seed, metres, world.
    """

    time_s: float
    commander_state: str = ""
    raster: float = 0.0
    positions: Mapping[str, Tuple[float, float]] = None  # type: ignore[assignment]


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
        return now.raster >= when.raster
    positions = now.positions or {}
    if when.robot not in positions or when.near not in positions:
        return False
    (ax, ay), (bx, by) = positions[when.robot], positions[when.near]
    return (ax - bx) ** 2 + (ay - by) ** 2 < when.below_m**2


def read_events(top: Fields, faults: Faults, spawn_reader: Callable[[Fields], ThingSpec]) -> Tuple[Event, ...]:
    """The ``events`` list of a scene file; ``spawn_reader`` reads an object to spawn."""
    return tuple(_event(fields, i, faults, spawn_reader) for i, fields in enumerate(top.entries("events")))


def _event(fields: Fields, i: int, faults: Faults, spawn_reader: Callable[[Fields], ThingSpec]) -> Event:
    name = fields.text("name", f"event {i + 1}")
    when = _trigger(fields.section("when"))
    action = fields.section("do")
    fields.finish()
    kinds = [kind for kind in ("spawn", "delete", "push", "camera") if action.has(kind)]
    if len(kinds) != 1:
        faults.add(action.key, sorted(action.raw), "exactly one of spawn, delete, push, camera")
        return Event(name, when)
    event = _action(name, when, kinds[0], action, spawn_reader)
    action.finish()
    return event


def _action(name: str, when: Trigger, kind: str, action: Fields, spawn_reader: Callable[[Fields], ThingSpec]) -> Event:
    if kind == "spawn":
        return Event(name, when, spawn=spawn_reader(action.section("spawn")))
    if kind == "delete":
        return Event(name, when, delete=action.text("delete"))
    if kind == "camera":
        return Event(name, when, camera=action.whole("camera", 1, 4, 1), camera_on=action.flag("enabled"))
    return Event(
        name,
        when,
        push=action.text("push"),
        dx_m=action.number("dx", -1.0, 1.0, "m", 0.0),
        dy_m=action.number("dy", -1.0, 1.0, "m", 0.0),
    )


def _trigger(fields: Fields) -> Trigger:
    kinds = [kind for kind in ("time", "state", "raster", "robot") if fields.has(kind)]
    after_s = fields.number("after", 0.0, 3600.0, "s", 0.0)
    trigger = Trigger(after_s=after_s)
    if len(kinds) != 1:
        fields.faults.add(fields.key, sorted(fields.raw), "exactly one of time, state, raster, robot")
        return trigger
    if kinds[0] == "time":
        trigger = Trigger(time_s=fields.number("time", 0.0, 86400.0, "s"), after_s=after_s)
    elif kinds[0] == "state":
        trigger = Trigger(state=fields.text("state", choices=COMMANDER_STATES), after_s=after_s)
    elif kinds[0] == "raster":
        trigger = Trigger(raster=fields.number("raster", 0.0, 1.0, ""), after_s=after_s)
    else:
        trigger = Trigger(
            robot=fields.text("robot"),
            near=fields.text("near"),
            below_m=fields.number("below", 0.01, 10.0, "m"),
            after_s=after_s,
        )
    fields.finish()
    return trigger
