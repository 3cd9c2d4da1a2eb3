"""The predicted face: what of it is seen, drawn upright, and its outline."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from python.tags.tag_views import BOX, TAGS, camera_at, robot_at, tagged, view
from yarm.geometry import Pose2
from yarm.geometry.pinhole import BoxSize
from yarm.tags.alignment import agrees_with_pose, best_first, fits, flattened, likeness_of, reference_of
from yarm.tags.elsewhere import find_anywhere, pose_from_homography
from yarm.tags.face_view import MARGIN_PX, UPRIGHT_PX, FaceView, outline_support, upright
from yarm.tags.features import Detector
from yarm.tags.pictures import size_at
from yarm.tags.recogniser import texture_of

SHIFT = np.array([[1.0, 0.0, MARGIN_PX], [0.0, 1.0, MARGIN_PX], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def detector() -> Detector:
    return Detector("sift")


@pytest.mark.parametrize("angle", [-50.0, 0.0, 30.0])
def test_the_upright_face_is_the_tag_wherever_it_is_seen_from(angle: float) -> None:
    frame, T_world_optical = view(TAGS[6], robot_at(0.9, angle))
    face = upright(frame.grey, FaceView(T_world_optical, BOX))
    assert face is not None
    inner = (slice(MARGIN_PX, -MARGIN_PX), slice(MARGIN_PX, -MARGIN_PX))
    seen = face.mask[inner] > 0
    picture, tag = face.picture[inner], size_at(UPRIGHT_PX, TAGS[6])
    assert np.corrcoef(picture[seen], tag[seen])[0, 1] > 0.95
    assert 0.85 < face.share <= 1.0


def test_the_share_that_is_seen_and_the_detail() -> None:
    near = FaceView(camera_at(robot_at(0.5)), BOX)
    face = upright(np.zeros((480, 640), np.uint8), near)
    assert face is not None
    assert face.share == pytest.approx(0.64, abs=0.01)
    assert face.detail == pytest.approx(547 / UPRIGHT_PX[0], rel=0.02)


def test_a_nearer_box_hides_a_farther_one_not_the_other_way_round() -> None:
    before = BOX.compose(Pose2(0.35, 0.2, 0.0))
    behind = BOX.compose(Pose2(-0.6, 0.2, 0.0))
    shares = []
    for others in ((), ((before, BoxSize()),), ((behind, BoxSize()),)):
        face = upright(np.zeros((480, 640), np.uint8), FaceView(camera_at(robot_at(1.1)), BOX, others=others))
        assert face is not None
        shares.append(face.share)
    assert shares[1] < 0.7 * shares[0]
    assert shares[2] == shares[0]


def test_from_behind_and_from_too_far_aside_there_is_no_face() -> None:
    image = np.zeros((480, 640), np.uint8)
    for angle, there in ((0.0, True), (75.0, True), (86.0, False), (180.0, False)):
        assert (upright(image, FaceView(camera_at(robot_at(1.0, angle)), BOX)) is not None) is there


def test_a_blank_box_shows_its_outline_and_an_empty_place_little() -> None:
    for angle in (-30.0, 0.0, 40.0):
        there, T_world_optical = view(None, robot_at(0.7, angle))
        face = FaceView(T_world_optical, BOX)
        assert outline_support(there.grey, face) > 0.35
        rough = np.full((480, 640), 120, np.uint8)
        assert outline_support(rough, face) == 0.0


def test_the_right_tag_lies_best_by_far(detector: Detector) -> None:
    references = {number: reference_of(TAGS[number], detector) for number in (2, 6, 9)}
    frame, T_world_optical = view(TAGS[6], robot_at(0.7, 25.0))
    face = upright(frame.grey, FaceView(T_world_optical, BOX))
    assert face is not None
    found, keypoints = fits(face, flattened(face.picture, face.mask), references, detector)
    first, second, _ = best_first(found)
    assert keypoints > 50
    assert (first.tag, first.inliers > 30) == (6, True)
    assert first.likeness > 0.9 > 3.0 * second.likeness
    assert first.matches is not None
    assert first.matches.shape == (first.inliers, 4)


def test_likeness_is_one_with_oneself_and_does_not_mind_light(detector: Detector) -> None:
    reference = reference_of(TAGS[3], detector)
    small = size_at(UPRIGHT_PX, TAGS[3])
    whole = np.full(small.shape, 255, np.uint8)
    slope = np.linspace(0.3, 0.6, small.shape[1])[None, :]
    for picture, least in ((small, 0.999), (np.round(small * slope).astype(np.uint8), 0.9)):
        assert likeness_of(flattened(picture), whole, reference, np.eye(3)) > least
    assert likeness_of(flattened(small), np.zeros_like(whole), reference, np.eye(3)) == 0.0
    assert abs(likeness_of(flattened(size_at(UPRIGHT_PX, TAGS[4])), whole, reference, np.eye(3))) < 0.2


def test_what_the_mask_hides_changes_nothing(detector: Detector) -> None:
    small = size_at(UPRIGHT_PX, TAGS[3])
    mask = np.full(small.shape, 255, np.uint8)
    mask[150:] = 0
    painted = small.copy()
    painted[150:] = 0
    assert np.array_equal(flattened(small, mask), flattened(painted, mask))


def test_a_homography_must_put_the_tag_where_the_pose_does() -> None:
    assert agrees_with_pose(SHIFT)
    assert not agrees_with_pose(SHIFT + np.array([[0, 0, 60.0], [0, 0, 0], [0, 0, 0]]))
    assert not agrees_with_pose(SHIFT @ np.diag([-1.0, -1.0, 1.0]))


def test_a_tag_is_found_anywhere_but_on_other_boxes(detector: Detector) -> None:
    references = {number: reference_of(TAGS[number], detector) for number in (2, 6)}
    there = BOX.compose(Pose2(0.0, 0.3, 0.2))
    frame, T_world_optical = view(None, robot_at(1.0), others=[tagged(TAGS[6], there)])
    face = FaceView(T_world_optical, BOX.compose(Pose2(0.0, -0.2, 0.0)))
    found = find_anywhere(frame.grey, face, references, detector)
    assert found is not None
    assert (found.fit.tag, found.upside_down) == (6, False)
    assert found.box.distance(there) < 0.03
    in_place = upright(frame.grey, FaceView(T_world_optical, there))
    assert in_place is not None
    texture = texture_of(in_place, flattened(in_place.picture, in_place.mask))
    assert found.texture == pytest.approx(texture, rel=0.2), "of the tag, not of the plain place where it was expected"
    known = FaceView(T_world_optical, face.box, others=((there, BoxSize()),))
    assert find_anywhere(frame.grey, known, references, detector) is None


def test_the_pose_of_a_box_from_its_homography() -> None:
    for pose in (BOX, BOX.compose(Pose2(0.1, 0.2, 0.3))):
        told = FaceView(camera_at(robot_at(0.9)), BOX)
        true = FaceView(told.T_world_optical, pose)
        box, upside_down, tilt = pose_from_homography(true.upright_to_image() @ SHIFT, told)
        assert box.distance(pose) < 1e-6
        assert not upside_down
        assert tilt < 0.1
        half_turn = np.array([[-1.0, 0.0, UPRIGHT_PX[0] - 1], [0.0, -1.0, UPRIGHT_PX[1] - 1], [0.0, 0.0, 1.0]])
        turned, upside_down, _ = pose_from_homography(true.upright_to_image() @ SHIFT @ half_turn, told)
        assert upside_down
        assert turned.distance(pose) < 1e-6


def test_the_other_boxes_mask_covers_what_is_behind_them_too() -> None:
    face = FaceView(camera_at(robot_at(0.9)), BOX, others=((BOX.compose(Pose2(0.0, 0.6)), BoxSize()),))
    mask = face.other_tags_mask()
    assert 0 < cv2.countNonZero(255 - mask[:408]) < mask[:408].size // 2
