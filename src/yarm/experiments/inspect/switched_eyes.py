"""The report's eyes with those of its program's faults that are the camera's or the recognition's, or mended."""

from __future__ import annotations

import dataclasses
from typing import List, Mapping, Optional

from yarm.experiments.inspect.eyes import Camera, Eyes, Moment, OnLook, boxes_of
from yarm.experiments.inspect.switches import LARGE_PX2, LEAST_INLIERS, STRANGE_EVERY, Switches
from yarm.geometry import Pose2
from yarm.inspection.model import BLANK, PRINTED, REPORT, UNKNOWN, Look, Reading
from yarm.inspection.readers import Reader, ReportReader, make_reader
from yarm.sim.scenes.layout import Layout
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import shipped_pictures
from yarm.tags.report import NO_HOMOGRAPHY, ReportRecogniser, Sighting

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


class StricterRecogniser(ReportRecogniser):
    """The report's, to which an outline does not count that is too small, or that too few matches agree with."""

    def __init__(self, tags: Mapping[int, GreyImage], least_px2: float, least_inliers: int) -> None:
        """With these tags.

        Args:
            tags: by their numbers.
            least_px2: area from which on an outline counts.
            least_inliers: matches that must agree with the homography.
        """
        super().__init__(tags)
        self._least_px2, self._least_inliers = least_px2, least_inliers

    def look(self, image: Optional[GreyImage], box: int = 0, predicted_deg: float = 90.0) -> List[Sighting]:
        """As its base; what does not count here has no homography."""
        seen = super().look(image, box, predicted_deg)
        return [s if s.rejection or self._counts(s) else dataclasses.replace(s, status=NO_HOMOGRAPHY) for s in seen]

    def _counts(self, sighting: Sighting) -> bool:
        return sighting.area_px2 >= self._least_px2 and sighting.inliers >= self._least_inliers


def with_strangers(layout: Layout) -> Layout:
    """The layout with a stranger's picture in place of every third tag, blanks not counted."""
    tagged = [place for place, tag in enumerate(layout.tags) if tag != BLANK]
    strange = set(tagged[STRANGE_EVERY - 1 :: STRANGE_EVERY])
    return dataclasses.replace(layout, tags=tuple(UNKNOWN if i in strange else t for i, t in enumerate(layout.tags)))


def switched_eyes(layout: Layout, camera: Camera, on_look: OnLook, switches: Switches) -> Eyes:
    """The report's eyes with some of the faults."""
    boxes, tags = boxes_of(layout), shipped_pictures()
    reader = make_reader(PRINTED if switches.printed_vote else REPORT, boxes, tags)
    if switches.whole_images:
        reader = ReportReader(boxes, ReportRecogniser(tags, crop=False))
    elif switches.large_only or switches.inliers_used:
        least_px2 = LARGE_PX2 if switches.large_only else 0.0
        reader = ReportReader(boxes, StricterRecogniser(tags, least_px2, LEAST_INLIERS * switches.inliers_used))
    return (LosingEyes if switches.frames_lost else Eyes)(reader, camera, on_look, switches.printed_vote)
