"""Drives to goals: plans, has every way checked, follows it, backs off from bumps, and says when it cannot."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Deque, List, Optional, Tuple

import numpy as np

from yarm.exploration.model import LOOP_S, Command, Event, Observation
from yarm.exploration.params import ExploreParams
from yarm.exploration.seen import EDGE_M, SweptGround
from yarm.exploration.suspicion import Suspicion
from yarm.geometry import BoolArray, FloatArray, Pose2, pairs, wrap_angle
from yarm.navigation.follower import FollowSettings, PathFollower, room_ahead
from yarm.navigation.grid_map import OCCUPIED_AT_LEAST, GridMap
from yarm.navigation.ground import Ground, PlanSettings
from yarm.navigation.path_check import check_path
from yarm.navigation.planner import Cell, Field
from yarm.robots import turtlebot


def _strip_ahead(from_m: float, to_m: float, half_width_m: float, apart_m: float = EDGE_M) -> FloatArray:
    """(n, 2) points no farther apart than a square of swept ground, or so far, of the strip ahead, outside the body."""
    ahead = np.linspace(from_m, to_m, math.ceil((to_m - from_m) / apart_m) + 1)
    aside = np.linspace(-half_width_m, half_width_m, math.ceil(2.0 * half_width_m / apart_m) + 1)
    points = np.stack(np.meshgrid(ahead, aside), axis=-1).reshape(-1, 2)
    outside: FloatArray = points[np.hypot(points[:, 0], points[:, 1]) > turtlebot.RADIUS_M]
    return outside


DISC_M = 0.18
"""Radius of the disc that every way keeps clear."""
STRIP_M = turtlebot.RADIUS_M + 0.02
"""Half the width of the strip ahead in which something counts as near."""
LOOK_PASSES = 3
"""Every n-th scan is taken to say which floor was seen."""
FLOOR_SEEN_M = (0.85, 2.5)
"""Floor is seen from no nearer and no farther: nearer the robot's own plate hides the lowest obstacles."""
SAME_PLACE_M = 0.01
UNMOVED_M = 0.002
"""A robot that turns in place is off by no more between two passes."""
SOON_PASSED: FloatArray = _strip_ahead(0.10, 0.27, DISC_M)
"""(n, 2) points of the floor that the robot is about to pass before it can be slow, base frame, metres."""
SOON_SWEPT: FloatArray = _strip_ahead(0.0, 0.27, DISC_M, 0.5 * EDGE_M)
"""(n, 2) the same with what lies beside the body's front half, for robots that are quick to speed up and to turn."""
BACKED_SHARE = 0.5
"""Who backed off by less than this share of the way has something behind him."""
TOUCHING_M = turtlebot.RADIUS_M + 0.02
"""Something this near ahead stops the robot."""


class Drives(Enum):
    """How driving goes."""

    IDLE = "idle"
    DRIVING = "driving"
    BACKING = "backing"
    ARRIVED = "arrived"
    FAILED = "failed"


@dataclass
class _Backing:
    """Backing off: how far it still is, where it began, why.

    ``stuck`` when nothing was bumped into: it goes ahead instead when the way back is blocked; ``ahead`` while it does.
    """

    left_m: float = 0.0
    start: Pose2 = field(default_factory=lambda: Pose2(0.0, 0.0))
    reason: str = ""
    stuck: bool = False
    ahead: bool = False


@dataclass(frozen=True)
class DriverSettings:
    """How goals are driven to.

    Attributes:
        unknown_passable: ways may lead over unknown ground.
        cautious: where the floor has not been seen, no faster than touch_mps.
        touch_mps: greatest speed at which the robot may touch something.
        back_mps: speed when it backs off.
        back_m: how far it backs off.
        stuck_s: told to move for so long ...
        stuck_m: ... and moved less than this by odometry, or in the map, and
        stuck_rad: ... turned less than this: it is stuck.
        blocked_s: standing before something for so long is a failure.
        turn_radps: greatest rate of turning.
        turn_up_radps2: how fast the rate of turning may change.
        turn_gain_per_s: rate of turning per heading error.
        speed_up_mps2: how fast the speed may grow.
        foresee_s: the floor beside the body's front, and what it sweeps if it turns on for so long, must have been
            seen too; 0: only what lies straight ahead.
        drive_below_rad: a robot that turns in place sets off once its heading error is below this.
        arrive_m: a goal is reached within this.
        arrive_rad: its heading is reached within this.
    """

    unknown_passable: bool = False
    cautious: bool = True
    touch_mps: float = 0.098
    back_mps: float = 0.08
    back_m: float = 0.12
    stuck_s: float = 3.0
    stuck_m: float = 0.03
    stuck_rad: float = 0.1
    blocked_s: float = 1.5
    turn_radps: float = 1.2
    turn_up_radps2: float = 4.0
    turn_gain_per_s: float = 2.5
    speed_up_mps2: float = 0.6
    foresee_s: float = 0.0
    drive_below_rad: float = 0.20
    arrive_m: float = 0.05
    arrive_rad: float = 0.06


