"""The report's eyes with those of its program's faults that are the camera's or the recognition's."""

from __future__ import annotations

from typing import Optional

from yarm.experiments.inspect.eyes import Camera, Eyes, Moment, OnLook, boxes_of
from yarm.experiments.inspect.switches import Switches
from yarm.geometry import Pose2
from yarm.inspection.model import PRINTED, REPORT, Look, Reading
from yarm.inspection.readers import Reader, ReportReader, make_reader
from yarm.sim.scenes.layout import Layout
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import shipped_pictures
from yarm.tags.report import ReportRecogniser

LOST_EVERY = 3
"""One in so many images does not come."""


class StillCamera(Camera):
    """Gives the same frame as long as the robot stands, as a camera does that has none newer."""

    def __init__(self, layout: Layout, seed: int) -> None:
        """As its base."""
        super().__init__(layout, seed)
        self._at: Optional[Pose2] = None
        self._still: Optional[GreyImage] = None

    def picture(self, robot: Pose2) -> GreyImage:
        """The frame of the moment at which the robot came to this pose."""
        if self._still is None or robot != self._at:
            self._at, self._still = robot, super().picture(robot)
        return self._still


class LosingEyes(Eyes):
    """Every third image does not come, and the reader is told so."""

    def __init__(self, reader: Reader, camera: Camera, on_look: OnLook, printed: bool) -> None:
        """As its base."""
        super().__init__(reader, camera, on_look, printed)
        self._frames = 0

    def look(self, order: Look, moment: Moment) -> Optional[Reading]:
        """One more image of the box, or none."""
        self._frames += 1
        if self._frames % LOST_EVERY == 0:
            self._reader.missed(order.box, 1)
            return None
        return super().look(order, moment)


def switched_eyes(layout: Layout, camera: Camera, on_look: OnLook, switches: Switches) -> Eyes:
    """The report's eyes with some of the faults."""
    boxes, tags = boxes_of(layout), shipped_pictures()
    reader = make_reader(PRINTED if switches.printed_vote else REPORT, boxes, tags)
    if switches.whole_images:
        reader = ReportReader(boxes, ReportRecogniser(tags, crop=False))
    return (LosingEyes if switches.frames_lost else Eyes)(reader, camera, on_look, switches.printed_vote)
