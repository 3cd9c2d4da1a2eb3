"""Gathers what happens in one experiment and turns it into a scored record; ROS-free, times are simulated seconds."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Dict, Iterable, List, Mapping, Sequence, Set, Tuple

from yarm.commander.events import TaskState
from yarm.experiments.run.cases import Case
from yarm.experiments.run.ledger import Told
from yarm.experiments.run.nearness import Nearness
from yarm.experiments.run.record import (
    ContactTally,
    DecisionRow,
    GoalRecord,
    NodeUsage,
    PathRow,
    PauseRecord,
    PlannedWay,
    RobotRecord,
    RunInfo,
    RunRecord,
    StepTally,
    TimingRow,
    WaypointRow,
)
from yarm.experiments.run.scoring import goes_to_bin, judge
from yarm.experiments.run.squares import PartSquares
from yarm.experiments.run.track import Track
from yarm.experiments.statistics import percentile
from yarm.geometry import STRAY, GridSpec
from yarm.geometry.kinds import GOAL_KINDS, ContactKind

Cells = Tuple[Tuple[int, int], ...]


@dataclass(frozen=True)
class ContactSample:
    """One contact as the simulator reports it: bodies, their links, penetration in metres, and its verdict."""

    body_a: str
    link_a: str
    body_b: str
    link_b: str
    depth_m: float
    kind: str


@dataclass(frozen=True)
class TaskSample:
    """One task as the Commander reports it."""

    robot: str
    goal: str
    kind: str
    status: str
    reason: str = ""


@dataclass(frozen=True)
class PlanSample:
    """One robot's part of a planning step; milliseconds of wall time, lengths in cells, path as columns."""

    robot: str
    goal: str
    status: str
    planning_ms: float
    robot_ms: float
    check_ms: float
    length_cells: float
    safe: bool
    particles: int
    path: Cells


GAP_S = 0.5
"""Poses, which come 60 times a second, that are farther apart in time have been missed, s."""
TOGETHER_S = 0.2
"""A plan and the waypoint it sends are heard of within this of each other, in either order."""


