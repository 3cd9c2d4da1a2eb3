"""Scenes: who stands where in the cell and what happens to them. YAML in, checked dataclasses out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Dict, List, Optional, Set, Tuple, Union

from yarm.geometry import GridSpec
from yarm.geometry.kinds import GOAL_KINDS, ObjectKind
from yarm.resources import resource
from yarm.robots import bin as bins
from yarm.robots.ankurbot import EE_HEIGHT_M
from yarm.robots.hc10 import AT_ORIGIN, N_JOINTS, NAME, STATION_FIXTURES, Station
from yarm.sim.scenes.events import Event, read_events
from yarm.sim.scenes.specs import (
    DRAWN,
    HALF_CELL_M,
    NOT_DRAWN,
    ROBOT_TYPES,
    ArmSpec,
    FixtureSpec,
    RobotSpec,
    ThingSpec,
)
from yarm.sim.scenes.variation import Vary, read_vary, vary_layout
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

TOP_M = GridSpec().upper[2]
ARM_TYPES = ("hc10",)
MOST_ROBOTS = 20
"""Mobile robots in a scene; the floor of the volume holds no more."""
MOST_ARMS = 8
"""Manipulators; each has a table, a stand and limits of its own."""
MOST_BINS = 8
"""Bins for debris."""
MOST_MODEL_BYTES = 100_000
"""Largest description of a thing, bytes."""
MOST_THINGS = 100
"""Debris, targets or obstacles in a scene, of each kind."""

__all__ = ["Scene", "SceneError", "load_scene", "scene_path", "shipped_scenes"]


@dataclass(frozen=True)
class Scene:
    """Everything that is in the cell at its start, the events that change it, and what another seed may change.

    Attributes:
        name: unique name.
        seed: of the depth noise.
        about: one sentence.
        fixtures: types of the fixtures that each station has.
        robots: mobile robots.
        arms: manipulators.
        bins: where debris is taken to.
        things: debris, targets, obstacles.
        events: what happens.
        vary: what another seed may change; None for nothing.
    """

    name: str
    seed: int = 0
    about: str = ""
    fixtures: Tuple[str, ...] = STATION_FIXTURES
    robots: Tuple[RobotSpec, ...] = ()
    arms: Tuple[ArmSpec, ...] = ()
    bins: Tuple[FixtureSpec, ...] = ()
    things: Tuple[ThingSpec, ...] = ()
    events: Tuple[Event, ...] = field(default=())
    vary: Optional[Vary] = None

    @property
    def working_arms(self) -> Tuple[str, ...]:
        """Names of the manipulators that are not tucked away."""
        return tuple(arm.name for arm in self.arms if not arm.tucked)

    @property
    def all_things(self) -> Tuple[ThingSpec, ...]:
        """Debris, targets and obstacles, those too that events bring."""
        return (*self.things, *(event.spawn for event in self.events if event.spawn is not None))

    @property
    def has_stray_debris(self) -> bool:
        """Whether there is debris that nobody registers, from the start or by an event."""
        return any(thing.kind == ObjectKind.DEBRIS and not thing.registered for thing in self.all_things)

    def fixtures_of(self, arm: str) -> Tuple[FixtureSpec, ...]:
        """Table and stand of a manipulator; the first one's carry the plain names, the others' the arm's as well."""
        for i, spec in enumerate(self.arms):
            if spec.name == arm:
                prefix = f"{arm}_" if i else ""
                return tuple(FixtureSpec(f"{prefix}{kind}", kind, spec.station) for kind in self.fixtures)
        return ()

    @property
    def placed_fixtures(self) -> Tuple[FixtureSpec, ...]:
        """Every table, stand and bin; a scene without manipulators has table and stand of the station at the origin."""
        stations = tuple(fixture for arm in self.arms for fixture in self.fixtures_of(arm.name))
        return (stations if self.arms else tuple(FixtureSpec(kind, kind) for kind in self.fixtures)) + self.bins

    def things_of(self, kind: str) -> Tuple[ThingSpec, ...]:
        """The debris, targets or obstacles."""
        return tuple(thing for thing in self.things if thing.kind == kind)


def scene_path(name: str) -> Path:
    """File of a scene: a path ending in .yaml, or the name of a shipped scene such as "2m1ma"."""
    return Path(name) if name.endswith(".yaml") else resource("scenes", "cell", f"{name}.yaml")


def shipped_scenes() -> Tuple[str, ...]:
    """Names of the scenes that come with the package."""
    return tuple(sorted(path.stem for path in resource("scenes", "cell").glob("*.yaml")))


