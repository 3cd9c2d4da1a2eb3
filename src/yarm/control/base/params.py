"""Parameters of the mobile base's controller."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.params import param
from yarm.robots.ankurbot import ARM_REACH_M, BODY_RADIUS_M


@dataclass(frozen=True)
class BaseParams:
    """Speeds, limits and tolerances of the mobile base; the tables are capped by ``cap_mps``."""

    translation_limits_m: Tuple[float, ...] = param((3.0, 0.5), "m", "bands of the translation table, falling", 0.0)
    translation_speeds_mps: Tuple[float, ...] = param((5.0, 1.0, 0.5), "m/s", "speed in each band", 0.01, 10.0)
    rotation_limits_deg: Tuple[float, ...] = param((30.0, 2.0), "deg", "bands of the rotation table, falling", 0.0)
    rotation_speeds_radps: Tuple[float, ...] = param((2.0, 1.0), "rad/s", "speed in each band but the last", 0.01, 10.0)
    rotation_gain: float = param(0.5, "1/s", "yaw rate over angle left in the last band", 0.05, 5.0)
    cap_mps: float = param(1.0, "m/s", "largest speed of the fastest point of a robot", 0.05, 5.0)
    acceleration_mps2: float = param(1.0, "m/s^2", "speeding up, fastest point", 0.1, 5.0)
    deceleration_mps2: float = param(1.5, "m/s^2", "slowing down, fastest point", 0.1, 5.0)
    delay_s: float = param(0.1, "s", "time from a pose to the wheels' answer, foreseen when stopping", 0.0, 0.5)
    reach_m: float = param(ARM_REACH_M, "m", "end effector ahead of the body's centre", 0.2, 3.0)
    body_radius_m: float = param(BODY_RADIUS_M, "m", "radius of the body", 0.1, 1.0)
    position_tolerance_m: float = param(0.03, "m", "a pose goal is reached within this distance", 0.005, 0.2)
    yaw_tolerance_deg: float = param(1.0, "deg", "a pose goal is reached within this angle", 0.1, 10.0)
    caster_tolerance_deg: float = param(3.0, "deg", "the base drives only with every caster this near", 0.5, 15.0)
    cross_track_gain: float = param(2.0, "rad/m", "re-steering over distance from the line", 0.0, 10.0)
    cross_track_limit_deg: float = param(12.0, "deg", "largest re-steering", 0.0, 45.0)
    steering_rate_radps: float = param(0.5, "rad/s", "re-steering speed while driving", 0.05, 5.0)
    corner_m: float = param(0.03, "m", "a corner that is driven round is passed within this distance", 0.005, 0.1)
    corner_rate_radps: float = param(1.5, "rad/s", "re-steering speed round a corner", 0.05, 5.0)
    yaw_drift_deg: float = param(3.0, "deg", "translation stops for a turn beyond this yaw error", 1.0, 20.0)
    stuck_s: float = param(10.0, "s", "a robot that has not moved for so long gives up", 1.0, 120.0)
    attempts: int = param(5, "", "translations and turns tried before a goal is given up", 1, 50)
