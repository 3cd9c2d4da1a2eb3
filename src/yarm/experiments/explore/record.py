"""What one exploration leaves behind: plain rows, free of ROS, each field with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Dict, Mapping, Optional, Tuple

from yarm.exploration.model import Event
from yarm.geometry import Pose2
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import CAMERA_Z_M
from yarm.sim.touches import Touch

IN_WORLD = Pose2(0.0, 0.0)


@dataclass(frozen=True)
class PathRow:
    """One pass of the loop.

    Attributes:
        t_s: time since the start.
        true_x: where the robot really was, world, metres.
        true_y: metres.
        true_yaw: rad.
        x: where it believed to be, world, metres.
        y: metres.
        yaw: rad.
        v: speed it was told, m/s.
        w: turning it was told, rad/s, + = left.
        speed: how fast its base really moved since the last row, m/s.
    """

    t_s: float
    true_x: float
    true_y: float
    true_yaw: float
    x: float
    y: float
    yaw: float
    v: float
    w: float
    speed: float


@dataclass(frozen=True)
class CoverageRow:
    """What was known at a time.

    Attributes:
        t_s: time since the start.
        known_m2: area of the known cells.
        share: of the mappable cells, those known and right; NaN when the truth is not known.
    """

    t_s: float
    known_m2: float
    share: float


@dataclass(frozen=True)
class TouchRow:
    """The robot came into contact with something.

    Attributes:
        t_s: time since the start.
        block: name of what was touched.
        low: it is too low for the scan.
        x: where, world, metres.
        y: metres.
        bearing_rad: of the contact from ahead, + = left.
        speed: of the robot just before, m/s.
    """

    t_s: float
    block: str
    low: bool
    x: float
    y: float
    bearing_rad: float
    speed: float

    @staticmethod
    def of(touch: Touch) -> TouchRow:
        """The row of a touch."""
        low = touch.height_m < CAMERA_Z_M
        return TouchRow(touch.t_s, touch.block, low, touch.x, touch.y, touch.bearing_rad, touch.speed_mps)


class Outcome(Enum):
    """How an exploration ended."""

    MAPPED = "mapped"
    """The controller said that nothing is left."""
    TIME_OVER = "time over"
    BROKEN_OFF = "broken off"
    """Stopped, or failed, before the time limit."""


@dataclass(frozen=True, eq=False)
class ExploreRecord:
    """One run.

    Attributes:
        arena: its name.
        controller: its name.
        seed: of the run.
        mode: kinematic or physics.
        time_limit_s: the robot was to stand from here on.
        max_speed: it was allowed, m/s.
        near_speed: it was allowed near obstacles, m/s.
        near_distance: what is nearer than this ahead counts as near, metres.
        end_s: when the controller was done; the time limit when it never was.
        done: the controller said that nothing is left.
        reason: its last words.
        path: one row a pass.
        coverage: one row a second.
        touches: contacts, in order.
        events: what the controller told, in order.
        first_seen: when each obstacle was first in the map, s, by name; those never seen are missing.
        behaviours: seconds in each.
        step_ms: what passes of the controller took, ms of processor time: all of them, or every so many-th.
        map: at the end; None when there never was one.
        world_from_map: pose of the map frame in the world.
    """

    arena: str
    controller: str
    seed: int
    mode: str
    time_limit_s: float
    max_speed: float
    near_speed: float
    near_distance: float
    end_s: float
    done: bool
    reason: str
    path: Tuple[PathRow, ...]
    coverage: Tuple[CoverageRow, ...]
    touches: Tuple[TouchRow, ...]
    events: Tuple[Event, ...]
    first_seen: Mapping[str, float] = field(default_factory=dict)
    behaviours: Mapping[str, float] = field(default_factory=dict)
    step_ms: Tuple[float, ...] = ()
    map: Optional[GridMap] = None
    world_from_map: Pose2 = IN_WORLD

    @property
    def outcome(self) -> Outcome:
        """How it ended."""
        if self.done:
            return Outcome.MAPPED
        return Outcome.TIME_OVER if self.end_s >= self.time_limit_s else Outcome.BROKEN_OFF


class BehaviourClock:
    """Adds up the seconds of each behaviour."""

    def __init__(self) -> None:
        """Nothing yet."""
        self.seconds: Dict[str, float] = {}

    def spend(self, behaviour: str, dt_s: float) -> None:
        """So long in this one."""
        self.seconds[behaviour] = self.seconds.get(behaviour, 0.0) + dt_s
