"""Ours: the tag on a box whose pose is known; the report's known faults are gone."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, Sequence

import numpy as np
import pytest

from python.tags.tag_views import BOX, TAGS, camera_at, robot_at, room_of, tagged, view, view_across_the_room
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.sim.sensors.rgb_camera import Imaging, RgbCamera, TaggedBox
from yarm.tags.calibration import BLANK, UNKNOWN
from yarm.tags.evidence import ACCEPTING, BoxEvidence
from yarm.tags.face_view import FaceView
from yarm.tags.pictures import BLANKS, blank, hard_set, stranger
from yarm.tags.recogniser import Finding, Look, Recogniser, Status
from yarm.tags.report import ImageError

ERROR = Pose2(0.012, -0.01, 0.012)
"""What the robot's pose is off by."""


@pytest.fixture(scope="module")
def recogniser() -> Recogniser:
    return Recogniser(TAGS)


def look(recogniser: Recogniser, boxes: Sequence[TaggedBox], robot: Pose2, imaging: Any = None, **changes: Any) -> Look:
    """What is made of the box at BOX from a robot whose pose is a little wrong."""
    frame = RgbCamera().render(room_of(boxes), camera_at(robot), imaging or Imaging())
    return recogniser.look(frame.grey, FaceView(camera_at(robot.compose(ERROR)), BOX, **changes))


@pytest.mark.parametrize("number", TAGS)
def test_each_tag_is_named_from_ahead_and_from_the_side(recogniser: Recogniser, number: int) -> None:
    for distance, angle in ((0.5, 0.0), (0.8, 45.0), (0.5, -60.0)):
        seen = look(recogniser, [tagged(TAGS[number])], robot_at(distance, angle))
        assert (seen.status, seen.finding, seen.answer) == (Status.LOOKED, Finding.IN_PLACE, number)
        assert seen.probabilities[number] > 0.999
        assert sum(seen.probabilities.values()) == pytest.approx(1.0)
        assert len(seen.probabilities) == 17
        assert seen.measured is not None
        assert seen.measured.distance(BOX) < 0.05


def test_a_hundred_tags_can_be_looked_for() -> None:
    rng = np.random.default_rng(5)
    more = {n: np.kron(rng.integers(0, 256, (20, 25), np.uint8), np.ones((8, 8), np.uint8)) for n in range(16, 101)}
    seen = look(Recogniser({**TAGS, **more}), [tagged(TAGS[7])], robot_at(0.5, 20.0))
    assert seen.answer == 7 and seen.probabilities[7] > 0.999 and len(seen.probabilities) == 102
    seen = look(Recogniser({**TAGS, **more}), [tagged(more[57])], robot_at(0.5, 20.0))
    assert seen.answer == 57 and seen.probabilities[57] > 0.999


@pytest.mark.parametrize("kind", BLANKS)
def test_a_blank_face_is_blank(recogniser: Recogniser, kind: str) -> None:
    for angle in (0.0, 40.0):
        seen = look(recogniser, [tagged(blank(kind))], robot_at(0.5, angle))
        assert seen.answer == BLANK, (kind, angle, seen.texture)


@pytest.mark.parametrize("number", range(10))
def test_a_strangers_tag_is_unknown(recogniser: Recogniser, number: int) -> None:
    seen = look(recogniser, [tagged(stranger(number))], robot_at(0.6, 20.0))
    assert seen.answer == UNKNOWN
    assert max(p for tag, p in seen.probabilities.items() if tag > 0) < 0.05


def test_the_hard_set_is_told_apart() -> None:
    hard = hard_set()
    recogniser = Recogniser(hard)
    for number, picture in hard.items():
        seen = look(recogniser, [tagged(picture)], robot_at(0.6, 15.0))
        assert seen.answer == number, (number, [(f.tag, f.likeness, f.inliers) for f in seen.fits[:3]])


@pytest.mark.parametrize("changes", [{"blur_px": 4.0}, {"gain": 0.25}, {"gain": 1.6}, {"noise": 8.0}], ids=str)
def test_blur_light_and_noise_are_borne(recogniser: Recogniser, changes: Any) -> None:
    for number in (1, 8, 11):
        seen = look(recogniser, [tagged(TAGS[number])], robot_at(0.8, 30.0), Imaging(**changes))
        assert seen.answer == number


