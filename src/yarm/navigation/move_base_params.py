"""Parameters of driving to goals, by the names and with the values of the platform's own navigation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.navigation.costmap import CostmapSettings
from yarm.navigation.follower import FollowSettings
from yarm.navigation.ground import PlanSettings
from yarm.params import param

NEAR_SHARE = 0.5
"""What is near ahead is passed at this share of the greatest speed."""
CLEAR, BACK_OFF, TURN = "clear", "back_off", "turn"
"""Recovery behaviours."""
ARRIVE_SHARE = 0.25
"""Of the tolerance: the follower ends up to twice this from the end of the way."""


@dataclass(frozen=True)
class MoveBaseParams:
    """How goals are planned and driven."""

    controller_frequency: float = param(5.0, "Hz", "velocity commands a second", 4.0, 20.0)
    planner_frequency: float = param(1.0, "Hz", "how often the way is planned again; 0: when it is blocked", 0.0, 10.0)
    planner_patience: float = param(5.0, "s", "without a way for so long: recovery", 0.1, 600.0)
    controller_patience: float = param(3.0, "s", "standing on a way for so long: recovery", 0.1, 600.0)
    oscillation_timeout: float = param(10.0, "s", "less than oscillation_distance in so long: recovery", 1.0, 600.0)
    oscillation_distance: float = param(0.2, "m", "what counts as getting on", 0.01, 5.0)
    recovery_behavior_enabled: bool = param(True, "", "recover before giving up")
    recovery_behaviors: Tuple[str, ...] = param(
        (CLEAR, BACK_OFF, TURN),
        "",
        "one after the other until one helps, each after forgetting what was seen: nothing more, back along the way it "
        "came, once round",
        choices=(CLEAR, BACK_OFF, TURN),
    )
    clearing_rotation_allowed: bool = param(True, "", "turning once is among the recoveries")
    sensor_patience: float = param(
        5.0, "s", "without scan, transform or map for so long: the goal is given up", 0.5, 600
    )
    scan_timeout: float = param(0.25, "s", "an older scan counts as none: the robot stands", 0.05, 0.25)
    robot_radius: float = param(0.20, "m", "of the disc that is kept clear", 0.05, 1.0)
    inflation_radius: float = param(0.50, "m", "nearer than this to something a way costs more", 0.05, 5.0)
    cost_scaling_factor: float = param(5.0, "1/m", "how fast that cost falls beyond the robot's radius", 0.1, 100.0)
    obstacle_range: float = param(2.5, "m", "what the scan sees farther away is not marked", 0.5, 10.0)
    raytrace_range: float = param(3.0, "m", "marks farther away are not cleared", 0.5, 10.0)
    max_vel_x: float = param(0.3, "m/s", "greatest speed", 0.05, 0.65)
    max_vel_theta: float = param(1.0, "rad/s", "greatest rate of turning", 0.2, 3.0)
    xy_goal_tolerance: float = param(0.15, "m", "a goal is reached within this", 0.02, 1.0)
    yaw_goal_tolerance: float = param(0.3, "rad", "its heading is reached within this", 0.02, 3.2)

    @property
    def period_s(self) -> float:
        """Between two commands."""
        return 1.0 / self.controller_frequency

    def recoveries(self) -> Tuple[str, ...]:
        """The recovery behaviours that are allowed, in their order."""
        allowed = self.recovery_behaviors if self.recovery_behavior_enabled else ()
        return tuple(kind for kind in allowed if kind != TURN or self.clearing_rotation_allowed)

    def plan_settings(self) -> PlanSettings:
        """For the planner."""
        comfort = max(self.inflation_radius, self.robot_radius + 0.01)
        return PlanSettings(radius_m=self.robot_radius, comfort_m=comfort, decay_per_m=self.cost_scaling_factor)

    def follow_settings(self) -> FollowSettings:
        """For the follower."""
        return FollowSettings(
            max_speed_mps=self.max_vel_x,
            near_speed_mps=NEAR_SHARE * self.max_vel_x,
            turn_radps=self.max_vel_theta,
            arrive_m=ARRIVE_SHARE * self.xy_goal_tolerance,
            arrive_rad=self.yaw_goal_tolerance,
            tick_s=self.period_s,
        )

    def costmap_settings(self) -> CostmapSettings:
        """For what the scan marks."""
        return CostmapSettings(self.obstacle_range, self.raytrace_range)
