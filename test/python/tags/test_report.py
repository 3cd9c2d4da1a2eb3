"""The report's recognition, and each of its known faults, shown on rendered views."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from python.tags.tag_views import BOX, TAGS, robot_at, tagged, view, view_across_the_room
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize, face_corners, tag_face
from yarm.robots.turtlebot import RGB_CAMERA
from yarm.sim.sensors.rgb_camera import Imaging
from yarm.tags.pictures import stranger
from yarm.tags.quads import bottom_left_angle_deg
from yarm.tags.report import (
    FEW,
    FOUND,
    LEAST_AREA_PX2,
    NO_IMAGE,
    EdgeCase,
    ImageError,
    ReportRecogniser,
    Sighting,
    as_grey,
    cropped,
    edge_case,
    predicted_angle_deg,
)

SOME = {n: TAGS[n] for n in (1, 2, 5, 8, 12)}


@pytest.fixture(scope="module")
def recogniser() -> ReportRecogniser:
    return ReportRecogniser(SOME)


def sighting(tag: int, **changes: Any) -> Sighting:
    """One that counts."""
    corners = np.array([[100.0, 100.0], [300.0, 100.0], [300.0, 260.0], [100.0, 260.0]])
    full = Sighting(tag, 1, FOUND, 32000.0, 0.3, corners, False, 400, 80, (90.0,) * 4, 90.0, 32000.0, 90.0)
    return replace(full, **changes)


def test_the_crop_is_rows_38_to_407_and_columns_89_to_550() -> None:
    image = np.arange(480 * 640, dtype=np.int64).reshape(480, 640)
    part, (left, top) = cropped(image)
    assert (left, top) == (89, 38)
    assert part.shape == (370, 462)
    assert np.array_equal(part, image[38:408, 89:551])


@pytest.mark.parametrize("shape", [(59, 80), (480, 300)])
def test_an_image_too_small_to_crop_is_refused(shape: Any) -> None:
    with pytest.raises(ImageError, match=f"image of {shape[1]} x {shape[0]} px: expected at least"):
        cropped(np.zeros(shape, np.uint8))


@pytest.mark.parametrize("image", [np.zeros((10, 10)), np.zeros((9, 9, 4), np.uint8), np.zeros(9, np.uint8)])
def test_what_is_no_image_is_refused(image: np.ndarray) -> None:
    with pytest.raises(ImageError, match="expected 8 bits, grey or RGB"):
        as_grey(image)


@pytest.mark.parametrize("number", [1, 8])
def test_a_tag_before_the_robot_is_found_with_its_outline(recogniser: ReportRecogniser, number: int) -> None:
    frame, _ = view(TAGS[number])
    found = {s.tag: s for s in recogniser.look(frame.grey, 3)}
    right = found[number]
    assert right.rejection == ""
    assert right.box == 3
    assert right.area_px2 == pytest.approx(239000.0, rel=0.02)
    assert right.corners is not None
    assert right.corners[:, 0] == pytest.approx([47, 593, 593, 47], abs=6)
    assert right.angles == pytest.approx((90.0,) * 4, abs=2.0)
    assert right.good > 34
    assert all(s.good < right.good for n, s in found.items() if n != number)


def test_colour_and_grey_give_the_same(recogniser: ReportRecogniser) -> None:
    frame, _ = view(TAGS[5])
    rgb = np.repeat(frame.grey[..., None], 3, axis=2)
    assert [s.good for s in recogniser.look(rgb)] == [s.good for s in recogniser.look(frame.grey)]


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({}, ""),
        ({"area_px2": 3000.0}, "small"),
        ({"share": 0.099}, "few matches for the tag's keypoints"),
        ({"tangled": True}, "tangled"),
        ({"status": FEW}, "few matches"),
        ({"status": NO_IMAGE}, "no image"),
    ],
)
def test_what_is_rejected(changes: Any, reason: str) -> None:
    assert sighting(4, **changes).rejection == reason


def test_votes(recogniser: ReportRecogniser) -> None:
    def of(*counts: int) -> Any:
        return recogniser.verdict([sighting(tag) for tag, n in zip((1, 2, 5), counts) for _ in range(n)])

    assert (of(21).tag, of(21).edge_case, of(21).detector) == (1, False, "sift")
    assert of(9).tag == 0, "fewer than ten survivors are blank"
    assert of(8, 2).tag == 1
    assert of(7, 3).edge_case, "nobody has more than seven"
    assert of(9, 9).edge_case


def test_the_edge_case_weighs_angle_and_area_alike() -> None:
    near = [sighting(1, bottom_left_deg=92.0, effective_px2=10.0)]
    large = [sighting(2, bottom_left_deg=130.0, effective_px2=90.0)]
    both = [sighting(5, bottom_left_deg=94.0, effective_px2=80.0)]
    apart = edge_case([*near, *large], [1, 2])
    assert (apart.by_angle, apart.by_area) == (1, 2) and apart.together in (1, 2)
    assert edge_case([*near, *large, *both], [1, 2, 5]).together == 5
    clear = [sighting(1, bottom_left_deg=91.0), sighting(2, bottom_left_deg=99.0, effective_px2=5.0)]
    assert edge_case(clear, [1, 2]) == EdgeCase(1, 1, 1)


class TestKnownFaults:
    """What the report's recognition gets wrong; test_recogniser.py shows each of these gone."""

    def test_copies_of_one_frame_are_counted_as_evidence(self, recogniser: ReportRecogniser) -> None:
        frame, _ = view(TAGS[2])
        one = recogniser.look(frame.grey)
        assert recogniser.verdict(one).tag == 0
        assert recogniser.verdict(one * 21).tag == 2

    def test_a_dark_room_is_taken_for_a_blank_box(self, recogniser: ReportRecogniser) -> None:
        frame, _ = view(TAGS[2], imaging=Imaging(gain=0.01))
        assert recogniser.verdict(recogniser.look(frame.grey) * 21).tag == 0

    def test_frames_that_did_not_come_are_taken_for_a_blank_box(self, recogniser: ReportRecogniser) -> None:
        assert recogniser.verdict(recogniser.look(None) * 21).tag == 0

    @pytest.mark.parametrize("number", [0, 3, 6, 9])
    def test_a_strangers_tag_is_called_blank(self, recogniser: ReportRecogniser, number: int) -> None:
        frame, _ = view(stranger(number))
        assert recogniser.verdict(recogniser.look(frame.grey) * 21).tag == 0

    def test_a_neighbour_in_view_names_a_blank_box(self, recogniser: ReportRecogniser) -> None:
        """The heading is 12 degrees off, which is inside move_base's tolerance of 17."""
        neighbour = tagged(TAGS[8], BOX.compose(Pose2(0.0, 0.55, 0.0)))
        frame, _ = view(None, robot_at(0.8, turn_deg=-12.0), others=[neighbour])
        assert recogniser.verdict(recogniser.look(frame.grey) * 21).tag == 8

    def test_a_tag_4_5_m_away_names_a_box_that_is_not_there(self) -> None:
        frame, _ = view_across_the_room(11)
        recogniser = ReportRecogniser({2: TAGS[2], 11: TAGS[11]})
        seen = recogniser.look(frame.grey)
        (far,) = (s for s in seen if s.rejection == "")
        assert far.area_px2 == pytest.approx(LEAST_AREA_PX2, rel=0.05), "about what the least area lets in"
        assert recogniser.verdict(seen * 21).tag == 11

    def test_a_tag_seen_from_the_side_is_taken_for_a_blank_box(self, recogniser: ReportRecogniser) -> None:
        """Its own share of good matches falls with the part and the angle that is seen."""
        frame, _ = view(TAGS[8], robot_at(0.5, 60.0))
        assert recogniser.verdict(recogniser.look(frame.grey) * 21).tag == 0

    def test_the_predicted_angle_is_ten_degrees_off_at_the_side(self) -> None:
        for angle, at_half_a_metre in ((30.0, 109.0), (60.0, 140.0)):
            _, T_world_optical = view(None, robot_at(0.5, angle))
            face = np.linalg.inv(T_world_optical) @ tag_face(BOX, BoxSize())
            corners = RGB_CAMERA.project(face_corners(0.5, 0.4) @ face[:3, :3].T + face[:3, 3])
            assert bottom_left_angle_deg(corners) == pytest.approx(at_half_a_metre, abs=2.0)
            assert predicted_angle_deg(angle) - bottom_left_angle_deg(corners) > 9.0

    def test_sums_favour_the_tag_seen_least_often(self) -> None:
        often = [sighting(1, bottom_left_deg=92.0) for _ in range(12)]
        rarely = [sighting(2, bottom_left_deg=110.0, effective_px2=32000.0 * 12)]
        assert edge_case([*often, *rarely], [1, 2]).together == 2

    def test_a_homography_without_inliers_is_a_sighting(self, recogniser: ReportRecogniser) -> None:
        frame, _ = view(stranger(2), robot_at(0.8, 30.0))
        found = [s for s in recogniser.look(frame.grey) if s.status == FOUND]
        assert all(seen.corners is not None and not math.isnan(seen.share) for seen in found)
        assert min(seen.inliers for seen in found) == 4, "four matches agree with any homography through them"
