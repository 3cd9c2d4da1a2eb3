"""Whether the pictures of a camera can be used: silent, frozen, dark, over-exposed; pure, picture by picture."""

from __future__ import annotations

import math
from typing import Optional

import numpy as np

from yarm.tags.motifs import GreyImage

SILENT_S = 1.0
"""Without a picture for so long the camera is silent."""
FROZEN_COUNT = 5
"""So many pictures in a row that are alike to the last bit come from a camera that has stopped: noise never repeats."""
DARK_GREY, BRIGHT_GREY, MOST_BURNT = 18.0, 250, 0.8
"""Nearly all pixels below this grey: dark. A greater share than this at or above the other: over-exposed."""
SAMPLE = 4
"""Every so many-th pixel each way is looked at for darkness."""


class PictureWatch:
    """Looks at stamps and pixels of one camera."""

    def __init__(self) -> None:
        """Nothing has come."""
        self._newest: Optional[GreyImage] = None
        self._stamp_s, self._heard_s = -math.inf, -math.inf
        self._alike = 0
        self._fault = ""

    def take(self, stamp_s: float, grey: GreyImage, now_s: float) -> str:
        """What is wrong with the next picture, (h, w) grey, that comes now; empty when it can be used."""
        self._heard_s, self._fault = now_s, self._fault_of(stamp_s, grey)
        return self._fault

    def refuse(self, fault: str, now_s: float) -> None:
        """The picture that comes now could not even be read."""
        self._heard_s, self._fault = now_s, fault

    def fault(self, now_s: float) -> str:
        """What is wrong with the camera now; empty when all is well."""
        if self._heard_s == -math.inf:
            return "no picture has come yet"
        age_s = now_s - self._heard_s
        return f"silent: no picture for {age_s:.1f} s" if age_s > SILENT_S else self._fault

    def _fault_of(self, stamp_s: float, grey: GreyImage) -> str:
        if stamp_s <= self._stamp_s:
            return f"frozen: the stamp {stamp_s:.3f} s is not after {self._stamp_s:.3f} s, the one before"
        self._stamp_s = stamp_s
        before, self._newest = self._newest, grey
        same = before is not None and before.shape == grey.shape and bool(np.array_equal(before, grey))
        self._alike = self._alike + 1 if same else 0
        if self._alike + 1 >= FROZEN_COUNT:
            return f"frozen: {self._alike + 1} pictures in a row are the same to the last bit"
        return light_fault(grey)


def light_fault(grey: GreyImage) -> str:
    """Whether a picture is too dark or too bright as a whole."""
    sample = grey[::SAMPLE, ::SAMPLE]
    bright = float(np.percentile(sample, 95))
    if bright < DARK_GREY:
        return f"dark: 95 % of the pixels are below {bright:.0f} of 255; is the lens covered, the light on?"
    burnt = float((sample >= BRIGHT_GREY).mean())
    if burnt > MOST_BURNT:
        return f"over-exposed: {100 * burnt:.0f} % of the pixels are white; shorten the exposure"
    return ""
