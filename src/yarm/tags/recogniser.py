"""Which tag is on a box whose pose is known: only what lies where the box must be can speak for it.

An image that shows too little says so instead of voting for blank, and a blank face is one that is seen, lit and empty.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Mapping, Optional, Tuple

import numpy as np

from yarm.geometry import Pose2, wrap_angle
from yarm.tags.alignment import Fit, FloatImage, best_first, fits, flattened, reference_of, texture_within
from yarm.tags.calibration import Calibration, Measures, load_calibration, probabilities
from yarm.tags.elsewhere import FRAME_PX, Found, find_anywhere, pose_from_homography
from yarm.tags.face_view import MARGIN_PX, FaceView, Upright, outline_support, upright
from yarm.tags.features import DETECTOR, Detector
from yarm.tags.motifs import GreyImage
from yarm.tags.report import as_grey

LEAST_SHARE = 0.15
DARK_GREY, BRIGHT_GREY, MOST_BURNT = 18.0, 250, 0.8
SURE_LIKENESS = 0.5
"""A tag that is as like as this lies there; wrong ones stay below 0.3."""
EMPTY_TEXTURE = 0.03
LEAST_OUTLINE = 0.35
"""A face shows at least so much of its outline. That less is seen does not prove that no box stands there: something
may hide it, or its edges may be as bright as what is behind. That takes a range sensor."""
MOVED_M, MOVED_DEG = 0.10, 10.0
FARTHEST_MOVE_M = 0.6
"""A tag farther from its place belongs to another box, and so does one nearer to another box's place."""


class Status(Enum):
    """Whether an image could be used."""

    LOOKED = "looked"
    OUT_OF_VIEW = "out of view"
    HIDDEN = "hidden"
    DARK = "dark"
    BURNT = "over-exposed"
    WRONG_SIZE = "wrong size"


class Finding(Enum):
    """How the box stands."""

    IN_PLACE = "in place"
    MOVED = "moved"
    UPSIDE_DOWN = "upside down"
    MISSING = "missing"
    NOT_SEEN = "not seen"


@dataclass(frozen=True, eq=False)
class Look:
    """What one image says about one box.

    Attributes:
        status: whether it could be used.
        reason: in words, when it could not.
        probabilities: of each tag, BLANK and UNKNOWN; empty when the image could not be used or shows no box.
        finding: how the box stands.
        fits: every tag laid on the face, the likest first.
        share: share of the face that is seen.
        texture: deviation of its grey without light and noise, for a mean of 1.
        measured: where the box stands by this image; None when no tag was found.
        measures: what the probabilities were made of.
    """

    status: Status
    reason: str = ""
    probabilities: Mapping[int, float] = field(default_factory=dict)
    finding: Finding = Finding.NOT_SEEN
    fits: Tuple[Fit, ...] = ()
    share: float = 0.0
    texture: float = 0.0
    measured: Optional[Pose2] = None
    measures: Optional[Measures] = None

    @property
    def answer(self) -> Optional[int]:
        """The most probable answer; None when there is none."""
        return max(self.probabilities, key=lambda a: self.probabilities[a]) if self.probabilities else None


