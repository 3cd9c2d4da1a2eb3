"""Scenes of the youBot's floor: who stands where. YAML in, checked dataclasses out.

    start: {x: 0.0, y: 0.0, heading_deg: 0}
    bin: {x: 1.5, y: 0.0, heading_deg: 0, size: [0.40, 0.30, 0.20]}   # outside, the rim is the third, 0.30 at most
    debris:
      - {name: debris_1, x: 0.5, y: -0.9, yaw_deg: 30}                # mass_kg: 0.3 unless given
    obstacles:
      - {name: post, size: [0.2, 0.2, 0.5], x: 0.8, y: 0.6}

Metres, world: origin on the floor, z up. The bin's x axis points to where the robot stands to drop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Dict, List, Tuple

import numpy as np

from yarm.geometry import FloatArray, Pose2, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Shape, Solid
from yarm.geometry.urdf import LinkSolid
from yarm.robots.youbot import NAME
from yarm.sim.scenes.bodies import DEBRIS_FILE, Body, FramedSolid, description, rigid_solids
from yarm.yaml_fields import Faults, Fields, load_yaml

HALF_M = 2.5
"""Half the floor's side."""
RIM_M = 0.30
"""Highest rim that the arm gets a piece over."""
WALL_M = 0.01
DEBRIS_HEIGHT_M = 0.04
DEBRIS_KG = 0.30
"""As urdf/cell/debris.urdf.xacro has it, unless a scene says otherwise."""
MOST = 20
SPREAD_M = 0.25
"""Debris of a seed other than 0 lies up to so far from where the scene has it."""


@dataclass(frozen=True)
class FloorPiece:
    """Debris on the floor: name, middle, metres, heading of its long axis, rad, height, metres, and mass, kg."""

    name: str
    x: float
    y: float
    yaw_rad: float
    height_m: float = DEBRIS_HEIGHT_M
    mass_kg: float = DEBRIS_KG


@dataclass(frozen=True)
class Bin:
    """An open box on the floor: middle, heading, and outer size along its x, y and z, metres."""

    place: Pose2
    size: Tuple[float, float, float]

    @property
    def pose(self) -> FloatArray:
        """T_world_bin (4, 4): on the floor under its middle."""
        return transform_matrix((self.place.x, self.place.y, 0.0), quaternion_from_rpy(0.0, 0.0, self.place.yaw_rad))

    def walls(self) -> Tuple[Solid, ...]:
        """Four walls and a bottom, world."""
        x, y, z = self.size
        parts = [((x, y, WALL_M), (0.0, 0.0, 0.5 * WALL_M))]
        parts += [((WALL_M, y, z), (side * 0.5 * (x - WALL_M), 0.0, 0.5 * z)) for side in (-1, 1)]
        parts += [((x, WALL_M, z), (0.0, side * 0.5 * (y - WALL_M), 0.5 * z)) for side in (-1, 1)]
        upright = (0.0, 0.0, 0.0, 1.0)
        return tuple(Solid(Shape.BOX, size, self.pose @ transform_matrix(at, upright)) for size, at in parts)


@dataclass(frozen=True, eq=False)
class FloorScene:
    """The floor at its start."""

    name: str
    start: Pose2
    bin: Bin
    debris: Tuple[FloorPiece, ...]
    obstacles: Tuple[Tuple[str, Solid], ...]

    def boxes(self) -> List[Tuple[str, Solid]]:
        """Everything that stands firm, world: the bin's walls and the obstacles."""
        return [*(("bin", wall) for wall in self.bin.walls()), *self.obstacles]

    def varied(self, seed: int) -> FloorScene:
        """The scene of a seed: debris lies elsewhere and turned; seed 0 is the scene as it is."""
        if seed == 0:
            return self
        rng = np.random.default_rng(seed)
        moved = [
            replace(
                piece,
                x=piece.x + rng.uniform(-SPREAD_M, SPREAD_M),
                y=piece.y + rng.uniform(-SPREAD_M, SPREAD_M),
                yaw_rad=rng.uniform(-math.pi, math.pi),
            )
            for piece in self.debris
        ]
        return replace(self, debris=tuple(moved))


