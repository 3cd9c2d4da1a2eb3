"""Camera pictures of several encodings, and the recogniser's parameters, checked together."""

from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import Image

from yarm.params import ParamError
from yarm.ros.inspection.images import take_camera_picture, take_picture
from yarm.ros.inspection.recogniser_node import picture_message
from yarm.ros.inspection.recogniser_params import recogniser_params

GREY = np.arange(48, dtype=np.uint8).reshape(6, 8) * 5


def test_grey_goes_through_unchanged_with_padded_rows_too():
    assert np.array_equal(take_picture(picture_message(GREY))[0], GREY)
    padded = np.zeros((6, 16), np.uint8)
    padded[:, :8] = GREY
    message = Image(height=6, width=8, encoding="mono8", step=16, data=padded.tobytes())
    assert np.array_equal(take_picture(message)[0], GREY)


@pytest.mark.parametrize(("encoding", "grey"), [("rgb8", 76), ("bgr8", 29)])
def test_colours_are_weighed_by_their_order(encoding, grey):
    pixels = np.zeros((6, 8, 3), np.uint8)
    pixels[..., 0] = 255
    message = Image(height=6, width=8, encoding=encoding, step=24, data=pixels.tobytes())
    picture, fault = take_picture(message)
    assert fault == "" and np.all(picture == grey)


def test_what_cannot_be_read_is_named_with_numbers():
    for change, words in (
        ({"encoding": "16UC1"}, "encoding '16UC1', expected one of mono8"),
        ({"step": 7}, "rows of 7 bytes, expected at least 8"),
        ({"data": bytes(47)}, "47 bytes for 6 rows of 8"),
        ({"width": 0}, "0 x 6 pixels"),
    ):
        message = picture_message(GREY)
        for name, value in change.items():
            setattr(message, name, value)
        picture, fault = take_picture(message)
        assert words in fault and picture.size == 0


def test_the_robots_camera_has_one_size_of_pictures():
    grey = np.random.default_rng(1).integers(0, 255, (480, 640)).astype(np.uint8)
    assert np.array_equal(take_camera_picture(picture_message(grey))[0], grey)
    picture, fault = take_camera_picture(picture_message(grey[::2, ::2]))
    assert picture.size == 0 and fault == "320 x 240 pixels, expected 640 x 480"
    assert "encoding" in take_camera_picture(Image(height=2, width=2, encoding="32FC1", step=8, data=bytes(16)))[1]


def test_all_that_is_wrong_with_the_parameters_is_told_at_once():
    with pytest.raises(ParamError) as caught:
        recogniser_params({"detector": "harris", "ratio": 2.0, "speed": 1, "tags": "/nowhere.yaml"}, "/tag_recogniser")
    text = str(caught.value)
    for words in ("detector = 'harris'", "ratio = 2.0: must be", "speed: unknown", "tags = '/nowhere.yaml'"):
        assert words in text
    params, tags = recogniser_params({"detector": "orb"}, "/tag_recogniser")
    assert params.detector == "orb" and sorted(tags) == list(range(1, 16))
