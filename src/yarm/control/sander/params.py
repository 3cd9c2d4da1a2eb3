"""Parameters of the HC10 sander."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.geometry import GridSpec
from yarm.params import param

TOP_M = GridSpec().upper[2]


@dataclass(frozen=True)
class SanderParams:
    """Heights are the tip's, world; ``ready_pose`` picks the branch of the inverse kinematics.

    x and y are those of the arm's station: the world's, unless the station is moved.
    """

    ready_pose: Tuple[float, ...] = param(
        (-0.19, 0.92, 1.51, 0.0, -0.58, 0.19), "rad", "joints near which poses over the part are looked for", -6.3, 6.3
    )
    part_centre_m: Tuple[float, ...] = param(
        (-0.25, 0.0), "m", "roughly where the part is, x, y of the station", -2.5, 2.5
    )
    hover_height_m: float = param(1.18, "m", "height of the tip when it hovers", 0.9, TOP_M)
    scan_height_m: float = param(1.16, "m", "height of the tip while it scans", 0.9, TOP_M)
    scan_reach_m: float = param(0.40, "m", "length of the sweep along the station's y", 0.05, 1.0)
    scan_speed_mps: float = param(0.25, "m/s", "speed of the sweep", 0.02, 1.0)
    spacing_m: float = param(0.04, "m", "distance between two passes of the raster", 0.01, 0.2)
    inset_m: float = param(0.02, "m", "outermost passes inside the part's edge", 0.0, 0.1)
    standoff_m: float = param(
        0.002, "m", "height of the tip over the fitted surface (force is not modelled)", 0.0, 0.01
    )
    sanding_speed_mps: float = param(0.1, "m/s", "speed of the tip on the part", 0.01, 0.5)
    sanding_acceleration_mps2: float = param(0.5, "m/s^2", "of the tip", 0.05, 5.0)
    approach_speed_mps: float = param(0.4, "m/s", "speed of the tip when it lifts or comes down", 0.02, 1.0)
    stop_s: float = param(0.15, "s", "a motion is brought to rest in this time", 0.05, 1.0)
    joint_share: float = param(0.5, "", "share of the joints' greatest speeds used by free moves", 0.05, 0.95)
    joint_acceleration: float = param(2.0, "rad/s^2", "of each joint in free moves", 0.1, 20.0)
    margin_m: float = param(0.02, "m", "distance kept to stand, table, part and the arm itself", 0.0, 0.1)
    planning_limit_s: float = param(10.0, "s", "wall time after which planning a move is given up", 0.5, 120.0)
    seed: int = param(1, "", "of the motion planner's random numbers", 1, 1000000)
    teleoperation_mps: float = param(0.1, "m/s", "tip speed of a joystick axis fully pushed", 0.01, 0.5)
    teleoperation_radps: float = param(0.5, "rad/s", "turning speed of the tool, axis fully pushed", 0.05, 2.0)
    part_least_area_m2: float = param(0.05, "m^2", "a level surface smaller than this is not the part", 0.005, 1.0)
