"""Whether a camera's pictures can be used: each fault is named, and goes away by itself."""

from __future__ import annotations

from typing import List

import numpy as np
import pytest

from yarm.tags.motifs import GreyImage
from yarm.tags.picture_watch import FROZEN_COUNT, SILENT_S, PictureWatch


def pictures(count: int, low: int = 60, high: int = 200) -> List[GreyImage]:
    rng = np.random.default_rng(5)
    return [rng.integers(low, high, (48, 64), dtype=np.uint8) for _ in range(count)]


def test_before_the_first_picture_it_says_so_and_then_nothing() -> None:
    watch = PictureWatch()
    assert "no picture has come" in watch.fault(1.0)
    assert watch.take(1.0, pictures(1)[0], 1.0) == "" and watch.fault(1.0 + SILENT_S) == ""


def test_silence_is_named_with_its_length() -> None:
    watch = PictureWatch()
    watch.take(1.0, pictures(1)[0], 1.0)
    assert watch.fault(4.0) == "silent: no picture for 3.0 s"


def test_a_stamp_that_stands_still_is_frozen_and_a_newer_one_mends_it() -> None:
    watch = PictureWatch()
    first, second = pictures(2)
    watch.take(1.0, first, 1.0)
    assert "frozen: the stamp 1.000 s is not after" in watch.take(1.0, second, 1.1)
    assert "frozen" in watch.fault(1.0)
    assert watch.take(1.1, second, 1.2) == "" and watch.fault(1.2) == ""


def test_the_same_pixels_again_and_again_are_frozen_but_a_few_times_are_not() -> None:
    watch = PictureWatch()
    one, other = pictures(2)
    faults = [watch.take(0.1 * i, one.copy(), 0.1 * i) for i in range(FROZEN_COUNT)]
    assert not any(faults[:-1]) and f"{FROZEN_COUNT} pictures in a row" in faults[-1]
    assert watch.take(2.0, other, 2.0) == ""


@pytest.mark.parametrize(("low", "high", "word"), [(0, 12, "dark"), (252, 255, "over-exposed")])
def test_light(low: int, high: int, word: str) -> None:
    watch = PictureWatch()
    assert watch.take(1.0, pictures(1, low, high)[0], 1.0).startswith(word)
    assert watch.fault(1.0).startswith(word)
    assert watch.take(2.0, pictures(1)[0], 2.0) == ""


def test_what_cannot_be_read_stays_named_until_the_next_picture() -> None:
    watch = PictureWatch()
    watch.refuse("encoding '16UC1'", 1.0)
    assert watch.fault(1.0) == "encoding '16UC1'"
    assert "silent" in watch.fault(5.0)
    watch.take(2.0, pictures(1)[0], 2.0)
    assert watch.fault(2.0) == ""