def test_the_angle_of_the_view_is_known_from_the_pose() -> None:
    for angle in (-60.0, -20.0, 0.0, 45.0):
        T_world_optical = camera_at(Pose2(0.087, 0.0, 0.0).inverse().compose(Pose2(0, 0)).compose(robot_at(0.5, angle)))
        assert abs(FaceView(T_world_optical, BOX).angle_deg) <= 90.0
    face = FaceView(camera_at(robot_at(0.7, 40.0)), BOX, BoxSize(depth=0.0))
    other = FaceView(camera_at(robot_at(0.7, -40.0)), BOX, BoxSize(depth=0.0))
    assert abs(face.angle_deg) == pytest.approx(40.0, abs=1.0)
    assert face.angle_deg == pytest.approx(-other.angle_deg)


class TestKnownFaultsAreGone:
    """The cases of test_report.py and test_printed.py."""

    def test_copies_of_one_frame_weigh_as_one(self, recogniser: Recogniser) -> None:
        doubtful = Look(Status.LOOKED, probabilities={1: 0.6, BLANK: 0.2, UNKNOWN: 0.2}, finding=Finding.IN_PLACE)
        copies = BoxEvidence(3)
        for _ in range(21):
            copies.add(doubtful, Pose2(0.0, 0.0))
        assert copies.verdict().probability == pytest.approx(0.6)
        assert not copies.verdict().final
        assert "look from another place" in copies.verdict().reason
        moving = BoxEvidence(3)
        for x in (0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2):
            moving.add(doubtful, Pose2(x, 0.0))
        assert moving.verdict().final
        assert moving.verdict().places == 7

    def test_a_dark_or_burnt_picture_is_not_a_blank_box(self, recogniser: Recogniser) -> None:
        for gain, status in ((0.01, Status.DARK), (6.0, Status.BURNT)):
            seen = look(recogniser, [tagged(TAGS[2])], robot_at(), Imaging(gain=gain))
            assert (seen.status, seen.answer) == (status, None)
            evidence = BoxEvidence(1)
            evidence.add(seen, robot_at())
            assert (evidence.verdict().text, evidence.verdict().images) == ("none", 1)
            assert evidence.verdict().reason == seen.reason != ""

    def test_no_frames_are_no_verdict(self) -> None:
        verdict = BoxEvidence(4).verdict()
        assert (verdict.answer, verdict.probability, verdict.reason) == (None, 0.0, "no image has come")

    def test_a_neighbour_in_view_cannot_vote(self, recogniser: Recogniser) -> None:
        at = BOX.compose(Pose2(0.0, 0.55, 0.0))
        robot = robot_at(0.8, turn_deg=-12.0)
        known = look(recogniser, [tagged(None), tagged(TAGS[8], at)], robot, others=((at, BoxSize()),))
        assert known.answer == BLANK
        assert known.probabilities[8] < 1e-3

    def test_a_neighbour_that_stands_a_little_beside_its_known_place_cannot_vote(self, recogniser: Recogniser) -> None:
        """What sticks out beside its mask is enough to be found in the rest of the image."""
        at = BOX.compose(Pose2(-0.15, 0.58, 0.0))
        told = ((BOX.compose(Pose2(-0.15, 0.85, 0.0)), BoxSize()),)
        robot = robot_at(1.1, 10.0)
        boxes = [tagged(stranger(3)), tagged(TAGS[5], at)]
        assert look(recogniser, boxes, robot).answer == 5, "it is in view: with nobody told of it, it passes for moved"
        assert look(recogniser, boxes, robot, others=told).answer == UNKNOWN

    def test_a_tag_seen_from_the_side_is_named(self, recogniser: Recogniser) -> None:
        assert look(recogniser, [tagged(TAGS[8])], robot_at(0.5, 60.0)).answer == 8

    def test_a_tag_4_5_m_away_is_nobodys(self, recogniser: Recogniser) -> None:
        frame, robot = view_across_the_room(11)
        view_of_none = FaceView(camera_at(robot.compose(ERROR)), robot.compose(Pose2(0.5, 0.0, math.pi)))
        for stands in (None, True):
            probabilities = recogniser.look(frame.grey, replace(view_of_none, stands=stands)).probabilities
            assert probabilities[11] < 0.001
            assert max(probabilities.values()) < ACCEPTING
        seen = recogniser.look(frame.grey, replace(view_of_none, stands=False))
        assert (seen.finding, seen.answer) == (Finding.MISSING, None)

    def test_a_tag_seen_once_does_not_win_over_one_seen_often(self) -> None:
        """What is gathered is probability, place by place, and no sum that few large sightings reach, too."""

        def seen(tag: int, other: int) -> Look:
            shares = {tag: 0.9, other: 0.02, BLANK: 0.04, UNKNOWN: 0.04}
            return Look(Status.LOOKED, probabilities=shares, finding=Finding.IN_PLACE)

        evidence = BoxEvidence(3)
        for place in range(12):
            evidence.add(seen(1, 2), Pose2(0.2 * place, 0.0))
        evidence.add(seen(2, 1), Pose2(0.0, 1.0))
        assert (evidence.verdict().answer, evidence.verdict().final) == (1, True)

    def test_an_outline_that_few_matches_agree_on_is_no_tag(self, recogniser: Recogniser) -> None:
        seen = look(recogniser, [tagged(stranger(2))], robot_at(0.8, 30.0))
        assert seen.answer == UNKNOWN
        assert max(seen.probabilities[tag] for tag in TAGS) < 0.1

    def test_where_the_box_is_hidden_nothing_is_said(self, recogniser: Recogniser) -> None:
        post = BOX.compose(Pose2(0.3, 0.0, 0.0))
        size = BoxSize(0.48, 0.05, 0.4)
        seen = look(recogniser, [tagged(TAGS[8]), tagged(None, post, size)], robot_at(0.9), others=((post, size),))
        assert (seen.status, seen.answer) == (Status.HIDDEN, None)
        assert "% of the face is seen" in seen.reason


