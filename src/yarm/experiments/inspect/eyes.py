"""Looking at a box: pictures drawn from where the robot really is, read by ours or by the report's recognition."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from typing import Callable, List, Optional

import numpy as np

from yarm.experiments.inspect.record import LookRecord
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, level_camera
from yarm.geometry.scans import Scan
from yarm.inspection.boxes import Box
from yarm.inspection.model import BLANK, PRINTED, UNKNOWN, Look, Reading
from yarm.inspection.readers import Reader, Shot, make_reader
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_MOUNT
from yarm.sim.scenes.layout import WALL_HIGH_M, Layout
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, RgbFrame, Room, TaggedBox
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import BLANKS, STRANGERS, blank, shipped_pictures, stranger

OnLook = Callable[[LookRecord], None]
"""Told of each image that was looked at."""


@dataclass(frozen=True)
class Moment:
    """What the robot is given for one look.

    Attributes:
        t_s: time since the start.
        true: where the robot is, world.
        believed: where it believes to be.
        scan: of its range sensor.
        goal: of its last drive, map.
    """

    t_s: float
    true: Pose2
    believed: Pose2
    scan: Scan
    goal: Pose2


def boxes_of(layout: Layout) -> List[Box]:
    """The boxes as a round is told of them."""
    return [
        Box(i + 1, block.pose, BoxSize(block.size[1], block.size[0], block.size[2]))
        for i, block in enumerate(layout.boxes)
    ]


class Camera:
    """Draws what the robot sees in a layout, under a light that the seed chooses."""

    def __init__(self, layout: Layout, seed: int) -> None:
        """Hang the pictures up: of UNKNOWN tags strangers', the boxes' numbers choose which."""
        rng = np.random.default_rng((seed, 7))
        tags = shipped_pictures()

        def picture(tag: int) -> GreyImage:
            if tag == BLANK:
                return blank(BLANKS[int(rng.integers(len(BLANKS)))], int(rng.integers(1000)))
            return tags[tag]

        shown = [
            TaggedBox(box.pose, box.size, stranger(box.number % STRANGERS) if tag == UNKNOWN else picture(tag))
            for box, tag in zip(boxes_of(layout), layout.tags)
        ]
        self._room = Room(layout.arena.lower, layout.arena.upper, WALL_HIGH_M, tuple(shown))
        light = (float(rng.uniform(-0.6, 0.6)), float(rng.uniform(-0.6, 0.6)), 1.0)
        self._imaging = Imaging(light, gain=float(rng.uniform(0.8, 1.1)), blur_px=float(rng.uniform(0.5, 1.2)))
        self._camera = RgbCamera(seed=seed)
        self._frames = 0

    def picture(self, robot: Pose2) -> GreyImage:
        """The next frame from the robot's true pose."""
        self._frames += 1
        return self.frame(robot, self._frames).grey

    def frame(self, robot: Pose2, number: int) -> RgbFrame:
        """The frame of a number from the robot's true pose: the same for the same number and pose."""
        pose = level_camera(robot, RGB_MOUNT, CAMERA_Z_M)
        return self._camera.render(self._room, pose, self._imaging, number)


class Eyes:
    """Takes the pictures, has them read, and tells of each."""

    def __init__(self, reader: Reader, camera: Camera, on_look: OnLook, printed: bool = False) -> None:
        """Nothing seen.

        Args:
            reader: reads the pictures.
            camera: draws them.
            on_look: told of each.
            printed: whether the reader is the printed program's.
        """
        self._reader, self._camera, self._on_look, self._printed = reader, camera, on_look, printed
        self.computing_s = 0.0

    def look(self, order: Look, moment: Moment) -> Optional[Reading]:
        """One more image of the box; a reading once that is enough."""
        picture = self._camera.picture(moment.true)
        began = process_time()
        read = self._reader.read(order.box, Shot(picture, moment.believed, moment.scan, moment.goal))
        reading = self._reader.reading(order.box) if read.final else None
        self.computing_s += process_time() - began
        self._on_look(LookRecord.of(moment.t_s, read, self._printed))
        return reading

    def reading(self, box: int) -> Reading:
        """What is known of a box so far."""
        return self._reader.reading(box)


def make_eyes(controller: str, layout: Layout, camera: Camera, on_look: OnLook) -> Eyes:
    """The eyes that go with a controller."""
    reader = make_reader(controller, boxes_of(layout), shipped_pictures())
    return Eyes(reader, camera, on_look, controller == PRINTED)
