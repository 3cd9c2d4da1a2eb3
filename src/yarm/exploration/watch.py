"""Whether the sensors can be trusted: which is sick, since when, and what to do; the robot stands meanwhile.

Each check looks at one input and says what is wrong with it now. What is young is not yet missing: a robot that has
just been started waits without a complaint for ``PATIENCE_S``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Dict, List, Optional, Protocol, Set, Tuple

import numpy as np

from yarm.exploration.model import Command, Observation
from yarm.geometry import Pose2
from yarm.geometry.poses import wrap_angle
from yarm.geometry.scans import Odometry, RangeArray, Scan
from yarm.robots.turtlebot import SPEED_LIMIT_MPS, Bumper, BumperEvent

AGE_S = 0.3
"""A scan or an odometry older than this is missing: with a pass of the loop the robot is told to stand in 0.4 s."""
PATIENCE_S = 5.0
FROZEN_S = 0.35
"""Odometry that is the same to the last bit for so long, while the robot is told to move, is frozen."""
FROZEN_HOLD_S = 2.0
"""After so long it is tried again whether frozen odometry moves: nothing but moving can show it."""
TOLD_MPS, TOLD_RADPS = 0.02, 0.1
"""A command above one of these moves the robot."""
FROZEN_WAY_M, FROZEN_TURN_RAD = 0.05, 0.1
"""A scan that is the same to the last bit over such a motion is frozen."""
BLIND_WAY_M, BLIND_TURN_RAD = 1.0, math.pi
"""A scan without a single range over such a way, or such a turn, sees nothing: before a wall it would have by now."""
JUMP_M, JUMP_RAD = 0.2, 0.35
"""A pose that changes by more between two passes, beyond what the robot can drive, has jumped."""
JUMP_HOLD_S = 0.5
STUCK_BUMPER_S, STUCK_BUMPER_WAY_M = 10.0, 0.3
"""A sector that stays pressed for so long and over such a way is stuck."""


@dataclass(frozen=True)
class Complaint:
    """One input that cannot be trusted.

    Attributes:
        sensor: scan, odometry, pose, map or bumper.
        since_s: when it began, on the observation's clock.
        what: what is wrong, a clause.
        remedy: what to do.
        stands: the robot stands meanwhile.
    """

    sensor: str
    since_s: float
    what: str
    remedy: str
    stands: bool = True

    @property
    def text(self) -> str:
        """One sentence for people."""
        return f"{self.sensor}: {self.what} since {self.since_s:.1f} s; {self.remedy}"


@dataclass(frozen=True)
class _Fault:
    what: str
    remedy: str
    since_s: Optional[float] = None
    stands: bool = True


class _Check(Protocol):
    sensor: str

    def look(self, seen: Observation, told: Command) -> Optional[_Fault]: ...


class SensorWatch:
    """All checks; pure, one pass of the loop after the other."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self._since_s: Dict[str, float] = {}
        self._pose = _PoseCheck()
        self._bumper = _BumperCheck()
        self._checks: Tuple[_Check, ...] = (_ScanCheck(), _OdometryCheck(), self._pose, self._bumper)

    def step(self, seen: Observation, told: Command) -> Tuple[Complaint, ...]:
        """What is wrong at this pass.

        Args:
            seen: all that is known.
            told: what the base was told at the last pass.
        """
        found: List[Complaint] = []
        for check in self._checks:
            fault = check.look(seen, told)
            if fault is None:
                self._since_s.pop(check.sensor, None)
                continue
            began_s = self._since_s.setdefault(check.sensor, seen.now_s)
            since_s = began_s if fault.since_s is None else fault.since_s
            found.append(Complaint(check.sensor, since_s, fault.what, fault.remedy, fault.stands))
        return tuple(found)

    def take_jump(self) -> bool:
        """Whether the pose has jumped since the last call: whatever was planned before is void."""
        return self._pose.take_jump()

    def bumps(self, events: Tuple[BumperEvent, ...]) -> Tuple[BumperEvent, ...]:
        """The bumper's changes as they can be believed: a sector that is stuck counts as let go."""
        return self._bumper.believed(events)


