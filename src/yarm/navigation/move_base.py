"""Drives a robot to goals over a known map: plans, follows, sees what is in the way, recovers, gives up with a reason.

Pure: :meth:`MoveBase.step` takes what is known at a moment and says what to drive. Time and sensors come in as values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import List, Optional, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2, wrap_angle
from yarm.geometry.scans import Scan
from yarm.navigation.approach import Approach
from yarm.navigation.costmap import Costmap, points_near
from yarm.navigation.follower import Drive, PathFollower, room_ahead
from yarm.navigation.grid_map import GridMap
from yarm.navigation.ground import PlanSettings
from yarm.navigation.move_base_params import BACK_OFF, CLEAR, TURN, MoveBaseParams
from yarm.navigation.overlay import Overlay
from yarm.navigation.path_check import check_path
from yarm.navigation.retreat import RETREAT_M, Retreat, Trail
from yarm.navigation.ways import Way, find_way
from yarm.robots import turtlebot
from yarm.robots.turtlebot import BumperEvent

SLACK_M = 0.015
"""A way that is being driven stays good while it keeps this much less than the disc's radius."""
LAST_M = 0.5
"""So near to the goal a way is planned again only when it is blocked."""
SHORTER_M = 0.15
"""A new way replaces one that is good when it is shorter by this much."""
STRIP_M = turtlebot.RADIUS_M + 0.01
"""Half the width of the strip ahead in which something counts as near."""
TOUCHING_M = turtlebot.RADIUS_M + 0.03
"""Something this near ahead stops the robot."""
TURN_SHARE = 0.8
"""Of the greatest rate, when the robot turns once to look around."""
TURN_S = 30.0
"""A turn that takes longer is given up."""
BACK_MPS, BACK_M = 0.08, 0.12
UNKNOWN_NEAR_M = 1.5
"""Around the robot unknown cells are taken for free on request, metres."""
NEARER_SHARE = 0.5
"""Of the tolerance: a robot farther than this from the end of its way can still get nearer to the goal."""
LOOK_M = 1.0
"""The map is looked at so far around the robot for what is ahead."""


RECOVERED = {CLEAR: "forgot what was seen", BACK_OFF: "backed off", TURN: "turned once"}
"""What was done about a way that could not be driven, in words."""


class Status(Enum):
    """How a goal goes."""

    IDLE = "idle"
    ACTIVE = "active"
    SUCCEEDED = "succeeded"
    ABORTED = "aborted"


@dataclass(frozen=True, eq=False)
class Observation:
    """What is known at a step.

    Attributes:
        now_s: simulated time.
        pose: of the robot's base in the map, at this moment; None when it is not known.
        pose_fault: why not.
        scan: the newest; None when there was none yet.
        scan_pose: of the base in the map when the scan was taken; None when not known.
        map: the known map; None when there was none yet.
        map_count: changes with the map.
        low: (n, 2) low obstacles seen since the last step, base frame, metres; None without a camera.
        bumps: changes of the bumper since the last step.
        odometry: pose of the base in odometry's frame, at the moment of ``pose``; None when it is not known.
    """

    now_s: float
    pose: Optional[Pose2] = None
    pose_fault: str = "no transform"
    scan: Optional[Scan] = None
    scan_pose: Optional[Pose2] = None
    map: Optional[GridMap] = None
    map_count: int = 0
    low: Optional[FloatArray] = None
    bumps: Tuple[BumperEvent, ...] = ()
    odometry: Optional[Pose2] = None


@dataclass(frozen=True)
class Step:
    """What a step came to.

    Attributes:
        status: of the goal; SUCCEEDED and ABORTED are said once.
        drive: speeds to command; None: nothing is to be said.
        reason: why it was aborted; empty otherwise.
        events: what happened, one sentence each.
    """

    status: Status = Status.IDLE
    drive: Optional[Drive] = None
    reason: str = ""
    events: Tuple[str, ...] = ()


@dataclass
class _Attempt:
    """One goal, and how it stands; ``followed`` says whether the follower's path is its own."""

    goal: Pose2
    followed: bool = False
    progress: Optional[Pose2] = None
    progress_s: float = 0.0
    planned_s: float = -math.inf
    planned_version: Tuple[int, int] = (-1, -1)
    no_way_s: Optional[float] = None
    standing_s: Optional[float] = None
    missing_s: Optional[float] = None
    tried: int = 0
    stuck: Optional[Pose2] = None
    done: List[str] = field(default_factory=list)
    retreat: Optional[Retreat] = None
    turned_rad: float = 0.0
    turn_yaw: Optional[float] = None
    turn_s: float = 0.0
    approach: Approach = field(default_factory=Approach)


