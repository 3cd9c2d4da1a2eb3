"""Where each manipulator's station is: from the scene to the parameter ``<arm>/station``, and from there to a node."""

from __future__ import annotations

import math
from typing import Any, Dict, List, Mapping

import rospy

from yarm.params import ParamError
from yarm.robots.hc10 import AT_ORIGIN, Station, station_faults
from yarm.ros.common import names
from yarm.sim.scenes.scene import load_scene

KEYS = ("x", "y", "yaw_rad", "storage")


def station_values(arm: str, scene: str = "") -> Dict[str, Any]:
    """The parameter's value for an arm of a scene; of the station at the origin when the scene has no such arm.

    Raises:
        SceneError: the scene is faulty.
    """
    arms = load_scene(scene).arms if scene else ()
    station = next((spec.station for spec in arms if spec.name == arm), AT_ORIGIN)
    return {"x": station.x, "y": station.y, "yaw_rad": station.yaw_rad, "storage": list(station.storage)}


def load_station(arm: str) -> Station:
    """The station of an arm, from the parameter server; where nothing is said, the one at the origin.

    Raises:
        ParamError: keys or values are wrong; the message names them and what is accepted.
    """
    return station_of(rospy.get_param(names.station(arm), {}), names.station(arm))


def station_of(raw: object, where: str) -> Station:
    """A station from plain values; ``where`` is named in messages.

    Raises:
        ParamError: keys or values are wrong; all are listed.
    """
    if not isinstance(raw, Mapping):
        raise ParamError(f"{where} = {raw!r}: must be a mapping with any of {', '.join(KEYS)}")
    faults = [f"{key}: unknown key; known: {', '.join(KEYS)}" for key in raw if key not in KEYS]
    faults += [f"{key} = {raw[key]!r}: must be a number" for key in KEYS[:3] if not _is_number(raw.get(key, 0.0))]
    storage = raw.get("storage", [])
    if not isinstance(storage, list) or not all(_is_number(angle) for angle in storage):
        faults.append(f"storage = {storage!r}: must be a list of numbers")
    if not faults:
        numbers: List[float] = [float(raw.get(key, 0.0)) for key in KEYS[:3]]
        station = Station(numbers[0], numbers[1], numbers[2], tuple(float(angle) for angle in storage))
        faults = [fault for fault in (station_faults(station),) if fault]
    if faults:
        raise ParamError(f"{where}: " + "; ".join(faults))
    return station


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
