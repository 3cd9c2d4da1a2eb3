"""Scenes: who stands where in the cell and what happens to them. YAML in, checked dataclasses out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Dict, List, Optional, Tuple, Union

from yarm.resources import resource
from yarm.sim.scene_events import Event, read_events
from yarm.sim.yaml_fields import Faults, Fields, SceneError, load_yaml

HALF_CELL_M = 2.5
"""The mapped volume is x, y in [-2.5, 2.5), metres."""
TOP_M = 1.3
EE_HEIGHT_M = 0.89
DEBRIS_HALF_HEIGHT_M = 0.02
FIXTURES = ("table", "stand")
ROBOT_TYPES = ("ankurbot",)
ARM_TYPES = ("hc10",)

__all__ = ["Scene", "SceneError", "load_scene", "scene_path", "shipped_scenes"]


@dataclass(frozen=True)
class RobotSpec:
    """A mobile robot at its start: body centre on the floor, metres, and heading of its arm, rad."""

    name: str
    type: str
    x: float
    y: float
    heading_rad: float


@dataclass(frozen=True)
class ArmSpec:
    """A manipulator; where it is bolted and folded is in config/hc10.yaml.

    Attributes:
        name: unique name.
        type: one of ARM_TYPES.
        tucked: it stays folded and takes no orders: to everybody it is an Obstacle.
    """

    name: str
    type: str
    tucked: bool = False


@dataclass(frozen=True)
class ThingSpec:
    """Debris, a target or an obstacle.

    Attributes:
        name: unique name.
        kind: "Debris", "Target" or "Obstacle".
        x: centre, metres, world.
        y: centre, metres, world.
        z: centre, metres, world.
        yaw_rad: heading, rad.
        size: obstacles: box along x, y, z, metres; else empty.
        registered: obstacles: whether anybody is told of it, or it can only be seen.
    """

    name: str
    kind: str
    x: float
    y: float
    z: float
    yaw_rad: float = 0.0
    size: Tuple[float, ...] = ()
    registered: bool = True


@dataclass(frozen=True)
class Scene:
    """Everything that is in the cell at its start, and the events that change it."""

    name: str
    seed: int = 0
    about: str = ""
    fixtures: Tuple[str, ...] = FIXTURES
    robots: Tuple[RobotSpec, ...] = ()
    arms: Tuple[ArmSpec, ...] = ()
    things: Tuple[ThingSpec, ...] = ()
    events: Tuple[Event, ...] = field(default=())

    @property
    def has_working_arm(self) -> bool:
        """Whether a manipulator is there that is not tucked away."""
        return any(not arm.tucked for arm in self.arms)

    def things_of(self, kind: str) -> Tuple[ThingSpec, ...]:
        """The debris, targets or obstacles."""
        return tuple(thing for thing in self.things if thing.kind == kind)


def scene_path(name: str) -> Path:
    """File of a scene: a path ending in .yaml, or the name of a shipped scene such as "2m1ma"."""
    return Path(name) if name.endswith(".yaml") else resource("scenes", f"{name}.yaml")


def shipped_scenes() -> Tuple[str, ...]:
    """Names of the scenes that come with the package."""
    return tuple(sorted(path.stem for path in resource("scenes").glob("*.yaml")))


def load_scene(source: Union[str, Path]) -> Scene:
    """A scene by name or file.

    Raises:
        SceneError: faults, all listed: file, key, value, what was expected.
    """
    path = scene_path(str(source))
    if not path.is_file():
        raise SceneError(f"{path}: no such scene; shipped: {', '.join(shipped_scenes())}")
    return scene_from(load_yaml(path), str(path))


def scene_from(raw: object, file: str) -> Scene:
    """A scene from plain values; ``file`` is named in messages.

    Raises:
        SceneError: faults, all listed.
    """
    faults = Faults(file)
    top = Fields(raw, "", faults)
    things = [_debris(f) for f in top.entries("debris")]
    things += [_target(f) for f in top.entries("targets")]
    things += [_obstacle(f) for f in top.entries("obstacles")]
    scene = Scene(
        name=top.text("name"),
        seed=top.whole("seed", 0, 2**31 - 1, 0),
        about=top.text("about", "-"),
        fixtures=_fixtures(top),
        robots=tuple(_robot(f) for f in top.entries("robots")),
        arms=tuple(_arm(f) for f in top.entries("manipulators")),
        things=tuple(things),
        events=read_events(top, faults, spawn_reader=_spawned),
    )
    top.finish()
    _check_names(scene, faults)
    faults.raise_if_any()
    return scene


def _fixtures(top: Fields) -> Tuple[str, ...]:
    value = top.value("fixtures", "a list", list(FIXTURES))
    if not isinstance(value, list) or any(item not in FIXTURES for item in value):
        top.faults.add("fixtures", value, f"a list of {', '.join(FIXTURES)}")
        return ()
    return tuple(value)


def _robot(fields: Fields) -> RobotSpec:
    spec = RobotSpec(
        name=_name(fields),
        type=fields.text("type", choices=ROBOT_TYPES),
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m"),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m"),
        heading_rad=_angle(fields, "heading_deg", None),
    )
    fields.finish()
    return spec


def _arm(fields: Fields) -> ArmSpec:
    spec = ArmSpec(
        name=_name(fields), type=fields.text("type", choices=ARM_TYPES), tucked=fields.flag("tucked", default=False)
    )
    fields.finish()
    return spec


def _debris(fields: Fields) -> ThingSpec:
    return _thing(fields, "Debris", default_z=None)


def _target(fields: Fields) -> ThingSpec:
    return _thing(fields, "Target", default_z=EE_HEIGHT_M)


def _obstacle(fields: Fields) -> ThingSpec:
    return _thing(fields, "Obstacle", default_z=None)


def _spawned(fields: Fields) -> ThingSpec:
    kind = fields.text("type", choices=("Debris", "Target", "Obstacle"))
    return _thing(fields, kind, default_z=EE_HEIGHT_M if kind == "Target" else None)


def _thing(fields: Fields, kind: str, default_z: Optional[float]) -> ThingSpec:
    spec = ThingSpec(
        name=_name(fields),
        kind=kind,
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m"),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m"),
        z=fields.number("z", 0.0, TOP_M, "m", default_z),
        yaw_rad=_angle(fields, "yaw_deg", 0.0),
        size=fields.numbers("size", 3, 0.01, 5.0) if kind == "Obstacle" else (),
        registered=fields.flag("registered", default=True) if kind == "Obstacle" else True,
    )
    fields.finish()
    return spec


def _name(fields: Fields) -> str:
    name = fields.text("name")
    if name and not name.replace("_", "").isalnum():
        fields.faults.add(fields.path("name"), name, "letters, digits and underscores")
    return name


def _angle(fields: Fields, name: str, default: Optional[float]) -> float:
    return math.radians(fields.number(name, -360.0, 360.0, "deg", default))


def _check_names(scene: Scene, faults: Faults) -> None:
    owners: Dict[str, List[str]] = {name: [f"fixtures ({name})"] for name in ("floor", *FIXTURES)}
    for key, specs in (("robots", scene.robots), ("manipulators", scene.arms), ("things", scene.things)):
        for spec in specs:
            owners.setdefault(spec.name, []).append(key)
    for name, keys in owners.items():
        if name and len(keys) > 1:
            faults.add("name", name, f"unique names; it is used {len(keys)} times ({', '.join(keys)})")
    if scene.arms and "stand" not in scene.fixtures:
        faults.add("manipulators", [arm.name for arm in scene.arms], "fixtures to hold the stand they are bolted to")
    if len(scene.arms) > 1:
        faults.add("manipulators", [arm.name for arm in scene.arms], "at most one: there is one stand")
    _check_event_names(scene, faults)


def _check_event_names(scene: Scene, faults: Faults) -> None:
    known = {spec.name for specs in (scene.robots, scene.arms, scene.things) for spec in specs}
    known |= {event.spawn.name for event in scene.events if event.spawn is not None}
    for event in scene.events:
        for name in event.names():
            if name not in known:
                faults.add(f"events ({event.name})", name, f"an object of the scene: {', '.join(sorted(known))}")
