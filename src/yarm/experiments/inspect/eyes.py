"""Looking at a box: pictures drawn from where the robot really is, read by ours or by the report's recognition."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from typing import Callable, Dict, List, Mapping, Optional, Sequence

import numpy as np

from yarm.experiments.inspect.record import LookRecord
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, level_camera
from yarm.geometry.scans import Scan
from yarm.inspection.boxes import Box
from yarm.inspection.model import BLANK, UNSEEN, Look, Reading
from yarm.inspection.reading import face_view, predicted_deg, reading_of, stands
from yarm.robots.turtlebot import CAMERA_Z_M, RGB_MOUNT
from yarm.sim.scenes.layout import WALL_HIGH_M, Layout
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, RgbFrame, Room, TaggedBox
from yarm.tags.evidence import BoxEvidence
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import BLANKS, blank, shipped_pictures
from yarm.tags.printed import printed_verdict, row_of
from yarm.tags.recogniser import Recogniser
from yarm.tags.report import ReportRecogniser, Sighting

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
        """Hang the pictures up."""
        rng = np.random.default_rng((seed, 7))
        tags = shipped_pictures()
        shown = [
            TaggedBox(box.pose, box.size, self._picture(tag, tags, rng))
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

    @staticmethod
    def _picture(tag: int, tags: Mapping[int, GreyImage], rng: np.random.Generator) -> GreyImage:
        if tag == BLANK:
            return blank(BLANKS[int(rng.integers(len(BLANKS)))], int(rng.integers(1000)))
        return tags[tag]


class OurEyes:
    """Ours: from where the robot believes to be, until it is sure."""

    def __init__(self, layout: Layout, camera: Camera, on_look: OnLook) -> None:
        """Learn the tags."""
        self._boxes = {box.number: box for box in boxes_of(layout)}
        self._camera = camera
        self._on_look = on_look
        self._recogniser = Recogniser(shipped_pictures())
        self._evidence: Dict[int, BoxEvidence] = {}
        self.computing_s = 0.0

    def look(self, order: Look, moment: Moment) -> Optional[Reading]:
        """One more image of the box; a reading once it is final."""
        box = self._boxes[order.box]
        picture = self._camera.picture(moment.true)
        began = process_time()
        evidence = self._evidence.setdefault(order.box, BoxEvidence(order.box))
        there = stands(moment.scan, moment.believed, box)
        view = face_view(moment.believed, box, list(self._boxes.values()), there)
        look = self._recogniser.look(picture, view)
        evidence.add(look, moment.believed)
        final = evidence.verdict().final
        self.computing_s += process_time() - began
        self._on_look(LookRecord(moment.t_s, order.box, moment.believed, picture, look))
        return self.reading(order.box) if final else None

    def reading(self, box: int) -> Reading:
        """What is known of a box so far."""
        return reading_of(self._evidence[box].verdict(), self._boxes[box])


class ReportEyes:
    """The report's: all images it asked for, then the vote."""

    def __init__(self, layout: Layout, camera: Camera, on_look: OnLook) -> None:
        """Learn the tags."""
        self._boxes = {box.number: box for box in boxes_of(layout)}
        self._camera = camera
        self._on_look = on_look
        self._recogniser = ReportRecogniser(shipped_pictures())
        self._sightings: Dict[int, List[Sighting]] = {}
        self.computing_s = 0.0

    def look(self, order: Look, moment: Moment) -> Optional[Reading]:
        """One more image of the box; never enough before the last."""
        picture = self._camera.picture(moment.true)
        began = process_time()
        seen: Sequence[Sighting] = self._recogniser.look(
            picture, order.box, predicted_deg(moment.goal, self._boxes[order.box])
        )
        self.computing_s += process_time() - began
        self._sightings.setdefault(order.box, []).extend(seen)
        self._on_look(LookRecord(moment.t_s, order.box, moment.believed, picture, sightings=tuple(seen)))
        return None

    def reading(self, box: int) -> Reading:
        """The vote over everything seen of a box; it knows no probability."""
        sightings = self._sightings.get(box, [])
        if not sightings:
            return Reading(UNSEEN)
        return Reading(self._recogniser.verdict(sightings).tag, 1.0)


class PrintedEyes(ReportEyes):
    """The printed program's: whole images, and its vote."""

    def __init__(self, layout: Layout, camera: Camera, on_look: OnLook) -> None:
        """Learn the tags."""
        super().__init__(layout, camera, on_look)
        self._recogniser = ReportRecogniser(shipped_pictures(), crop=False)

    def reading(self, box: int) -> Reading:
        """The printed vote, whose tags are numbered from 0; UNSEEN for a box that gets no line."""
        verdict = printed_verdict([row_of(sighting) for sighting in self._sightings.get(box, [])])
        if verdict.tag is None:
            return Reading(UNSEEN)
        return Reading(verdict.tag + 1, 1.0)
