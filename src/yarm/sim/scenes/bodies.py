"""What the things of a scene are made of, without an engine: solids, frames, and where they stand.

The simulation puts them into its world; the registry of a real cell tells of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Dict, Tuple

import numpy as np

from yarm.geometry import FloatArray, quaternion_from_rpy, transform_matrix
from yarm.geometry.kinds import ObjectKind
from yarm.geometry.solids import Shape
from yarm.geometry.urdf import LinkSolid, UrdfError, UrdfModel, expand_xacro, parse_urdf
from yarm.resources import resource
from yarm.robots import bin as bins
from yarm.robots.ankurbot import LIFT_LINKS
from yarm.sim.scenes.scene import Scene
from yarm.sim.scenes.specs import ArmSpec, FixtureSpec, RobotSpec, ThingSpec

SEED_POINTS = {"table": (0.20, 0.0, 0.70), "stand": (-0.95, 0.0, 0.70), bins.NAME: (0.0, 0.0, bins.RIM_M)}
"""A point of each fixture's top that the cameras see, metres, frame of its station; a bin's is amid its rim."""
TOOL_FRAMES = ("tool0", "sander_tip", "wrist_camera_optical_frame")
"""Frames of an arm beyond its last joint."""


class SpawnError(ValueError):
    """An object cannot be put into the cell or taken out; the message names it and why."""


@dataclass(frozen=True, eq=False)
class FramedSolid:
    """A known solid fixed to a tf frame: pose of its centre in that frame (4, 4), metres."""

    frame: str
    solid: LinkSolid
    T_frame_solid: FloatArray


@dataclass(eq=False)
class Body:
    """One object of the cell.

    Attributes:
        name: unique name.
        kind: "Mobile", "Manipulator", "Debris", "Target" or "Obstacle".
        dynamic: whether it can move.
        seed_frame: tf frame of its seed.
        link_frames: tf frames of its rigid links.
        solids: its known solids, each in one of those frames.
        uids: its PyBullet bodies; none for a target.
        static_frames: frames that never move: T_world_frame (4, 4).
        registered: whether anybody is told of it; what is not can only be seen.
        drawn: whether anybody is told of its solids; else perception has to learn them.
    """

    name: str
    kind: str
    dynamic: bool
    seed_frame: str
    link_frames: Tuple[str, ...]
    solids: Tuple[FramedSolid, ...] = ()
    uids: Tuple[int, ...] = ()
    static_frames: Dict[str, FloatArray] = field(default_factory=dict)
    registered: bool = True
    drawn: bool = True

    @property
    def frames(self) -> Tuple[str, ...]:
        """Every frame that those who are told of it need."""
        solids = [item.frame for item in self.solids] if self.drawn else []
        return tuple(dict.fromkeys((self.seed_frame, *self.link_frames, *solids)))


Solids = Tuple[Tuple[LinkSolid, FloatArray], ...]
DEBRIS_FILE = "debris.urdf.xacro"
"""The debris that has no description of its own."""


@lru_cache(maxsize=None)
def description(file: str, part: str = "", system: str = "cell", hand: bool = False) -> Tuple[str, UrdfModel]:
    """URDF text and content of a file in a folder of urdf/, with the xacro arguments ``part`` and ``hand`` if given."""
    words = {**({"part": part} if part else {}), **({"hand": "true"} if hand else {})}
    text = expand_xacro(resource("urdf", system, file), **words)
    return text, parse_urdf(text)


def rigid_solids(model: UrdfModel) -> Tuple[Tuple[LinkSolid, FloatArray], ...]:
    """The solids of a thing in one piece, each with its pose (4, 4) in the root link's frame.

    Raises:
        UrdfError: the thing has no solids, or joints that move.
    """
    if not model.solids or model.moving_joints:
        moving = ", ".join(joint.name for joint in model.moving_joints) or "none"
        raise UrdfError(
            f"{model.name}: must be one rigid thing with collision solids; "
            f"it has {len(model.solids)}, and joints that move: {moving}"
        )
    return tuple((solid, model.rigid_group(solid.link)[1] @ solid.pose) for solid in model.solids)


def scene_bodies(scene: Scene, hands: bool = False) -> Tuple[Body, ...]:
    """Everything that is in a scene at its start, its events left out.

    Args:
        scene: what is in it.
        hands: all mobile robots carry a hand; without, those whose type has one.

    Raises:
        SpawnError: a thing's description cannot be used.
    """
    return (
        *(fixture_body(spec) for spec in scene.placed_fixtures),
        *(mobile_body(spec, hands) for spec in scene.robots),
        *(arm_body(spec) for spec in scene.arms),
        *(thing_body(spec) for spec in scene.things),
    )


def ankurbot_description(hand: bool) -> Tuple[str, UrdfModel]:
    """URDF text and content of the mobile robot; with a hand its arm is raised and carries one."""
    return description("ankurbot.urdf.xacro", hand=hand)


def mobile_body(spec: RobotSpec, hands: bool = False) -> Body:
    """A mobile robot: its solids, wheels too (balls: their turning changes nothing), are all in base_link.

    But those of a hand that its lift moves, which are in frames of their own.
    """
    _, model = ankurbot_description(hands or spec.has_hand)
    base, solids = f"{spec.name}/base_link", []
    for solid in model.solids:
        pose, link = solid.pose, solid.link
        while link != "base_link" and link not in LIFT_LINKS:
            joint = next(j for j in model.joints.values() if j.child == link)
            pose, link = joint.T_parent_child @ pose, joint.parent
        solids.append(FramedSolid(f"{spec.name}/{link}", solid, pose))
    tip = f"{spec.name}/ee"
    return Body(spec.name, ObjectKind.MOBILE, True, tip, (base, tip), tuple(solids), drawn=spec.drawn)


def arm_body(spec: ArmSpec) -> Body:
    """A manipulator: its solids are in the frame of the moving link that carries them."""
    _, model = description("hc10.urdf.xacro")
    name, station, solids = spec.name, spec.station, []
    for solid in model.solids:
        link, T_group_link = model.rigid_group(solid.link)
        solids.append(FramedSolid(f"{name}/{link}", solid, T_group_link @ solid.pose))
    frames = ("base_link", *(joint.child for joint in model.moving_joints), "tool0")
    kind = ObjectKind.OBSTACLE if spec.tucked else ObjectKind.MANIPULATOR
    T_world_base = transform_matrix(station.base_xyz, quaternion_from_rpy(0.0, 0.0, station.yaw_rad))
    links = tuple(f"{name}/{frame}" for frame in frames)
    fixed = {f"{name}/base_link": T_world_base}
    return Body(name, kind, not spec.tucked, f"{name}/tool0", links, tuple(solids), static_frames=fixed)


def fixture_body(spec: FixtureSpec) -> Body:
    """The table with its workpiece, the stand, or a bin."""
    name, station = spec.name, spec.station
    _, model = description("cell.urdf.xacro", spec.type)
    seed = transform_matrix(SEED_POINTS[spec.type], (0.0, 0.0, 0.0, 1.0))
    inverse = np.linalg.inv(seed)
    solids = tuple(
        FramedSolid(name, solid, inverse @ model.rigid_group(solid.link)[1] @ solid.pose) for solid in model.solids
    )
    return Body(name, ObjectKind.OBSTACLE, False, name, (name,), solids, static_frames={name: station.pose @ seed})


def thing_body(spec: ThingSpec) -> Body:
    """Debris, target or obstacle.

    Raises:
        SpawnError: its description cannot be used.
    """
    if spec.kind == ObjectKind.TARGET:
        pose = transform_matrix((spec.x, spec.y, spec.z), quaternion_from_rpy(0.0, 0.0, spec.yaw_rad))
        return Body(spec.name, ObjectKind.TARGET, False, spec.name, (spec.name,), static_frames={spec.name: pose})
    try:
        solids = _solids_of(spec)
    except UrdfError as error:
        raise SpawnError(f"{spec.name}: {error}") from error
    if spec.kind == ObjectKind.DEBRIS:
        framed = tuple(FramedSolid(spec.name, solid, pose) for solid, pose in solids)
        name, known = spec.name, spec.registered
        return Body(name, ObjectKind.DEBRIS, True, name, (name,), framed, registered=known)
    return _fixed(spec, solids)


def _solids_of(spec: ThingSpec) -> Solids:
    if spec.kind == ObjectKind.OBSTACLE and not spec.model:
        size = (spec.size[0], spec.size[1], spec.size[2])
        return ((LinkSolid(Shape.BOX, size, np.eye(4), spec.name), np.eye(4)),)
    return rigid_solids(description(spec.model or DEBRIS_FILE)[1])


def _fixed(spec: ThingSpec, solids: Solids) -> Body:
    """An obstacle; its frame is above its root link, as high as its top, which the cameras see."""
    height = max(float(pose[2, 3] + np.abs(pose[2, :3]) @ solid.half_extent) for solid, pose in solids)
    top = transform_matrix((spec.x, spec.y, spec.z + height), quaternion_from_rpy(0.0, 0.0, spec.yaw_rad))
    below = transform_matrix((0.0, 0.0, -height), (0.0, 0.0, 0.0, 1.0))
    framed = tuple(FramedSolid(spec.name, solid, below @ pose) for solid, pose in solids)
    return Body(
        spec.name,
        ObjectKind.OBSTACLE,
        False,
        spec.name,
        (spec.name,),
        framed,
        static_frames={spec.name: top},
        registered=spec.registered,
    )