def load_scene(source: Union[str, Path], seed: int = -1) -> Scene:
    """A scene by name or file.

    Args:
        source: name of a shipped scene, or a file.
        seed: of the layout, for a scene that has a ``vary`` block; -1, or the scene's own, gives the file's layout.

    Raises:
        SceneError: faults, all listed: file, key, value, what was expected.
    """
    path = scene_path(str(source))
    if not path.is_file():
        raise SceneError(f"{path}: no such scene; shipped: {', '.join(shipped_scenes())}")
    scene = scene_from(load_yaml(path), str(path))
    return scene if seed in (-1, scene.seed) else with_layout(scene, seed)


def with_layout(scene: Scene, seed: int) -> Scene:
    """The scene as a seed lays it out; a scene without a ``vary`` block stays as it is.

    Raises:
        SceneError: its ranges leave no room.
    """
    if scene.vary is None:
        return scene
    robots, things, events = vary_layout(
        scene.vary, seed, scene.placed_fixtures, scene.robots, scene.things, scene.events
    )
    return replace(scene, robots=robots, things=things, events=events)


def without_shapes(scene: Scene) -> Scene:
    """The scene with mobile robots whose shapes nobody is told."""
    return replace(scene, robots=tuple(replace(robot, drawn=False) for robot in scene.robots))


def scene_from(raw: object, file: str) -> Scene:
    """A scene from plain values; ``file`` is named in messages.

    Raises:
        SceneError: faults, all listed.
    """
    faults = Faults(file)
    top = Fields(raw, "", faults)
    things = [_debris(f) for f in top.entries("debris", MOST_THINGS)]
    things += [_target(f) for f in top.entries("targets", MOST_THINGS)]
    things += [_obstacle(f) for f in top.entries("obstacles", MOST_THINGS)]
    scene = Scene(
        name=top.text("name"),
        seed=top.whole("seed", 0, 2**31 - 1, 0),
        about=top.text("about", "-"),
        fixtures=_fixtures(top),
        robots=tuple(_robot(f) for f in top.entries("robots", MOST_ROBOTS)),
        arms=tuple(_arm(f) for f in top.entries("manipulators", MOST_ARMS)),
        bins=tuple(_bin(f) for f in top.entries("bins", MOST_BINS)),
        things=tuple(things),
        events=read_events(top, faults, spawn_reader=_spawned),
        vary=read_vary(top.section("vary")) if top.has("vary") else None,
    )
    top.finish()
    _check_names(scene, faults)
    faults.raise_if_any()
    return scene


def _fixtures(top: Fields) -> Tuple[str, ...]:
    value = top.value("fixtures", "a list", list(STATION_FIXTURES))
    known = isinstance(value, list) and all(item in STATION_FIXTURES for item in value)
    if not known or len(set(value)) < len(value):
        top.faults.add("fixtures", value, f"a list of {', '.join(STATION_FIXTURES)}, each once at most")
        return ()
    return tuple(value)


def _robot(fields: Fields) -> RobotSpec:
    spec = RobotSpec(
        name=_name(fields),
        type=fields.text("type", choices=ROBOT_TYPES),
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m"),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m"),
        heading_rad=_angle(fields, "heading_deg", None),
        drawn=not fields.has("shapes") or fields.text("shapes", choices=(DRAWN, NOT_DRAWN)) == DRAWN,
    )
    fields.finish()
    return spec


def _arm(fields: Fields) -> ArmSpec:
    spec = ArmSpec(
        name=_name(fields),
        type=fields.text("type", choices=ARM_TYPES),
        tucked=fields.flag("tucked", default=False),
        station=_station(fields.section("station")) if fields.has("station") else AT_ORIGIN,
    )
    fields.finish()
    if spec.name and not spec.name.startswith(NAME):
        expected = f"a name that begins with {NAME}, by which the controls server knows an HC10"
        fields.faults.add(fields.path("name"), spec.name, expected)
    return spec


def _station(fields: Fields) -> Station:
    folded = fields.numbers("storage_deg", N_JOINTS, -360.0, 360.0) if fields.has("storage_deg") else ()
    station = Station(
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m", 0.0),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m", 0.0),
        yaw_rad=_angle(fields, "yaw_deg", 0.0),
        storage=tuple(math.radians(angle) for angle in folded),
    )
    fields.finish()
    return station


def _bin(fields: Fields) -> FixtureSpec:
    name = _name(fields)
    place = Station(
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m"),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m"),
        yaw_rad=_angle(fields, "yaw_deg", 0.0),
    )
    fields.finish()
    if name and not bins.is_bin(name):
        fields.faults.add(fields.path("name"), name, f"a name that begins with {bins.NAME}, by which bins are known")
    return FixtureSpec(name, bins.NAME, place)


