"""Reading boxes from pictures: ours, or the report's recognition, behind one face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Dict, List, Mapping, Optional, Protocol, Sequence, Tuple

from yarm.geometry import Pose2
from yarm.geometry.scans import Scan
from yarm.inspection.boxes import Box
from yarm.inspection.model import OURS, PRINTED, UNSEEN, Reading
from yarm.inspection.reading import face_view, predicted_deg, reading_of, stands
from yarm.tags.evidence import ACCEPTING, BoxEvidence, TagVerdict
from yarm.tags.features import DETECTOR
from yarm.tags.motifs import GreyImage
from yarm.tags.printed import printed_verdict, row_of
from yarm.tags.recogniser import Look, Recogniser
from yarm.tags.report import ReportRecogniser, Sighting


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture, and what is known of the moment it was taken.

    Attributes:
        picture: (h, w) grey.
        robot: where the robot believes to be, map.
        scan: of its range sensor; None while there is none.
        goal: of its last drive, map; None before the first.
    """

    picture: GreyImage
    robot: Pose2
    scan: Optional[Scan] = None
    goal: Optional[Pose2] = None


@dataclass(frozen=True, eq=False)
class PictureRead:
    """What one picture told of a box.

    Attributes:
        box: its number.
        shot: the picture.
        look: what ours made of it; None for the report's.
        sightings: what the report made of it, a tag each; empty for ours.
        final: no further picture is needed.
        trouble: why the picture could not be used; empty when it could.
    """

    box: int
    shot: Shot
    look: Optional[Look] = None
    sightings: Tuple[Sighting, ...] = ()
    final: bool = False
    trouble: str = ""


class Reader(Protocol):
    """Reads boxes, picture by picture."""

    def read(self, box: int, shot: Shot) -> PictureRead:
        """One more picture of a box."""

    def missed(self, box: int, images: int) -> None:
        """So many pictures of a box did not come."""

    def reading(self, box: int) -> Reading:
        """What is known of a box so far."""

    def evidence(self, box: int) -> Optional[TagVerdict]:
        """What that rests on; None where there is no evidence of ours."""


class OurReader:
    """Ours: only what lies where the box must be, until it is sure."""

    def __init__(self, boxes: Sequence[Box], recogniser: Recogniser, sure: float = ACCEPTING) -> None:
        """Nothing seen; a look ends at this probability."""
        self._boxes = {box.number: box for box in boxes}
        self._recogniser = recogniser
        self._sure = sure
        self._evidence: Dict[int, BoxEvidence] = {}

    def read(self, box: int, shot: Shot) -> PictureRead:
        """One more picture of a box."""
        there = None if shot.scan is None else stands(shot.scan, shot.robot, self._boxes[box])
        view = face_view(shot.robot, self._boxes[box], list(self._boxes.values()), there)
        look = self._recogniser.look(shot.picture, view)
        evidence = self._evidence.setdefault(box, BoxEvidence(box, self._sure))
        evidence.add(look, shot.robot)
        return PictureRead(box, shot, look, (), evidence.verdict().final, look.reason)

    def missed(self, box: int, images: int) -> None:
        """No picture, no opinion."""

    def reading(self, box: int) -> Reading:
        """What is known of a box so far."""
        verdict = self.evidence(box)
        return Reading() if verdict is None else reading_of(verdict, self._boxes[box])

    def evidence(self, box: int) -> Optional[TagVerdict]:
        """What that rests on."""
        return self._evidence[box].verdict() if box in self._evidence else None


class ReportReader:
    """The report's: as many pictures as there are, then the vote. It knows no probability."""

    def __init__(self, boxes: Sequence[Box], recogniser: ReportRecogniser) -> None:
        """Nothing seen."""
        self._boxes = {box.number: box for box in boxes}
        self._recogniser = recogniser
        self._sightings: Dict[int, List[Sighting]] = {}

    def read(self, box: int, shot: Shot) -> PictureRead:
        """One more picture of a box; never enough before the last."""
        angle = predicted_deg(shot.goal or shot.robot, self._boxes[box])
        seen = self._recogniser.look(shot.picture, box, angle)
        self._sightings.setdefault(box, []).extend(seen)
        return PictureRead(box, shot, None, tuple(seen))

    def missed(self, box: int, images: int) -> None:
        """They count as nothing."""

    def reading(self, box: int) -> Reading:
        """The vote over everything seen of a box."""
        sightings = self._sightings.get(box, [])
        return Reading(self._recogniser.verdict(sightings).tag, 1.0) if sightings else Reading(UNSEEN)

    def evidence(self, box: int) -> Optional[TagVerdict]:
        """None: votes are no evidence of ours."""
        return None


class PrintedReader(ReportReader):
    """The printed program's: its vote over whole pictures, in which one that did not come speaks for every tag."""

    def missed(self, box: int, images: int) -> None:
        """A row for each tag and picture."""
        for _ in range(images):
            self._sightings.setdefault(box, []).extend(self._recogniser.look(None, box))

    def reading(self, box: int) -> Reading:
        """The printed vote, whose tags are numbered from 0; UNSEEN for a box that gets no line."""
        verdict = printed_verdict([row_of(seen) for seen in self._sightings.get(box, [])])
        return Reading(UNSEEN) if verdict.tag is None else Reading(verdict.tag + 1, 1.0)


def make_reader(
    controller: str,
    boxes: Sequence[Box],
    tags: Mapping[int, GreyImage],
    sure: float = ACCEPTING,
    detector: str = DETECTOR,
) -> Reader:
    """The reader that goes with a controller.

    Args:
        controller: whose round is driven.
        boxes: known boxes.
        tags: their pictures, by number.
        sure: probability at which ours ends a look.
        detector: whose features the report's match.

    Raises:
        DetectorError: the installed OpenCV does not have this detector.
    """
    if controller == OURS:
        return OurReader(boxes, Recogniser(tags), sure)
    if controller == PRINTED:
        return PrintedReader(boxes, ReportRecogniser(tags, detector, crop=False))
    return ReportReader(boxes, ReportRecogniser(tags, detector))