class Recogniser:
    """The tags, prepared once; one instance looks at any number of images, by one thread at a time."""

    def __init__(self, tags: Mapping[int, GreyImage], calibration: Optional[Calibration] = None) -> None:
        """Prepare the tags, numbered from 1.

        Raises:
            ValueError: no tags, or a number below 1.
        """
        if not tags or min(tags) < 1:
            raise ValueError(f"tags {sorted(tags)}: expected at least one, numbered from 1")
        self._detector = Detector(DETECTOR)
        self._calibration = calibration or load_calibration()
        self._references = {number: reference_of(picture, self._detector) for number, picture in tags.items()}

    def look(self, image: GreyImage, view: FaceView) -> Look:
        """What an image, (h, w) grey or (h, w, 3) RGB, says about the box of a view.

        Raises:
            ImageError: not an image.
        """
        grey = as_grey(image)
        size, expected = (grey.shape[1], grey.shape[0]), (view.camera.width, view.camera.height)
        if size != expected:
            wanted = f"the camera's {expected[0]} x {expected[1]}"
            return Look(Status.WRONG_SIZE, f"image of {size[0]} x {size[1]} px: expected {wanted}")
        face = upright(grey, view)
        unusable = _unusable(face)
        if face is None or unusable is not None:
            return unusable or Look(Status.OUT_OF_VIEW)
        flat = flattened(face.picture, face.mask)
        found, _ = fits(face, flat, self._references, self._detector)
        texture = texture_of(face, flat)
        best = best_first(found)[0]
        measured = None
        finding = Finding.IN_PLACE
        if best.likeness < SURE_LIKENESS:
            other = self._elsewhere(grey, view, texture)
            if other is not None:
                found = [other.fit if fit.tag == other.fit.tag else fit for fit in found]
                measured, finding, texture = other.box, _finding_of(other, view), other.texture
        elif best.homography is not None:
            measured = _measured(best, face, view)
        if measured is None and best.likeness < SURE_LIKENESS:
            absent = _absent(grey, view, face.share)
            if absent is not None:
                return absent
        measures = Measures({fit.tag: (fit.likeness, fit.inliers) for fit in found}, texture)
        answers = probabilities(measures, self._calibration)
        return Look(
            Status.LOOKED, "", answers, finding, tuple(best_first(found)), face.share, texture, measured, measures
        )

    def _elsewhere(self, grey: GreyImage, view: FaceView, texture: float) -> Optional[Found]:
        """A tag anywhere in the image but on the other boxes, when the place itself is not plainly an empty face."""
        if texture < EMPTY_TEXTURE and view.stands is not False and _stands(grey, view):
            return None
        found = find_anywhere(grey, view, self._references, self._detector)
        return found if found is not None and _is_own(found.box, view) else None


def texture_of(face: Upright, flat: FloatImage) -> float:
    """Texture of an upright face inside its margin and what may be printed along its edge."""
    return texture_within(face.picture, face.mask, flat, MARGIN_PX + FRAME_PX)


def _unusable(face: Optional[Upright]) -> Optional[Look]:
    """Why a face cannot be judged; None when it can."""
    if face is None:
        return Look(Status.OUT_OF_VIEW, "the face is behind, beside or too steep before the camera")
    if face.share < LEAST_SHARE:
        return Look(
            Status.HIDDEN, f"{100 * face.share:.0f} % of the face is seen; at least {100 * LEAST_SHARE:.0f} %",
            share=face.share,
        )  # fmt: skip
    seen = face.picture[face.mask > 0]
    if float(np.percentile(seen, 90)) < DARK_GREY:
        return Look(Status.DARK, f"grey {np.percentile(seen, 90):.0f} of 255 where the face must be", share=face.share)
    burnt = float((seen >= BRIGHT_GREY).mean())
    if burnt > MOST_BURNT:
        return Look(Status.BURNT, f"{100 * burnt:.0f} % of the face's pixels are white", share=face.share)
    return None


def _stands(grey: GreyImage, view: FaceView) -> bool:
    """Whether a body stands there: by the range sensor, else by the face's outline in the image."""
    return view.stands if view.stands is not None else outline_support(grey, view) >= LEAST_OUTLINE


def _absent(grey: GreyImage, view: FaceView, share: float) -> Optional[Look]:
    """What is said when no tag was found and no box is seen either; None when one is."""
    if _stands(grey, view):
        return None
    if view.stands is False:
        return Look(Status.LOOKED, "nothing stands where the box must be", {}, Finding.MISSING, share=share)
    return Look(Status.LOOKED, "neither a tag nor the outline of a box is seen", share=share)


def _measured(fit: Fit, face: Upright, view: FaceView) -> Pose2:
    """Where the box stands, from where its tag's corners are in the image."""
    assert fit.homography is not None
    return pose_from_homography(face.to_image @ fit.homography, view)[0]


def _is_own(found: Pose2, view: FaceView) -> bool:
    """Whether a tag that was found somewhere can be that of the box that is looked for."""
    away = found.distance(view.box)
    return away <= FARTHEST_MOVE_M and all(away < found.distance(pose) for pose, _ in view.others)


def _finding_of(other: Found, view: FaceView) -> Finding:
    if other.upside_down:
        return Finding.UPSIDE_DOWN
    turned = abs(math.degrees(wrap_angle(other.box.yaw_rad - view.box.yaw_rad))) > MOVED_DEG
    return Finding.MOVED if turned or other.box.distance(view.box) > MOVED_M else Finding.IN_PLACE
