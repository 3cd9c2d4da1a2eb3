"""Parameters of the explorer; names and defaults of explore_lite where it has them."""

from __future__ import annotations

from dataclasses import dataclass

from yarm.params import param


@dataclass(frozen=True)
class ExploreParams:
    """What every controller is given; numbers of the report's method are in yarm.exploration.report."""

    controller: str = param("yarm", "", "which controller decides")
    time_limit_s: float = param(900.0, "s", "the robot stands from this long after the start", low=1.0, high=36000.0)
    max_speed: float = param(0.3, "m/s", "greatest speed", low=0.05, high=0.7)
    near_speed: float = param(0.15, "m/s", "greatest speed near walls and obstacles", low=0.02, high=0.7)
    near_distance: float = param(0.7, "m", "what is nearer than this ahead counts as near", low=0.3, high=3.0)
    return_to_start: bool = param(False, "", "come back to where the run began before the time is over")
    planner_frequency: float = param(1.0, "Hz", "how often goals are chosen again", low=0.1, high=10.0)
    progress_timeout: float = param(
        30.0, "s", "explore_lite: a goal without progress for this long is given up", low=1.0, high=600.0
    )
    potential_scale: float = param(1e-3, "1/m", "explore_lite: weight of the distance to a frontier", low=0.0, high=1e3)
    orientation_scale: float = param(
        0.0, "", "accepted as explore_lite has it, without effect there too", low=0.0, high=1e3
    )
    gain_scale: float = param(1.0, "1/m", "explore_lite: weight of a frontier's size", low=0.0, high=1e3)
    min_frontier_size: float = param(0.5, "m", "explore_lite: smaller frontiers are left", low=0.05, high=10.0)

    @property
    def faults(self) -> str:
        """What is wrong between parameters; empty when nothing is."""
        if self.near_speed > self.max_speed:
            return f"near_speed = {self.near_speed:g} m/s is above max_speed = {self.max_speed:g} m/s"
        return ""
