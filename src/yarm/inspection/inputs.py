"""What a round is given: boxes and tag images, as YAML or as the OpenCV storage files of such worlds.

    boxes:
      - {number: 1, x: 3.19, y: -3.76, phi: 2.33}
    tags:
      - {number: 1, file: tag_01.png}

``coords.xml`` holds the same as <coordinate1> x y phi </coordinate1> and so on, ``templates.xml`` as
<templates> "tag_01.png" "tag_02.png" </templates>.
"""

from __future__ import annotations

import math
import os
import re
import shlex
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import List, Sequence, Tuple
from xml.etree import ElementTree

from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.inspection.boxes import Box, overlap
from yarm.yaml_fields import MOST_BYTES, Faults, Fields, load_yaml

MOST_BOXES, MOST_TAGS = 30, 100
FAR_M = 100.0
SAME_M = 0.01
"""Boxes nearer than this to each other are one box given twice."""
OVERLAP_M = 0.15
"""Boxes may be given as overlapping by less than this: their poses are measured."""


@dataclass(frozen=True)
class TagFile:
    """A tag image: its number from 1, and its file."""

    number: int
    path: Path


def read_boxes(path: Path) -> Tuple[Box, ...]:
    """The boxes of a YAML or an OpenCV storage file, in the order of their numbers.

    Raises:
        SceneError: faults, all listed: file, key, value, what was expected.
    """
    faults = Faults(str(path))
    boxes = _boxes_of_xml(path, faults) if path.suffix == ".xml" else _boxes_of_yaml(path, faults)
    faults.raise_if_any()
    _check(boxes, faults)
    faults.raise_if_any()
    return tuple(sorted(boxes, key=lambda box: box.number))


def read_tags(path: Path) -> Tuple[TagFile, ...]:
    """The tag images that a YAML or an OpenCV storage file names; relative paths are beside the file.

    Raises:
        SceneError: faults, all listed: file, key, value, what was expected.
    """
    faults = Faults(str(path))
    tags = _tags_of_xml(path, faults) if path.suffix == ".xml" else _tags_of_yaml(path, faults)
    if not 1 <= len(tags) <= MOST_TAGS:
        faults.add("tags", f"{len(tags)} tags", f"1 to {MOST_TAGS}")
    numbers = [tag.number for tag in tags]
    for tag in tags:
        if numbers.count(tag.number) > 1:
            faults.add("tags", tag.number, "numbers that are given once")
        if not tag.path.is_file():
            faults.add("tags", os.path.relpath(tag.path, path.parent), "an image file that is there, beside this one")
    faults.raise_if_any()
    return tuple(sorted(tags, key=lambda tag: tag.number))


def _boxes_of_yaml(path: Path, faults: Faults) -> List[Box]:
    top = Fields(load_yaml(path), "", faults)
    boxes = []
    for i, entry in enumerate(top.entries("boxes", MOST_BOXES)):
        number = entry.whole("number", 1, 9999, i + 1)
        x, y = (entry.number(axis, -FAR_M, FAR_M, "m") for axis in ("x", "y"))
        phi = entry.number("phi", -2 * math.pi, 2 * math.pi, "rad (degrees are not meant)")
        size = entry.numbers("size", 3, 0.05, 5.0, list(astuple(BoxSize())))
        boxes.append(Box(number, Pose2(x, y, phi), BoxSize(*size)))
        entry.finish()
    top.finish("tags")
    return boxes


def _tags_of_yaml(path: Path, faults: Faults) -> List[TagFile]:
    top = Fields(load_yaml(path), "", faults)
    tags = []
    for i, entry in enumerate(top.entries("tags", MOST_TAGS)):
        tags.append(TagFile(entry.whole("number", 1, 9999, i + 1), path.parent / entry.text("file")))
        entry.finish()
    top.finish("boxes")
    return tags


def _boxes_of_xml(path: Path, faults: Faults) -> List[Box]:
    boxes = []
    for element in _storage(path, faults):
        match = re.fullmatch(r"coordinate(\d{1,4})", element.tag)
        if match is None:
            faults.add(element.tag, element.text or "", "<coordinate1>, <coordinate2> ...")
            continue
        values = _numbers(element.text or "")
        if len(values) != 3:
            faults.add(element.tag, element.text or "", "three finite numbers: x and y in metres, phi in rad")
        elif max(abs(values[0]), abs(values[1])) > FAR_M or abs(values[2]) > 2 * math.pi:
            faults.add(element.tag, values, f"x and y within {FAR_M:g} m, phi within 2 pi rad (degrees are not meant)")
        else:
            boxes.append(Box(int(match.group(1)), Pose2(*values)))
    return boxes


def _tags_of_xml(path: Path, faults: Faults) -> List[TagFile]:
    found = [element for element in _storage(path, faults) if element.tag == "templates"]
    if len(found) != 1:
        faults.add("templates", f"{len(found)} of them", "one <templates>")
        return []
    try:
        names = shlex.split(found[0].text or "")
    except ValueError:
        faults.add("templates", found[0].text or "", "file names in quotes")
        return []
    return [TagFile(i + 1, path.parent / name) for i, name in enumerate(names)]


def _storage(path: Path, faults: Faults) -> Sequence[ElementTree.Element]:
    """The elements of an <opencv_storage>; none, and a fault, when it is not one."""
    expected = "an <opencv_storage> file without entities"
    if not path.is_file():
        faults.add("", str(path), "a file that is there")
        return ()
    if path.stat().st_size > MOST_BYTES:
        faults.add("", f"{path.stat().st_size} bytes", f"at most {MOST_BYTES}")
        return ()
    text = path.read_text(errors="replace")
    if "<!" in text:
        faults.add("", "<!", expected)
        return ()
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        faults.add("", str(error), expected)
        return ()
    if root.tag != "opencv_storage":
        faults.add("", f"<{root.tag}>", expected)
        return ()
    return list(root)


def _numbers(text: str) -> List[float]:
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        return []
    return values if all(math.isfinite(value) for value in values) else []


def _check(boxes: Sequence[Box], faults: Faults) -> None:
    if not 1 <= len(boxes) <= MOST_BOXES:
        faults.add("boxes", f"{len(boxes)} boxes", f"1 to {MOST_BOXES}")
    for i, box in enumerate(boxes):
        for other in boxes[:i]:
            pair = f"boxes {other.number} and {box.number}"
            if box.number == other.number:
                faults.add("boxes", box.number, "numbers that are given once")
            if box.pose.distance(other.pose) < SAME_M:
                faults.add("boxes", pair, f"places at least {SAME_M:g} m apart; one box is given twice")
            elif overlap(box, other) > OVERLAP_M:
                deep = overlap(box, other)
                faults.add("boxes", pair, f"boxes that overlap by {OVERLAP_M:g} m at most, not by {deep:.2f} m")
