"""Ours and the report's recognition behind one face."""

from __future__ import annotations

import pytest

from yarm.experiments.inspect.eyes import Camera, boxes_of
from yarm.geometry import Pose2
from yarm.inspection.model import BLANK, OURS, PRINTED, REPORT, UNSEEN
from yarm.inspection.readers import OurReader, ReportReader, Shot, make_reader
from yarm.sim.checks.layout_check import sights
from yarm.sim.scenes.layout_maker import make_layout
from yarm.tags.features import DetectorError, available_detectors
from yarm.tags.pictures import shipped_pictures

LAYOUT = make_layout("open", 0)
BOX = next(i + 1 for i, tag in enumerate(LAYOUT.tags) if tag > 0)
PLACE = next(sight.pose for sight in sights(LAYOUT) if sight.box == BOX) or Pose2(0.0, 0.0)
TAGS = shipped_pictures()


def test_ours_is_final_with_evidence() -> None:
    reader = make_reader("yarm", boxes_of(LAYOUT), TAGS)
    assert isinstance(reader, OurReader)
    assert reader.reading(BOX).tag == UNSEEN and reader.evidence(BOX) is None
    read = reader.read(BOX, Shot(Camera(LAYOUT, 1).picture(PLACE), PLACE))
    assert read.final and read.look is not None and read.trouble == ""
    evidence = reader.evidence(BOX)
    assert evidence is not None and evidence.answer == reader.reading(BOX).tag == LAYOUT.tags[BOX - 1]


def test_a_look_ends_at_the_probability_that_is_asked_for() -> None:
    """A look that is final for who asks for a little less than it knows is not for who asks for more."""
    aside = PLACE.compose(Pose2(0.0, 0.0, 0.35))
    shot = Shot(Camera(LAYOUT, 1).picture(aside), aside)
    reader = make_reader(OURS, boxes_of(LAYOUT), TAGS)
    reader.read(BOX, shot)
    known = reader.reading(BOX).probability
    assert 0.5 < known < 1.0
    for sure, final in ((0.999 * known, True), (0.5 + 0.5 * known, False)):
        asked = make_reader(OURS, boxes_of(LAYOUT), TAGS, sure)
        assert asked.read(BOX, shot).final is final, sure
        evidence = asked.evidence(BOX)
        assert evidence is not None and evidence.final is final and (evidence.reason == "") is final


def test_a_picture_of_something_else_says_why_it_is_of_no_use() -> None:
    reader = make_reader("yarm", boxes_of(LAYOUT), TAGS)
    away = PLACE.compose(Pose2(0.0, 0.0, 3.0))
    read = reader.read(BOX, Shot(Camera(LAYOUT, 1).picture(away), away))
    assert not read.final and "behind, beside or too steep" in read.trouble


def test_the_report_is_never_final() -> None:
    reader = make_reader("report", boxes_of(LAYOUT), TAGS)
    assert isinstance(reader, ReportReader) and reader.reading(BOX).tag == UNSEEN
    camera = Camera(LAYOUT, 1)
    reads = [reader.read(BOX, Shot(camera.picture(PLACE), PLACE)) for _ in range(12)]
    assert not any(read.final for read in reads) and reads[0].look is None and len(reads[0].sightings) == len(TAGS)
    assert reader.reading(BOX).tag == LAYOUT.tags[BOX - 1] and reader.evidence(BOX) is None


def test_the_report_matches_the_features_that_are_asked_for() -> None:
    one, picture = {7: TAGS[7]}, Camera(LAYOUT, 1).picture(PLACE)
    keypoints = {}
    for name in available_detectors():
        for controller in (REPORT, PRINTED):
            reader = make_reader(controller, boxes_of(LAYOUT), one, detector=name)
            (seen,) = reader.read(BOX, Shot(picture, PLACE)).sightings
            keypoints[controller, name] = seen.keypoints
    assert len(set(keypoints.values())) == len(keypoints), keypoints
    (usual,) = make_reader(REPORT, boxes_of(LAYOUT), one).read(BOX, Shot(picture, PLACE)).sightings
    assert usual.keypoints == keypoints[REPORT, "sift"]


def test_a_detector_that_the_build_does_not_have_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("yarm.tags.features._surf", lambda: None)
    with pytest.raises(DetectorError, match="detector 'surf': the installed OpenCV has sift, orb, akaze"):
        make_reader(REPORT, boxes_of(LAYOUT), {7: TAGS[7]}, detector="surf")


def test_a_picture_that_did_not_come_speaks_for_every_tag_to_the_printed_program_alone() -> None:
    for controller, expected in ((PRINTED, UNSEEN), (REPORT, UNSEEN), (OURS, UNSEEN)):
        reader = make_reader(controller, boxes_of(LAYOUT), TAGS)
        reader.missed(BOX, 8)
        assert reader.reading(BOX).tag == expected, controller
    one = make_reader(PRINTED, boxes_of(LAYOUT), {7: TAGS[7]})
    one.missed(BOX, 8)
    assert one.reading(BOX).tag == BLANK, "eight votes for the only tag are fewer than ten in all"
    one.missed(BOX, 2)
    assert one.reading(BOX).tag == 7
