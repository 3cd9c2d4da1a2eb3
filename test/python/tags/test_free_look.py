"""Tags anywhere in a picture: found where they were drawn, by number, size and corners; nothing where there is none."""

from __future__ import annotations

from typing import Tuple

import cv2
import numpy as np
import pytest

from yarm.geometry import FloatArray
from yarm.tags.features import DetectorError
from yarm.tags.free_look import FreeRecogniser, FreeSettings, qt_homography
from yarm.tags.motifs import GreyImage
from yarm.tags.pictures import shipped_pictures, stranger

TAGS = shipped_pictures()
SIZE = (640, 480)
SETTINGS = FreeSettings()


def recogniser(settings: FreeSettings = SETTINGS, numbers: Tuple[int, ...] = (3, 5, 8, 11)) -> FreeRecogniser:
    made = FreeRecogniser(settings)
    for number in numbers:
        made.add(number, TAGS[number])
    return made


def placed(corners: FloatArray, width: int, height: int) -> FloatArray:
    outline = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    found: FloatArray = cv2.getPerspectiveTransform(outline, corners.astype(np.float32))
    return found


def scene(*parts: Tuple[GreyImage, FloatArray]) -> GreyImage:
    """Pictures hung up in a grey room with a little noise."""
    picture = np.full(SIZE[::-1], 120, np.uint8)
    for image, corners in parts:
        homography = placed(corners, image.shape[1], image.shape[0])
        drawn = cv2.warpPerspective(cv2.GaussianBlur(image, (0, 0), 1.5), homography, SIZE, flags=cv2.INTER_AREA)
        seen = cv2.warpPerspective(np.full(image.shape, 255, np.uint8), homography, SIZE)
        picture[seen > 127] = drawn[seen > 127]
    noisy: GreyImage = np.clip(picture + np.random.default_rng(3).normal(0, 2, picture.shape), 0, 255).astype(np.uint8)
    return noisy


LEFT = np.array([[60.0, 80], [300, 95], [300, 285], [60, 300]])
RIGHT = np.array([[380.0, 150], [560, 140], [565, 290], [380, 285]])


def test_two_tags_are_found_where_they_hang_the_larger_one_first() -> None:
    look = recogniser().look(scene((TAGS[5], LEFT), (TAGS[8], RIGHT)))
    assert {sight.tag for sight in look.sights} == {5, 8} and look.reason == ""
    for sight in look.sights:
        assert sight.size == (1000, 800)
        assert np.abs(sight.corners - (LEFT if sight.tag == 5 else RIGHT)).max() < 6.0
    first = look.sights[0].tag
    assert look.probabilities[first] > 0.99 and sum(look.probabilities.values()) == pytest.approx(1.0)
    assert set(look.probabilities) == {3, 5, 8, 11, 0, -1}


def test_a_stranger_is_no_tag_and_says_nothing() -> None:
    look = recogniser().look(scene((stranger(2), LEFT)))
    assert look.sights == () and look.probabilities == {} and "(min_inliers)" in look.reason


def test_a_removed_tag_is_found_no_more_and_an_added_one_is() -> None:
    made, picture = recogniser(), scene((TAGS[11], LEFT))
    assert made.remove(11) and not made.remove(11)
    assert made.look(picture).sights == () and made.tags == (3, 5, 8)
    made.add(21, TAGS[11])
    assert [sight.tag for sight in made.look(picture).sights] == [21]


def test_without_tags_it_says_what_to_do() -> None:
    assert "~load_tags" in FreeRecogniser(FreeSettings()).look(scene()).reason


@pytest.mark.parametrize("detector", ["orb", "akaze"])
def test_other_detectors_find_it_too(detector: str) -> None:
    found = recogniser(FreeSettings(detector=detector)).look(scene((TAGS[8], LEFT))).sights
    assert [sight.tag for sight in found] == [8]
    assert np.abs(found[0].corners - LEFT).max() < 10.0


def test_cropped_away_it_is_not_found() -> None:
    low = np.array([[4.0, 300], [84, 300], [84, 364], [4, 364]])
    assert recogniser().look(scene((TAGS[8], low))).sights
    assert not recogniser(FreeSettings(crop=True)).look(scene((TAGS[8], low))).sights


def test_bad_settings_and_tags_are_refused() -> None:
    with pytest.raises(DetectorError, match="the installed OpenCV has sift"):
        FreeRecogniser(FreeSettings(detector="harris"))
    assert "harris" in FreeSettings(detector="harris").faults[0] and FreeSettings().faults == ()
    made = recogniser()
    with pytest.raises(ValueError, match="numbers begin at 1"):
        made.add(0, TAGS[1])
    with pytest.raises(ValueError, match=r"tag 9: \d+ keypoints, at least 12"):
        made.add(9, np.full((80, 100), 128, np.uint8))


def test_qt_has_the_translation_in_its_last_row() -> None:
    matrix = np.array([[2.0, 0.1, 30.0], [0.2, 3.0, 40.0], [0.001, 0.002, 1.0]]) * 2.0
    assert qt_homography(matrix) == pytest.approx((2.0, 0.2, 0.001, 0.1, 3.0, 0.002, 30.0, 40.0, 1.0))