@dataclass(frozen=True)
class Driven:
    """One pass of driving.

    Attributes:
        state: how it goes.
        command: what to drive.
        reason: why it failed; empty otherwise.
        events: what happened.
        blocked: it failed because something stands ahead, though the map shows a way.
    """

    state: Drives
    command: Command = field(default_factory=Command)
    reason: str = ""
    events: Tuple[Event, ...] = ()
    blocked: bool = False


class Driver:
    """Owns the way, and remembers which ground the camera has seen."""

    def __init__(self, params: ExploreParams, settings: Optional[DriverSettings] = None) -> None:
        """Stands, without a goal."""
        self._settings = settings or DriverSettings()
        self._follower = PathFollower(
            FollowSettings(
                max_speed_mps=params.max_speed,
                near_speed_mps=params.near_speed,
                near_distance_m=params.near_distance,
                turn_radps=self._settings.turn_radps,
                gain_per_s=self._settings.turn_gain_per_s,
                drive_below_rad=self._settings.drive_below_rad,
                speed_up_mps2=self._settings.speed_up_mps2,
                turn_up_radps2=self._settings.turn_up_radps2,
                arrive_m=self._settings.arrive_m,
                arrive_rad=self._settings.arrive_rad,
            )
        )
        self._near_m = params.near_distance
        self.floor = SweptGround(*FLOOR_SEEN_M)
        self._suspicion = Suspicion(self.floor)
        self.map: Optional[GridMap] = None
        self._ground: Optional[Ground] = None
        self._field: Optional[Field] = None
        self._early: Optional[Field] = None
        self._passes = 0
        self._version = -1
        self._goal: Optional[Cell] = None
        self._goal_point: FloatArray = np.zeros(2)
        self._yaw: Optional[float] = None
        self._backing = _Backing()
        self._moves: Deque[Tuple[float, Pose2, Pose2]] = Deque()
        self._turns_radps = 0.0
        self._blocked_s = 0.0
        self._checked = -1
        self._events: List[Event] = []

    @property
    def path(self) -> FloatArray:
        """(n, 2) the way that is driven, map frame, metres; (0, 2) without one."""
        return self._follower.path

    @property
    def version(self) -> int:
        """Changes whenever the map does."""
        return self._version

    def sense(self, observation: Observation) -> Optional[GridMap]:
        """Take in what was observed; gives the map, None before there is one."""
        pose = observation.pose
        self._passes += 1
        if pose is not None and self._settings.cautious:
            self.floor.stand(pose, observation.now_s)
            if observation.scan is not None and self._passes % LOOK_PASSES == 1:
                self.floor.see(pose, observation.scan, observation.now_s, self._map_points(pose, FLOOR_SEEN_M[1]))
        if observation.map is None:
            return None
        if pose is not None:
            self._feel(observation, pose)
        if observation.map_count != self._version:
            self._version, self.map = observation.map_count, observation.map
            self._ground = self._field = self._early = None
        if observation.jumped:
            self.stop()
        return self.map

    def field(self, pose: Pose2, within_m: float = math.inf) -> Field:
        """Ways over the newest map from here, or from where they were last computed if that is within so many metres.

        Raises:
            RuntimeError: there is no map yet.
        """
        if self._field is None or self._field.start.distance(pose) > within_m:
            self._field = self._field_at(pose)
        return self._field

    def search_early(self, pose: Pose2, within_m: float) -> None:
        """Search for what ``field`` will give from here, so that it need not be waited for then.

        Raises:
            RuntimeError: there is no map yet.
        """
        field = self.field(pose)
        if field.start.distance(pose) > within_m:
            field = self._early = self._field_at(pose)
        field.search()

    def _field_at(self, pose: Pose2) -> Field:
        if self.map is None:
            raise RuntimeError("ways were asked for before there was a map")
        for known in (self._early, self._field):
            if known is not None and known.start.distance(pose) <= UNMOVED_M:
                return known
        if self._ground is None:
            unknown = self._settings.unknown_passable
            more = self._suspicion.weights(self.map, DISC_M)
            self._ground = Ground(self.map, PlanSettings(radius_m=DISC_M, unknown_passable=unknown), more)
        return Field(self.map, pose, ground=self._ground)

    def go(self, field: Field, cell: Cell, yaw_rad: Optional[float]) -> str:
        """Drive to a cell and turn to a heading there; gives why not, or an empty text."""
        path = field.path_to(cell)
        if len(path) == 0:
            return "the disc cannot get there"
        verdict = check_path(field.grid_map, path, DISC_M)
        if not verdict.clear:
            return f"the way was refused: {verdict.reason}"
        self._goal, self._goal_point, self._yaw = cell, np.array(field.grid_map.centre_of(*cell)), yaw_rad
        self._follower.follow(path, yaw_rad)
        self._checked = self._version
        self._blocked_s = 0.0
        return ""

    def turn(self, pose: Pose2, yaw_rad: float) -> None:
        """Turn in place to a heading of the map."""
        self._goal, self._yaw = None, yaw_rad
        self._follower.follow(np.array([[pose.x, pose.y]]), yaw_rad)

    def stop(self) -> None:
        """Stand and forget the goal."""
        self._goal = None
        self._follower.stop()

    def step(self, observation: Observation) -> Driven:
        """One pass; ``sense`` comes first."""
        pose, events = observation.pose, self._events
        self._events = []
        if pose is None or observation.odometry is None:
            self._follower.stop()
            return Driven(Drives.IDLE, events=tuple(events))
        if self._backing.left_m > 0.0:
            return self._back(observation, pose, events)
        if len(self._follower.path) == 0:
            return Driven(Drives.IDLE, events=tuple(events))
        unmoved = self._stuck(observation.now_s, observation.odometry.pose, pose)
        if unmoved:
            events.append(Event(observation.now_s, "stuck", (("x", pose.x), ("y", pose.y))))
            self._begin_backing(pose, f"told to move, but {unmoved} hardly changed", stuck=True)
            return self._back(observation, pose, events)
        fault = self._way_fault(pose)
        if fault:
            self.stop()
            return Driven(Drives.FAILED, Command(), fault, tuple(events))
        return self._follow(observation, pose, events)

    def _follow(self, observation: Observation, pose: Pose2, events: List[Event]) -> Driven:
        ahead = self._ahead(observation, pose)
        cap = self._cap(pose)
        if ahead < TOUCHING_M:
            cap = 0.0
        drive = self._follower.step(pose, ahead, self.field(pose).sees, cap)
        self._turns_radps = drive.w_radps
        self._note_move(observation, pose, drive.v_mps, drive.w_radps)
        if drive.arrived:
            self._goal = None
            return Driven(Drives.ARRIVED, Command(), "", tuple(events))
        standing = ahead < TOUCHING_M and abs(drive.w_radps) < 0.05
        self._blocked_s = self._blocked_s + LOOP_S if standing else 0.0
        if self._blocked_s > self._settings.blocked_s:
            self.stop()
            reason = f"something stands {ahead:.2f} m ahead"
            return Driven(Drives.FAILED, Command(), reason, tuple(events), blocked=True)
        return Driven(Drives.DRIVING, Command(drive.v_mps, drive.w_radps), "", tuple(events))

    def _feel(self, observation: Observation, pose: Pose2) -> None:
        """Backs off from what was bumped into; the map that comes has it marked."""
        for bump in observation.bumps:
            if not bump.pressed:
                continue
            details = (("sector", bump.bumper.name), ("x", pose.x), ("y", pose.y))
            self._events.append(Event(observation.now_s, "bump", details))
            if self._settings.cautious:
                self._suspicion.met(pose, bump.bumper)
            self._begin_backing(pose, f"bumped, {bump.bumper.name.lower()}")

    def _begin_backing(self, pose: Pose2, reason: str, stuck: bool = False) -> None:
        self._follower.stop()
        self._goal = None
        self._backing = _Backing(self._settings.back_m, pose, reason, stuck)
        self._moves.clear()

    def _back(self, observation: Observation, pose: Pose2, events: List[Event]) -> Driven:
        """Straight back, where it came from; the goal is given up when this is over."""
        backing = self._backing
        backing.left_m -= self._settings.back_mps * LOOP_S
        if backing.left_m <= 0.0 and self._stayed(backing, pose):
            self._backing = backing = _Backing(self._settings.back_m, pose, backing.reason, ahead=True)
        if backing.left_m <= 0.0 or (backing.ahead and self._ahead(observation, pose) < TOUCHING_M):
            self._backing = _Backing()
            return Driven(Drives.FAILED, Command(), backing.reason, tuple(events))
        speed = self._settings.back_mps if backing.ahead else -self._settings.back_mps
        return Driven(Drives.BACKING, Command(speed, 0.0), "", tuple(events))

    def _stayed(self, backing: _Backing, pose: Pose2) -> bool:
        """Whether a robot that was stuck is so still: what holds it stands behind it."""
        return backing.stuck and backing.start.distance(pose) < BACKED_SHARE * self._settings.back_m

    def _way_fault(self, pose: Pose2) -> str:
        """Checks what is left of the way when the map has changed, and plans another when it is no longer clear."""
        if self._goal is None or self._checked == self._version or self.map is None:
            return ""
        self._checked = self._version
        if check_path(self.map, self._left(pose), DISC_M).clear:
            return ""
        field = self.field(pose, SAME_PLACE_M)
        if field.reason:
            return field.reason
        return self.go(field, self.map.cell_of(*self._goal_point), self._yaw)

    def _left(self, pose: Pose2) -> FloatArray:
        return np.concatenate([np.array([[pose.x, pose.y]]), self._follower.ahead])

    def _ahead(self, observation: Observation, pose: Pose2) -> float:
        """Free way ahead by the map, the scan, and what was just seen low, metres from the base's centre."""
        seen = [self._map_points(pose, self._near_m + 0.1)]
        if observation.scan is not None:
            seen.append(observation.scan.points())
        if observation.low is not None:
            seen.append(observation.low.points)
        return room_ahead(np.concatenate(seen), STRIP_M)

    def _map_points(self, pose: Pose2, reach_m: float) -> FloatArray:
        """(n, 2) centres of the occupied cells around the robot, base frame."""
        if self.map is None:
            return np.zeros((0, 2))
        row, column = self.map.cell_of(pose.x, pose.y)
        reach = math.ceil(reach_m / self.map.resolution_m)
        top, left = max(row - reach, 0), max(column - reach, 0)
        window = self.map.cells[top : max(row + reach + 1, 0), left : max(column + reach + 1, 0)]
        cells = np.argwhere(window >= OCCUPIED_AT_LEAST) + np.array([top, left])
        away = self.map.centres_of(cells) - (pose.x, pose.y)
        c, s = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
        return pairs(c * away[:, 0] + s * away[:, 1], c * away[:, 1] - s * away[:, 0])

    def _cap(self, pose: Pose2) -> Optional[float]:
        """A limit of the speed where neither camera nor map knows the floor that the robot is about to pass."""
        if not self._settings.cautious:
            return None
        points = self._soon_passed(pose)
        unseen = points[~self.floor.since(points, 0.0)]
        return None if self._taken(unseen).all() else self._settings.touch_mps

    def _soon_passed(self, pose: Pose2) -> FloatArray:
        """(n, 2) points of the floor that the body is about to sweep, map frame, metres."""
        if self._settings.foresee_s == 0.0:
            return pose.moved(SOON_PASSED)
        turned = Pose2(pose.x, pose.y, pose.yaw_rad + self._turns_radps * self._settings.foresee_s)
        return np.concatenate([pose.moved(SOON_SWEPT), turned.moved(SOON_SWEPT)])

    def _taken(self, points: FloatArray) -> BoolArray:
        """(n,) which of points (n, 2) of the map frame lie on occupied cells."""
        taken = np.zeros(len(points), bool)
        if self.map is not None and len(points):
            row, column = self.map.cells_of(points).T
            inside = (row >= 0) & (row < self.map.rows) & (column >= 0) & (column < self.map.columns)
            taken[inside] = self.map.cells[row[inside], column[inside]] >= OCCUPIED_AT_LEAST
        return taken

    def _note_move(self, observation: Observation, pose: Pose2, v_mps: float, w_radps: float) -> None:
        if abs(v_mps) < 0.02 and abs(w_radps) < 0.1:
            self._moves.clear()
        elif observation.odometry is not None:
            self._moves.append((observation.now_s, observation.odometry.pose, pose))

    def _stuck(self, now_s: float, odometry: Pose2, pose: Pose2) -> str:
        """What has hardly changed though the robot was told to move: wheels that spin go on, its place does not."""
        while self._moves and self._moves[0][0] < now_s - self._settings.stuck_s - LOOP_S:
            self._moves.popleft()
        if not self._moves or now_s - self._moves[0][0] < self._settings.stuck_s - 1e-9:
            return ""
        if self._stays([odometry_then for _, odometry_then, _ in self._moves] + [odometry]):
            return "the odometry"
        return "the place in the map" if self._stays([pose_then for _, _, pose_then in self._moves] + [pose]) else ""

    def _stays(self, poses: List[Pose2]) -> bool:
        first, s = poses[0], self._settings
        return all(
            first.distance(pose) < s.stuck_m and abs(wrap_angle(pose.yaw_rad - first.yaw_rad)) < s.stuck_rad
            for pose in reversed(poses)  # the newest is the likeliest to be away
        )