class TestHowTheBoxStands:
    """Boxes that are moved, missing or upside down are reported."""

    @pytest.mark.parametrize("by", [(-0.1, 0.13, 0.1), (0.0, -0.25, 0.0), (-0.15, 0.0, 0.35)], ids=str)
    def test_moved(self, recogniser: Recogniser, by: Any) -> None:
        now = BOX.compose(Pose2(*by))
        seen = look(recogniser, [tagged(TAGS[5], now)], robot_at(0.8))
        assert (seen.finding, seen.answer) == (Finding.MOVED, 5)
        assert seen.measured is not None
        assert seen.measured.distance(now) < 0.06

    def test_a_little_off_is_in_place(self, recogniser: Recogniser) -> None:
        seen = look(recogniser, [tagged(TAGS[5], BOX.compose(Pose2(0.02, 0.03, 0.05)))], robot_at(0.8))
        assert (seen.finding, seen.answer) == (Finding.IN_PLACE, 5)

    def test_upside_down(self, recogniser: Recogniser) -> None:
        seen = look(recogniser, [tagged(np.ascontiguousarray(TAGS[5][::-1, ::-1]))], robot_at(0.7, 10.0))
        assert (seen.finding, seen.answer) == (Finding.UPSIDE_DOWN, 5)

    def test_missing_by_the_range_sensor(self, recogniser: Recogniser) -> None:
        """By the image alone it stays open; no tag is named, and the place is not called blank."""
        for angle in (-40.0, -20.0, 0.0, 30.0):
            open_still = look(recogniser, [], robot_at(0.8, angle))
            assert (open_still.finding, open_still.answer) == (Finding.NOT_SEEN, None)
            assert open_still.reason == "neither a tag nor the outline of a box is seen"
        seen = look(recogniser, [], robot_at(0.8, -20.0), stands=False)
        assert (seen.finding, seen.reason) == (Finding.MISSING, "nothing stands where the box must be")

    def test_a_blank_box_that_the_range_sensor_sees_is_not_missing(self, recogniser: Recogniser) -> None:
        seen = look(recogniser, [tagged(None)], robot_at(0.8, -20.0), stands=True)
        assert (seen.finding, seen.answer) == (Finding.IN_PLACE, BLANK)

    def test_from_behind_nothing_is_said(self, recogniser: Recogniser) -> None:
        seen = look(recogniser, [tagged(TAGS[5])], robot_at(0.8, 150.0))
        assert (seen.status, seen.answer) == (Status.OUT_OF_VIEW, None)


def test_an_image_of_another_size_or_kind_is_refused(recogniser: Recogniser) -> None:
    seen = recogniser.look(np.zeros((240, 320), np.uint8), FaceView(camera_at(robot_at()), BOX))
    assert (seen.status, seen.reason) == (Status.WRONG_SIZE, "image of 320 x 240 px: expected the camera's 640 x 480")
    with pytest.raises(ImageError):
        recogniser.look(np.zeros((480, 640)), FaceView(camera_at(robot_at()), BOX))


@pytest.mark.parametrize("tags", [{}, {0: TAGS[1]}])
def test_tags_must_be_numbered_from_one(tags: Any) -> None:
    with pytest.raises(ValueError, match="expected at least one, numbered from 1"):
        Recogniser(tags)


def test_the_same_image_gives_the_same_verdict(recogniser: Recogniser) -> None:
    frame, T_world_optical = view(TAGS[3])
    first, second = (recogniser.look(frame.grey, FaceView(T_world_optical, BOX)) for _ in range(2))
    assert first.probabilities == second.probabilities
    assert first.measured == second.measured
