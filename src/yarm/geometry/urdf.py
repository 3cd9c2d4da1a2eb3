"""Robot descriptions: xacro files expanded to URDF text, and the solids, links and joints a URDF speaks of."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Callable, Dict, List, Optional, Tuple, Union

import numpy as np
import xacro

from yarm.geometry.grid import FloatArray
from yarm.geometry.poses import quaternion_from_rpy, transform_matrix
from yarm.geometry.solids import Shape, Solid

DEFAULT_COLOUR = (0.7, 0.7, 0.7)
_ARG = re.compile(r"^\$\(arg\s+(\w+)\s*\)$")


class JointKind(str, Enum):
    """Types of joints: equal to the words of URDF."""

    FIXED = "fixed"
    REVOLUTE = "revolute"
    CONTINUOUS = "continuous"
    PRISMATIC = "prismatic"
    FLOATING = "floating"
    PLANAR = "planar"

    def __str__(self) -> str:
        """The word."""
        return str(self.value)


class UrdfError(ValueError):
    """A robot description cannot be used; the message names the file or element and what was expected."""


@dataclass(frozen=True, eq=False)
class LinkSolid(Solid):
    """A solid of a robot's link; its pose is in the link's frame.

    Attributes:
        link: link it belongs to.
        colour: red, green, blue, 0 to 1.
    """

    link: str
    colour: Tuple[float, float, float] = DEFAULT_COLOUR


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint: frame ``child`` in frame ``parent`` at joint value 0 is ``T_parent_child``; limits in rad, rad/s."""

    name: str
    kind: JointKind
    parent: str
    child: str
    T_parent_child: FloatArray
    axis: Tuple[float, float, float] = (1.0, 0.0, 0.0)
    lower: float = 0.0
    upper: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0


@dataclass(frozen=True, eq=False)
class UrdfModel:
    """Links in order of the file, joints by name, and every collision solid."""

    name: str
    links: Tuple[str, ...]
    joints: Dict[str, Joint]
    solids: Tuple[LinkSolid, ...] = field(default=())

    def rigid_group(self, link: str) -> Tuple[str, FloatArray]:
        """The nearest ancestor that fixed joints tie the link to (the root, or the child of a moving joint).

        Returns:
            its name, and T_ancestor_link (4, 4).
        """
        pose = np.eye(4)
        parents = {joint.child: joint for joint in self.joints.values()}
        while link in parents and parents[link].kind is JointKind.FIXED:
            pose = parents[link].T_parent_child @ pose
            link = parents[link].parent
        return link, pose

    @property
    def moving_joints(self) -> Tuple[Joint, ...]:
        """Joints that are not fixed, in order of the file."""
        return tuple(joint for joint in self.joints.values() if joint.kind is not JointKind.FIXED)


def expand_xacro(path: Union[str, Path], **args: object) -> str:
    """URDF text of a xacro file; ``args`` are the values of its ``xacro:arg`` elements.

    Raises:
        UrdfError: the file does not exist or is not well formed.
    """
    file = Path(path)
    if not file.is_file():
        raise UrdfError(f"{file}: no such robot description")
    xacro.eval_extension = _substituted
    try:
        document = xacro.process_file(str(file), mappings={name: str(value) for name, value in args.items()})
    except Exception as error:  # xacro raises many unrelated kinds
        raise UrdfError(f"{file}: {error}") from error
    return str(document.toprettyxml(indent="  "))


def _substituted(text: str, others: Callable[[str], str] = xacro.eval_extension) -> str:
    """``$(arg NAME)``'s value; what else xacro hands to roslaunch goes there, whose import takes a node 0.3 s."""
    match = _ARG.match(text)
    known = xacro.substitution_args_context.get("arg", {})
    return str(known[match[1]]) if match is not None and match[1] in known else others(text)


