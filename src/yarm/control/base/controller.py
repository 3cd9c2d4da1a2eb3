"""Motion of the mobile robot to a pose: turn, translate, turn again; one call of ``step`` per new pose.

The pose is the end effector's in the world frame. The controller owns no clock and no threads.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import Callable, Deque, List, Optional, Sequence, Tuple

from yarm.control.base.corners import Corner, corners_ahead, speed_for
from yarm.control.base.kinematics import BODY_CENTRE, Casters, driving_casters, full_turn, half_turn, turning_casters
from yarm.control.base.params import BaseParams
from yarm.control.base.speed_profile import slew, stopping_speed, table_speed
from yarm.geometry.poses import Pose2

REST_SPEED_MPS = 0.01
REST_YAW_RATE_RADPS = 0.01
VELOCITY_WINDOW_S = 0.06
SETTLE_S = 0.1
SAME_PLACE_M = 1e-3
SAME_YAW_RAD = 1e-3
ROUNDING_LAG_S = 0.15
"""Time by which casters lag behind their commands round a corner, at most."""


class Stage(Enum):
    """What the robot is doing."""

    IDLE = "idle"
    FIRST_TURN = "first turn"
    TRANSLATION = "translation"
    LAST_TURN = "last turn"


class Outcome(Enum):
    """How a motion stands."""

    ACTIVE = "ACTIVE"
    SUCCEEDED = "SUCCEEDED"
    ABORTED = "ABORTED"
    PREEMPTED = "PREEMPTED"


@dataclass(frozen=True)
class BaseGoal:
    """Where to.

    Attributes:
        target: pose wanted of the end effector, world.
        about_body: turn about the body's centre.
        tolerance_m: how near, metres; None: by the params.
        via: where to go by, at the target's heading, without stopping at corners that can be driven round.
    """

    target: Pose2
    about_body: bool = False
    tolerance_m: Optional[float] = None
    via: Tuple[Pose2, ...] = ()


@dataclass(frozen=True)
class BaseCommand:
    """What to send to the base.

    Attributes:
        casters: caster angles, rad, body frame; None to leave them as they are.
        drive_mps: drive speed along the wheels' heading, m/s.
        yaw_rate_radps: yaw rate about the centre the casters define, rad/s.
        stage: what the robot is doing.
        outcome: how the motion stands.
        reason: sentence on the outcome; empty while active.
    """

    casters: Optional[Casters] = None
    drive_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    stage: Stage = Stage.IDLE
    outcome: Outcome = Outcome.ACTIVE
    reason: str = ""


@dataclass(frozen=True)
class _Sample:
    stamp_s: float
    pose: Pose2


class BaseController:
    """Drives one robot to one goal at a time."""

    def __init__(self, params: BaseParams) -> None:
        """Controller at rest.

        Args:
            params: speeds, limits, tolerances.
        """
        self._params = params
        self._history: Deque[_Sample] = deque()
        self._goal: Optional[BaseGoal] = None
        self._way: List[Pose2] = []
        self._rounding_mps: Optional[float] = None
        self._stage = Stage.IDLE
        self._casters: Casters = (0.0, 0.0, 0.0, 0.0)
        self._line_start: Optional[Pose2] = None
        self._sign = 1.0
        self._speed = 0.0
        self._attempts = 0
        self._braking_since: Optional[float] = None
        self._moved: Optional[_Sample] = None
        self._moved_casters: Sequence[float] = self._casters

    @property
    def active(self) -> bool:
        """Whether a goal is being pursued."""
        return self._goal is not None

    def continues(self, goal: BaseGoal) -> bool:
        """Whether a goal leads on from the straight way being driven, so that nothing needs to stop for it."""
        return self._left_of(goal) is not None

    def start(self, goal: BaseGoal) -> None:
        """Take a new goal; what was under way is stopped first unless the new goal continues it."""
        left = self._left_of(goal)
        self._goal, self._attempts = goal, 0
        if left is not None:
            self._way = left
            return
        self._way = [*goal.via, goal.target]
        self._moved = None
        self._enter(Stage.FIRST_TURN)

    def stop(self, reason: str, outcome: Outcome = Outcome.PREEMPTED) -> BaseCommand:
        """Give the goal up and stand still at once."""
        return self._finish(outcome, reason)

    def pause(self) -> BaseCommand:
        """Stand still but keep the goal; the next pose goes on from rest, and is not stuck for having stood."""
        self._speed, self._moved = 0.0, None
        return self._command()

    def reset(self) -> None:
        """Forget goal and history (time went backwards)."""
        self._history.clear()
        self._finish(Outcome.PREEMPTED, "")

    def velocity(self) -> Tuple[float, float, float]:
        """Velocity of the end effector (m/s, m/s, world) and yaw rate, rad/s, over the last few poses."""
        if len(self._history) < 2:
            return 0.0, 0.0, 0.0
        first, last = self._history[0], self._history[-1]
        span = last.stamp_s - first.stamp_s
        turn = full_turn(last.pose.yaw_rad - first.pose.yaw_rad)
        return (last.pose.x - first.pose.x) / span, (last.pose.y - first.pose.y) / span, turn / span

    def step(self, pose: Pose2, casters: Sequence[float], stamp_s: float) -> BaseCommand:
        """Command that answers one pose.

        Args:
            pose: of the end effector, world.
            casters: four measured caster angles, rad, body frame.
            stamp_s: time of the pose; must grow from call to call.
        """
        dt_s = self._remember(pose, stamp_s)
        if self._goal is None:
            return BaseCommand()
        if self._stuck(pose, casters, stamp_s):
            return self._finish(Outcome.ABORTED, self._stuck_reason(pose, casters))
        for _ in Stage:
            command = self._act(pose, casters, stamp_s, dt_s)
            if command is not None:
                return command
        return BaseCommand(casters=self._casters, stage=self._stage)

    def _act(self, pose: Pose2, casters: Sequence[float], stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        """Command of the present stage, or None when the next stage has been entered."""
        if self._braking_since is not None:
            return self._brake(pose, stamp_s, dt_s)
        if self._stage is Stage.TRANSLATION:
            return self._translate(pose, casters, stamp_s, dt_s)
        return self._turn(pose, casters, stamp_s, dt_s)

    def _turn(self, pose: Pose2, casters: Sequence[float], stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        assert self._goal is not None
        left = full_turn(self._goal.target.yaw_rad - pose.yaw_rad)
        tolerance = math.radians(self._params.yaw_tolerance_deg)
        if abs(left) <= 0.8 * tolerance or (self._speed != 0.0 and left * self._speed <= 0.0):
            return self._after_turn(pose, stamp_s, dt_s)
        about_body = self._goal.about_body and self._stage is Stage.FIRST_TURN
        self._casters = turning_casters(BODY_CENTRE if about_body else (self._params.reach_m, 0.0))
        if not self._casters_ready(casters, half_turn):
            self._speed = 0.0
            return self._command()
        radius = self._params.reach_m + (0.0 if about_body else self._params.body_radius_m)
        wanted = math.copysign(self._yaw_rate(abs(left), radius), left)
        params = self._params
        self._speed = slew(
            self._speed, wanted, params.acceleration_mps2 / radius, params.deceleration_mps2 / radius, dt_s
        )
        return self._command(yaw_rate_radps=self._speed)

    def _yaw_rate(self, left_rad: float, radius_m: float) -> float:
        params = self._params
        near = params.rotation_gain * left_rad
        table = table_speed(math.degrees(left_rad), params.rotation_limits_deg, (*params.rotation_speeds_radps, near))
        profile = stopping_speed(left_rad, params.deceleration_mps2 / radius_m, params.delay_s)
        return min(table, params.cap_mps / radius_m, profile)

    def _after_turn(self, pose: Pose2, stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        if self._speed != 0.0:
            return self._start_braking(pose, stamp_s, dt_s)
        if self._stage is Stage.FIRST_TURN:
            self._enter(Stage.TRANSLATION)
            return None
        return self._conclude(pose)

    def _left_of(self, goal: BaseGoal) -> Optional[List[Pose2]]:
        """What is left of a goal's way when it goes by where the straight way being driven ends; None when not."""
        if self._stage is not Stage.TRANSLATION or self._line_start is None or self._braking_since is not None:
            return None
        if abs(self._yaw_between(goal.target, self._way[0])) > SAME_YAW_RAD:
            return None
        way = [*goal.via, goal.target]
        met = next((k for k, pose in enumerate(way) if pose.distance(self._way[0]) <= SAME_PLACE_M), None)
        return None if met is None else way[met:]

    def _translate(self, pose: Pose2, casters: Sequence[float], stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        assert self._goal is not None
        params = self._params
        if self._line_start is None:
            if pose.distance(self._way[0]) <= 0.6 * self._tolerance_m:
                self._enter(Stage.LAST_TURN)
                return None
            self._start_line(pose, casters)
        corners = self._round_corners(pose)
        along, across, line_rad = self._on_line(pose)
        if along <= 0.2 * self._tolerance_m or abs(self._yaw_left(pose)) > math.radians(params.yaw_drift_deg):
            if self._speed != 0.0:
                return self._start_braking(pose, stamp_s, dt_s)
            self._enter(Stage.LAST_TURN)
            return None
        turned = self._steer(line_rad - pose.yaw_rad, across, dt_s)
        if turned and self._casters_ready(casters, full_turn):
            self._rounding_mps = None
        lag_rad = 0.0 if self._rounding_mps is None else params.corner_rate_radps * ROUNDING_LAG_S
        if not self._casters_ready(casters, full_turn, lag_rad):
            wanted = 0.0
        else:
            table = table_speed(corners[-1].left_m, params.translation_limits_m, params.translation_speeds_mps)
            round_mps = params.cap_mps if self._rounding_mps is None else self._rounding_mps
            wanted = min(table, params.cap_mps, speed_for(corners, params), round_mps)
        self._speed = slew(self._speed, wanted, params.acceleration_mps2, params.deceleration_mps2, dt_s)
        return self._command(drive_mps=self._sign * self._speed)

    def _round_corners(self, pose: Pose2) -> List[Corner]:
        """The corners ahead; one whose arc begins is behind from now on, and the next line is the one to follow."""
        assert self._line_start is not None
        while True:
            along, _, line_rad = self._on_line(pose)
            caster_rad = self._casters[0] + full_turn(line_rad - pose.yaw_rad - self._heading_of_casters())
            corners = corners_ahead(along, caster_rad, [self._line_start, *self._way], self._params)
            first = corners[0]
            if first.speed_mps <= 0.0:
                return corners
            arc_m = first.before_m * min(1.0, self._speed / first.speed_mps)
            if first.left_m > arc_m + self._speed * self._params.delay_s:
                return corners
            self._line_start = self._way.pop(0)
            self._rounding_mps = first.speed_mps

    def _heading_of_casters(self) -> float:
        """Direction in which the base drives, body frame, rad."""
        return self._casters[0] + (math.pi if self._sign < 0.0 else 0.0)

    def _start_line(self, pose: Pose2, casters: Sequence[float]) -> None:
        self._line_start, self._rounding_mps = pose, None
        direction = math.atan2(self._way[0].y - pose.y, self._way[0].x - pose.x) - pose.yaw_rad
        self._casters, self._sign = driving_casters(direction, casters)

    def _on_line(self, pose: Pose2) -> Tuple[float, float, float]:
        """Distance left along the line, distance from the line (left of it positive), direction of the line, rad."""
        assert self._line_start is not None
        target, start = self._way[0], self._line_start
        line = math.atan2(target.y - start.y, target.x - start.x)
        dx, dy = target.x - pose.x, target.y - pose.y
        return dx * math.cos(line) + dy * math.sin(line), dx * math.sin(line) - dy * math.cos(line), line

    def _steer(self, direction_rad: float, across_m: float, dt_s: float) -> bool:
        """Move the commanded caster angle towards the direction that leads back to the line; whether it is there."""
        params = self._params
        limit = math.radians(params.cross_track_limit_deg)
        wanted = direction_rad - max(-limit, min(limit, params.cross_track_gain * across_m))
        if self._sign < 0.0:
            wanted += math.pi
        change = full_turn(wanted - self._casters[0])
        rate = params.steering_rate_radps if self._rounding_mps is None else params.corner_rate_radps
        step = rate * dt_s
        angle = full_turn(self._casters[0] + max(-step, min(step, change)))
        self._casters = (angle, angle, angle, angle)
        return abs(change) <= step

    def _casters_ready(self, measured: Sequence[float], wrap: Callable[[float], float], lag_rad: float = 0.0) -> bool:
        """Whether all casters are where they are wanted, or lag behind that by no more than an angle."""
        tolerance = math.radians(self._params.caster_tolerance_deg) + lag_rad
        return all(abs(wrap(m - c)) <= tolerance for m, c in zip(measured, self._casters))

    def _start_braking(self, pose: Pose2, stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        self._braking_since = stamp_s
        return self._brake(pose, stamp_s, dt_s)

    def _brake(self, pose: Pose2, stamp_s: float, dt_s: float) -> Optional[BaseCommand]:
        """Stand still for a moment before the stage is judged."""
        assert self._braking_since is not None
        radius = 1.0 if self._stage is Stage.TRANSLATION else self._params.reach_m + self._params.body_radius_m
        self._speed = slew(self._speed, 0.0, 1.0, self._params.deceleration_mps2 / radius, dt_s)
        vx, vy, yaw_rate = self.velocity()
        still = math.hypot(vx, vy) < REST_SPEED_MPS and abs(yaw_rate) < REST_YAW_RATE_RADPS
        if self._speed != 0.0 or not still or stamp_s - self._braking_since < SETTLE_S:
            translating = self._stage is Stage.TRANSLATION
            return self._command(
                drive_mps=self._sign * self._speed if translating else 0.0,
                yaw_rate_radps=0.0 if translating else self._speed,
            )
        self._braking_since = None
        if self._stage is Stage.TRANSLATION:
            self._enter(Stage.LAST_TURN)
        return None

    def _conclude(self, pose: Pose2) -> Optional[BaseCommand]:
        """After the last turn: done, once more, or given up."""
        assert self._goal is not None
        params = self._params
        left, turn = pose.distance(self._way[0]), math.degrees(self._yaw_left(pose))
        if left <= self._tolerance_m and abs(turn) <= params.yaw_tolerance_deg:
            if len(self._way) > 1:
                self._way.pop(0)
                self._attempts = 0
                self._enter(Stage.TRANSLATION)
                return None
            return self._finish(Outcome.SUCCEEDED, f"reached; {left:.3f} m and {turn:.2f} deg left")
        self._attempts += 1
        if self._attempts >= params.attempts:
            return self._finish(
                Outcome.ABORTED,
                f"not reached in {params.attempts} attempts: {left:.3f} m and {turn:.2f} deg left, allowed "
                f"{self._tolerance_m:g} m and {params.yaw_tolerance_deg:g} deg; do the wheels slip?",
            )
        self._enter(Stage.TRANSLATION)
        return None

    @property
    def _tolerance_m(self) -> float:
        wanted = self._goal.tolerance_m if self._goal is not None else None
        return self._params.position_tolerance_m if wanted is None else wanted

    def _yaw_left(self, pose: Pose2) -> float:
        assert self._goal is not None
        return full_turn(self._goal.target.yaw_rad - pose.yaw_rad)

    @staticmethod
    def _yaw_between(one: Pose2, other: Pose2) -> float:
        return full_turn(one.yaw_rad - other.yaw_rad)

    def _enter(self, stage: Stage) -> None:
        self._stage = stage
        self._rounding_mps = None
        self._line_start = None
        self._speed = 0.0
        self._braking_since = None

    def _command(self, drive_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> BaseCommand:
        return BaseCommand(self._casters, drive_mps, yaw_rate_radps, self._stage)

    def _finish(self, outcome: Outcome, reason: str) -> BaseCommand:
        self._goal, self._way = None, []
        self._enter(Stage.IDLE)
        return BaseCommand(outcome=outcome, reason=reason)

    def _remember(self, pose: Pose2, stamp_s: float) -> float:
        """Keep the pose for velocities; time since the last one, s."""
        dt_s = stamp_s - self._history[-1].stamp_s if self._history else 0.0
        if dt_s < 0.0:
            self._history.clear()
            dt_s = 0.0
        if dt_s > 0.0 or not self._history:
            self._history.append(_Sample(stamp_s, pose))
        while len(self._history) > 2 and stamp_s - self._history[0].stamp_s > VELOCITY_WINDOW_S:
            self._history.popleft()
        return min(dt_s, 0.1)

    def _stuck(self, pose: Pose2, casters: Sequence[float], stamp_s: float) -> bool:
        if self._moved is None or (
            pose.distance(self._moved.pose) > 0.005
            or abs(full_turn(pose.yaw_rad - self._moved.pose.yaw_rad)) > math.radians(0.2)
            or any(abs(full_turn(a - b)) > math.radians(1.0) for a, b in zip(casters, self._moved_casters))
        ):
            self._moved, self._moved_casters = _Sample(stamp_s, pose), tuple(casters)
        return stamp_s - self._moved.stamp_s > self._params.stuck_s

    def _stuck_reason(self, pose: Pose2, casters: Sequence[float]) -> str:
        assert self._goal is not None
        wanted = ", ".join(f"{math.degrees(a):.0f}" for a in self._casters)
        measured = ", ".join(f"{math.degrees(a):.0f}" for a in casters)
        return (
            f"has not moved for {self._params.stuck_s:g} s in the {self._stage.value}: "
            f"{pose.distance(self._goal.target):.2f} m and {math.degrees(self._yaw_left(pose)):.1f} deg left; "
            f"casters wanted at ({wanted}) deg, measured ({measured}) deg"
        )
