"""Parameters of the safety monitor."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class SafetyParams:
    """Everything about the safety monitor that can be set."""

    sync: bool = param(False, "", "lock-step: acknowledge every camera set to the simulator")
    rate_hz: float = param(30.0, "Hz", "looks a second of simulated time", 1.0, 60.0)
    stop_clearance_m: float = param(0.03, "m", "less room than this ahead stops a robot", 0.0, 0.5)
    latency_s: float = param(0.2, "s", "time from a pose to the robot braking", 0.0, 2.0)
    deceleration_mps2: float = param(1.5, "m/s^2", "braking of a robot's fastest point", 0.1, 10.0)
    reach_m: float = param(1.65, "m", "fastest point of a robot from its end effector", 0.1, 5.0)
    spacing_m: float = param(0.08, "m", "largest distance of the points a robot's surface is seen as", 0.02, 0.5)
    hold_s: float = param(0.5, "s", "a robot that was stopped is held at least this long", 0.0, 10.0)
    still_mps: float = param(0.03, "m/s", "below this a robot stands still", 0.001, 1.0)
    window_s: float = param(0.06, "s", "motion is measured over this time", 0.01, 1.0)
    stale_s: float = param(0.3, "s", "frames older than this are not used", 0.05, 10.0)