def parse_urdf(text: str) -> UrdfModel:
    """Links, joints and collision solids of URDF text.

    Raises:
        UrdfError: not XML, a geometry other than box, cylinder and sphere, or a joint of a type that URDF has not.
    """
    try:
        root = ET.fromstring(text)
    except ET.ParseError as error:
        raise UrdfError(f"URDF text: {error}") from error
    colours = {
        material.get("name", ""): _numbers(colour.get("rgba"), 4)
        for material in root.iter("material")
        for colour in material.findall("color")
    }
    solids: List[LinkSolid] = []
    for link in root.findall("link"):
        solids.extend(_solids_of(link, colours))
    return UrdfModel(
        name=root.get("name", ""),
        links=tuple(link.get("name", "") for link in root.findall("link")),
        joints={joint.get("name", ""): _joint_of(joint) for joint in root.findall("joint")},
        solids=tuple(solids),
    )


def _solids_of(link: ET.Element, colours: Dict[str, Tuple[float, ...]]) -> List[LinkSolid]:
    material = link.find("visual/material")
    rgba = colours.get(material.get("name", ""), ()) if material is not None else ()
    colour = (rgba[0], rgba[1], rgba[2]) if rgba else DEFAULT_COLOUR
    name = link.get("name", "")
    return [
        LinkSolid(*_geometry_of(collision.find("geometry"), name), _origin_of(collision.find("origin")), name, colour)
        for collision in link.findall("collision")
    ]


def _geometry_of(geometry: Optional[ET.Element], link: str) -> Tuple[Shape, Tuple[float, ...]]:
    for element in geometry if geometry is not None else ():
        if element.tag == Shape.BOX:
            return Shape.BOX, _numbers(element.get("size"), 3)
        if element.tag == Shape.CYLINDER:
            return Shape.CYLINDER, (float(element.get("radius", 0)), float(element.get("length", 0)))
        if element.tag == Shape.SPHERE:
            return Shape.SPHERE, (float(element.get("radius", 0)),)
    raise UrdfError(f"link {link}: its geometry must be a box, a cylinder or a sphere")


def _joint_of(joint: ET.Element) -> Joint:
    parent, child, axis, limit = (joint.find(tag) for tag in ("parent", "child", "axis", "limit"))
    if parent is None or child is None:
        raise UrdfError(f"joint {joint.get('name')}: needs a parent and a child")
    limits = {} if limit is None else limit.attrib
    lower, upper = (float(limits.get(side, 0.0)) for side in ("lower", "upper"))
    if not lower <= upper:
        raise UrdfError(f"joint {joint.get('name')}: its limits {lower:g} to {upper:g} are reversed, or no numbers")
    direction = _numbers(None if axis is None else axis.get("xyz"), 3, default=(1.0, 0.0, 0.0))
    return Joint(
        name=joint.get("name", ""),
        kind=_kind_of(joint),
        parent=parent.get("link", ""),
        child=child.get("link", ""),
        T_parent_child=_origin_of(joint.find("origin")),
        axis=(direction[0], direction[1], direction[2]),
        lower=lower,
        upper=upper,
        velocity=float(limits.get("velocity", 0.0)),
        effort=float(limits.get("effort", 0.0)),
    )


def _kind_of(joint: ET.Element) -> JointKind:
    kind = joint.get("type", "")
    if kind not in tuple(JointKind):
        raise UrdfError(f"joint {joint.get('name')}: its type {kind!r} must be one of {', '.join(JointKind)}")
    return JointKind(kind)


def _origin_of(origin: Optional[ET.Element]) -> FloatArray:
    attributes = {} if origin is None else origin.attrib
    xyz = _numbers(attributes.get("xyz"), 3, default=(0.0, 0.0, 0.0))
    rpy = _numbers(attributes.get("rpy"), 3, default=(0.0, 0.0, 0.0))
    return transform_matrix(xyz, quaternion_from_rpy(*rpy))


def _numbers(text: Optional[str], n: int, default: Optional[Tuple[float, ...]] = None) -> Tuple[float, ...]:
    if text is None and default is not None:
        return default
    values = tuple(float(word) for word in (text or "").split())
    if len(values) != n:
        raise UrdfError(f"{text!r} must be {n} numbers")
    return values
