"""What the Commander is told (events) and what it wants done (actions): plain data, carried by the node.

Times are simulated seconds, lengths metres, angles radians, everything in the world frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Mapping, Optional, Tuple, Union

from yarm.control.sander.states import SanderState
from yarm.geometry import CellMap
from yarm.planning.model.types import FleetPlan, PlanRequest
from yarm.robots.shapes import PieceShape, RobotShape
from yarm.safety.people import Tracked


class Outcome(Enum):
    """How a goal ended; every terminal GoalStatus has a name here, and only SUCCEEDED is success."""

    SUCCEEDED = "SUCCEEDED"
    PREEMPTED = "PREEMPTED"
    ABORTED = "ABORTED"
    REJECTED = "REJECTED"
    RECALLED = "RECALLED"
    LOST = "LOST"


@dataclass(frozen=True, eq=False)
class MapUpdate:
    """A new occupancy map, and what is followed that nobody registered."""

    map: CellMap
    people: Tuple[Tracked, ...] = ()


@dataclass(frozen=True, eq=False)
class RegistryUpdate:
    """Who is in the cell, by name, with its kind ("Mobile", "Manipulator", "Debris", ...), and known shapes.

    ``complete`` is false while the frames of a robot that has a shape are not known yet.
    """

    kinds: Mapping[str, str]
    shapes: Mapping[str, RobotShape] = field(default_factory=dict)
    pieces: Mapping[str, PieceShape] = field(default_factory=dict)
    complete: bool = True


@dataclass(frozen=True)
class ServerUpdate:
    """A robot's action server has come (or come back), or gone."""

    robot: str
    connected: bool


@dataclass(frozen=True)
class GoalDone:
    """A goal has ended: its serial number as in SendGoal, how, and what the robot said."""

    robot: str
    serial: int
    outcome: Outcome
    message: str = ""


@dataclass(frozen=True)
class SanderChange:
    """A manipulator's sander is in a state."""

    robot: str
    state: SanderState


@dataclass(frozen=True)
class Hold:
    """The safety monitor holds a robot, or has released it."""

    robot: str
    held: bool
    reason: str = ""


@dataclass(frozen=True)
class Grasp:
    """A robot's hand says whether something hangs on it."""

    robot: str
    grasping: bool


@dataclass(frozen=True)
class DeleteDone:
    """Answer to DeleteObject."""

    name: str
    success: bool
    message: str = ""


@dataclass(frozen=True)
class Tick:
    """Time has passed; sent a few times a second so that silence is noticed."""


@dataclass(frozen=True)
class ClockReset:
    """Simulated time has gone backwards: the simulator was started again."""


Event = Union[
    MapUpdate, RegistryUpdate, ServerUpdate, GoalDone, SanderChange, Hold, Grasp, DeleteDone, Tick, ClockReset
]


@dataclass(frozen=True)
class Target:
    """Pose of an end effector: x, y, metres; heading, rad."""

    x: float
    y: float
    yaw_rad: float


@dataclass(frozen=True)
class KeepOff:
    """Places (x, y), metres, world, and how far the tip of a manipulator must stay away from them, metres."""

    places: Tuple[Tuple[float, float], ...] = ()
    distance_m: float = 0.0


NOTHING = KeepOff()


@dataclass(frozen=True)
class SendGoal:
    """Send a MoveRobot goal; ``target`` is None for goals without a pose, ``via`` where to go by without stopping.

    ``keep_off`` is of manipulators alone.
    ``purpose`` (of ``Purpose``) and ``why`` are for the ledger.
    """

    robot: str
    serial: int
    action: str
    target: Optional[Target] = None
    via: Tuple[Target, ...] = ()
    purpose: str = field(default="", compare=False)
    why: str = field(default="", compare=False)
    keep_off: KeepOff = NOTHING


@dataclass(frozen=True)
class CancelGoal:
    """Cancel the goal with this serial number; ``why`` is for the ledger."""

    robot: str
    serial: int
    why: str = field(default="", compare=False)


@dataclass(frozen=True)
class SetAssociation:
    """Switch perception between calibrating (off) and running (on)."""

    on: bool


@dataclass(frozen=True)
class DeleteObject:
    """Delete a debris that was reached.

    Attributes:
        name: its name.
        place_m: where it is, metres, world: what nobody registered has no name but on the map.
    """

    name: str
    place_m: Tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class ShowPlan:
    """A plan was made: for the markers and the report.

    Attributes:
        request: what was asked.
        plan: the answer.
        sent: robots that are sent a step.
        refused: what the checker has against the plan; empty when all of it is safe, or it was not asked.
        check_ms: wall time of the check, ms.
        refusals: plans of this mission, this one included, that the checker had something against.
    """

    request: PlanRequest
    plan: FleetPlan
    sent: Tuple[str, ...] = ()
    refused: str = ""
    check_ms: float = 0.0
    refusals: int = 0


class Level(Enum):
    """How urgent a message to a person is."""

    INFO = "info"
    WARN = "warn"


@dataclass(frozen=True)
class Log:
    """Something a person should read."""

    level: Level
    text: str


class DecisionKind(str, Enum):
    """What an entry of the ledger is about, as Decision.msg writes it."""

    STATE = "state"
    SEEN = "seen"
    ASSIGN = "assign"
    REACHED = "reached"
    GIVEN_BACK = "given_back"
    PLAN = "plan"
    SEND = "send"
    HAND = "hand"
    SWITCH = "switch"
    CANCEL = "cancel"
    ENDED = "ended"
    DELETE = "delete"
    HOLD = "hold"
    END = "end"


@dataclass(frozen=True)
class Decision:
    """One entry of the ledger of a mission; fields as in Decision.msg."""

    number: int
    kind: DecisionKind
    robot: str = ""
    goal: str = ""
    text: str = ""


Action = Union[SendGoal, CancelGoal, SetAssociation, DeleteObject, ShowPlan, Log, Decision]
Actions = Tuple[Action, ...]


class TaskState(str, Enum):
    """What has become of a task, as TaskStatus.msg writes it."""

    WAITING = "waiting"
    ASSIGNED = "assigned"
    MOVING = "moving"
    PICKING = "picking"
    CARRYING = "carrying"
    DROPPING = "dropping"
    REACHED = "reached"
    BACKING_OUT = "backing_out"
    UNREACHABLE = "unreachable"
    STOPPED = "stopped"
    FAILED = "failed"


@dataclass(frozen=True)
class TaskView:
    """One task as shown on ``commander/status``; fields as in TaskStatus.msg."""

    robot: str
    goal: str
    kind: str
    status: TaskState
    reason: str = ""
    distance_left_m: float = float("nan")
