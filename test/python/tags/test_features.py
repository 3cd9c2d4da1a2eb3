"""Detectors by name, features of empty images, good matches."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from yarm.resources import resource
from yarm.tags.features import Detector, DetectorError, available_detectors, features_of
from yarm.tags.pictures import read_picture, size_at, stranger

NAMES = ("sift", "orb", "akaze")


@pytest.fixture(scope="module")
def picture() -> np.ndarray:
    return size_at((400, 320), read_picture(resource("tags", "tag_02.png")))


@pytest.mark.parametrize("name", NAMES)
def test_a_turned_picture_matches_itself_where_it_should(name: str, picture: np.ndarray) -> None:
    detector = Detector(name)
    turn = cv2.getRotationMatrix2D((200, 160), 25.0, 0.8)
    turned = cv2.warpAffine(picture, turn, (400, 320))
    here, there = detector.find(picture), detector.find(turned)
    good = detector.good_matches(here, there, 0.77)
    assert len(good) > 40
    expected = here.points[good[:, 0]] @ turn[:, :2].T + turn[:, 2]
    off = np.linalg.norm(expected - there.points[good[:, 1]], axis=1)
    assert np.median(off) < 2.0


@pytest.mark.parametrize("name", NAMES)
def test_a_bare_image_has_no_features_and_matches_nothing(name: str, picture: np.ndarray) -> None:
    detector = Detector(name)
    bare = detector.find(np.full((200, 200), 120, np.uint8))
    assert len(bare) == 0
    assert bare.descriptors.shape[1] == detector.find(picture).descriptors.shape[1]
    assert detector.good_matches(detector.find(picture), bare, 0.77).shape == (0, 2)
    assert detector.good_matches(bare, detector.find(picture), 0.77).shape == (0, 2)


@pytest.mark.parametrize("name", NAMES)
def test_the_features_of_a_picture_are_found_once_and_are_its_own(name: str, picture: np.ndarray) -> None:
    found, other = features_of(name, picture), features_of(name, np.ascontiguousarray(picture[::-1]))
    here = Detector(name).find(picture)
    assert np.array_equal(found.points, here.points) and np.array_equal(found.descriptors, here.descriptors)
    assert features_of(name, picture.copy()) is found and features_of(name, picture[::-1]) is other
    assert not np.array_equal(other.points, found.points)


def test_the_mask_keeps_features_out(picture: np.ndarray) -> None:
    mask = np.zeros_like(picture)
    mask[:, 200:] = 255
    found = Detector("sift").find(picture, mask)
    assert len(found) > 20
    assert found.points[:, 0].min() >= 199.0


def test_a_smaller_ratio_leaves_fewer_matches(picture: np.ndarray) -> None:
    detector = Detector("sift")
    tag, scene = detector.find(picture), detector.find(size_at((400, 320), stranger(1)))
    counts = [len(detector.good_matches(tag, scene, ratio)) for ratio in (0.6, 0.8, 1.01)]
    assert counts[0] <= counts[1] <= counts[2] == len(tag)


def test_a_detector_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(DetectorError, match="detector 'brisk': the installed OpenCV has sift, orb, akaze"):
        Detector("brisk")
    if "surf" not in available_detectors():
        with pytest.raises(DetectorError, match="'surf'"):
            Detector("surf")
