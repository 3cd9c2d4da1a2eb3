"""What an exploration controller is given and what it gives back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Optional, Protocol, Tuple, Union

from yarm.geometry import FloatArray, Pose2
from yarm.geometry.scans import Odometry, Scan
from yarm.navigation.grid_map import GridMap
from yarm.robots.turtlebot import BumperEvent

LOOP_S = 0.1
"""A controller is asked this often, s."""


@dataclass(frozen=True, eq=False)
class LowView:
    """What one depth image shows below the height of the scan.

    Attributes:
        stamp_s: when the image was taken, s.
        points: (n, 2) obstacles that stand on the floor, in the robot's base frame, metres.
    """

    stamp_s: float
    points: FloatArray


@dataclass(frozen=True, eq=False)
class Observation:
    """All that is known at one pass of the loop. Stamps and ``now_s`` share one clock.

    Attributes:
        now_s: simulated time since the start of the run, s.
        odometry: the newest; None before the first.
        map_from_odom: pose of the odometry frame in the map; None while it is not known.
        scan: the newest; None before the first.
        bumps: changes of the bumper since the last pass, in order.
        map: the newest, with every low obstacle found so far in it; None before the first.
        map_count: how often the map has changed; equal counts mean the same map.
        low: newest low obstacles; None when no new image came.
        jumped: the pose has jumped since the last pass: plans made before are void.
    """

    now_s: float
    odometry: Optional[Odometry] = None
    map_from_odom: Optional[Pose2] = None
    scan: Optional[Scan] = None
    bumps: Tuple[BumperEvent, ...] = ()
    map: Optional[GridMap] = None
    map_count: int = 0
    low: Optional[LowView] = None
    jumped: bool = False

    @property
    def pose(self) -> Optional[Pose2]:
        """The robot's base in the map; None while it is not known."""
        if self.odometry is None or self.map_from_odom is None:
            return None
        return self.map_from_odom.compose(self.odometry.pose)


@dataclass(frozen=True)
class Command:
    """Speeds of the base.

    Attributes:
        v_mps: ahead.
        w_radps: turning, + = left.
    """

    v_mps: float = 0.0
    w_radps: float = 0.0


Detail = Union[str, int, float]


@dataclass(frozen=True)
class Event:
    """A line of events.csv.

    Attributes:
        t_s: time since the start of the run, s.
        kind: one word: behaviour, draw, frontier, goal, abort, bump, done ...
        details: names and values, in order.
    """

    t_s: float
    kind: str
    details: Tuple[Tuple[str, Detail], ...] = ()


@dataclass(frozen=True)
class FrontierView:
    """A frontier as a picture shows it.

    Attributes:
        x: its place in the map, metres.
        y: its place in the map, metres.
        score: greater is better, in the controller's own unit.
        refused: why it is not driven to; empty for a candidate.
    """

    x: float
    y: float
    score: float
    refused: str = ""


@dataclass(frozen=True, eq=False)
class Intent:
    """What a controller is about to do, for pictures and status.

    Attributes:
        goal: pose it drives to, in the map.
        path: (n, 2) its way there, in the map, metres.
        frontiers: what it chose from.
    """

    goal: Optional[Pose2] = None
    path: Optional[FloatArray] = None
    frontiers: Tuple[FrontierView, ...] = ()


@dataclass(frozen=True, eq=False)
class Step:
    """One pass of a controller.

    Attributes:
        command: what to drive now.
        behaviour: name of what it does now.
        events: what happened at this pass.
        done: nothing is left to map; the robot is to stand.
        reason: why it is done, or stands; a sentence, empty when all is well.
        intent: for pictures.
    """

    command: Command = Command()
    behaviour: str = "stand"
    events: Tuple[Event, ...] = ()
    done: bool = False
    reason: str = ""
    intent: Intent = field(default_factory=Intent)


class Controller(Protocol):
    """Decides, pass by pass.

    It owns its state and its random numbers, never waits, and knows no clock but the observation's.
    """

    def step(self, observation: Observation) -> Step:
        """One pass of the loop."""
