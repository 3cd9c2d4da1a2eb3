"""Parameters of the map server and of move_base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Tuple

from yarm.navigation.move_base_params import MoveBaseParams
from yarm.params import param


@dataclass(frozen=True)
class MapServerParams:
    """What ``config/inspection/map_server.yaml`` holds."""

    frame_id: str = param("map", "", "frame of the map")
    boxes: str = param("", "", "file of boxes that are known and drawn into the map, YAML or coords.xml; empty: none")


@dataclass(frozen=True)
class MoveBaseNodeParams(MoveBaseParams):
    """What ``config/inspection/move_base.yaml`` holds."""

    low_obstacles: bool = param(False, "", "look for low obstacles in the depth images")
    publish_frequency: float = param(1.0, "Hz", "most costmaps a second, each when somebody listens", 0.1, 10.0)
    local_width: float = param(4.0, "m", "side of the local costmap", 0.5, 20.0)
    transform_tolerance: float = param(0.3, "s", "an older transform or odometry counts as missing", 0.05, 10.0)
    base_frame: str = param("base_footprint", "", "the robot's frame")
    odom_frame: str = param("odom", "", "odometry's frame")
    map_frame: str = param("map", "", "the map's frame")
    sync: bool = param(False, "", "lock-step: take in all of a pass before it is decided, and acknowledge it")
    sync_wait: float = param(2.0, "s", "lock-step: wall time a pass waits for what was measured at it", 0.01, 60.0)
    waits_for: Tuple[str, ...] = param((), "", "lock-step: nodes that must have answered before the first pass")
