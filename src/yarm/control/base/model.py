"""A kinematic stand-in for the base: casters turn at a limited rate, speeds follow commands with a lag and a limit."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import List, Tuple

from yarm.control.base.controller import BaseCommand
from yarm.control.base.kinematics import Casters, body_velocity, full_turn
from yarm.geometry.poses import Pose2
from yarm.robots.ankurbot import ARM_REACH_M


@dataclass
class BaseModel:
    """A base without inertia but with delays; the pose is the end effector's.

    Attributes:
        pose: of the end effector, world.
        casters: caster angles, rad, body frame.
        reach_m: end effector ahead of the body's centre.
        caster_rate_radps: speed of the casters.
        delay_steps: steps until a command takes effect.
        braking_mps2: most change of speed per second, of drive speed and (over the reach) of yaw rate.
        slip: share of the commanded speed that is lost.
    """

    pose: Pose2
    casters: Casters = (0.0, 0.0, 0.0, 0.0)
    reach_m: float = ARM_REACH_M
    caster_rate_radps: float = 4.0
    delay_steps: int = 3
    braking_mps2: float = 4.0
    slip: float = 0.0
    stamp_s: float = 0.0
    _queue: List[BaseCommand] = field(default_factory=list)
    _drive: float = 0.0
    _yaw_rate: float = 0.0

    def step(self, command: BaseCommand, dt_s: float) -> None:
        """Move on by one step with a command given now."""
        self._queue.append(command)
        applied = self._queue.pop(0) if len(self._queue) > self.delay_steps else BaseCommand()
        if applied.casters is not None:
            self._turn_casters(applied.casters, dt_s)
        step = self.braking_mps2 * dt_s
        self._drive += max(-step, min(step, applied.drive_mps - self._drive))
        self._yaw_rate += max(-step / self.reach_m, min(step / self.reach_m, applied.yaw_rate_radps - self._yaw_rate))
        if self._drive != 0.0 or self._yaw_rate != 0.0:
            vx, vy, yaw_rate = self.velocity()
            self.pose = self._moved(vx * dt_s, vy * dt_s, yaw_rate * dt_s)
        self.stamp_s += dt_s

    def velocity(self) -> Tuple[float, float, float]:
        """Velocity of the body's centre, body frame, m/s, and yaw rate, rad/s."""
        keep = 1.0 - self.slip
        vx, vy, yaw_rate = body_velocity(self.casters, self._drive * keep, self._yaw_rate * keep)
        return vx, vy, yaw_rate

    def _turn_casters(self, wanted: Casters, dt_s: float) -> None:
        step = self.caster_rate_radps * dt_s
        moved = [a + max(-step, min(step, w - a)) for a, w in zip(self.casters, wanted)]
        self.casters = (moved[0], moved[1], moved[2], moved[3])

    def _moved(self, dx: float, dy: float, turn: float) -> Pose2:
        body = self.pose.compose(Pose2(-self.reach_m, 0.0))
        middle = Pose2(body.x, body.y, body.yaw_rad + turn / 2.0)
        moved = middle.compose(Pose2(dx, dy))
        return Pose2(moved.x, moved.y, full_turn(body.yaw_rad + turn)).compose(Pose2(self.reach_m, 0.0))


def path_deviation(start: Pose2, target: Pose2, pose: Pose2) -> float:
    """Distance of a pose from the straight line between two others, metres."""
    length = start.distance(target)
    if length < 1e-9:
        return start.distance(pose)
    cross = (target.x - start.x) * (pose.y - start.y) - (target.y - start.y) * (pose.x - start.x)
    return abs(cross) / length if math.isfinite(cross) else math.inf