BASE_FRAME, CUP_FRAME = "base_link", "suction_cup"
"""Frames of the base's middle and of the cup."""


def floor_bodies(scene: FloorScene) -> Tuple[Body, ...]:
    """Robot, debris and whatever stands firm; the robot's frames are its links, another body's has its name."""
    _, robot = description("youbot.urdf.xacro", system="manipulation")
    own = tuple(FramedSolid(solid.link, solid, solid.pose) for solid in robot.solids)
    links = tuple(dict.fromkeys(item.frame for item in own))
    debris = rigid_solids(description(DEBRIS_FILE)[1])
    firm: Dict[str, List[Solid]] = {}
    for name, solid in scene.boxes():
        firm.setdefault(name, []).append(solid)
    return (
        Body(NAME, ObjectKind.MOBILE, True, BASE_FRAME, links, own),
        *(
            Body(
                piece.name,
                ObjectKind.DEBRIS,
                True,
                piece.name,
                (piece.name,),
                tuple(FramedSolid(piece.name, solid, pose) for solid, pose in debris),
            )
            for piece in scene.debris
        ),
        *(_firm_body(name, solids) for name, solids in firm.items()),
    )


def _firm_body(name: str, solids: List[Solid]) -> Body:
    """A body whose frame is that of its first solid."""
    T_frame_world = np.linalg.inv(solids[0].pose)
    framed = tuple(
        FramedSolid(name, LinkSolid(solid.shape, solid.size, np.eye(4), name), T_frame_world @ solid.pose)
        for solid in solids
    )
    fixed = {name: solids[0].pose}
    return Body(name, ObjectKind.OBSTACLE, False, name, (name,), framed, static_frames=fixed)


def load_floor_scene(path: Path) -> FloorScene:
    """Read a scene.

    Raises:
        SceneError: the file's faults, all of them.
    """
    faults = Faults(str(path))
    fields = Fields(load_yaml(path), "", faults)
    start = _place(fields.section("start"))
    box = fields.section("bin")
    size = box.numbers("size", 3, 0.05, 1.0)
    if size[2] > RIM_M:
        faults.add(box.path("size"), list(size), f"a rim of {RIM_M:g} m at most, which the arm reaches over")
    found = Bin(_place(box), (size[0], size[1], size[2]))
    debris = [_piece(entry) for entry in fields.entries("debris", MOST)]
    obstacles = [_obstacle(entry) for entry in fields.entries("obstacles", MOST)]
    fields.finish()
    names = [piece.name for piece in debris] + [name for name, _ in obstacles]
    for name in sorted({name for name in names if names.count(name) > 1 or name in ("floor", "bin")}):
        faults.add("name", name, "a name of its own, not floor and not bin")
    faults.raise_if_any()
    return FloorScene(path.stem, start, found, tuple(debris), tuple(obstacles))


def _place(fields: Fields) -> Pose2:
    x, y = (fields.number(axis, -HALF_M, HALF_M, "m") for axis in ("x", "y"))
    heading = fields.number("heading_deg", -360.0, 360.0, "deg")
    fields.finish()
    return Pose2(x, y, math.radians(heading))


def _piece(fields: Fields) -> FloorPiece:
    name = fields.text("name")
    x, y = (fields.number(axis, -HALF_M, HALF_M, "m") for axis in ("x", "y"))
    yaw = fields.number("yaw_deg", -360.0, 360.0, "deg", default=0.0)
    mass = fields.number("mass_kg", 0.05, 20.0, "kg", default=DEBRIS_KG)
    fields.finish()
    return FloorPiece(name, x, y, math.radians(yaw), mass_kg=mass)


def _obstacle(fields: Fields) -> Tuple[str, Solid]:
    name = fields.text("name")
    size = fields.numbers("size", 3, 0.01, 2.0 * HALF_M)
    x, y = (fields.number(axis, -HALF_M, HALF_M, "m") for axis in ("x", "y"))
    yaw = fields.number("yaw_deg", -360.0, 360.0, "deg", default=0.0)
    fields.finish()
    pose = transform_matrix((x, y, 0.5 * size[2]), quaternion_from_rpy(0.0, 0.0, math.radians(yaw)))
    return name, Solid(Shape.BOX, size, pose)