def _debris(fields: Fields) -> ThingSpec:
    return _thing(fields, ObjectKind.DEBRIS, default_z=None)


def _target(fields: Fields) -> ThingSpec:
    return _thing(fields, ObjectKind.TARGET, default_z=EE_HEIGHT_M)


def _obstacle(fields: Fields) -> ThingSpec:
    return _thing(fields, ObjectKind.OBSTACLE, default_z=None)


def _spawned(fields: Fields) -> ThingSpec:
    kind = fields.text("type", choices=(ObjectKind.DEBRIS, ObjectKind.TARGET, ObjectKind.OBSTACLE))
    return _thing(fields, kind, default_z=EE_HEIGHT_M if kind == ObjectKind.TARGET else None)


def _thing(fields: Fields, kind: str, default_z: Optional[float]) -> ThingSpec:
    model = _model(fields) if kind in (ObjectKind.DEBRIS, ObjectKind.OBSTACLE) else ""
    spec = ThingSpec(
        name=_name(fields),
        kind=kind,
        x=fields.number("x", -HALF_CELL_M, HALF_CELL_M, "m"),
        y=fields.number("y", -HALF_CELL_M, HALF_CELL_M, "m"),
        z=fields.number("z", 0.0, TOP_M, "m", default_z),
        yaw_rad=_angle(fields, "yaw_deg", 0.0),
        size=fields.numbers("size", 3, 0.01, 5.0) if kind == ObjectKind.OBSTACLE and not model else (),
        registered=fields.flag("registered", default=True) if kind != ObjectKind.TARGET else True,
        model=model,
    )
    fields.finish()
    return spec


def _model(fields: Fields) -> str:
    """Path of a description, given relative to the scene's own file; empty when none is given."""
    if not fields.has("model"):
        return ""
    name = fields.text("model")
    file = Path(fields.faults.file).resolve().parent / name
    if name and not file.is_file():
        fields.faults.add(fields.path("model"), name, f"a URDF or xacro file beside the scene; there is no {file}")
    elif name and file.stat().st_size > MOST_MODEL_BYTES:
        size = f"a description of at most {MOST_MODEL_BYTES} bytes, not {file.stat().st_size}"
        fields.faults.add(fields.path("model"), name, size)
    return str(file)


def _name(fields: Fields) -> str:
    name = fields.text("name")
    if name and not name.replace("_", "").isalnum():
        fields.faults.add(fields.path("name"), name, "letters, digits and underscores")
    return name


def _angle(fields: Fields, name: str, default: Optional[float]) -> float:
    return math.radians(fields.number(name, -360.0, 360.0, "deg", default))


def _check_names(scene: Scene, faults: Faults) -> None:
    stations = [fixture.name for fixture in scene.placed_fixtures if fixture not in scene.bins]
    fixed = ["floor", *STATION_FIXTURES, *stations]
    owners: Dict[str, List[str]] = {name: [f"fixtures ({name})"] for name in fixed}
    groups = (("robots", scene.robots), ("manipulators", scene.arms), ("bins", scene.bins), ("things", scene.things))
    for key, specs in groups:
        for spec in specs:
            owners.setdefault(spec.name, []).append(key)
    for name, keys in owners.items():
        if name and len(keys) > 1:
            faults.add("name", name, f"unique names; it is used {len(keys)} times ({', '.join(keys)})")
    if scene.arms and "stand" not in scene.fixtures:
        faults.add("manipulators", [arm.name for arm in scene.arms], "fixtures to hold the stand they are bolted to")
    _check_event_names(scene, faults)
    goals = _goal_names(scene)
    for name in scene.vary.places if scene.vary is not None else ():
        if name not in goals:
            faults.add("vary.places", name, f"a debris or target of the scene: {', '.join(sorted(goals))}")


def _goal_names(scene: Scene) -> Set[str]:
    """Debris and targets, those too that events spawn."""
    spawned = [event.spawn for event in scene.events if event.spawn is not None]
    return {thing.name for thing in (*scene.things, *spawned) if thing.kind in GOAL_KINDS}


def _check_event_names(scene: Scene, faults: Faults) -> None:
    known = {spec.name for specs in (scene.robots, scene.arms, scene.bins, scene.things) for spec in specs}
    known |= {event.spawn.name for event in scene.events if event.spawn is not None}
    for event in scene.events:
        for name in event.names():
            if name not in known:
                faults.add(f"events ({event.name})", name, f"an object of the scene: {', '.join(sorted(known))}")