class _ScanCheck:
    sensor = "scan"
    _remedy = "look at the camera and its driver; goes on by itself when scans come"

    def __init__(self) -> None:
        self._ranges: Optional[RangeArray] = None
        self._changed_at: Optional[Pose2] = None
        self._changed_s = 0.0
        self._frozen = False
        self._here: Optional[Pose2] = None
        self._seen_s, self._way_m, self._turned_rad = 0.0, 0.0, 0.0

    def look(self, seen: Observation, told: Command) -> Optional[_Fault]:
        scan, now_s = seen.scan, seen.now_s
        if scan is None:
            return _missing("no scan has come yet", self._remedy, now_s)
        if now_s - scan.stamp_s > AGE_S:
            return _Fault(f"none newer than {now_s - scan.stamp_s:.1f} s", self._remedy, scan.stamp_s)
        if len(scan.ranges) == 0:
            return _Fault("it has no beams", self._remedy)
        if self._is_frozen(scan, seen):
            return _Fault("it does not change though the robot moves", self._remedy, self._changed_s)
        if self._is_blind(scan, seen):
            return _Fault("no beam has a range though the robot moves", self._remedy, self._seen_s)
        return None

    def _is_blind(self, scan: Scan, seen: Observation) -> bool:
        before, self._here = self._here, None if seen.odometry is None else seen.odometry.pose
        if np.any(scan.valid()):
            self._seen_s, self._way_m, self._turned_rad = seen.now_s, 0.0, 0.0
        elif before is not None and self._here is not None:
            self._way_m += before.distance(self._here)
            self._turned_rad += abs(wrap_angle(self._here.yaw_rad - before.yaw_rad))
        return self._way_m > BLIND_WAY_M or self._turned_rad > BLIND_TURN_RAD

    def _is_frozen(self, scan: Scan, seen: Observation) -> bool:
        here = None if seen.odometry is None else seen.odometry.pose
        ranges, before, self._ranges = scan.ranges, self._ranges, scan.ranges
        changed = before is None or len(before) != len(ranges) or not np.array_equal(before, ranges, equal_nan=True)
        if changed or self._changed_at is None or not np.any(scan.valid()):
            self._changed_at, self._changed_s, self._frozen = here, seen.now_s, False
        elif here is not None and not self._frozen:
            way_m = self._changed_at.distance(here)
            turn_rad = abs(wrap_angle(here.yaw_rad - self._changed_at.yaw_rad))
            self._frozen = way_m > FROZEN_WAY_M or turn_rad > FROZEN_TURN_RAD
        return self._frozen


class _OdometryCheck:
    sensor = "odometry"
    _remedy = "look at the base and its driver; goes on by itself when it comes"

    def __init__(self) -> None:
        self._last: Optional[Odometry] = None
        self._moved_s = -math.inf
        self._frozen_s: Optional[float] = None
        self._jumped_s = -math.inf
        self._jump_m = 0.0

    def look(self, seen: Observation, told: Command) -> Optional[_Fault]:
        odometry, now_s = seen.odometry, seen.now_s
        if odometry is None:
            return _missing("none has come yet", self._remedy, now_s)
        if now_s - odometry.stamp_s > AGE_S:
            return _Fault(f"none newer than {now_s - odometry.stamp_s:.1f} s", self._remedy, odometry.stamp_s)
        pose = odometry.pose
        if not all(math.isfinite(value) for value in (pose.x, pose.y, pose.yaw_rad)):
            return _Fault(f"its pose is no number: {pose}", self._remedy)
        self._compare(odometry, told, now_s)
        if self._frozen_s is not None:
            tried_s = self._frozen_s + FROZEN_HOLD_S
            return _Fault(
                f"it does not change though the robot was told to move, tried again at {tried_s:.1f} s",
                "look at the wheels, and at what the robot pushes against",
                self._moved_s,
            )
        if now_s - self._jumped_s < JUMP_HOLD_S:
            return _Fault(f"it jumped by {self._jump_m:.2f} m", "look at the base's driver", self._jumped_s)
        return None

    def _compare(self, odometry: Odometry, told: Command, now_s: float) -> None:
        before, self._last = self._last, odometry
        if before is None or before.stamp_s > odometry.stamp_s:
            self._moved_s, self._frozen_s = now_s, None
            return
        step_m = before.pose.distance(odometry.pose)
        if step_m > JUMP_M + SPEED_LIMIT_MPS * (odometry.stamp_s - before.stamp_s):
            self._jumped_s, self._jump_m = now_s, step_m
        still = before.pose == odometry.pose and (abs(told.v_mps) > TOLD_MPS or abs(told.w_radps) > TOLD_RADPS)
        if self._frozen_s is not None and (now_s - self._frozen_s >= FROZEN_HOLD_S or before.pose != odometry.pose):
            self._moved_s, self._frozen_s = now_s, None
        elif not still and self._frozen_s is None:
            self._moved_s = now_s
        elif self._frozen_s is None and now_s - self._moved_s >= FROZEN_S:
            self._frozen_s = now_s


