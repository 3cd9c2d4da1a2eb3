"""What one experiment leaves behind: plain rows and records, free of ROS, each field with its unit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping, Tuple

from yarm.commander.params import Removal


@dataclass(frozen=True)
class WaypointRow:
    """One waypoint sent to a robot.

    Attributes:
        time_s: simulated time it was sent, s since the mission began.
        robot: name of the robot.
        goal: goal the robot was on its way to; empty when it stepped aside.
        index: how many waypoints the robot had before.
        column_x: column of the grid along x.
        column_y: column of the grid along y.
        x_m: where the end effector is sent, metres, world.
        y_m: metres, world.
        yaw_rad: heading, rad, world.
        verdict: what the checker says of the step; empty when the Commander told nothing of it.
        clearance_m: least distance to anything but the robot's goals until its next waypoint (ground truth), metres;
            NaN when nothing came within the simulator's range.
        nearest: what it was nearest to then.
    """

    time_s: float
    robot: str
    goal: str
    index: int
    column_x: int
    column_y: int
    x_m: float
    y_m: float
    yaw_rad: float
    verdict: str = ""
    clearance_m: float = math.nan
    nearest: str = ""


@dataclass(frozen=True)
class PathRow:
    """Where a robot's end effector really was (ground truth).

    Attributes:
        time_s: simulated time, s since the mission began.
        robot: name of the robot.
        x_m: end effector, metres, world.
        y_m: metres, world.
        yaw_rad: heading, rad, world.
        column_x: position along x in cells of the grid, with decimals.
        column_y: position along y in cells of the grid, with decimals.
    """

    time_s: float
    robot: str
    x_m: float
    y_m: float
    yaw_rad: float
    column_x: float
    column_y: float


@dataclass(frozen=True)
class TimingRow:
    """One planning step, for one robot.

    Attributes:
        time_s: simulated time, s since the mission began.
        robot: name of the robot.
        goal: its goal; empty when it stepped aside.
        waypoint: index of the waypoint this step would send.
        planning_ms: wall time of the whole fleet's planning step, ms.
        robot_ms: share spent on this robot, ms.
        check_ms: wall time of the independent check, ms.
        length_cells: length of the path that was planned, cells.
        status: PlanStatus of this robot.
        safe: the step passed the check.
        particles: number of particles.
    """

    time_s: float
    robot: str
    goal: str
    waypoint: int
    planning_ms: float
    robot_ms: float
    check_ms: float
    length_cells: float
    status: str
    safe: bool
    particles: int


@dataclass(frozen=True)
class ContactTally:
    """Every contact of one pair of bodies in one run.

    Attributes:
        pair: names of the two bodies, ordered.
        kind: a ``ContactKind``.
        messages: number of reports.
        first_s: simulated time of the first, s since the mission began.
        links: links of the deepest one, in the order of the pair.
        depth_m: deepest penetration, metres.
    """

    pair: Tuple[str, str]
    kind: str
    messages: int
    first_s: float
    links: Tuple[str, str]
    depth_m: float


@dataclass(frozen=True)
class GoalRecord:
    """What became of one goal.

    Attributes:
        name: its name.
        kind: "Debris" or "Target".
        robot: who was given it; empty when nobody was.
        reached: declared reached by the Commander, and true by the simulator's poses; of debris that goes to a bin,
            that it lies in one at the end.
        declared_s: simulated time it was declared reached, s since the mission began; NaN when it never was.
        distance_m: horizontal distance of the end effector at that moment, metres; NaN when it never was, or when
            nobody recorded then: the Commander's word counts.
        status: last status the Commander gave it.
        reason: why it was not reached; empty when it was.
        bin: the bin it lies in at the end, at rest and in nobody's hand (ground truth); empty for none.
        seen_s: simulated time the Commander first saw it, s since the mission began; NaN when it never did.
        cameras: by which cameras, and where; empty when it never did.
        why: why its robot was given it, and no other.
    """

    name: str
    kind: str
    robot: str = ""
    reached: bool = False
    declared_s: float = math.nan
    distance_m: float = math.nan
    status: str = ""
    reason: str = ""
    bin: str = ""
    seen_s: float = math.nan
    cameras: str = ""
    why: str = ""


@dataclass(frozen=True)
class RobotRecord:
    """What one mobile robot did.

    Attributes:
        name: its name.
        goals: goals it reached, in order.
        reached: every goal it was given was reached.
        time_s: simulated time it reached the last one, s since the mission began; NaN when it reached none.
        waypoints: waypoints it was sent.
        path_m: way its end effector covered, metres.
        plans: planning steps it took part in.
        replans: how often its path changed against what was left of the one before.
        planning_p50_ms: median wall time of its planning steps, ms.
        planning_p99_ms: 99th percentile, ms.
        min_clearance_m: least distance to anything but its own goal (ground truth), metres.
        nearest: what it was nearest to then.
    """

    name: str
    goals: Tuple[str, ...]
    reached: bool
    time_s: float
    waypoints: int
    path_m: float
    plans: int
    replans: int
    planning_p50_ms: float
    planning_p99_ms: float
    min_clearance_m: float
    nearest: str


@dataclass(frozen=True)
class PauseRecord:
    """One pause of a manipulator.

    Attributes:
        manipulator: its name.
        start_s: simulated time it was told to pause, s since the mission began.
        end_s: simulated time it was told to go on; NaN when it never was.
        cause: what was near its tool, and how near; empty when the Commander told nothing of it.
    """

    manipulator: str
    start_s: float
    end_s: float = math.nan
    cause: str = ""

    @property
    def length_s(self) -> float:
        """How long it took, s; NaN when it never ended."""
        return self.end_s - self.start_s


@dataclass(frozen=True)
class DecisionRow:
    """One entry of the Commander's ledger.

    Attributes:
        number: from 1.
        time_ms: simulated time, ms since the mission began.
        kind: as in Decision.msg.
        robot: whom it is about; empty for nobody in particular.
        goal: the goal it is about; empty for none.
        text: what exactly, and why.
    """

    number: int
    time_ms: int
    kind: str
    robot: str
    goal: str
    text: str


@dataclass(frozen=True)
class SquareRow:
    """One square of a part's top, and whether it was sanded (ground truth).

    Attributes:
        manipulator: whose part it is on.
        row: of the square, along x of the station.
        column: of the square, along y.
        x_m: its middle, metres, world.
        y_m: metres, world.
        sanded_s: simulated time the tool was first over its middle, s since the mission began (negative: before); NaN
            when it never was.
        speed_mps: speed of the tool when it was nearest to the middle, m/s; NaN when it never was over it.
        tilt_deg: angle of the tool to the part's normal then, deg; NaN likewise.
        reason: why it was not sanded; empty when it was.
    """

    manipulator: str
    row: int
    column: int
    x_m: float
    y_m: float
    sanded_s: float = math.nan
    speed_mps: float = math.nan
    tilt_deg: float = math.nan
    reason: str = ""


@dataclass(frozen=True)
class PlannedWay:
    """The first way that was planned for a robot to a goal: columns of the grid."""

    robot: str
    goal: str
    columns: Tuple[Tuple[int, int], ...]


@dataclass(frozen=True)
class NodeUsage:
    """What one process cost.

    Attributes:
        node: its ROS nodes, or its name.
        cpu_share: processor time over wall time, 1.0 is one core.
        ms_per_frame: processor time over camera sets, ms; NaN without camera sets.
        memory_start_mb: resident memory at the start, MB.
        memory_end_mb: resident memory at the end, MB.
        memory_middle_mb: resident memory half-way through a soak, MB; NaN outside a soak.
    """

    node: str
    cpu_share: float
    ms_per_frame: float
    memory_start_mb: float
    memory_end_mb: float
    memory_middle_mb: float = math.nan


@dataclass(frozen=True)
class RunInfo:
    """What an experiment was run with, and how fast.

    Attributes:
        case: name of the case.
        seed: seed of the scene and the planner.
        mode: "bounded" or "boundless".
        outcome: what the Commander says of its mission: "succeeded", "failed", "stopped" or "" when it never ended.
        reason: its reason.
        sim_s: simulated length of the mission, s.
        wall_s: wall time of the mission, s.
        real_time_factor: simulated seconds per wall second.
        camera_sets: camera sets during the mission.
        loop_ms: wall milliseconds per camera frame of each part of the simulator's loop.
        versions: version by name of software.
        parameters: parameters by node.
        layout: where everything was at the start or fell, and how it was pushed: metres, degrees.
        removal: what became of debris: "delete" or "bin".
        begun_again: how often the cell has begun anew, its simulation having been started again; all that is told is
            of its last beginning, contacts are of all.
        unrecorded_s: simulated time that was not recorded because the recording process had died, or stood still, s;
            who has touched whom is known of it all the same.
    """

    case: str
    seed: int
    mode: str
    outcome: str = ""
    reason: str = ""
    sim_s: float = 0.0
    wall_s: float = 0.0
    real_time_factor: float = math.nan
    camera_sets: int = 0
    loop_ms: Mapping[str, float] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, object] = field(default_factory=dict)
    layout: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    removal: str = Removal.DELETE.value
    begun_again: int = 0
    unrecorded_s: float = 0.0


@dataclass(frozen=True)
class StepTally:
    """What the independent checker said of the mission's planning steps.

    Attributes:
        planned: planning steps of the Commander.
        refused: those that it had something against; with check_steps report they were sent all the same.
    """

    planned: int = 0
    refused: int = 0


@dataclass(frozen=True)
class RunRecord:
    """One experiment, scored.

    Attributes:
        info: what it was run with.
        success: true when nothing is wrong.
        faults: everything that is wrong, one sentence each.
        robots: the mobile robots, by name.
        goals: the goals, by name.
        contacts: contacts by pair, failures first.
        pauses: pauses of the manipulators, in order.
        usage: cost of each node, most expensive first.
        steps: what the checker said.
        waypoints: every waypoint sent.
        path: where the robots really went.
        timing: every planning step.
        decisions: the Commander's ledger of the mission.
        squares: the parts' tops.
        planned: the first way planned for each robot to each goal.
    """

    info: RunInfo
    success: bool
    faults: Tuple[str, ...]
    robots: Tuple[RobotRecord, ...] = ()
    goals: Tuple[GoalRecord, ...] = ()
    contacts: Tuple[ContactTally, ...] = ()
    pauses: Tuple[PauseRecord, ...] = ()
    usage: Tuple[NodeUsage, ...] = ()
    steps: StepTally = StepTally()
    waypoints: Tuple[WaypointRow, ...] = ()
    path: Tuple[PathRow, ...] = ()
    timing: Tuple[TimingRow, ...] = ()
    decisions: Tuple[DecisionRow, ...] = ()
    squares: Tuple[SquareRow, ...] = ()
    planned: Tuple[PlannedWay, ...] = ()
