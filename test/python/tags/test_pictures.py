"""The tag pictures have the properties that recognition lives from."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path
from typing import Dict

import cv2
import numpy as np
import pytest

from yarm.tags.features import Detector, Features
from yarm.tags.motifs import SIZE_PX
from yarm.tags.pictures import (
    BLANKS,
    DESIGNS,
    STRANGERS,
    PictureError,
    blank,
    contact_sheet,
    draw,
    file_name,
    hard_set,
    read_picture,
    shipped_pictures,
    size_at,
    stranger,
    twins,
    write_pictures,
)

FACE_PX = (547, 437)
"""The face of a box in the image of a robot half a metre before it."""
RATIO = 0.77


def features(detector: Detector, picture: np.ndarray) -> Features:
    return detector.find(size_at(FACE_PX, picture))


@pytest.fixture(scope="module")
def detector() -> Detector:
    return Detector("sift")


@pytest.fixture(scope="module")
def tags() -> Dict[int, np.ndarray]:
    return shipped_pictures()


@pytest.fixture(scope="module")
def found(detector: Detector, tags: Dict[int, np.ndarray]) -> Dict[int, Features]:
    return {number: features(detector, picture) for number, picture in tags.items()}


def test_there_are_fifteen_grey_pictures_of_the_faces_proportions(tags: Dict[int, np.ndarray]) -> None:
    assert list(tags) == list(range(1, 16))
    assert {(picture.shape, picture.dtype) for picture in tags.values()} == {(SIZE_PX[::-1], np.dtype(np.uint8))}
    assert SIZE_PX[0] * 4 == SIZE_PX[1] * 5
    assert all(np.percentile(p, 90) - np.percentile(p, 10) > 100 for p in tags.values()), "high contrast"


@pytest.mark.parametrize("number", DESIGNS)
def test_the_shipped_picture_is_what_the_script_draws(number: int, tags: Dict[int, np.ndarray]) -> None:
    difference = np.abs(draw(DESIGNS[number]).astype(int) - tags[number].astype(int))
    assert difference.mean() < 0.5, "an OpenCV of another version may round a pixel differently, no more"


def test_keypoints_are_from_150_to_900_and_their_numbers_differ_by_a_factor_of_four(found: Dict[int, Features]) -> None:
    numbers = [len(f) for f in found.values()]
    assert min(numbers) >= 150
    assert max(numbers) <= 900
    assert max(numbers) >= 4 * min(numbers)


def test_each_of_the_sixteen_fields_has_five_keypoints(found: Dict[int, Features]) -> None:
    for number, f in found.items():
        counts, _, _ = np.histogram2d(f.points[:, 1], f.points[:, 0], 4, ((0, FACE_PX[1]), (0, FACE_PX[0])))
        assert counts.min() >= 5, f"tag {number}: {counts}"


def test_no_two_tags_have_ten_good_matches(detector: Detector, found: Dict[int, Features]) -> None:
    exact = cv2.BFMatcher()
    for a, b in permutations(found, 2):
        pairs = exact.knnMatch(found[a].descriptors, found[b].descriptors, k=2)
        assert sum(first.distance < RATIO * second.distance for first, second in pairs) < 10, (a, b)


def test_the_visible_part_of_the_nearest_view_gives_34_good_matches(
    detector: Detector, tags: Dict[int, np.ndarray], found: Dict[int, Features]
) -> None:
    """Half a metre away the crop leaves columns 43 to 504 and rows 0 to 280 of the face."""
    noise = np.random.default_rng(5)
    for number, picture in tags.items():
        seen = size_at(FACE_PX, picture)[:281, 43:505].astype(float)
        seen = cv2.GaussianBlur(seen, (0, 0), 0.7) + noise.normal(0.0, 3.0, seen.shape)
        scene = detector.find(np.clip(seen, 0, 255).astype(np.uint8))
        assert len(detector.good_matches(found[number], scene, RATIO)) >= 34, number


@pytest.mark.parametrize("flip", [1, 0, -1], ids=["left and right", "up and down", "half a turn"])
def test_no_symmetry_maps_a_tag_onto_itself(flip: int, tags: Dict[int, np.ndarray]) -> None:
    for number, picture in tags.items():
        plain = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), 6.0)
        plain -= plain.mean()
        likeness = float((plain * cv2.flip(plain, flip)).sum() / (plain * plain).sum())
        assert abs(likeness) < 0.3, (number, likeness)


def test_nothing_is_repeated_inside_a_tag(found: Dict[int, Features]) -> None:
    """Keypoints whose like stands elsewhere (more than 20 px away, descriptors nearer than 150) are few."""
    for number, f in found.items():
        product = f.descriptors @ f.descriptors.T
        squares = np.diag(product)
        between = np.sqrt(np.maximum(squares[:, None] + squares[None] - 2 * product, 0.0))
        apart = np.linalg.norm(f.points[:, None] - f.points[None], axis=2) > 20.0
        twins = (np.where(apart, between, np.inf).min(1) < 150.0).mean()
        assert twins < 0.2, (number, twins)


def test_the_hard_set_is_hard(detector: Detector) -> None:
    hard = hard_set()
    hard_found = {number: features(detector, picture) for number, picture in hard.items()}
    for a, b in ((1, 2), (3, 4), (5, 6)):
        assert np.array_equal(hard[a][:, :500], hard[b][:, :500])
        assert len(detector.good_matches(hard_found[a], hard_found[b], RATIO)) > 60
    assert all(np.ptp(hard[number]) < 60 for number in (7, 8)), "low in contrast"
    assert 20 < len(hard_found[9]) < 200


def test_strangers_and_blanks_are_like_no_tag(detector: Detector, found: Dict[int, Features]) -> None:
    others = [stranger(n) for n in range(STRANGERS)] + [blank(kind) for kind in BLANKS]
    assert len({other.tobytes() for other in others}) == STRANGERS + len(BLANKS)
    for i, other in enumerate(others):
        scene = features(detector, other)
        assert max(len(detector.good_matches(f, scene, RATIO)) for f in found.values()) <= 33, i


def test_a_blank_of_no_kind_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="blank 'green': expected one of white, cardboard, shadow, frame"):
        blank("green")


def test_written_pictures_can_be_read_again(tmp_path: Path, tags: Dict[int, np.ndarray]) -> None:
    paths = write_pictures(tmp_path / "new")
    assert [p.name for p in paths] == [file_name(n) for n in DESIGNS]
    assert np.array_equal(read_picture(paths[3]), draw(DESIGNS[4]))


@pytest.mark.parametrize(
    ("name", "picture", "said"),
    [
        ("absent.png", None, "no such file"),
        ("text.png", b"not a picture", "expected an 8-bit picture"),
        ("tiny.png", np.zeros((39, 60), np.uint8), "60 x 39 px; expected at least 50 x 40"),
        ("deep.png", np.zeros((100, 100), np.uint16), "expected an 8-bit picture"),
        ("red.png", np.full((100, 100, 3), (0, 0, 200), np.uint8), "3 channels that differ; expected a grey picture"),
    ],
)
def test_a_picture_that_cannot_be_used_is_refused(tmp_path: Path, name: str, picture: object, said: str) -> None:
    path = tmp_path / name
    if isinstance(picture, bytes):
        path.write_bytes(picture)
    elif picture is not None:
        assert cv2.imwrite(str(path), picture)
    with pytest.raises(PictureError, match=said) as raised:
        read_picture(path)
    assert str(path) in str(raised.value)


def test_the_same_picture_twice_is_told_from_pictures_that_share_a_part() -> None:
    pictures = dict(shipped_pictures())
    assert twins(pictures) == [] == twins(hard_set())
    paler = (cv2.resize(pictures[7], (400, 320)) // 2 + 60).astype(np.uint8)
    assert twins({**pictures, 20: paler}) == [(7, 20)]
    plain = np.full((80, 100), 200, np.uint8)
    assert twins({1: plain, 2: plain // 2, 3: pictures[3]}) == [(1, 2)]


def test_a_grey_picture_in_three_equal_channels_is_taken(tmp_path: Path) -> None:
    grey = stranger(0)
    assert cv2.imwrite(str(tmp_path / "grey.png"), cv2.merge([grey, grey, grey]))
    assert np.array_equal(read_picture(tmp_path / "grey.png"), grey)


def test_a_sheet_shows_every_picture() -> None:
    sheet = contact_sheet({"a": blank("white"), "b": blank("shadow"), "c": blank("frame")}, columns=2, width_px=100)
    assert sheet.shape == (2 * (80 + 28), 2 * 112)
