"""A scene as the text of a scene file: what ``load_scene`` reads back as the same scene, to a millionth."""

from __future__ import annotations

import math
from typing import Any, Dict

import yaml

from yarm.geometry.kinds import ObjectKind
from yarm.robots.hc10 import AT_ORIGIN, Station
from yarm.sim.scenes.events import Event, Trigger
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import NOT_DRAWN, ArmSpec, RobotSpec, ThingSpec

DIGITS = 6
LISTS = {ObjectKind.DEBRIS: "debris", ObjectKind.TARGET: "targets", ObjectKind.OBSTACLE: "obstacles"}


def scene_text(scene: Scene) -> str:
    """The YAML of a scene without models and ranges to vary.

    Raises:
        ValueError: it has some, which would be lost.
    """
    if scene.vary is not None or any(thing.model for thing in scene.all_things):
        raise ValueError(f"{scene.name}: ranges to vary and models are not written")
    values: Dict[str, Any] = {
        "name": scene.name,
        "about": scene.about,
        "seed": scene.seed,
        "fixtures": list(scene.fixtures),
        "robots": [_robot(robot) for robot in scene.robots],
        "manipulators": [_arm(arm) for arm in scene.arms],
        "bins": [{"name": b.name, **_place(b.station)} for b in scene.bins],
    }
    for kind, key in LISTS.items():
        values[key] = [_thing(thing) for thing in scene.things_of(kind)]
    values["events"] = [{"name": e.name, "when": _when(e.when), "do": _do(e)} for e in scene.events]
    text: str = yaml.safe_dump(values, sort_keys=False, width=120, default_flow_style=None)
    return text


def _m(value: float) -> float:
    return round(value, DIGITS)


def _deg(angle_rad: float) -> float:
    return round(math.degrees(angle_rad), DIGITS)


def _robot(robot: RobotSpec) -> Dict[str, Any]:
    place = {"x": _m(robot.x), "y": _m(robot.y), "heading_deg": _deg(robot.heading_rad)}
    return {"name": robot.name, "type": robot.type, **place, **({} if robot.drawn else {"shapes": NOT_DRAWN})}


def _arm(arm: ArmSpec) -> Dict[str, Any]:
    values: Dict[str, Any] = {"name": arm.name, "type": arm.type, "tucked": arm.tucked}
    if arm.station != AT_ORIGIN:
        values["station"] = _place(arm.station)
        if arm.station.storage:
            values["station"]["storage_deg"] = [_deg(angle) for angle in arm.station.storage]
    return values


def _place(station: Station) -> Dict[str, Any]:
    return {"x": _m(station.x), "y": _m(station.y), "yaw_deg": _deg(station.yaw_rad)}


def _thing(thing: ThingSpec) -> Dict[str, Any]:
    values: Dict[str, Any] = {"name": thing.name, "x": _m(thing.x), "y": _m(thing.y), "z": _m(thing.z)}
    values["yaw_deg"] = _deg(thing.yaw_rad)
    if thing.kind == ObjectKind.OBSTACLE:
        values["size"] = [_m(length) for length in thing.size]
        values["registered"] = thing.registered
    elif not thing.registered:
        values["registered"] = False
    return values


def _when(when: Trigger) -> Dict[str, Any]:
    if when.time_s is not None:
        values: Dict[str, Any] = {"time": _m(when.time_s)}
    elif when.state:
        values = {"state": when.state}
    elif when.raster is not None:
        values = {"raster": _m(when.raster), **({"manipulator": when.arm} if when.arm else {})}
    elif when.holding:
        values = {"holding": when.holding}
    else:
        values = {"robot": " ".join(when.robots), "near": when.near, "below": _m(when.below_m)}
    return {**values, "after": _m(when.after_s)} if when.after_s else values


def _do(event: Event) -> Dict[str, Any]:
    if event.spawn is not None:
        return {"spawn": {"type": str(event.spawn.kind), **_thing(event.spawn)}}
    if event.delete:
        return {"delete": event.delete}
    if event.camera:
        return {"camera": event.camera, "enabled": event.enabled}
    if event.vacuum:
        return {"vacuum": event.vacuum, "enabled": event.enabled}
    by = {"dx": _m(event.dx_m), "dy": _m(event.dy_m)}
    return {"move": event.move, **by, "speed": _m(event.speed_mps)} if event.move else {"push": event.push, **by}