class _PoseCheck:
    """Of the robot in the map, from the mapping (SLAM)."""

    sensor = "pose"
    _remedy = "look at the mapping node; goes on by itself when it says where the robot is"

    def __init__(self) -> None:
        self._last: Optional[Pose2] = None
        self._jumped_s = -math.inf
        self._jump_m = 0.0
        self._new_jump = False

    def look(self, seen: Observation, told: Command) -> Optional[_Fault]:
        if seen.map_from_odom is None:
            never = "not known yet" if self._last is None else "lost: no transform map -> odom"
            return _missing(never, self._remedy, seen.now_s) if self._last is None else _Fault(never, self._remedy)
        if seen.odometry is not None and self._last is not None:
            here, there = self._last.compose(seen.odometry.pose), seen.map_from_odom.compose(seen.odometry.pose)
            jump_m = here.distance(there)
            if jump_m > JUMP_M or abs(wrap_angle(here.yaw_rad - there.yaw_rad)) > JUMP_RAD:
                self._jumped_s, self._jump_m, self._new_jump = seen.now_s, jump_m, True
        self._last = seen.map_from_odom
        if seen.map is None:
            return _missing("there is no map yet", self._remedy, seen.now_s)
        if seen.now_s - self._jumped_s < JUMP_HOLD_S:
            return _Fault(f"it jumped by {self._jump_m:.2f} m", "plans afresh; look at the mapping", self._jumped_s)
        return None

    def take_jump(self) -> bool:
        jumped, self._new_jump = self._new_jump, False
        return jumped


class _BumperCheck:
    sensor = "bumper"

    def __init__(self) -> None:
        self._pressed: Dict[Bumper, Tuple[float, float]] = {}
        self._stuck: Set[Bumper] = set()
        self._fresh: List[BumperEvent] = []
        self._way_m = 0.0
        self._here: Optional[Pose2] = None

    def look(self, seen: Observation, told: Command) -> Optional[_Fault]:
        self._travel(seen)
        for event in seen.bumps:
            if event.pressed:
                self._pressed.setdefault(event.bumper, (seen.now_s, self._way_m))
            else:
                self._pressed.pop(event.bumper, None)
        for bumper, (since_s, way_m) in self._pressed.items():
            long_s = seen.now_s - since_s > STUCK_BUMPER_S
            if bumper not in self._stuck and long_s and self._way_m - way_m > STUCK_BUMPER_WAY_M:
                self._stuck.add(bumper)
                self._fresh.append(BumperEvent(bumper, False))
        stuck = sorted(bumper for bumper in self._stuck if bumper in self._pressed)
        if not stuck:
            return None
        which = ", ".join(Bumper(bumper).name for bumper in stuck)
        since_s = min(self._pressed[bumper][0] for bumper in stuck)
        what = f"{which} pressed though the robot drives"
        return _Fault(what, "not counted until let go; free the bumper", since_s, stands=False)

    def believed(self, events: Tuple[BumperEvent, ...]) -> Tuple[BumperEvent, ...]:
        kept = tuple(event for event in events if event.bumper not in self._stuck)
        self._stuck -= {event.bumper for event in events if not event.pressed}
        fresh, self._fresh = tuple(self._fresh), []
        return kept + fresh

    def _travel(self, seen: Observation) -> None:
        if seen.odometry is not None:
            here = seen.odometry.pose
            self._way_m += 0.0 if self._here is None else here.distance(self._here)
            self._here = here


def _missing(what: str, remedy: str, now_s: float) -> _Fault:
    """Something that has never come: at first it is only waited for."""
    return _Fault(what, remedy if now_s > PATIENCE_S else "waits for it", 0.0)
