"""Layouts by name: the shipped ones, files, and made ones such as open_3. YAML in, a checked layout out."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import List, Tuple

from yarm.geometry import Pose2
from yarm.resources import resource
from yarm.sim.scenes.arena import HALF_M, Arena, Block, BlockKind
from yarm.sim.scenes.layout import Layout, walls
from yarm.sim.scenes.layout_maker import KINDS, SEEDS, make_layout
from yarm.yaml_fields import Faults, Fields, SceneError, load_yaml

MOST_BOXES, MOST_TAG = 30, 100
MADE = re.compile(rf"({'|'.join(KINDS)})_(\d{{1,6}})")

KNOWN = f"practice, {', '.join(f'{kind}_0 .. {kind}_{SEEDS - 1}' for kind in KINDS)}, or a file that ends in .yaml"


def layout_path(name: str) -> Path:
    """File of a layout: a path ending in .yaml, or the name of a shipped one such as "practice"."""
    return Path(name) if name.endswith(".yaml") else resource("scenes", "inspection", f"{name}.yaml")


def is_layout(name: str) -> bool:
    """Whether a layout goes by this name; its file may still be faulty."""
    return MADE.fullmatch(name) is not None or layout_path(name).is_file()


def find_layout(name: str) -> Layout:
    """A layout by name: a shipped one's, a file, or a made one's such as wall_7.

    Raises:
        SceneError: no such layout, or faults in its file, all listed: file, key, value, what was expected.
    """
    made = MADE.fullmatch(name)
    if made is not None:
        return make_layout(made.group(1), int(made.group(2)))
    path = layout_path(name)
    if not path.is_file():
        raise SceneError(f"{name}: no such layout; known: {KNOWN}")
    return layout_from(load_yaml(path), path)


def layout_from(raw: object, file: Path) -> Layout:
    """A layout from plain values; the file of its boxes is beside ``file``.

    Raises:
        SceneError: faults, all listed.
    """
    faults = Faults(str(file))
    top = Fields(raw, "", faults)
    lower = top.numbers("lower", 2, -HALF_M, HALF_M)
    upper = top.numbers("upper", 2, -HALF_M, HALF_M)
    size = top.numbers("box_size", 3, 0.05, 5.0)
    place = top.section("start")
    start = Pose2(
        place.number("x", -HALF_M, HALF_M, "m"),
        place.number("y", -HALF_M, HALF_M, "m"),
        math.radians(place.number("yaw_deg", -360.0, 360.0, "deg", 0.0)),
    )
    place.finish()
    name, seed, about = top.text("name"), top.whole("seed", 0, 2**31 - 1, 0), top.text("about", "-")
    poses = _poses(file.parent / top.text("boxes"), faults)
    tags = top.wholes("tags", len(poses), 0, MOST_TAG)
    top.finish()
    _check((lower[0], lower[1]), (upper[0], upper[1]), start, poses, faults)
    faults.raise_if_any()
    boxes = [Block(f"box_{i + 1}", BlockKind.BOX, pose, (size[1], size[0], size[2])) for i, pose in enumerate(poses)]
    bounds = (lower[0], lower[1]), (upper[0], upper[1])
    return Layout(Arena(name, "custom", seed, *bounds, (*walls(*bounds), *boxes), start, about), tags or ())


def _poses(path: Path, faults: Faults) -> List[Pose2]:
    """Of the boxes, in the order of their numbers, which run from 1 without a gap."""
    if not path.is_file():
        faults.add("boxes", path.name, "a file that is there, beside this one")
        return []
    top = Fields(load_yaml(path), "", faults)
    found = {}
    entries = top.entries("boxes", MOST_BOXES)
    for i, entry in enumerate(entries):
        number = entry.whole("number", 1, MOST_BOXES, i + 1)
        x, y = (entry.number(axis, -HALF_M, HALF_M, "m") for axis in ("x", "y"))
        found[number] = Pose2(x, y, entry.number("phi", -2 * math.pi, 2 * math.pi, "rad"))
        entry.finish()
    if sorted(found) != list(range(1, len(entries) + 1)):
        faults.add("boxes", sorted(found), "numbers from 1 on, each given once")
    return [found[number] for number in sorted(found)]


def _check(
    lower: Tuple[float, float], upper: Tuple[float, float], start: Pose2, poses: List[Pose2], faults: Faults
) -> None:
    if not (lower[0] < upper[0] and lower[1] < upper[1]):
        faults.add("upper", list(upper), f"more than lower, {list(lower)}, along both axes")
        return
    for key, pose in [("start", start), *((f"boxes[{i}]", pose) for i, pose in enumerate(poses))]:
        if not (lower[0] < pose.x < upper[0] and lower[1] < pose.y < upper[1]):
            faults.add(key, (pose.x, pose.y), f"a place within {lower} and {upper}")