class Recorder:
    """Takes in events in the order they happen; not thread-safe, the caller holds a lock."""

    def __init__(self, spec: GridSpec, robots: Sequence[str], start_s: float, path_period_s: float = 0.05) -> None:
        """Begin.

        Args:
            spec: the grid, for positions in cells.
            robots: names of the mobile robots.
            start_s: simulated time the mission begins, s; all recorded times count from there.
            path_period_s: the least time between two recorded poses of one robot, s.
        """
        self._spec = spec
        self._period_s = path_period_s
        self._robots = list(robots)
        self._contacts: Dict[Tuple[Tuple[str, str], str], ContactTally] = {}
        self._goal_xy: Dict[str, Tuple[float, float]] = {}
        self._bins: Dict[str, str] = {}
        self._lost = 0
        self._parts: Dict[str, PartSquares] = {}
        self._blind = False
        self._forget(start_s)

    def _forget(self, start_s: float) -> None:
        """Nothing recorded yet, but contacts and where goals are."""
        self._start_s = start_s
        self._missed_s = 0.0
        self._late: Set[str] = set()
        self._track = Track()
        self._last: Dict[str, PathRow] = {}
        self._length_m: Dict[str, float] = dict.fromkeys(self._robots, 0.0)
        self._waypoints: List[WaypointRow] = []
        self._sent: Dict[str, int] = dict.fromkeys(self._robots, 0)
        self._timing: List[TimingRow] = []
        self._paths: Dict[str, Tuple[str, Cells]] = {}
        self._steps = StepTally()
        self._replans: Dict[str, int] = {}
        self._nearness = Nearness()
        self._decisions: List[DecisionRow] = []
        self._planned: Dict[Tuple[str, str], PlannedWay] = {}
        self._pauses: List[PauseRecord] = []
        self._goals: Dict[str, GoalRecord] = {}
        self._given: Dict[str, Set[str]] = {}

    def begin(self, now_s: float) -> None:
        """The mission begins: times count from now on, and only contacts of what was before are kept."""
        shift = self._start_s - now_s
        kept = {key: replace(tally, first_s=tally.first_s + shift) for key, tally in self._contacts.items()}
        last = self._last
        self._forget(now_s)
        self._contacts = kept
        for part in self._parts.values():
            part.shift(shift)
        for row in last.values():
            self.pose(now_s, row.robot, row.x_m, row.y_m, row.yaw_rad)

    def begin_again(self) -> None:
        """The cell has begun anew, time with it: only contacts, and whom they were of, are kept."""
        self._forget(0.0)
        self._goal_xy, self._bins = {}, {}
        for part in self._parts.values():
            part.forget()

    def resume(self) -> None:
        """It goes on after a while in which nobody recorded: what is done by now was done unseen."""
        self._blind = True

    @property
    def heard_s(self) -> float:
        """Simulated time of the newest pose, s; -inf before any."""
        return max((row.time_s + self._start_s for row in self._last.values()), default=-math.inf)

    @property
    def missed_s(self) -> float:
        """Simulated time of the mission without a pose, s: the recording process was dead, or stood still."""
        return self._missed_s

    @property
    def waypoints_sent(self) -> int:
        """Waypoints sent to all robots so far."""
        return len(self._waypoints)

    @property
    def pauses(self) -> Tuple[PauseRecord, ...]:
        """Pauses so far."""
        return tuple(self._pauses)

    @property
    def goals(self) -> Tuple[GoalRecord, ...]:
        """Goals so far, by name."""
        return tuple(self._goals[name] for name in sorted(self._goals))

    @property
    def failures(self) -> int:
        """Pairs of bodies that touched and may not."""
        return sum(tally.kind == ContactKind.FAILURE for tally in self._contacts.values())

    def pose(self, now_s: float, robot: str, x_m: float, y_m: float, yaw_rad: float) -> None:
        """End effector of a mobile robot, metres and rad, world."""
        if robot not in self._sent:
            self._robots.append(robot)
            self._sent[robot] = 0
            self._length_m[robot] = 0.0
        lower, size = self._spec.lower, self._spec.resolution
        row = PathRow(
            self._since(now_s),
            robot,
            x_m,
            y_m,
            yaw_rad,
            (x_m - lower[0]) / float(size[0]),
            (y_m - lower[1]) / float(size[1]),
        )
        last = self._last.get(robot)
        if last is not None:
            if row.time_s - last.time_s < self._period_s - 1e-6:
                return
            if row.time_s - last.time_s > GAP_S and robot == self._robots[0]:
                self._missed_s += row.time_s - last.time_s
            self._length_m[robot] += math.hypot(x_m - last.x_m, y_m - last.y_m)
        self._last[robot] = row
        self._track.add(row)

    def goal_pose(self, goal: str, x_m: float, y_m: float) -> None:
        """Where a goal is now, metres, world."""
        self._goal_xy[goal] = (x_m, y_m)

    def waypoint(self, now_s: float, robot: str, x_m: float, y_m: float, yaw_rad: float) -> None:
        """A waypoint was sent to a robot; metres and rad, world."""
        column = self._spec.column_of((x_m, y_m))
        index = self._sent.get(robot, 0)
        self._sent[robot] = index + 1
        self._waypoints.append(
            WaypointRow(self._since(now_s), robot, "", index, column[0], column[1], x_m, y_m, yaw_rad)
        )

    def step(self, safe: bool) -> None:
        """The Commander has planned a step; whether the checker had nothing against it."""
        self._steps = StepTally(self._steps.planned + 1, self._steps.refused + (not safe))

    def plan(self, now_s: float, sample: PlanSample) -> None:
        """A planning step decided this for one robot."""
        before = self._paths.get(sample.robot)
        if before is not None and before[0] == sample.goal and not _continues(before[1], sample.path):
            self._replans[sample.robot] = self._replans.get(sample.robot, 0) + 1
        self._paths[sample.robot] = (sample.goal, sample.path)
        if sample.goal and sample.path:
            way = PlannedWay(sample.robot, sample.goal, sample.path)
            self._planned.setdefault((sample.robot, sample.goal), way)
        self._timing.append(
            TimingRow(
                self._since(now_s),
                sample.robot,
                sample.goal,
                0,
                sample.planning_ms,
                sample.robot_ms,
                sample.check_ms,
                sample.length_cells,
                sample.status,
                sample.safe,
                sample.particles,
            )
        )

    def contacts(self, now_s: float, samples: Iterable[ContactSample]) -> None:
        """The simulator saw these contacts."""
        for sample in samples:
            ends = sorted([(sample.body_a, sample.link_a), (sample.body_b, sample.link_b)])
            pair, links = (ends[0][0], ends[1][0]), (ends[0][1], ends[1][1])
            kind = self._kind(sample, pair)
            tally = self._contacts.get((pair, kind))
            if tally is None:
                tally = ContactTally(pair, kind, 0, self._since(now_s), links, -math.inf)
            if sample.depth_m > tally.depth_m:
                tally = replace(tally, links=links, depth_m=sample.depth_m)
            first_s = min(tally.first_s, self._since(now_s))
            self._contacts[(pair, kind)] = replace(tally, messages=tally.messages + 1, first_s=first_s)

    def touched(self, now_s: float, pairs: Iterable[str]) -> None:
        """Every pair, "a b", that the simulator has seen touch and may not; one that was missed is as of now."""
        for words in pairs:
            one, other = sorted(words.split())
            key = ((one, other), ContactKind.FAILURE.value)
            if key not in self._contacts:
                self._contacts[key] = ContactTally(key[0], key[1], 0, self._since(now_s), ("", ""), 0.0)

    def clearance(self, now_s: float, robot: str, nearest: str, distance_m: float) -> None:
        """Least distance of a robot to anything, metres; its own goal does not count."""
        if nearest not in self._given.get(robot, set()) and robot in self._sent:
            self._nearness.add(self._since(now_s), robot, nearest, distance_m)

    def decision(self, now_s: float, number: int, kind: str, robot: str, goal: str, text: str) -> None:
        """An entry of the Commander's ledger; the first one of a mission begins it anew."""
        if number == 1:
            self._decisions = []
        self._decisions.append(DecisionRow(number, round(1e3 * self._since(now_s)), kind, robot, goal, text))

    @property
    def decisions(self) -> Tuple[DecisionRow, ...]:
        """The ledger so far."""
        return tuple(self._decisions)

    def follow_parts(self, parts: Iterable[PartSquares]) -> None:
        """The parts that manipulators work on."""
        self._parts = {part.manipulator: part for part in parts}

    def tool(self, now_s: float, name: str, flange: Sequence[float], axis: Sequence[float]) -> None:
        """A manipulator that is on its raster: its flange, metres, and the direction its tool looks in, world."""
        if name in self._parts:
            self._parts[name].tool(self._since(now_s), flange, axis)

    def sander(self, name: str, words: str, progress: float) -> None:
        """What a manipulator does, in words, and the share of its raster that is done."""
        if name in self._parts:
            self._parts[name].note(words, progress)

    def manipulator(self, now_s: float, name: str, moving: bool) -> None:
        """A manipulator was told to move, or to pause."""
        paused = [i for i, p in enumerate(self._pauses) if p.manipulator == name and math.isnan(p.end_s)]
        if moving and paused:
            self._pauses[paused[-1]] = replace(self._pauses[paused[-1]], end_s=self._since(now_s))
        elif not moving and not paused:
            self._pauses.append(PauseRecord(name, self._since(now_s)))

    def tasks(self, now_s: float, samples: Iterable[TaskSample]) -> None:
        """The Commander's tasks as they stand."""
        for sample in samples:
            if sample.kind not in GOAL_KINDS:
                continue
            if sample.robot:
                self._given.setdefault(sample.robot, set()).add(sample.goal)
            record = self._goals.get(sample.goal, GoalRecord(sample.goal, sample.kind))
            if math.isnan(record.declared_s):
                record = replace(record, robot=sample.robot or record.robot, status=sample.status, reason=sample.reason)
                if sample.status in (TaskState.REACHED, TaskState.BACKING_OUT):
                    away_m = math.nan if self._blind else self._distance(record.robot, sample.goal)
                    last = self._last.get(record.robot)
                    if not self._blind and last is not None and abs(last.time_s - self._since(now_s)) > GAP_S:
                        self._late.add(sample.goal)
                    record = replace(record, declared_s=self._since(now_s), distance_m=away_m)
            self._goals[sample.goal] = record
        self._blind = False

    def in_bins(self, bins: Mapping[str, str], lost: int = 0) -> None:
        """By ground truth the bin each piece of debris lies in now, empty for none, and how often hands lost one."""
        self._bins, self._lost = dict(bins), lost

    def finish(self, info: RunInfo, case: Case, arrival_limit_m: float, usage: Sequence[NodeUsage] = ()) -> RunRecord:
        """Score everything that was taken in.

        Args:
            info: what was run and how it ended.
            case: what must come out.
            arrival_limit_m: largest horizontal distance of an end effector from a goal it is said to have reached.
            usage: cost of each node.
        """
        told = Told(self._decisions)
        goals = tuple(told.of_goal(self._scored(goal, info, arrival_limit_m)) for goal in self.goals)
        pauses = tuple(told.of_pause(pause) for pause in self.pauses)
        waypoints = [self._with_clearance(told.of_waypoint(row)) for row in map(self._with_goal, self._waypoints)]
        contacts = tuple(sorted(self._contacts.values(), key=lambda c: (c.kind != ContactKind.FAILURE, c.pair, c.kind)))
        robots = tuple(self._robot(name, goals) for name in sorted(self._robots))
        faults = judge(info, case, robots, goals, contacts, self.pauses, arrival_limit_m, self._lost)
        return RunRecord(
            info,
            not faults,
            faults,
            robots,
            goals,
            contacts,
            pauses,
            tuple(sorted(usage, key=lambda u: -u.cpu_share)),
            self._steps,
            tuple(sorted(waypoints, key=lambda row: (row.time_s, row.robot))),
            self._track.rows(),
            tuple(sorted(map(self._with_index, self._timing), key=lambda row: (row.time_s, row.robot))),
            self.decisions,
            tuple(row for _, part in sorted(self._parts.items()) for row in part.rows(pauses)),
            tuple(way for _, way in sorted(self._planned.items())),
        )

    def _scored(self, goal: GoalRecord, info: RunInfo, arrival_limit_m: float) -> GoalRecord:
        """A goal with where it is in the end, and whether it was reached."""
        goal = replace(goal, bin=self._bin_of(goal.name))
        if math.isnan(goal.declared_s):
            return goal
        if goal.name in self._late:
            goal = replace(goal, distance_m=self._distance_then(goal))
        near = math.isnan(goal.distance_m) or goal.distance_m <= arrival_limit_m
        there = bool(goal.bin) if goes_to_bin(info, goal) else near
        return replace(goal, reached=there)

    def _bin_of(self, name: str) -> str:
        """The bin that a piece lies in; empty for none.

        The truth does not know debris_auto_<n>: the first of those that were declared done is the first piece in a bin
        that was nobody's goal, and so on.
        """
        if not name.startswith(STRAY):
            return self._bins.get(name, "")
        done = sorted(n for n, goal in self._goals.items() if n.startswith(STRAY) and not math.isnan(goal.declared_s))
        unnamed = [found for piece, found in sorted(self._bins.items()) if found and piece not in self._goals]
        return dict(zip(done, unnamed)).get(name, "")

    def _with_goal(self, row: WaypointRow) -> WaypointRow:
        """A waypoint and the goal of the plan it is of; which of the two was heard of first does not matter."""
        plans = [p for p in self._timing if p.robot == row.robot and p.time_s <= row.time_s + TOGETHER_S]
        return replace(row, goal=plans[-1].goal) if plans else row

    def _with_clearance(self, row: WaypointRow) -> WaypointRow:
        """A waypoint and the least clearance until the robot's next one."""
        later = [w.time_s for w in self._waypoints if w.robot == row.robot and w.index == row.index + 1]
        clearance_m, nearest = self._nearness.least(row.robot, row.time_s, later[0] if later else math.inf)
        return replace(row, clearance_m=clearance_m if nearest else math.nan, nearest=nearest)

    def _with_index(self, row: TimingRow) -> TimingRow:
        """A plan and how many waypoints its robot had been sent before."""
        before = [w for w in self._waypoints if w.robot == row.robot and w.time_s < row.time_s - TOGETHER_S]
        return replace(row, waypoint=len(before))

    def _robot(self, name: str, goals: Sequence[GoalRecord]) -> RobotRecord:
        mine = sorted((g for g in goals if g.robot == name), key=lambda g: g.declared_s)
        reached = [g for g in mine if g.reached]
        planning = [row.planning_ms for row in self._timing if row.robot == name]
        clearance, nearest = self._nearness.least(name)
        return RobotRecord(
            name,
            tuple(g.name for g in reached),
            bool(mine) and len(reached) == len(mine),
            reached[-1].declared_s if reached else math.nan,
            self._sent.get(name, 0),
            self._length_m.get(name, 0.0),
            len(planning),
            self._replans.get(name, 0),
            percentile(planning, 50),
            percentile(planning, 99),
            clearance,
            nearest,
        )

    def _kind(self, sample: ContactSample, pair: Tuple[str, str]) -> str:
        """The simulator's verdict, made stricter by what it cannot know: whose goal a debris is."""
        for robot, other in (pair, pair[::-1]):
            is_goal = other in self._goals or other in self._goal_xy
            if robot in self._sent and is_goal and other not in self._given.get(robot, set()):
                return ContactKind.FAILURE.value
        return sample.kind

    def _distance(self, robot: str, goal: str) -> float:
        last, xy = self._last.get(robot), self._goal_xy.get(goal)
        return math.inf if last is None or xy is None else math.hypot(last.x_m - xy[0], last.y_m - xy[1])

    def _distance_then(self, goal: GoalRecord) -> float:
        """The same of a goal that was declared while poses came late, by its stamp; NaN when none came from then."""
        rows = [row for row in self._track.rows() if row.robot == goal.robot]
        later = [row for row in rows if row.time_s > goal.declared_s]
        xy = self._goal_xy.get(goal.name)
        if not later or xy is None:
            return goal.distance_m
        row = min(rows, key=lambda row: abs(row.time_s - goal.declared_s))
        near = abs(row.time_s - goal.declared_s) <= GAP_S
        return math.hypot(row.x_m - xy[0], row.y_m - xy[1]) if near else math.nan

    def _since(self, now_s: float) -> float:
        return now_s - self._start_s


def _continues(before: Cells, after: Cells) -> bool:
    """Whether the new path is what was left of the one before, from any of its waypoints on."""
    return len(after) < 2 or any(before[i:] == after for i in range(len(before)))
