"""Parameters of the map server and of move_base."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, List, Mapping, Tuple

from yarm.navigation.move_base_params import MoveBaseParams
from yarm.navigation.platform_params import UNUSED, take_platform
from yarm.params import ParamError, build_noting, param


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


def move_base_params(values: Mapping[str, Any], where: str) -> Tuple[MoveBaseNodeParams, Tuple[str, ...]]:
    """The node's parameters, by our names or by those of the platform's own node, and what is to be told of these.

    Args:
        values: as the parameter server has them.
        where: name of the node, for messages.

    Raises:
        ParamError: everything that is wrong, at once: unknown names, values out of range.
    """
    taken = take_platform(values)
    faults: List[str] = []
    params = build_noting(MoveBaseNodeParams, taken.values, "", faults)
    faults = [_by_source(fault, taken.sources) for fault in faults] + list(taken.faults)
    if faults or params is None:
        raise ParamError(f"{where}: " + "; ".join(faults))
    told: List[str] = []
    if taken.sources:
        used = (f"{name} = {getattr(params, name):g} ({source})" for name, source in taken.sources.items())
        told.append(f"taken from the platform's names: {', '.join(used)}")
    if taken.unused:
        told.append(f"set, but without effect here ({UNUSED}): {', '.join(taken.unused)}")
    return params, tuple(told)


def _by_source(fault: str, sources: Mapping[str, str]) -> str:
    """A fault begins with the name of its parameter; people know it by the name that they have set."""
    name = fault.partition(" = ")[0]
    return fault.replace(name, sources[name], 1) if name in sources else fault
