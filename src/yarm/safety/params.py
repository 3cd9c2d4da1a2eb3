"""Parameters of the safety monitor."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param
from yarm.safety.people import Walking


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
    mover_mps: float = param(
        Walking.slowest_mps, "m/s", "what nobody registered and moves slower counts as standing", 0.05, 2.0
    )
    person_mps: float = param(
        Walking.unwatched_mps,
        "m/s",
        "what nobody registered moves so fast, any way, when it is first seen (ISO 13855)",
        0.0,
        5.0,
    )
    watched_s: float = param(Walking.watched_s, "s", "followed for so long, its measured speed alone counts", 0.0, 10.0)
    stale_s: float = param(0.3, "s", "a robot whose pose on /tf is older is held: it cannot be watched", 0.05, 10.0)


@dataclass(frozen=True)
class GuardParams:
    """Of a node that moves something: who must be heard from meanwhile."""

    guarded: bool = param(
        True, "", "nothing moves unless the safety monitor and the Commander are heard from; false: nobody is needed"
    )
    monitor_age_s: float = param(0.25, "s", "stands while the safety monitor's newest word is older", 0.05, 10.0)
    commander_age_s: float = param(0.6, "s", "stands while the map the Commander last took in is older", 0.05, 10.0)