class MoveBase:
    """One robot and its goal. Not thread-safe."""

    def __init__(self, params: Optional[MoveBaseParams] = None) -> None:
        """Without a map and without a goal."""
        self._params = params or MoveBaseParams()
        self._settings: PlanSettings = self._params.plan_settings()
        self._follower = PathFollower(self._params.follow_settings())
        self._costmap: Optional[Costmap] = None
        self._map_count = -1
        self._overlay = Overlay()
        self._scan_s = -math.inf
        self._grid: Optional[GridMap] = None
        self._grid_version = (-1, -1)
        self._attempt: Optional[_Attempt] = None
        self._way: Way = Way()
        self._backing_m = 0.0
        self._pose: Optional[Pose2] = None
        self._trail = Trail()
        self._events: List[str] = []

    @property
    def grid(self) -> Optional[GridMap]:
        """The map with everything that is in the way; None before there is one."""
        if self._costmap is None:
            return None
        if self._grid is None or self._grid_version != self.version:
            self._grid, self._grid_version = self._overlay.over(self._costmap.grid), self.version
        return self._grid

    @property
    def version(self) -> Tuple[int, int]:
        """Changes whenever the grid does, as long as the map is the same."""
        return (-1 if self._costmap is None else self._costmap.version), self._overlay.count

    @property
    def goal(self) -> Optional[Pose2]:
        """What is driven to; None when idle."""
        return None if self._attempt is None else self._attempt.goal

    @property
    def path(self) -> FloatArray:
        """(n, 2) the way that is followed, map frame, metres; (0, 2) without one."""
        return self._follower.path

    @property
    def ahead(self) -> FloatArray:
        """(n, 2) what of it is still to come."""
        return self._follower.ahead if len(self._follower.path) else self._follower.path

    def go(self, goal: Pose2, now_s: float) -> None:
        """Take a goal, map frame; one that stood before is dropped.

        Raises:
            ValueError: its numbers are not finite.
        """
        if not all(math.isfinite(value) for value in (goal.x, goal.y, goal.yaw_rad)):
            raise ValueError(f"a goal must be finite, not {goal}")
        self._attempt = _Attempt(goal, progress_s=now_s)
        self._way = Way()
        self._backing_m = 0.0

    def cancel(self) -> None:
        """Drop the goal; the next command has to be zero."""
        self._attempt = None
        self._follower.stop()

    def forget(self) -> None:
        """Time went backwards: nothing is known."""
        self.cancel()
        self._costmap, self._grid, self._map_count, self._scan_s = None, None, -1, -math.inf
        self._pose = None
        self._trail = Trail()
        self._overlay = Overlay()

    def clear_costmaps(self) -> None:
        """Forget everything that was seen or touched, but what was seen where the scan is blind now."""
        if self._costmap is not None:
            self._costmap.clear(self._pose)
        fresh = Overlay()
        fresh.count = self._overlay.count + 1
        self._overlay = fresh

    def clear_unknown_space(self, pose: Pose2) -> None:
        """Take unknown cells around a pose of the map for free."""
        if self._costmap is not None:
            self._costmap.clear_unknown(pose, UNKNOWN_NEAR_M)

    def make_plan(self, start: Pose2, goal: Pose2, tolerance_m: float = 0.0) -> Way:
        """The way that would be driven from a start to a goal now; drives nothing."""
        grid = self.grid
        return (
            Way(reason="there is no map yet")
            if grid is None
            else find_way(grid, start, goal, self._settings, tolerance_m)
        )

    def step(self, seen: Observation) -> Step:
        """One step, ``controller_frequency`` times a second."""
        self._events, self._pose = [], seen.pose
        self._sense(seen)
        attempt = self._attempt
        if attempt is None:
            return Step(events=tuple(self._events))
        fault = self._missing(seen)
        if fault:
            return self._wait(seen, attempt, fault)
        assert seen.pose is not None
        attempt.missing_s = None
        if self._backing_m > 0.0:
            return self._back()
        if attempt.retreat is not None:
            return self._retreat(seen, seen.pose, attempt, attempt.retreat)
        self._trail.note(seen.pose)
        if attempt.turn_yaw is not None:
            return self._turn(seen.now_s, seen.pose, attempt)
        return self._drive(seen, attempt.approach.place(seen.pose, seen.odometry), attempt)

    def _sense(self, seen: Observation) -> None:
        if seen.map is None:
            return
        if seen.map_count != self._map_count or self._costmap is None:
            self._costmap = Costmap(seen.map, self._params.costmap_settings())
            self._map_count, self._grid = seen.map_count, None
            self._follower.stop()
            if self._attempt is not None:
                self._attempt.planned_s = -math.inf
                self._attempt.approach.end()
        fresh = seen.scan is not None and seen.scan_pose is not None and seen.scan.stamp_s > self._scan_s
        if fresh:
            assert seen.scan is not None and seen.scan_pose is not None
            self._scan_s = seen.scan.stamp_s
            self._costmap.see(seen.scan_pose, seen.scan)
            if seen.low is not None:
                self._overlay.see(seen.scan_pose, seen.low, seen.scan)
        for bump in seen.bumps:
            if bump.pressed and seen.pose is not None:
                self._bumped(seen.pose, bump)

    def _bumped(self, pose: Pose2, bump: BumperEvent) -> None:
        self._overlay.bump(pose, bump.bumper, self.grid)
        self._events.append(f"bumped, {bump.bumper.name.lower()}, at ({pose.x:.2f}, {pose.y:.2f})")
        if self._attempt is not None:
            self._follower.stop()
            self._attempt.planned_s = -math.inf
            self._backing_m = BACK_M

    def _missing(self, seen: Observation) -> str:
        """What is not there without which nothing may move; empty when all is."""
        if seen.map is None:
            return "there is no map; is a map server or a mapping running?"
        if seen.pose is None:
            return f"the robot's place in the map is not known: {seen.pose_fault}"
        if seen.scan is None:
            return "no scan has come; is the sensor running?"
        age_s = seen.now_s - seen.scan.stamp_s
        if age_s > self._params.scan_timeout:
            return (
                f"the newest scan is {age_s:.2f} s old, at most {self._params.scan_timeout:g} s; is the sensor running?"
            )
        return ""

    def _wait(self, seen: Observation, attempt: _Attempt, fault: str) -> Step:
        """Stand; give up when it takes too long."""
        self._follower.stop()
        attempt.approach.end()
        attempt.planned_s, attempt.progress_s = -math.inf, seen.now_s
        if attempt.missing_s is None:
            attempt.missing_s = seen.now_s
            self._events.append(f"stands: {fault}")
        if seen.now_s - attempt.missing_s >= self._params.sensor_patience:
            return self._abort(f"{fault}; waited {self._params.sensor_patience:g} s")
        return self._stand()

    def _drive(self, seen: Observation, pose: Pose2, attempt: _Attempt) -> Step:
        self._note_progress(seen.now_s, pose, attempt)
        reason = self._plan(seen.now_s, pose, attempt)
        if reason:
            return self._without_way(seen.now_s, attempt, reason, pose)
        attempt.no_way_s = None
        if seen.now_s - attempt.progress_s > self._params.oscillation_timeout:
            less = f"moved less than {self._params.oscillation_distance:g} m"
            return self._recover(seen.now_s, pose, attempt, f"{less} in {self._params.oscillation_timeout:g} s")
        ahead_m = self._ahead(seen, pose)
        if ahead_m < TOUCHING_M and self._is_near_enough(seen, attempt):
            return self._turn_on_the_spot(pose, attempt)
        cap = 0.0 if ahead_m < TOUCHING_M else None
        sees = None if self._way.field is None else self._way.field.sees
        drive = self._follower.step(pose, ahead_m, sees, cap)
        if drive.arrived:
            return self._arrived(seen, attempt)
        if abs(drive.v_mps) > 0.01 or abs(drive.w_radps) > 0.05:
            attempt.standing_s = None
        elif attempt.standing_s is None:
            attempt.standing_s = seen.now_s
        elif seen.now_s - attempt.standing_s >= self._params.controller_patience:
            return self._recover(seen.now_s, pose, attempt, f"something stands {ahead_m:.2f} m ahead")
        return Step(Status.ACTIVE, drive, events=tuple(self._events))

    def _note_progress(self, now_s: float, pose: Pose2, attempt: _Attempt) -> None:
        if attempt.progress is None:
            attempt.progress, attempt.progress_s = pose, now_s
        elif attempt.progress.distance(pose) >= self._params.oscillation_distance:
            attempt.progress, attempt.progress_s = pose, now_s
            if attempt.stuck is None or attempt.stuck.distance(pose) >= self._params.oscillation_distance + RETREAT_M:
                attempt.tried, attempt.done = 0, []

    def _plan(self, now_s: float, pose: Pose2, attempt: _Attempt) -> str:
        """Keep the way, or find another when it is time or the way is blocked; why there is none, or empty."""
        grid = self.grid
        assert grid is not None
        blocked = not self._good(grid, pose, attempt)
        period_s = 1.0 / self._params.planner_frequency if self._params.planner_frequency > 0.0 else math.inf
        due = now_s - attempt.planned_s >= period_s - 1e-6 and pose.distance(attempt.goal) > LAST_M
        if not blocked and not due:
            return ""
        if blocked and attempt.no_way_s is not None and now_s - attempt.planned_s < min(period_s, 1.0) - 1e-6:
            return self._way.reason
        attempt.planned_s = now_s
        attempt.planned_version = self.version
        way = find_way(grid, pose, attempt.goal, self._settings)
        if way.reason:
            if not blocked:
                return ""
            self._way = way
            self._follower.stop()
            return way.reason
        if blocked or way.length_m < self._left_m(pose) - SHORTER_M:
            self._way, attempt.followed = way, True
            self._follower.follow(way.path, attempt.goal.yaw_rad)
        return ""

    def _good(self, grid: GridMap, pose: Pose2, attempt: _Attempt) -> bool:
        """Whether what is left of the way can be driven."""
        if len(self._follower.path) == 0 or not attempt.followed:
            return False
        if self.version == attempt.planned_version:
            return True
        attempt.planned_version = self.version
        return check_path(grid, self._left(pose), self._params.robot_radius - SLACK_M).clear

    def _left(self, pose: Pose2) -> FloatArray:
        return np.concatenate([np.array([[pose.x, pose.y]]), self._follower.ahead])

    def _left_m(self, pose: Pose2) -> float:
        return float(np.hypot(*np.diff(self._left(pose), axis=0).T).sum())

    def _without_way(self, now_s: float, attempt: _Attempt, reason: str, pose: Pose2) -> Step:
        if attempt.no_way_s is None:
            attempt.no_way_s = now_s
            self._events.append(f"no way: {reason}")
            hopeless = self._hopeless(pose, attempt)
            if hopeless:
                return self._abort(hopeless)
        if now_s - attempt.no_way_s >= self._params.planner_patience:
            return self._recover(now_s, pose, attempt, reason)
        return self._stand()

    def _hopeless(self, pose: Pose2, attempt: _Attempt) -> str:
        """Why even the map alone, without anything that was seen, allows no way; empty when it does."""
        assert self._costmap is not None
        return find_way(self._costmap.static, pose, attempt.goal, self._settings).reason

    def _recover(self, now_s: float, pose: Pose2, attempt: _Attempt, reason: str) -> Step:
        """The next recovery, or the end."""
        way = self._trail.back()
        kinds = [kind for kind in self._params.recoveries()[attempt.tried :] if kind != BACK_OFF or len(way) > 1]
        if not kinds:
            before = ", ".join(attempt.done)
            return self._abort(f"{reason}; {before} before" if before else reason)
        kind = kinds[0]
        attempt.tried = self._params.recoveries().index(kind, attempt.tried) + 1
        attempt.done.append(RECOVERED[kind])
        self._events.append(f"recovers ({RECOVERED[kind]}): {reason}")
        self._follower.stop()
        attempt.approach.end()
        self.clear_costmaps()
        attempt.planned_s, attempt.no_way_s, attempt.standing_s = -math.inf, None, None
        attempt.progress, attempt.progress_s, attempt.stuck = pose, now_s, pose
        if kind == TURN:
            attempt.turn_yaw, attempt.turned_rad, attempt.turn_s = pose.yaw_rad, 0.0, now_s
        elif kind == BACK_OFF:
            attempt.retreat = Retreat(way, now_s)
        return self._stand()

    def _retreat(self, seen: Observation, pose: Pose2, attempt: _Attempt, retreat: Retreat) -> Step:
        """Back along the way it came, as long as nothing stands on it."""
        grid = self.grid
        assert grid is not None
        before = len(retreat.way)
        drive = retreat.step(pose, seen.now_s)
        self._trail.cut(before - len(retreat.way))
        left = np.concatenate([np.array([[pose.x, pose.y]]), retreat.way])
        clear = check_path(grid, left, self._params.robot_radius - SLACK_M).clear
        if drive is None or not clear or (drive.v_mps > 0.0 and self._ahead(seen, pose) < TOUCHING_M):
            attempt.retreat, attempt.progress, attempt.progress_s = None, pose, seen.now_s
            return self._stand()
        return Step(Status.ACTIVE, drive, events=tuple(self._events))

    def _turn(self, now_s: float, pose: Pose2, attempt: _Attempt) -> Step:
        """Once round in place."""
        assert attempt.turn_yaw is not None
        attempt.turned_rad += wrap_angle(pose.yaw_rad - attempt.turn_yaw)
        attempt.turn_yaw = pose.yaw_rad
        if attempt.turned_rad >= 2.0 * math.pi or now_s - attempt.turn_s > TURN_S:
            attempt.turn_yaw, attempt.progress_s = None, now_s
            return self._stand()
        drive = Drive(0.0, TURN_SHARE * self._params.max_vel_theta)
        return Step(Status.ACTIVE, drive, events=tuple(self._events))

    def _back(self) -> Step:
        """Straight back from what was touched."""
        self._backing_m -= BACK_MPS * self._params.period_s
        return Step(Status.ACTIVE, Drive(-BACK_MPS, 0.0), events=tuple(self._events))

    def _arrived(self, seen: Observation, attempt: _Attempt) -> Step:
        """At the end of the way: the goal, or the middle of its cell when the goal itself is too near to something."""
        assert seen.pose is not None
        p = self._params
        away = seen.pose.distance(attempt.goal)
        turned = abs(wrap_angle(attempt.goal.yaw_rad - seen.pose.yaw_rad))
        if away <= p.xy_goal_tolerance and turned <= p.yaw_goal_tolerance:
            self.cancel()
            return Step(Status.SUCCEEDED, Drive(arrived=True), events=tuple(self._events))
        if away <= p.xy_goal_tolerance:
            return self._turn_on_the_spot(seen.pose, attempt)
        if self._nearer_is_possible(seen.pose) and attempt.approach.begin(seen.pose, seen.odometry):
            self._events.append(f"{away:.3f} m off at the goal's heading: drives that by odometry")
            self._follower.stop()
            attempt.planned_s, attempt.progress_s = -math.inf, seen.now_s
            return self._stand()
        return self._abort(f"the way ended {away:.2f} m from the goal, the tolerance is {p.xy_goal_tolerance:g} m")

    def _is_near_enough(self, seen: Observation, attempt: _Attempt) -> bool:
        """Whether the robot drives within the tolerance of the goal, where it may end as well as nearer to it."""
        assert seen.pose is not None
        driving = len(self._follower.path) > 1
        return driving and seen.pose.distance(attempt.goal) <= self._params.xy_goal_tolerance

    def _turn_on_the_spot(self, pose: Pose2, attempt: _Attempt) -> Step:
        """Near enough, but odometry's heading is not the believed one: that is turned to now."""
        attempt.approach.end()
        self._follower.follow(np.array([[pose.x, pose.y]]), attempt.goal.yaw_rad)
        return self._stand()

    def _nearer_is_possible(self, pose: Pose2) -> bool:
        """Whether what is missing is missing up to the way's end, not from there to the goal."""
        end = self._way.path[-1]
        return math.hypot(end[0] - pose.x, end[1] - pose.y) > NEARER_SHARE * self._params.xy_goal_tolerance

    def _ahead(self, seen: Observation, pose: Pose2) -> float:
        """Free way ahead by the map with its marks and by what is sensed at this moment, metres."""
        grid = self.grid
        assert grid is not None and seen.scan is not None
        found = [points_near(grid, pose, LOOK_M), seen.scan.points()]
        if seen.low is not None:
            found.append(seen.low)
        return room_ahead(np.concatenate(found), STRIP_M)

    def _stand(self) -> Step:
        return Step(Status.ACTIVE, Drive(), events=tuple(self._events))

    def _abort(self, reason: str) -> Step:
        self.cancel()
        self._events.append(f"gave up: {reason}")
        return Step(Status.ABORTED, Drive(), reason, tuple(self._events))
